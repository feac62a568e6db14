//! The inner loops of the matcher, each group in a portable version and one for Armv7E-M: see [`crate::arch`].

pub(crate) mod correlation;
pub(crate) mod gradients;
pub(crate) mod high_pass;
pub(crate) mod least_squares;
pub(crate) mod rows;
pub(crate) mod signs;
