//! Gives the images of each board their linker script. Host builds need none.

use std::env::var_os;
use std::path::PathBuf;

fn main() {
    println!("cargo:rerun-if-changed=build.rs");
    println!("cargo:rerun-if-changed=memory-an500.x");
    println!("cargo:rerun-if-changed=../memory.x");
    let is_bare_metal = var_os("CARGO_CFG_TARGET_OS").is_some_and(|os| os == "none");
    let Some(folder) = var_os("CARGO_MANIFEST_DIR").map(PathBuf::from) else { return };
    if !is_bare_metal {
        return;
    }
    let script = if has("AN500") {
        // By its whole path: the linker prefers files of the working directory to those of its search path.
        folder.join("memory-an500.x").display().to_string()
    } else {
        // cortex-m-rt's script, which includes the flight computer's memory.x from the workspace's root.
        println!("cargo:rustc-link-search={}", folder.join("..").display());
        "link.x".to_owned()
    };
    println!("cargo:rustc-link-arg-bins=-T{script}");
    println!("cargo:rustc-link-arg-bins=--nmagic");
    if has("DEFMT") {
        println!("cargo:rustc-link-arg-bins=-Tdefmt.x");
    }
}

/// Whether a feature of this package is on.
fn has(feature: &str) -> bool {
    var_os(format!("CARGO_FEATURE_{feature}")).is_some()
}
