//! The algorithm of Plumbline: what happens between a shutter edge and a position fix.
//!
//! A camera that looks down from a tilted vehicle is rectified onto the ground plane at the resolution of a reference
//! orthophoto, matched against it, and the offset becomes a position fix. The source is Zhang et al., "Automatic
//! geometric rectification model of follow-up system" (J. Remote Sensing 9(4), 2005), called *the paper* here; its
//! equations appear in corrected form, and each departure is stated where it is made.
//!
//! No `std`, no allocation, no hardware, no clock: data in, data out, buffers belong to the caller. The modules stand
//! in the order of the flow, and each uses only what stands before it:
//!
//! [`units`] [`lanes`] [`math`] [`frames`] [`budget`] → [`camera`] → [`stamp`] → [`pose`] → [`tilt`] → [`mount`] →
//! [`homography`] → [`motion`] → [`reduce`] → [`rectify`] → [`matching`] (search, refine, judge) → [`tile`] → [`fix`] →
//! [`exposure`] → [`pipeline`].
//!
//! All arithmetic is IEEE single precision or integer, every transcendental function goes through [`math`]: host,
//! emulator and board give the same bits.
#![no_std]
#![deny(unsafe_code)]

pub mod budget;
pub mod camera;
#[allow(unsafe_code, reason = "instructions that only assembly can name")]
pub mod dsp;
pub mod exposure;
pub mod fix;
pub mod frames;
pub mod homography;
#[allow(unsafe_code, reason = "instructions that only assembly can name")]
pub mod lanes;
pub mod matching;
pub mod math;
pub mod motion;
pub mod mount;
pub mod pipeline;
pub mod pose;
pub mod rectify;
pub mod reduce;
pub mod stamp;
pub mod tile;
pub mod tilt;
pub mod units;
