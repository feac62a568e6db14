//! Where the vehicle is by its matches, apart from what its navigation says.
//!
//! An autopilot that flies on fixes has them in its position: that cannot judge the next one. What can is the last match, carried on
//! by the reported velocity ([`reckoning`]). [`tracks`] keeps the places where matches have put the vehicle, and says of the next
//! match whether it is to be believed.

pub mod observed;
pub mod azimuth;
pub mod heights;
pub mod candidates;
pub mod reckoning;
pub mod filter;
pub mod protection;
pub mod surface;
pub mod tracks;
pub mod velocity;

use crate::elevation::Plane;
use azimuth::Azimuth;
use filter::Filter;
use heights::Heights;
use surface::Surface;
use tracks::Tracks;
use velocity::VelocityError;

/// What is known from one frame to the next. It belongs to the caller, as the pipeline's buffers do.
#[derive(Debug)]
pub struct Navigation {
    /// The places.
    pub tracks: Tracks,
    /// How far the heading is off.
    pub azimuth: Azimuth,
    /// How high the camera is.
    pub heights: Heights,
    /// How far the velocity is off, by the way between two matches.
    pub velocity: VelocityError,
    /// Where all frames together put it.
    pub surface: Surface,
    /// How far attitude and velocity are off.
    pub filter: Filter,
    /// The ground under the newest frame, where there is an elevation model.
    pub plane: Option<Plane>,
    /// The autopilot's estimator has lost or found satellites a moment ago.
    pub is_changing: bool,
    /// Frames since something was found: which of the candidates is next.
    pub candidate: u8,
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
            filter: Filter::new(),
            is_changing: false,
            candidate: 0,
        }
    }
}

impl Default for Navigation {
    fn default() -> Self {
        Navigation::new()
    }
}
