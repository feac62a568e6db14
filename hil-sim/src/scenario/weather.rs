//! `[weather]`: what stands between the camera and the ground.

use super::bounds::Bounded;
use serde::{Deserialize, Serialize};

/// Clouds below the vehicle, which drift, and haze.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct Weather {
    /// Share of the sight from above that clouds cover.
    pub cloud_fraction: f64,
    /// How high the layer lies above the ground under the vehicle. From below it nothing is seen of it.
    pub cloud_height_m: f64,
    /// About how wide a cloud is, and a gap.
    pub cloud_size_m: f64,
    /// Drift, metres a second, east and north.
    pub cloud_wind_m_s: [f64; 2],
    /// Grey of a cloud.
    pub cloud_dn: f64,
    /// Share of the light that comes from the air and not from the ground.
    pub haze: f64,
    /// Grey of the air.
    pub airlight_dn: f64,
}

impl Default for Weather {
    /// No clouds and no haze. A layer of low fog patches, with a fresh breeze (5 Beaufort is 8 to 10.7 m/s); greys of a bright
    /// sky, as beyond the horizon.
    fn default() -> Self {
        Weather {
            cloud_fraction: 0.0,
            cloud_height_m: 60.0,
            cloud_size_m: 30.0,
            cloud_wind_m_s: [8.0, 3.0],
            cloud_dn: 230.0,
            haze: 0.0,
            airlight_dn: 200.0,
        }
    }
}

impl Weather {
    pub(super) fn ranges(&self) -> Vec<Bounded> {
        let mut ranges = vec![
            ("weather.cloud_fraction", self.cloud_fraction, 0.0, 1.0),
            ("weather.cloud_height_m", self.cloud_height_m, 0.1, 1e5),
            ("weather.cloud_size_m", self.cloud_size_m, 1.0, 1e4),
            ("weather.cloud_dn", self.cloud_dn, 0.0, 255.0),
            ("weather.haze", self.haze, 0.0, 1.0),
            ("weather.airlight_dn", self.airlight_dn, 0.0, 255.0),
        ];
        ranges.extend(self.cloud_wind_m_s.map(|rate| ("weather.cloud_wind_m_s", rate, -100.0, 100.0)));
        ranges
    }
}
