//! The algorithm of Plumbline: what happens between a shutter edge and a position fix.
//!
//! A camera that looks down from a tilted vehicle is rectified onto the ground plane at the resolution of a reference
//! orthophoto, matched against it, and the offset becomes a position fix. The source is Zhang et al., "Automatic
//! geometric rectification model of follow-up system" (J. Remote Sensing 9(4), 2005), called *the paper* here; its
//! equations appear in corrected form, and each departure is stated where it is made.
//!
//! No `std`, no allocation, no hardware, no clock: data in, data out, buffers belong to the caller. The modules are
//! declared in the order of the flow, and each uses only what is declared before it, as a test of the source code checks.
//!
//! All arithmetic is IEEE single precision or integer, every transcendental function goes through [`math`]: host,
//! emulator and board give the same bits.
#![no_std]
#![deny(unsafe_code)]

#[cfg(all(feature = "dsp", not(target_arch = "arm")))]
compile_error!("the feature `dsp` is for Armv7E-M: its kernels are assembly of that architecture");

mod packed;
mod arch;
pub mod math;
pub mod units;
pub mod tilt;
pub mod frames;
pub mod image;
pub mod budget;
pub mod camera;
pub mod stamp;
pub mod pose;
pub mod mount;
pub mod homography;
pub mod motion;
pub mod reduce;
pub mod rectify;
pub mod matching;
pub mod tile;
pub mod fix;
pub mod exposure;
pub mod pipeline;
#[cfg(feature = "dsp")]
#[doc(hidden)]
pub mod selftest;
