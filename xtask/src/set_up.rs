//! What a machine with Rust may still lack: the boards' target and the emulator. Gets it for this workspace alone, or says
//! in one sentence why that cannot be.

use super::debian::{Machine, Wanted};
use super::places::THUMB;
use super::process::{cargo, output, run, succeeds};
use super::{Failure, places};
use std::env;
use std::path::{Path, PathBuf};
use std::process::Command;

/// How to compile for the boards.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Compiler {
    /// With the toolchain in use, which has the target.
    Installed,
    /// With Debian's compiler and its library's source.
    FromSource {
        /// That compiler.
        rustc: PathBuf,
        /// `rust-lld` or `ld.lld`.
        linker: PathBuf,
    },
}

impl Compiler {
    /// Adds to a cargo command that compiles for the boards what this way needs.
    pub fn apply(&self, cargo: &mut Command) {
        cargo.args(["--target", THUMB]);
        if let Compiler::FromSource { rustc, linker } = self {
            cargo.arg("-Zbuild-std=core").env("RUSTC", rustc).env("RUSTC_BOOTSTRAP", "1");
            cargo.env("CARGO_TARGET_THUMBV7EM_NONE_EABIHF_LINKER", linker);
        }
    }

    /// What it calls itself.
    pub fn version(&self) -> Result<String, Failure> {
        let rustc = match self {
            Compiler::Installed => rustc_in_use(),
            Compiler::FromSource { rustc, .. } => Command::new(rustc),
        };
        version(rustc).ok_or_else(|| "the compiler does not tell its version".into())
    }

    /// Whether clippy can check with it: clippy belongs to one version of the compiler.
    pub fn has_clippy(&self) -> bool {
        *self == Compiler::Installed
    }
}

/// Finds or gets a way to compile for the boards: rustup's target, else Debian's compiler with its library's source.
pub fn compiler() -> Result<Compiler, Failure> {
    if has_target() {
        return Ok(Compiler::Installed);
    }
    eprintln!("installing the target {THUMB}");
    if run(Command::new("rustup").args(["target", "add", THUMB])).is_ok() && has_target() {
        return Ok(Compiler::Installed);
    }
    eprintln!("rustup could not: taking Debian's compiler and library source instead");
    from_source(&Machine::here())
        .map_err(|why| format!("the target {THUMB} is missing: type `rustup target add {THUMB}` ({why})"))
}

/// Debian's compiler, of the version that the workspace asks for or newer.
fn from_source(machine: &Machine) -> Result<Compiler, Failure> {
    let rustc = machine.private("rustc");
    let compiles = || {
        let source = output(Command::new(&rustc).args(["--print", "sysroot"]))
            .is_some_and(|sysroot| Path::new(&sysroot).join("lib/rustlib/src/rust/library/core").exists());
        source
            && version(Command::new(&rustc)).and_then(|version| minor(&version))
                >= minor(env!("CARGO_PKG_RUST_VERSION"))
    };
    if !compiles() {
        let packages = ["rustc-web", "rust-web-src"];
        machine.unpack(&Wanted { packages: &packages, programs: &[("usr/bin/rustc", "")] }, compiles)?;
    }
    linker(machine).map(|linker| Compiler::FromSource { rustc, linker })
}

/// The linker of the toolchain in use, else Debian's.
pub fn rust_lld() -> Result<PathBuf, Failure> {
    linker(&Machine::here())
}

fn linker(machine: &Machine) -> Result<PathBuf, Failure> {
    let of_toolchain = output(rustc_in_use().args(["--print", "sysroot"])).and_then(|sysroot| {
        let hosts = std::fs::read_dir(Path::new(&sysroot).join("lib/rustlib")).ok()?;
        hosts.flatten().map(|host| host.path().join("bin/rust-lld")).find(|path| path.exists())
    });
    let private = machine.private("ld.lld");
    let links = |linker: &Path| succeeds(machine.command(linker).arg("--version"));
    match of_toolchain {
        Some(linker) => Ok(linker),
        None if links("ld.lld".as_ref()) => Ok("ld.lld".into()),
        None if links(&private) => Ok(private),
        None => {
            let wanted = Wanted { packages: &["lld"], programs: &[("usr/bin/ld.lld", "")] };
            machine.unpack(&wanted, || links(&private)).map(|()| private.clone())
        }
    }
}

/// The emulator's command and, on Debian, its package.
const QEMU: &str = "qemu-system-arm";

/// Finds or gets QEMU for Arm: under `target/tools`, else on the search path, as the simulator does
/// (`link::qemu::emulator`); where neither has it, it comes to `target/tools`.
pub fn emulator() -> Result<PathBuf, Failure> {
    emulator_of(&Machine::here())
}

fn emulator_of(machine: &Machine) -> Result<PathBuf, Failure> {
    let private = machine.private(QEMU);
    let emulates = |program: &Path| {
        output(machine.command(program).args(["-M", "help"])).is_some_and(|boards| boards.contains("mps2-an500 "))
    };
    if let Some(program) = [private.clone(), QEMU.into()].into_iter().find(|program| emulates(program)) {
        return Ok(program);
    }
    let program = ("usr/bin/qemu-system-arm", "-L \"$root/usr/share/qemu\"");
    let wanted = Wanted { packages: &[QEMU], programs: &[program] };
    machine.unpack(&wanted, || emulates(&private)).map(|()| private.clone()).map_err(|why| {
        format!(
            "QEMU for Arm is missing and could not be unpacked from Debian's packages ({why}): install qemu-system-arm"
        )
    })
}

/// Makes sure that a part of the toolchain is there, rustfmt or clippy: a minimal toolchain has neither.
pub fn component(component: &str, verb: &str) -> Result<(), Failure> {
    let has = || succeeds(cargo().args([verb, "--version"]));
    if !has() {
        let _ = run(Command::new("rustup").args(["component", "add", component]));
    }
    if has() { Ok(()) } else { Err(format!("{component} is missing: type `rustup component add {component}`")) }
}

/// Whether the compiler in use has the library for the boards.
fn has_target() -> bool {
    has_library(THUMB)
}

/// Whether the compiler in use has the library of a target.
pub fn has_library(target: &str) -> bool {
    output(rustc_in_use().args(["--print", "target-libdir", "--target", target]))
        .and_then(|folder| std::fs::read_dir(folder).ok())
        .is_some_and(|files| files.flatten().any(|file| file.file_name().to_string_lossy().starts_with("libcore-")))
}

fn rustc_in_use() -> Command {
    let mut rustc = Command::new(env::var_os("RUSTC").unwrap_or_else(|| "rustc".into()));
    rustc.current_dir(places::root());
    rustc
}

fn version(mut rustc: Command) -> Option<String> {
    output(rustc.arg("--version"))
}

/// The second number of a version of Rust, whose first is 1.
fn minor(version: &str) -> Option<u32> {
    version.split_once("1.")?.1.split('.').next()?.parse().ok()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::debian::write_program;
    use std::fs;

    /// An apt that would have to remove a package of the user's, and so refuses to install; it downloads.
    const REFUSES: &str = r#"case "$*" in
*status=/dev/null*--simulate*)
    echo "Inst libc6 (2.36 Debian:12 [amd64])"; echo "Inst libfdt1 (1.6 Debian:12 [amd64])"
    echo "Inst qemu-system-arm (1:7.2 Debian:12 [amd64])" ;;
*" download libfdt1 qemu-system-arm") : > libfdt1.deb; : > qemu-system-arm.deb ;;
*) echo "E: Packages need to be removed but remove is disabled." >&2; exit 100 ;;
esac"#;
    /// One whose package lists are empty, until it has fetched some into a folder of the caller's.
    const EMPTY: &str = r#"case "$*" in
*Dir::State=*" update") : > state/lists/some ;;
*Dir::State=*) ;;
*) echo "E: Unable to locate package qemu-system-arm" >&2; exit 100 ;;
esac
"#;
    const OFFLINE: &str = r#"case "$*" in
*--simulate*) echo "Inst qemu-system-arm (1:7.2 Debian:12 [amd64])" ;;
*) echo "W: a warning" >&2; echo "E: Could not resolve 'deb.debian.org'" >&2; exit 100 ;;
esac"#;
    const DPKG_QUERY: &str = r#"echo "installed libc6"; echo "config-files libfdt1""#;
    /// Unpacks an emulator that starts with its library and its data alone.
    const DPKG: &str = r#"[ "$1" = -x ] || exit 1
case "$2" in
*libfdt1*) /bin/mkdir -p "$3/usr/lib/x86_64-linux-gnu"; : > "$3/usr/lib/x86_64-linux-gnu/libfdt" ;;
*) /bin/mkdir -p "$3/usr/bin" "$3/usr/share/qemu"
    printf '#!/bin/sh\n[ -f "${LD_LIBRARY_PATH%%%%:*}/libfdt" ] && [ -d "$2" ] && echo "mps2-an500 $3 $4"\n' > "$3/usr/bin/qemu-system-arm"
    /bin/chmod +x "$3/usr/bin/qemu-system-arm" ;;
esac"#;

    /// A machine whose search path holds these programs and no other.
    fn machine(name: &str, programs: &[(&str, &str)]) -> Machine {
        let folder = std::env::temp_dir().join(format!("xtask-{name}-{}", std::process::id()));
        let _ = fs::remove_dir_all(&folder);
        fs::create_dir_all(folder.join("path")).unwrap();
        for (program, script) in programs {
            write_program(&folder.join("path").join(program), &format!("#!/bin/sh\n{script}\n")).unwrap();
        }
        Machine { path: folder.join("path").into(), tools: folder.join("tools") }
    }

    fn emulator(name: &str, programs: &[(&str, &str)]) -> (Machine, Result<PathBuf, Failure>) {
        let machine = machine(name, programs);
        let found = emulator_of(&machine);
        (machine, found)
    }

    fn done(machine: &Machine) {
        fs::remove_dir_all(machine.tools.parent().unwrap()).unwrap();
    }

    #[test]
    fn an_emulator_on_the_search_path_is_taken() {
        let (machine, found) = emulator("path", &[(QEMU, "echo 'mps2-an500   a Cortex-M7'")]);
        assert_eq!(found, Ok(QEMU.into()));
        assert!(!machine.tools.exists(), "nothing was unpacked");
        done(&machine);
    }

    #[test]
    fn an_apt_that_refuses_still_gives_a_private_emulator() {
        for (name, apt) in [("refuses", REFUSES.to_owned()), ("empty", EMPTY.to_owned() + REFUSES)] {
            // An emulator that knows no such board, as an old one, is none.
            let programs = [(QEMU, "echo 'mps2-an385'"), ("apt-get", &apt), ("dpkg", DPKG), ("dpkg-query", DPKG_QUERY)];
            let (machine, found) = emulator(name, &programs);
            let private = machine.private(QEMU);
            assert_eq!(found.as_ref(), Ok(&private), "{name}");
            assert_eq!(machine.tools.join("apt/state/lists/some").exists(), name == "empty");
            fs::remove_file(Path::new(&machine.path).join("apt-get")).unwrap();
            assert_eq!(emulator_of(&machine), found, "the next time it is there");
            done(&machine);
        }
    }

    #[test]
    fn without_a_way_to_packages_there_is_one_sentence_with_the_reason() {
        let without = [("dpkg", DPKG), ("dpkg-query", DPKG_QUERY)];
        let offline = [&without[..], &[("apt-get", OFFLINE)]].concat();
        let broken = [("dpkg", "echo 'dpkg: error: no space left' >&2; exit 2"), without[1], ("apt-get", REFUSES)];
        for (name, programs, reason) in [
            ("none", &[][..], "apt-get: No such file"),
            ("offline", &offline, "apt-get: Could not resolve 'deb.debian.org'"),
            ("broken", &broken, "dpkg: dpkg: error: no space left"),
        ] {
            let (machine, found) = emulator(name, programs);
            let why = found.unwrap_err();
            assert!(
                why.contains(reason) && why.ends_with("install qemu-system-arm") && why.lines().count() == 1,
                "{why}"
            );
            let left = fs::read_dir(&machine.tools).unwrap().flatten().map(|file| file.file_name());
            assert_eq!(left.collect::<Vec<_>>(), ["apt"], "nothing half unpacked");
            done(&machine);
        }
    }

    #[test]
    fn versions_are_compared_by_their_second_number() {
        assert_eq!(minor("rustc 1.96.0 (ac68faa20 2026-05-25) (built from a source tarball)"), Some(96));
        assert!(minor(env!("CARGO_PKG_RUST_VERSION")) > minor("rustc 1.85.0"));
        assert_eq!(minor("2"), None);
    }
}
