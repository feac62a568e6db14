//! `[navigation]`: a flight that is kept by its fixes. The vehicle flies where its autopilot believes to be, which has inertial
//! sensors, a barometer, a compass, satellite navigation as long as it lasts, and the firmware's fixes.

use super::bounds::Bounded;
use serde::{Deserialize, Serialize};

/// Latest second of a loss, as of faults.
const SECONDS_MAX: f64 = 1e9;
/// Most waypoints. Chosen: more than any flight over one reference needs.
const WAYPOINTS_MAX: usize = 1000;
/// Shortest leg, metres. Chosen: shorter ones have no course to be flown.
const LEG_MIN_M: f64 = 1.0;

/// Keys carry their units.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct Navigation {
    /// When satellite navigation is lost, seconds of the simulated time; never unless given.
    pub gnss_lost_s: Option<f64>,
    /// Quality of the inertial sensors.
    pub grade: Grade,
    /// East and north of the middle of the area that can be flown over, in turn and again from the first; a rectangle unless given.
    pub waypoints: Vec<[f64; 2]>,
    /// Largest bank that guidance asks for.
    pub bank_max_deg: f64,
    /// Mean wind.
    pub wind_m_s: f64,
    /// Where it comes from, clockwise from grid north.
    pub wind_from_deg: f64,
    /// Gusts along each axis, one sigma.
    pub gust_m_s: f64,
    /// Their time constant.
    pub gust_s: f64,
    /// White noise of satellite navigation's east, north and up each, one sigma.
    pub gnss_sigma_m: f64,
    /// Likewise of its velocity.
    pub gnss_velocity_sigma_m_s: f64,
    /// White noise of the barometer, one sigma.
    pub baro_sigma_m: f64,
    /// What it is off by.
    pub baro_bias_m: f64,
    /// Its height above the ground's base is multiplied by this.
    pub baro_scale: f64,
    /// Its drift, one sigma.
    pub baro_drift_m: f64,
    /// The drift's time constant.
    pub baro_drift_s: f64,
    /// White noise of the compass, one sigma.
    pub compass_sigma_deg: f64,
    /// What it is off by, clockwise.
    pub compass_bias_deg: f64,
    /// Its drift, one sigma.
    pub compass_drift_deg: f64,
    /// The drift's time constant.
    pub compass_drift_s: f64,
}

/// Quality of inertial sensors; the figures of each are in [`crate::vehicle::inertial::imu`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Grade {
    /// As in flight controllers.
    #[default]
    Consumer,
    /// As in guided vehicles.
    Tactical,
}

impl Default for Navigation {
    /// A calm day. Satellite navigation as u-blox states it of its M8 (2.5 m of 50 % of the positions, 0.05 m/s of 50 % of the
    /// velocities), rounded up to a sigma; barometer and compass are chosen: a pressure cell of some pascals, a compass near motors.
    fn default() -> Self {
        Navigation {
            gnss_lost_s: None,
            grade: Grade::Consumer,
            waypoints: Vec::new(),
            bank_max_deg: 20.0,
            wind_m_s: 0.0,
            wind_from_deg: 0.0,
            gust_m_s: 0.0,
            gust_s: 3.0,
            gnss_sigma_m: 2.0,
            gnss_velocity_sigma_m_s: 0.1,
            baro_sigma_m: 0.3,
            baro_bias_m: 0.0,
            baro_scale: 1.0,
            baro_drift_m: 0.5,
            baro_drift_s: 300.0,
            compass_sigma_deg: 1.0,
            compass_bias_deg: 0.0,
            compass_drift_deg: 1.0,
            compass_drift_s: 60.0,
        }
    }
}

impl Navigation {
    /// Each value that has bounds.
    pub(super) fn ranges(&self) -> Vec<Bounded> {
        let mut ranges = vec![
            ("navigation.gnss_lost_s", self.gnss_lost_s.unwrap_or(0.0), 0.0, SECONDS_MAX),
            ("navigation.bank_max_deg", self.bank_max_deg, 5.0, 60.0),
            ("navigation.wind_m_s", self.wind_m_s, 0.0, 100.0),
            ("navigation.wind_from_deg", self.wind_from_deg, -360.0, 360.0),
            ("navigation.gust_m_s", self.gust_m_s, 0.0, 30.0),
            ("navigation.gust_s", self.gust_s, 0.1, 1000.0),
            ("navigation.gnss_sigma_m", self.gnss_sigma_m, 0.01, 1000.0),
            ("navigation.gnss_velocity_sigma_m_s", self.gnss_velocity_sigma_m_s, 0.01, 100.0),
            ("navigation.baro_sigma_m", self.baro_sigma_m, 0.0, 100.0),
            ("navigation.baro_bias_m", self.baro_bias_m, -1000.0, 1000.0),
            ("navigation.baro_scale", self.baro_scale, 0.5, 2.0),
            ("navigation.baro_drift_m", self.baro_drift_m, 0.0, 100.0),
            ("navigation.baro_drift_s", self.baro_drift_s, 1.0, 1e6),
            ("navigation.compass_sigma_deg", self.compass_sigma_deg, 0.01, 90.0),
            ("navigation.compass_bias_deg", self.compass_bias_deg, -180.0, 180.0),
            ("navigation.compass_drift_deg", self.compass_drift_deg, 0.0, 90.0),
            ("navigation.compass_drift_s", self.compass_drift_s, 1.0, 1e6),
        ];
        ranges.extend(self.waypoints.iter().flatten().map(|m| ("navigation.waypoints", *m, -1e6, 1e6)));
        ranges
    }

    /// Checks the waypoints as such.
    ///
    /// # Errors
    /// The message; the caller puts the file's name before it.
    pub(super) fn check(&self) -> Result<(), String> {
        let count = self.waypoints.len();
        if count == 1 || count > WAYPOINTS_MAX {
            return Err(format!("navigation.waypoints has {count} points; it takes 2 to {WAYPOINTS_MAX}, or none"));
        }
        let next = self.waypoints.iter().cycle().skip(1);
        let is_short = |(a, b): &(&[f64; 2], &[f64; 2])| (a[0] - b[0]).hypot(a[1] - b[1]) < LEG_MIN_M;
        match self.waypoints.iter().zip(next).find(is_short) {
            Some(([east, north], _)) => Err(format!(
                "navigation.waypoints has [{east}, {north}] twice in succession: {LEG_MIN_M} m are the least"
            )),
            None => Ok(()),
        }
    }
}
