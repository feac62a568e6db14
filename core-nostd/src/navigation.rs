//! Where the vehicle is by its matches, apart from what its navigation says.
//!
//! An autopilot that flies on fixes has them in its position: that cannot judge the next one. What can is the last match, carried on
//! by the reported velocity ([`reckoning`]). [`tracks`] keeps the places where matches have put the vehicle, and says of the next
//! match whether it is to be believed.

pub mod reckoning;
pub mod tracks;

use tracks::Tracks;

/// What is known from one frame to the next. It belongs to the caller, as the pipeline's buffers do.
#[derive(Debug)]
pub struct Navigation {
    /// The places.
    pub tracks: Tracks,
}

impl Navigation {
    /// Nothing known yet.
    pub const fn new() -> Self {
        Navigation { tracks: Tracks::new() }
    }
}

impl Default for Navigation {
    fn default() -> Self {
        Navigation::new()
    }
}
