//! Flight lines on real terrain by simulated adjustment (paper 004).

pub mod area;
pub mod axes;
pub mod base_height;
pub mod cells;
pub mod checks;
mod clearance;
pub mod combinations;
pub mod constant;
pub mod course;
pub mod export;
pub mod file;
pub mod flown;
pub mod follow;
pub mod footprint;
mod horizon;
pub mod intersect;
pub mod lines;
pub mod model_file;
mod outcome;
pub mod overlap;
mod pair;
pub mod place;
pub mod planner;
pub mod terrain;
mod request;
mod swath;
pub mod sight;
pub mod simulate;
pub mod visible;

pub use file::PlanFile;
pub use model_file::ModelFile;
pub use planner::Planned;
pub use request::Request;

#[cfg(test)]
mod tests;
