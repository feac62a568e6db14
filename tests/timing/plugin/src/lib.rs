//! A plugin for QEMU's Arm emulation that counts what marked regions of a program cost.
//!
//! A region begins at the instruction `DBG #1` and ends at `DBG #2`. Both do nothing on the architecture, so the same
//! code runs on silicon. Inside a region instructions are counted by class ([`decode`]) and priced ([`model`]); reads
//! and writes of the external memory go through a data cache ([`cache`]). A line is written for every region, in the
//! order in which they end ([`regions`]). Nothing depends on the host or on time: two runs write the same file.
//!
//! | module | what |
//! |---|---|
//! | [`decode`] | Thumb-2 encodings to classes |
//! | [`model`] | classes to cycles: floor and serial estimate |
//! | [`cache`] | lines fetched from the external memory |
//! | [`regions`] | counting between the markers |
//! | [`image`] | the program's bytes |
//! | `plugin` | QEMU's side: what it calls, and what is called of it |
//!
//! Arguments: `image=ELF` (the program that QEMU runs) and `out=FILE` (what is written).

pub mod cache;
pub mod decode;
pub mod image;
pub mod model;
pub mod regions;

// What QEMU exports is there only when QEMU loads the library: tests and other systems do without.
#[cfg(all(target_os = "linux", not(test)))]
mod plugin;
