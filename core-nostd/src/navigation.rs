//! Position of the vehicle by its matches, independent of the autopilot's.
//!
//! The position of an autopilot that flies on fixes contains these, so it cannot be used to judge the next one. The last match can,
//! propagated by the reported velocity ([`reckoning`]). [`tracks`] keeps the candidate positions by matches, and decides whether the
//! next match is accepted.

pub mod observed;
pub mod azimuth;
pub mod heights;
pub mod candidates;
pub mod reckoning;
pub mod protection;
pub mod filter;
pub mod surface;
pub mod departure;
pub mod tracks;
pub mod velocity;

use crate::elevation::Plane;
use azimuth::Azimuth;
use departure::Departure;
use filter::Filter;
use heights::Heights;
use surface::Surface;
use tracks::Tracks;
use velocity::VelocityError;

/// What is known from one frame to the next. It belongs to the caller, as the pipeline's buffers do.
#[derive(Debug)]
pub struct Navigation {
    /// Candidate positions.
    pub tracks: Tracks,
    /// Error of the heading.
    pub azimuth: Azimuth,
    /// How high the camera is.
    pub heights: Heights,
    /// Error of the velocity, from the displacement between two matches.
    pub velocity: VelocityError,
    /// Log-likelihood surface of the nadir over several key frames.
    pub surface: Surface,
    /// Matches that depart together from the prediction.
    pub departure: Departure,
    /// How far attitude and velocity are off.
    pub filter: Filter,
    /// The ground under the newest frame, where there is an elevation model.
    pub plane: Option<Plane>,
    /// The autopilot's estimator has lost or found satellites a moment ago.
    pub is_changing: bool,
    /// Frames since the last match: the number of the next candidate.
    pub candidate: u8,
    /// Frames begun since the last match, refused ones as well.
    pub begun: u8,
}

impl Navigation {
    /// Nothing known yet.
    pub const fn new() -> Self {
        Navigation {
            plane: None,
            tracks: Tracks::new(),
            azimuth: Azimuth::new(),
            heights: Heights::new(),
            velocity: VelocityError::new(),
            surface: Surface::new(),
            departure: Departure::new(),
            filter: Filter::new(),
            is_changing: false,
            candidate: 0,
            begun: 0,
        }
    }
}

impl Default for Navigation {
    fn default() -> Self {
        Navigation::new()
    }
}
