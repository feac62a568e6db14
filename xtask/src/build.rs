//! Builds the images and the command.

use super::process::{cargo, run};
use super::set_up::{self, Compiler};
use super::{Failure, places};

/// Builds everything that flies: the images of both boards, and `plumbline` in release. The emulator is got as well; where
/// that cannot be, all the rest is still of use.
pub fn all() -> Result<(), Failure> {
    if let Err(why) = set_up::emulator() {
        eprintln!("{why}");
    }
    h743(&build()?)
}

/// Builds what flies without the flight computer: the emulated board's images, and `plumbline`. The way the images were
/// compiled.
pub fn build() -> Result<Compiler, Failure> {
    let compiler = set_up::compiler()?;
    images(&compiler)?;
    command()?;
    Ok(compiler)
}

/// Features of the emulated board's images.
pub const AN500: &str = "an500,defmt";

/// The emulated board's images.
pub fn images(compiler: &Compiler) -> Result<(), Failure> {
    let mut cargo = cargo();
    cargo.args(["build", "--package", "plumbline-firmware", "--bins", "--features", AN500]);
    cargo.args(["--profile", places::PROFILE]);
    compiler.apply(&mut cargo);
    run(&mut cargo)
}

/// All programs and tests of the host, in the development profile: one call, so that all share what they depend on.
pub fn host() -> Result<(), Failure> {
    run(cargo().args(["build", "--workspace", "--lib", "--bins", "--tests"]))
}

/// The command.
pub fn command() -> Result<(), Failure> {
    run(cargo().args(["build", "--release", "--package", "plumbline-cli", "--bin", "plumbline"]))
}

/// The flight computer's image behind the camera's bootloader, and the bare one.
pub const H743: [&str; 2] = ["h743-dfu", "h743"];

/// Builds both images of the flight computer; the library is compiled once.
///
/// Each is linked by a call of its own, which optimises the whole for speed: the package's own functions are small by the
/// profile, and cargo has no key for the program alone.
pub fn h743(compiler: &Compiler) -> Result<(), Failure> {
    for image in H743 {
        let mut cargo = cargo();
        cargo.args(["rustc", "--package", "plumbline-firmware", "--bin", image, "--features", "h743"]);
        cargo.args(["--profile", places::PROFILE_H743]);
        compiler.apply(&mut cargo);
        run(cargo.args(["--", "-C", "opt-level=3"]))?;
    }
    Ok(())
}
