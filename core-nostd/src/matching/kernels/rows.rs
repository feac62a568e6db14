//! Copying and filling rows, which are too short for a call of the library.

pub(crate) mod portable;
#[cfg(feature = "dsp")]
pub(crate) mod armv7em;

#[cfg(feature = "dsp")]
pub(in crate::matching) use armv7em::{copy, fill};
#[cfg(not(feature = "dsp"))]
pub(in crate::matching) use portable::{copy, fill};
