//! Least-squares adjustment of bundles of rays (papers 002 and 004).
//!
//! 1. [`Model`]: the unknowns (stations, heads, points), and each observation's residual with its analytic derivatives.
//!    [`Rig`] is the camera of several heads.
//! 2. [`Adjustment`]: normal equations with the points eliminated (Schur complement), sparse Cholesky (faer), Gauss-Newton
//!    that is damped where a step does not help, squares or Huber's loss.
//! 3. [`Cofactors`]: covariances, redundancies, and whether the unknowns are determined at all.
//!
//! Everything is in `f64`, radians, metres and pixels. The numbers are the same whatever the number of cores; machines of
//! other instruction sets may differ in the last digits.

pub mod bal;
mod covariance;
mod error;
mod lens;
mod loss;
mod model;
mod normal;
mod pattern;
pub mod rig;
pub mod rotation;
mod solve;
mod weakest;

pub use covariance::{Cofactors, OfPoint, Redundancy};
pub use error::SolveError;
pub use lens::{INTERIOR, INTERIOR_NAMES, Imaged, Interior};
pub use loss::{Loss, Moments};
pub use model::{At, HEAD_MAX, Link, Model, Place, Prior, Row, STATION_MAX, Structure};
pub use rig::{Rig, STATION_NAMES};
pub use solve::{Adjustment, Options, Solution};

#[cfg(test)]
mod tests;
