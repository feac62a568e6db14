//! `[land]` and `[changes]`: what procedural land is like, and what has happened to it since the reference was made.

use super::bounds::Bounded;
use serde::{Deserialize, Serialize};

/// What the land is like, in frames and in the reference.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct Land {
    /// Side of square parcels that are all alike, metres; 0 leaves the land as it is.
    pub parcel_m: f64,
    /// Period of stripes that run north, metres; 0 leaves the land as it is.
    pub stripe_m: f64,
    /// Share of parcels or stripes in a grey value; the rest is the land's own. 1 is copies and nothing else.
    pub repeats: f64,
    /// Share of the area that is water, in lakes.
    pub water_fraction: f64,
}

impl Default for Land {
    fn default() -> Self {
        Land { parcel_m: 0.0, stripe_m: 0.0, repeats: 1.0, water_fraction: 0.0 }
    }
}

impl Land {
    /// Whether all of it repeats.
    #[must_use]
    pub fn has_pattern(&self) -> bool {
        self.parcel_m > 0.0 || self.stripe_m > 0.0
    }

    pub(super) fn ranges(&self) -> [Bounded; 4] {
        [
            ("land.parcel_m", self.parcel_m, 0.0, 1000.0),
            ("land.stripe_m", self.stripe_m, 0.0, 1000.0),
            ("land.repeats", self.repeats, 0.0, 1.0),
            ("land.water_fraction", self.water_fraction, 0.0, 1.0),
        ]
    }
}

/// What frames show otherwise than the reference does. Fractions are of the fields, each drawn by itself.
#[derive(Debug, Clone, Copy, PartialEq, Default, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct Changes {
    /// Where the sun stands in frames, clockwise from grid north; where it stands in the reference unless given.
    pub sun_azimuth_deg: Option<f64>,
    /// How high it stands in frames; as high as in the reference unless given.
    pub sun_elevation_deg: Option<f64>,
    /// Fields with other crops: another brightness, their rows turned by a right angle.
    pub ploughed_fraction: f64,
    /// Fields under water: dark and featureless.
    pub flooded_fraction: f64,
    /// Fields whose greys are mirrored about a middle one: what was darker than others is brighter.
    pub inverted_fraction: f64,
    /// What the season does to each kind of land.
    pub season: Season,
}

/// Gain and offset (DN) of each kind of land.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct Season {
    /// Ploughed fields and stubble.
    pub bare: [f64; 2],
    /// Cereals and row crops.
    pub crops: [f64; 2],
    /// Meadows, orchards and gardens.
    pub meadow: [f64; 2],
    /// Woods and single trees.
    pub trees: [f64; 2],
}

impl Default for Season {
    fn default() -> Self {
        let same = [1.0, 0.0];
        Season { bare: same, crops: same, meadow: same, trees: same }
    }
}

impl Changes {
    pub(super) fn ranges(&self) -> Vec<Bounded> {
        let season = &self.season;
        let mut ranges = vec![
            ("changes.sun_azimuth_deg", self.sun_azimuth_deg.unwrap_or(0.0), -360.0, 360.0),
            // Lower, shadows are longer than the land is wide.
            ("changes.sun_elevation_deg", self.sun_elevation_deg.unwrap_or(90.0), 5.0, 90.0),
            ("changes.ploughed_fraction", self.ploughed_fraction, 0.0, 1.0),
            ("changes.flooded_fraction", self.flooded_fraction, 0.0, 1.0),
            ("changes.inverted_fraction", self.inverted_fraction, 0.0, 1.0),
        ];
        let kinds = [
            ("changes.season.bare", season.bare),
            ("changes.season.crops", season.crops),
            ("changes.season.meadow", season.meadow),
            ("changes.season.trees", season.trees),
        ];
        for (key, [gain, offset_dn]) in kinds {
            ranges.extend([(key, gain, -10.0, 10.0), (key, offset_dn, -1000.0, 1000.0)]);
        }
        ranges
    }
}
