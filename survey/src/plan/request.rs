//! What is to be planned.

use super::area::Area;
use super::combinations::Limits;
use super::course::Follow;
use super::intersect::Sigmas;
use super::lines::Overlaps;

/// Area, height, camera, overlaps, limits.
#[derive(Debug, Clone)]
pub struct Request {
    /// Working metres.
    pub area: Area,
    /// Height above the base plane.
    pub height_m: f64,
    /// Tangents of half of what every photo sees, along and across ([`super::visible`]), whatever its tilt of up to [`Self::tilt_deg`].
    pub half_tangent: [f64; 2],
    /// Tangent of a pixel, along and across.
    pub tangent_per_px: [f64; 2],
    /// The overlaps; `None` has them chosen.
    pub overlaps: Option<Overlaps>,
    /// The strips' heading, degrees; `None` has it chosen by the time of flight.
    pub heading_deg: Option<f64>,
    /// Speed, interval, accuracy.
    pub limits: Limits,
    /// Noise of measuring; its image part in tangents.
    pub sigmas: Sigmas,
    /// Length of an exposure.
    pub exposure_s: f64,
    /// Least height above the ground along strips and turns that counts as safe.
    pub min_clearance_m: f64,
    /// Seed of the simulated noise.
    pub seed: u64,
    /// Tilt that was allowed for, to either side.
    pub tilt_deg: f64,
    /// How the flying height follows the ground; `None` is one height for all.
    pub follow: Option<Follow>,
}
