//! When a message reaches the autopilot, and where on the map the positions are that a companion says.

use super::Autopilot;
use crate::noise::uniform;
use crate::vehicle::inertial::vision::Vision;
use plumbline_survey::crs::Crs;
use rand_chacha::ChaCha12Rng;

/// Shortest way of a message to the autopilot or back, and the mean of what it may wait beside, at most [`WAIT_MAX_US`]:
/// round trips from 1.6 to 13 ms were measured.
const WAY_US: f64 = 800.0;
const WAIT_MEAN_US: f64 = 1_200.0;
const WAIT_MAX_US: f64 = 5_700.0;
/// Metres of latitude in 1e-7 degrees (LOCATION_SCALING_FACTOR), by which it reckons its own frame.
const M_PER_E7: f64 = 0.011_131_884_502_145_034;

/// How long a message takes.
pub(super) fn way_us(waits: &mut ChaCha12Rng) -> u64 {
    let wait_us = -WAIT_MEAN_US * (1.0 - uniform(waits)).ln();
    (WAY_US + wait_us.min(WAIT_MAX_US)) as u64
}

impl Autopilot {
    /// When something that was sent at `at_us` arrives.
    pub fn arrival_us(&mut self, at_us: u64) -> u64 {
        at_us + way_us(&mut self.ways)
    }

    /// Where on the grid, east and north, a message says that the vehicle is; nothing before the autopilot has an origin.
    pub fn place_of(&self, message: &Vision, crs: &Crs) -> Option<[f64; 2]> {
        let (lat_e7, lon_e7, _) = self.origin?;
        let (north_m, east_m) = match message {
            Vision::Odometry(odometry) => (odometry.base.x, odometry.base.y),
            Vision::Position(position) => (position.base.x, position.base.y),
            Vision::Speed { .. } => return None,
        };
        let lat = f64::from(lat_e7) + f64::from(north_m) / M_PER_E7;
        // East goes by the cosine of the mean latitude.
        let middle_rad = (0.5e-7 * (lat + f64::from(lat_e7))).to_radians();
        let lon = f64::from(lon_e7) + f64::from(east_m) / (M_PER_E7 * middle_rad.cos());
        let (east, north) = crs.from_wgs84(1e-7 * lat, 1e-7 * lon).ok()?;
        (east.is_finite() && north.is_finite()).then_some([east, north])
    }
}
