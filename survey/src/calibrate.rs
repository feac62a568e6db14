//! Platform calibration of a camera of several heads by constrained bundle adjustment (paper 002), and of what a camera of
//! one head needs besides.
//!
//! [`Block`] and [`Observations`] are the files, checked key by key and line by line; [`check`] tells what they cannot
//! determine; [`Calibration`] adjusts and judges; [`Symmetrised`] is the virtual camera; [`seam`] how far the heads put one
//! direction apart in it. [`boresight`] is how a camera of one head sits in its vehicle, from a flight's fixes.

mod axes;
mod block;
pub mod boresight;
mod check;
mod fields;
mod file;
pub mod mounts;
mod observations;
mod result;
pub mod seam;
mod symmetrise;

pub use block::{Block, PointPrior, Sizes, StationPrior};
pub use check::check;
pub use file::{Calibrated, camera_file};
pub use observations::Observations;
pub use result::{Calibration, Correlation, HeadUnknown, OUTLIER_SIGMAS, Residual, unknown_name};
pub use symmetrise::{Symmetrised, mount, picture};
