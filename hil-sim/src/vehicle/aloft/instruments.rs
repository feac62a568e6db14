//! The sensors beside the inertial one: satellite navigation, barometer, compass.

use crate::noise::{GaussMarkov, White};
use crate::scenario::Navigation;
use crate::vehicle::inertial::estimator::Measurement;
use crate::vehicle::inertial::strapdown::Inertial;
use crate::vehicle::servo::wrapped;
use nalgebra::Vector3;

/// From one position of satellite navigation to the next: GPS_RATE_MS.
pub(super) const GNSS_US: u64 = 200_000;
/// From one value of barometer and compass to the next: what ArduPilot's filter takes at most.
pub(super) const SLOW_US: u64 = 100_000;

/// Whether something that comes each `interval_us` comes at `at_us`.
pub(super) fn is_due(interval_us: u64, at_us: u64) -> bool {
    at_us.is_multiple_of(interval_us)
}

/// The sensors of one flight.
#[derive(Clone, Debug)]
pub(super) struct Instruments {
    navigation: Navigation,
    base_up_m: f64,
    gnss_place: [White; 3],
    gnss_velocity: [White; 3],
    baro: White,
    baro_drift: GaussMarkov,
    compass: White,
    compass_drift: GaussMarkov,
}

impl Instruments {
    pub(super) fn new(navigation: &Navigation, base_up_m: f64, seed: u64) -> Self {
        let white = |sigma: f64, name: &str| White::new(sigma, seed, name);
        let three = |sigma: f64, names: [&str; 3]| names.map(|name| white(sigma, name));
        Instruments {
            base_up_m,
            gnss_place: three(navigation.gnss_sigma_m, ["gnss.north", "gnss.east", "gnss.down"]),
            gnss_velocity: three(
                navigation.gnss_velocity_sigma_m_s,
                ["gnss.velocity.north", "gnss.velocity.east", "gnss.velocity.down"],
            ),
            baro: white(navigation.baro_sigma_m, "baro"),
            baro_drift: GaussMarkov::new(navigation.baro_drift_m, navigation.baro_drift_s, seed, "baro.drift"),
            compass: white(navigation.compass_sigma_deg.to_radians(), "compass"),
            compass_drift: GaussMarkov::new(
                navigation.compass_drift_deg.to_radians(),
                navigation.compass_drift_s,
                seed,
                "compass.drift",
            ),
            navigation: navigation.clone(),
        }
    }

    /// What the filter is to take the compass' sigma for: its drift is alike in many values, and counts as often as it is.
    pub(super) fn heading_sigma_rad(&self) -> f64 {
        let navigation = &self.navigation;
        let alike = 2e6 * navigation.compass_drift_s / SLOW_US as f64;
        let drift_deg = navigation.compass_drift_deg * alike.max(1.0).sqrt();
        navigation.compass_sigma_deg.hypot(drift_deg).to_radians()
    }

    pub(super) fn gnss(&mut self, now: &Inertial) -> Measurement {
        let off = |noise: &mut [White; 3]| Vector3::from(noise.each_mut().map(White::draw));
        let place = now.place_m + off(&mut self.gnss_place);
        let velocity_m_s = now.velocity_m_s + off(&mut self.gnss_velocity);
        Measurement::Gnss { place_m: [place.x, place.y], velocity_m_s }
    }

    /// Barometer and compass.
    pub(super) fn slow(&mut self, now: &Inertial, at_us: u64) -> [Measurement; 2] {
        let navigation = &self.navigation;
        let height_m = -now.place_m.z - self.base_up_m;
        let off_m = navigation.baro_bias_m + self.baro_drift.at(at_us) + self.baro.draw();
        let up_m = self.base_up_m + height_m * navigation.baro_scale + off_m;
        let off_rad = navigation.compass_bias_deg.to_radians() + self.compass_drift.at(at_us) + self.compass.draw();
        let [heading_rad, ..] = now.angles_rad();
        [Measurement::Down(-up_m), Measurement::Heading(wrapped(heading_rad + off_rad))]
    }
}
