//! Gives the images of each board their linker script. Host builds need none.

use std::env::var_os;
use std::path::PathBuf;

/// Images of the flight computer, and where in flash each begins: bare, and behind the camera's bootloader.
const PROFILES: [(&str, u32); 2] = [("h743", 0x0800_0000), ("h743-dfu", 0x0804_0000)];

fn main() {
    println!("cargo:rerun-if-changed=build.rs");
    println!("cargo:rerun-if-changed=memory-an500.x");
    println!("cargo:rerun-if-changed=link-h743.x");
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
        for (image, origin) in PROFILES {
            println!("cargo:rustc-link-arg-bin={image}=--defsym=_flash_origin={origin:#010x}");
        }
    }
    println!("cargo:rustc-link-arg-bins=--nmagic");
    if has("DEFMT") || has("H743") {
        println!("cargo:rustc-link-arg-bins=-Tdefmt.x");
    }
}

/// Whether a feature of this package is on.
fn has(feature: &str) -> bool {
    var_os(format!("CARGO_FEATURE_{feature}")).is_some()
}
