//! Where things lie.

use std::env;
use std::path::{Path, PathBuf};

/// The target of the boards.
pub const THUMB: &str = "thumbv7em-none-eabihf";

/// The cargo profile of the images.
pub const PROFILE: &str = "firmware";

/// The cargo profile of the flight computer's images.
pub const PROFILE_H743: &str = "h743";

/// The workspace's root.
pub fn root() -> PathBuf {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    here.parent().unwrap_or(here).to_owned()
}

/// Cargo's target folder.
pub fn target() -> PathBuf {
    // A relative one is relative to where cargo was started, and so are we.
    env::var_os("CARGO_TARGET_DIR").map_or_else(|| root().join("target"), |folder| absolute(Path::new(&folder)))
}

/// The image of a board or of a test.
pub fn image(name: &str) -> PathBuf {
    target().join(THUMB).join(PROFILE).join(name)
}

/// An image of the flight computer.
pub fn image_h743(name: &str) -> PathBuf {
    target().join(THUMB).join(PROFILE_H743).join(name)
}

/// The command.
pub fn plumbline() -> PathBuf {
    release("plumbline")
}

/// A program of the host, built in release.
pub fn release(name: &str) -> PathBuf {
    target().join("release").join(format!("{name}{}", env::consts::EXE_SUFFIX))
}

/// A program of the host, in the development profile, as tests use it.
pub fn tested(name: &str) -> PathBuf {
    target().join("debug").join(format!("{name}{}", env::consts::EXE_SUFFIX))
}

/// Where programs lie that the machine lacks.
pub fn tools() -> PathBuf {
    target().join("tools")
}

/// Where tests leave what they made.
pub fn scratch() -> PathBuf {
    target().join("xtask")
}

fn absolute(path: &Path) -> PathBuf {
    std::path::absolute(path).unwrap_or_else(|_| path.to_owned())
}
