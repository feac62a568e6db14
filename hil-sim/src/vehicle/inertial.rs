//! Inertial navigation: what an [`imu`] measures, the [`strapdown`] integration of it, the error-state [`filter`] that other
//! sensors correct, and the autopilot's [`estimator`] around it, which takes measurements late, by gates, as a real one does.
//!
//! Axes: north, east, down of the map's grid, and forward, right, down of the body. The Earth is flat and does not turn, for truth
//! and navigation alike: over the minutes of a flight its curvature and its 15°/h are below what the sensors are off by.

pub mod estimator;
pub mod filter;
pub mod imu;
pub mod strapdown;
pub mod vision;
