//! What is in the air and on the water at an instant: clouds and haze between camera and ground, and waves, which no two frames
//! show alike. A ray has met the ground and knows its grey; what is passed on the way is laid over it.

mod clouds;
mod waves;

use crate::scenario::{self, Land};
use clouds::Clouds;
use waves::Waves;

/// The weather of a flight.
#[derive(Clone, Debug, Default)]
pub struct Weather {
    clouds: Option<Clouds>,
    waves: Option<Waves>,
    /// Share of the air's own light, and its grey.
    haze: [f64; 2],
}

/// The weather of one frame.
#[derive(Clone, Debug, Default)]
pub struct Moment<'w> {
    clouds: Option<clouds::Now<'w>>,
    waves: Option<waves::Now<'w>>,
    haze: [f64; 2],
}

impl Weather {
    /// As the scenario says; lakes are those of the procedural ground of this seed.
    pub fn new(seed: u64, weather: &scenario::Weather, land: &Land) -> Self {
        Weather {
            clouds: (weather.cloud_fraction > 0.0).then(|| Clouds::new(seed, weather)),
            waves: (land.water_fraction > 0.0).then(|| Waves::new(seed, land.water_fraction)),
            haze: [weather.haze, weather.airlight_dn],
        }
    }

    /// That of frame `frame`, taken at `at_s`, by a camera over ground of height `ground_m`.
    pub fn at(&self, frame: u64, at_s: f64, ground_m: f64) -> Moment<'_> {
        Moment {
            clouds: self.clouds.as_ref().map(|clouds| clouds.at(at_s, ground_m)),
            waves: self.waves.as_ref().map(|waves| waves.at(frame)),
            haze: self.haze,
        }
    }
}

impl Moment<'_> {
    /// Lays it over what rays from `origin` have `seen` that meet the ground so far `along` their directions. What is not known
    /// (NaN) stays so.
    pub(crate) fn pass(&self, origin: [f64; 3], directions: &[[f64; 3]], along: &[f64], seen: &mut [f64]) {
        if let Some(waves) = &self.waves {
            waves.pass(origin, directions, along, seen);
        }
        let [haze, airlight] = self.haze;
        if haze > 0.0 {
            seen.iter_mut().for_each(|seen| *seen += haze * (airlight - *seen));
        }
        if let Some(clouds) = &self.clouds {
            clouds.pass(origin, directions, seen);
        }
    }
}

#[cfg(test)]
mod tests;
