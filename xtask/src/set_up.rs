//! What a machine with Rust may still lack: the boards' target and the emulator. Installs it, or says in one sentence
//! what to type.

use super::places::THUMB;
use super::process::{output, run, succeeds};
use super::{Failure, places};
use std::env;
use std::path::{Path, PathBuf};
use std::process::Command;

/// How to compile for the boards.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Compiler {
    /// With the toolchain in use, which has the target.
    Installed,
    /// With Debian's compiler and its library's source, linked by this linker.
    FromSource {
        /// `rust-lld` or `ld.lld`.
        linker: PathBuf,
    },
}

impl Compiler {
    /// Adds to a cargo command that compiles for the boards what this way needs.
    pub fn apply(&self, cargo: &mut Command) {
        cargo.args(["--target", THUMB]);
        if let Compiler::FromSource { linker } = self {
            cargo.arg("-Zbuild-std=core").env("RUSTC", DEBIAN_RUSTC).env("RUSTC_BOOTSTRAP", "1");
            cargo.env("CARGO_TARGET_THUMBV7EM_NONE_EABIHF_LINKER", linker);
        }
    }

    /// What it calls itself.
    pub fn version(&self) -> Result<String, Failure> {
        let rustc = match self {
            Compiler::Installed => env::var_os("RUSTC").unwrap_or_else(|| "rustc".into()),
            Compiler::FromSource { .. } => DEBIAN_RUSTC.into(),
        };
        output(Command::new(rustc).current_dir(places::root()).arg("--version"))
            .ok_or_else(|| "the compiler does not tell its version".into())
    }

    /// Whether clippy can check with it: clippy belongs to one version of the compiler.
    pub fn has_clippy(&self) -> bool {
        *self == Compiler::Installed
    }
}

const DEBIAN_RUSTC: &str = "/usr/bin/rustc";

/// Finds or installs a way to compile for the boards: rustup's target, else Debian's packages `rustc-web` and
/// `rust-web-src`, which fit each other.
pub fn compiler() -> Result<Compiler, Failure> {
    if has_target() {
        return Ok(Compiler::Installed);
    }
    eprintln!("installing the target {THUMB}");
    if run(Command::new("rustup").args(["target", "add", THUMB])).is_ok() && has_target() {
        return Ok(Compiler::Installed);
    }
    let wanted = format!("the target {THUMB} is missing: type `rustup target add {THUMB}`");
    if !is_there("apt-get") {
        return Err(wanted);
    }
    eprintln!("rustup could not: taking Debian's compiler and library source instead");
    install(&["rustc-web", "rust-web-src"], has_debian_source())
        .map_err(|why| format!("{wanted} (Debian's packages would do as well, but {why})"))?;
    linker().map(|linker| Compiler::FromSource { linker })
}

/// Makes sure that QEMU for Arm is there.
pub fn emulator() -> Result<(), Failure> {
    if is_there(QEMU) {
        return Ok(());
    }
    if !is_there("apt-get") {
        return Err("QEMU is missing: install qemu-system-arm, 7.2 or newer, with this system's package manager".into());
    }
    install(&[QEMU], false).map_err(|why| format!("QEMU is missing, and {why}"))
}

/// The emulator's command and, on Debian, its package.
pub const QEMU: &str = "qemu-system-arm";

/// Makes sure that rustfmt and clippy are there; a minimal toolchain has neither.
pub fn checkers() -> Result<(), Failure> {
    for (component, verb) in [("rustfmt", "fmt"), ("clippy", "clippy")] {
        let has = || succeeds(super::process::cargo().args([verb, "--version"]));
        if !has() {
            let _ = run(Command::new("rustup").args(["component", "add", component]));
            if !has() {
                return Err(format!("{component} is missing: type `rustup component add {component}`"));
            }
        }
    }
    Ok(())
}

/// Whether the compiler in use has the library for the boards.
fn has_target() -> bool {
    let rustc = env::var_os("RUSTC").unwrap_or_else(|| "rustc".into());
    output(Command::new(rustc).current_dir(places::root()).args(["--print", "target-libdir", "--target", THUMB]))
        .and_then(|folder| std::fs::read_dir(folder).ok())
        .is_some_and(|files| files.flatten().any(|file| file.file_name().to_string_lossy().starts_with("libcore-")))
}

/// Whether Debian's compiler finds its library's source.
fn has_debian_source() -> bool {
    output(Command::new(DEBIAN_RUSTC).args(["--print", "sysroot"]))
        .is_some_and(|sysroot| Path::new(&sysroot).join("lib/rustlib/src/rust/library/core").exists())
}

/// The linker of the toolchain in use, else Debian's.
fn linker() -> Result<PathBuf, Failure> {
    let sysroot = output(Command::new("rustc").current_dir(places::root()).args(["--print", "sysroot"]));
    let of_toolchain = sysroot.and_then(|sysroot| {
        let hosts = std::fs::read_dir(Path::new(&sysroot).join("lib/rustlib")).ok()?;
        hosts.flatten().map(|host| host.path().join("bin/rust-lld")).find(|path| path.exists())
    });
    if let Some(linker) = of_toolchain {
        return Ok(linker);
    }
    let debian = PathBuf::from("/usr/bin/ld.lld");
    install(&["lld"], debian.exists()).map_err(|why| format!("the linker lld is missing, and {why}"))?;
    Ok(debian)
}

/// Installs Debian packages as root, or by sudo where it asks no password.
fn install(packages: &[&str], is_done: bool) -> Result<(), Failure> {
    if is_done {
        return Ok(());
    }
    let line = format!("apt-get install -y {}", packages.join(" "));
    let is_root = output(Command::new("id").arg("-u")).is_some_and(|id| id == "0");
    if !is_root && !succeeds(Command::new("sudo").args(["-n", "true"])) {
        return Err(format!("this user may not install it: type `sudo {line}`"));
    }
    eprintln!("{line}");
    let apt = |arguments: &[&str]| {
        let mut command = if is_root { Command::new("apt-get") } else { Command::new("sudo") };
        if !is_root {
            command.args(["-n", "apt-get"]);
        }
        // Standard output belongs to the command that is being prepared.
        run(command.args(arguments).env("DEBIAN_FRONTEND", "noninteractive").stdout(std::io::stderr()))
    };
    // Nothing that is there may go for it: rustc-web and Debian's own rustup exclude each other.
    let options = ["install", "-y", "--no-install-recommends", "--no-remove"];
    let wanted: Vec<&str> = options.into_iter().chain(packages.iter().copied()).collect();
    apt(&wanted)
        .or_else(|_| apt(&["update"]).and_then(|()| apt(&wanted)))
        .map_err(|_| format!("it could not be installed: type `sudo {line}` and see why"))
}

/// Whether a command of this name starts.
fn is_there(name: &str) -> bool {
    succeeds(Command::new(name).arg("--version"))
}
