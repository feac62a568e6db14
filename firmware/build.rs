//! Gives the images of each board their linker script. Host builds need none.

use std::env::var_os;
use std::fs;
use std::path::{Path, PathBuf};

/// Images of the flight computer, and whether each lies behind the camera's bootloader; memory.x knows where that is.
const PROFILES: [(&str, u32); 2] = [("h743", 0), ("h743-dfu", 1)];

fn main() {
    println!("cargo:rerun-if-changed=build.rs");
    println!("cargo:rerun-if-changed=memory-an500.x");
    println!("cargo:rerun-if-changed=link-h743.x");
    println!("cargo:rerun-if-changed=hot.txt");
    println!("cargo:rerun-if-changed=../memory.x");
    let is_bare_metal = var_os("CARGO_CFG_TARGET_OS").is_some_and(|os| os == "none");
    let Some(folder) = var_os("CARGO_MANIFEST_DIR").map(PathBuf::from) else { return };
    if !is_bare_metal {
        return;
    }
    // Scripts by their whole path: the linker prefers files of the working directory to those of its search path.
    let script = if has("H743") { "link-h743.x" } else { "memory-an500.x" };
    println!("cargo:rustc-link-arg-bins=-T{}", folder.join(script).display());
    if has("H743") {
        // It includes memory.x from the workspace's root.
        println!("cargo:rustc-link-search={}", folder.join("..").display());
        let Some(out) = var_os("OUT_DIR").map(PathBuf::from) else { return };
        write_hot(&folder.join("hot.txt"), &out.join("hot.x"));
        println!("cargo:rustc-link-search={}", out.display());
        for (image, is_behind) in PROFILES {
            println!("cargo:rustc-link-arg-bin={image}=--defsym=_behind_bootloader={is_behind}");
        }
    }
    println!("cargo:rustc-link-arg-bins=--nmagic");
    if has("DEFMT") || has("H743") {
        println!("cargo:rustc-link-arg-bins=-Tdefmt.x");
    }
}

/// Writes the linker's patterns of what lies in tightly coupled memory. Both ways of mangling put a name's length before it.
fn write_hot(list: &Path, script: &Path) {
    let mangled = |path: &str| path.split("::").map(|name| format!("{}{name}", name.len())).collect::<String>();
    let list = fs::read_to_string(list).expect("hot.txt is beside build.rs");
    let paths = list.lines().filter(|line| !line.starts_with('#'));
    let patterns: String = paths.map(|path| format!("*(.text.*14plumbline_core{}*);\n", mangled(path))).collect();
    fs::write(script, patterns).expect("OUT_DIR can be written");
}

/// Whether a feature of this package is on.
fn has(feature: &str) -> bool {
    var_os(format!("CARGO_FEATURE_{feature}")).is_some()
}
