//! Where the vehicle is by its matches, apart from what its navigation says.
//!
//! An autopilot that flies on fixes has them in its position: that cannot judge the next one. What can is the last match, carried on
//! by the reported velocity ([`reckoning`]). [`tracks`] keeps the places where matches have put the vehicle, and says of the next
//! match whether it is to be believed.

pub mod reckoning;
pub mod tracks;
