//! Wind: a mean, and gusts whose spectrum is Dryden's along the flight, which is that of a first-order Gauss-Markov process
//! (MIL-F-8785C), here along each axis alike.

use super::Air;
use crate::noise::GaussMarkov;
use crate::scenario::Navigation;

/// What a gust of 1 m/s turns the wings by, radians a second, and for how long: its gradient over a span of 2 m, of gusts as large as
/// that. Chosen: 3°/s.
const ROLL_OF_GUST: f64 = 3.0 * std::f64::consts::PI / 180.0;
const ROLL_GUST_S: f64 = 0.5;
/// Gusts up and down are weaker near the ground. Chosen: half.
const VERTICAL: f64 = 0.5;

/// The wind of one flight.
#[derive(Clone, Debug)]
pub struct Wind {
    mean_m_s: [f64; 3],
    gusts: [GaussMarkov; 3],
    roll: GaussMarkov,
}

impl Wind {
    /// The scenario's.
    #[must_use]
    pub fn new(navigation: &Navigation, seed: u64) -> Self {
        let (sin, cos) = navigation.wind_from_deg.to_radians().sin_cos();
        let (speed, gust) = (navigation.wind_m_s, navigation.gust_m_s);
        let along = |name: &str, strength: f64| GaussMarkov::new(strength, navigation.gust_s, seed, name);
        Wind {
            mean_m_s: [-speed * sin, -speed * cos, 0.0],
            gusts: [along("wind.east", gust), along("wind.north", gust), along("wind.up", VERTICAL * gust)],
            roll: GaussMarkov::new(ROLL_OF_GUST * gust, ROLL_GUST_S, seed, "wind.roll"),
        }
    }

    /// Where it goes to without gusts: east, north, up.
    #[must_use]
    pub fn mean_m_s(&self) -> [f64; 3] {
        self.mean_m_s
    }

    /// At `at_us`, not before the instant asked for last.
    pub fn at(&mut self, at_us: u64) -> Air {
        let gusts = self.gusts.each_mut().map(|gust| gust.at(at_us));
        Air { wind_m_s: std::array::from_fn(|axis| self.mean_m_s[axis] + gusts[axis]), roll_rad_s: self.roll.at(at_us) }
    }
}
