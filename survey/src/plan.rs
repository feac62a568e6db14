//! Flight lines on real terrain by simulated adjustment (paper 004).

pub mod area;
pub mod axes;
pub mod base_height;
pub mod cells;
pub mod checks;
pub mod combinations;
pub mod constant;
pub mod file;
pub mod flown;
pub mod geojson;
mod horizon;
pub mod intersect;
pub mod lines;
mod outcome;
pub mod overlap;
pub mod place;
pub mod planner;
pub mod relief;
pub mod sight;
pub mod simulate;

pub use file::PlanFile;
pub use planner::{Planned, Request};

#[cfg(test)]
mod tests;
