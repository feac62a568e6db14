//! The pages and files that commands leave behind for people to look at.

pub mod boresight;
pub mod calibration;
pub mod evaluation;
pub mod flight;
pub mod plan;
pub mod refusals;
pub mod reproduction;
mod scatter;
mod tile;
