//! Single instructions of the processor that the compiler does not find by itself, each with a portable version that
//! gives the same bits.
//!
//! Longer kernels stand beside their users (`reduce/kernels`, `rectify/kernels`, `matching/kernels`) in the same way:
//! `portable.rs` is always compiled and defines the result, `armv7em.rs` is compiled with the feature `dsp`, and the module
//! above both exports the one that the machine can run. The feature decides because the target's name does not tell whether
//! the processor has the DSP extension of Armv7E-M (Cortex-M4, Cortex-M7). [`crate::selftest`] compares the two versions.

pub(crate) mod portable;
#[cfg(feature = "dsp")]
pub(crate) mod armv7em;

#[cfg(feature = "dsp")]
pub(crate) use armv7em::{add_bytes, clamp_bytes, difference, dot, opaque, sqrt};
#[cfg(not(feature = "dsp"))]
pub(crate) use portable::{add_bytes, clamp_bytes, difference, dot, opaque, sqrt};
