//! `cargo xtask release`: archives of the command for machines without Rust, one an architecture.
//!
//! Linked against musl, the command needs no library of the machine that it runs on, and the linker and C library that come with
//! Rust suffice for either architecture: no compiler for C is needed beside the host's.

use super::process::{cargo, output, run, succeeds};
use super::{Failure, places, set_up};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// An architecture: Rust's target, the machine in an ELF header (`e_machine`, System V ABI), the emulator that runs it elsewhere.
struct Architecture {
    target: &'static str,
    machine: u16,
    emulator: &'static str,
}

const ARCHITECTURES: [Architecture; 2] = [
    Architecture { target: "x86_64-unknown-linux-musl", machine: 62, emulator: "qemu-x86_64" },
    Architecture { target: "aarch64-unknown-linux-musl", machine: 183, emulator: "qemu-aarch64" },
];

/// What goes into an archive beside the command.
const BESIDE: [&str; 6] = ["README.md", "CHANGELOG.md", "LICENSE-APACHE", "LICENSE-MIT", "docs", "examples"];

/// Builds, packs and tries the archives of the named targets, of all unless some are named.
pub fn release(wanted: &[String]) -> Result<(), Failure> {
    let known = || ARCHITECTURES.map(|architecture| architecture.target).join(", ");
    if let Some(unknown) = wanted.iter().find(|name| ARCHITECTURES.iter().all(|other| other.target != **name)) {
        return Err(format!("there is no archive for {unknown:?}, but for {}", known()));
    }
    let chosen =
        |architecture: &&Architecture| wanted.is_empty() || wanted.iter().any(|name| name == architecture.target);
    let folder = places::target().join("archives");
    fs::create_dir_all(&folder).map_err(|error| format!("{}: {error}", folder.display()))?;
    for architecture in ARCHITECTURES.iter().filter(chosen) {
        let program = build(architecture)?;
        check(architecture, &program)?;
        let archive = pack(&folder, architecture, &program)?;
        println!("{}", archive.display());
    }
    Ok(())
}

/// The command for an architecture.
fn build(architecture: &Architecture) -> Result<PathBuf, Failure> {
    let target = architecture.target;
    if !set_up::has_library(target) {
        run(Command::new("rustup").args(["target", "add", target]))
            .map_err(|why| format!("the target {target} is missing: type `rustup target add {target}` ({why})"))?;
    }
    let of_target = |key: &str| format!("CARGO_TARGET_{}_{key}", target.to_uppercase().replace('-', "_"));
    let mut cargo = cargo();
    cargo.args(["build", "--release", "--package", "plumbline-cli", "--bin", "plumbline", "--target", target]);
    cargo.env(of_target("LINKER"), set_up::rust_lld()?);
    cargo.env(of_target("RUSTFLAGS"), "-Clinker-flavor=ld.lld -Clink-self-contained=yes -Cstrip=debuginfo");
    run(&mut cargo)?;
    Ok(places::target().join(target).join("release/plumbline"))
}

/// The program is one for that machine, and tells its version where it can be run.
fn check(architecture: &Architecture, program: &Path) -> Result<(), Failure> {
    let bytes = fs::read(program).map_err(|error| format!("{}: {error}", program.display()))?;
    let machine = bytes.get(18..20).map(|bytes| u16::from_le_bytes([bytes[0], bytes[1]]));
    if !bytes.starts_with(b"\x7fELF") || machine != Some(architecture.machine) {
        return Err(format!("{} is no program for {}", program.display(), architecture.target));
    }
    let mut run = if architecture.target.starts_with(std::env::consts::ARCH) {
        Command::new(program)
    } else if succeeds(Command::new(architecture.emulator).arg("--version")) {
        let mut emulated = Command::new(architecture.emulator);
        emulated.arg(program);
        emulated
    } else {
        eprintln!(
            "{}: not run, since {} is missing (apt-get install qemu-user)",
            architecture.target, architecture.emulator
        );
        return Ok(());
    };
    let wanted = concat!("plumbline ", env!("CARGO_PKG_VERSION"));
    match output(run.arg("--version")) {
        Some(said) if said == wanted => Ok(()),
        said => Err(format!("{} says {said:?} instead of {wanted:?}", program.display())),
    }
}

/// The archive: one folder, sorted, owned by nobody in particular, of the commit's time, so that the same sources give the same
/// bytes; and its SHA-256 beside it.
fn pack(folder: &Path, architecture: &Architecture, program: &Path) -> Result<PathBuf, Failure> {
    let name = format!("plumbline-{}-{}", env!("CARGO_PKG_VERSION"), architecture.target.replace("-unknown", ""));
    let staged = folder.join(&name);
    let failed = |error: std::io::Error| format!("{}: {error}", staged.display());
    if staged.exists() {
        fs::remove_dir_all(&staged).map_err(failed)?;
    }
    fs::create_dir(&staged).map_err(failed)?;
    fs::copy(program, staged.join("plumbline")).map_err(failed)?;
    for entry in BESIDE {
        run(Command::new("cp").arg("-r").arg(places::root().join(entry)).arg(&staged))?;
    }
    let at = output(Command::new("git").args(["log", "-1", "--format=%ct"]).current_dir(places::root()));
    let archive = format!("{name}.tar.gz");
    let mut tar = Command::new("tar");
    tar.args(["--sort=name", "--owner=0", "--group=0", "--numeric-owner", "--mode=u+rw,go=rX"]);
    tar.arg(format!("--mtime=@{}", at.unwrap_or_else(|| "0".to_owned()))).args(["--use-compress-program", "gzip -n9"]);
    run(tar.args(["-cf", &archive, &name]).current_dir(folder))?;
    let sum = output(Command::new("sha256sum").arg(&archive).current_dir(folder)).ok_or("sha256sum failed")?;
    fs::write(folder.join(format!("{archive}.sha256")), sum + "\n").map_err(failed)?;
    fs::remove_dir_all(&staged).map_err(failed)?;
    Ok(folder.join(archive))
}
