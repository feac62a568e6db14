//! Flight lines on real terrain by simulated adjustment (paper 004).

pub mod file;

pub use file::PlanFile;
