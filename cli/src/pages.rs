//! The pages and files that commands leave behind for people to look at.

pub mod calibration;
pub mod evaluation;
pub mod flight;
pub mod plan;
pub mod refusals;
