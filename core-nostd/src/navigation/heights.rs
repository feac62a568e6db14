//! Height above ground: from the autopilot's altitude less the ground's elevation, from a laser range, and from the scale of matches.
//!
//! An altitude has a bias, since a barometer's zero and the elevation model's datum are off, and a scale error, since the air is not the
//! standard atmosphere: H = (1 + k) a + b, with a the altitude less the elevation. A Kalman filter of two states estimates both. In level
//! flight they are not observable separately; their sum is, and its sigma is right. A range is used unless it contradicts recent matches: a
//! laser that sees a roof, repeats its last value or is miscalibrated is detected by the picture's scale.
//!
//! Without an elevation model the ground is taken to be level, and b includes its elevation: initialised by the first range, or, where
//! there has never been one, by the take-off position, with process noise that grows with the distance flown.
//!
//! Cost: some 200 instructions a frame.

use super::observed::Observed;
use crate::math::{hypot, sqrt, squared};
use crate::units::Micros;

/// An altitude of the autopilot, and its rate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Altitude {
    /// Instant of the report.
    pub at: Micros,
    /// Above the datum of the elevation model as far as the autopilot knows, metres.
    pub metres: f32,
    /// Climb rate, upwards, m/s.
    pub climb_m_per_s: f32,
    /// Altitude of the take-off position, metres, where it is known.
    pub home_m: Option<f32>,
}

/// Oldest altitude that is extrapolated, microseconds.
const AGE_MAX_US: i32 = 2_000_000;
/// Process noise of the bias: of a barometer in gusts and turns, a random walk, metres a root second; of ground under an elevation model
/// and of ground taken to be level, metres a metre flown. Chosen: an autopilot that changes from satellites to the barometer moves its
/// altitude by some metres in ten seconds; slopes of 15 % are seldom exceeded.
const DRIFT_M_PER_ROOT_S: f32 = 1.0;
const DRIFT_BY_WAY: f32 = 0.01;
const DRIFT_BY_WAY_LEVEL: f32 = 0.15;
/// Length of a slope, metres: over a longer distance without a frame slopes are independent of each other. Chosen.
const SLOPE_M: f32 = 100.0;
/// Largest sigma of ground that is taken to be level, as a share of the height: minutes without a frame must leave enough to find a match.
/// Chosen: the range of scales that are tried.
const LEVEL_SHARE: f32 = 0.15;
/// Difference of a laser's spot to the mean ground of a picture, one sigma, as a share of the height. Chosen: half a metre at 100 m, as
/// over fields and roads; over forest and roofs it is more, and the range is outside the gate.
const SPOT_SHARE: f32 = 0.005;
/// Scale error of the map, common to frames of the same ground, one sigma. Chosen: as [`SPOT_SHARE`].
const MAP_SCALE_SIGMA: f32 = 0.005;
/// Gate of a range, sigmas. Chosen.
const SIGMAS: f32 = 4.0;
/// Time after a match for which its height decides on ranges, microseconds.
const CONFIRMED_US: i32 = 3_000_000;
/// Largest relative sigma of a usable height.
const SHARE_MAX: f32 = 0.3;
/// So many consecutive refused scales that agree with each other replace the state and exclude the range; after so many consecutive
/// contradictions between matches and ranges the ranges are ignored. Chosen: chance matches have any scale, and an echo of a bird any range.
const REFUSED_MAX: u8 = 3;

/// Height above ground.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Height {
    /// Of the camera above the ground at its nadir, metres.
    pub metres: f32,
    /// One sigma.
    pub sigma_m: f32,
}

/// What is known of the altitude before any range or match.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AltitudePrior {
    /// One sigma of the bias, metres.
    pub bias_m: f32,
    /// One sigma of the scale.
    pub scale: f32,
    /// Whether the elevation of the ground is known.
    pub has_elevation: bool,
    /// Whether there has been a range.
    pub has_ranges: bool,
}

/// State of the Kalman filter: bias and scale error of the altitude.
#[derive(Clone, Copy, Debug)]
struct AltitudeError {
    bias_m: f32,
    scale: f32,
    /// Variances of bias and scale, and their covariance.
    bias_variance: f32,
    scale_variance: f32,
    covariance: f32,
    at: Micros,
}

impl AltitudeError {
    /// Moves the state's reference from `ground_m` above the datum to the datum; for a prior, whose scale error is 0.
    fn above(self, ground_m: f32) -> Self {
        // H = (1 + k) (a - ground) + b = (1 + k) a + (b - (1 + k) ground).
        let covariance = -ground_m * self.scale_variance;
        AltitudeError {
            bias_m: self.bias_m - ground_m,
            bias_variance: self.bias_variance - ground_m * covariance,
            covariance,
            ..self
        }
    }

    fn height(&self, above_m: f32) -> Height {
        let variance = self.bias_variance + above_m * (2.0 * self.covariance + above_m * self.scale_variance);
        let metres = above_m * (1.0 + self.scale) + self.bias_m;
        Height { metres, sigma_m: sqrt(variance.max(0.0)) }
    }

    /// Update by a measured height.
    fn update(&mut self, above_m: f32, height_m: f32, variance: f32) {
        let expected = self.height(above_m);
        let by_bias = self.bias_variance + above_m * self.covariance;
        let by_scale = self.covariance + above_m * self.scale_variance;
        let all = squared(expected.sigma_m) + variance;
        let (bias, scale) = (by_bias / all, by_scale / all);
        let off = height_m - expected.metres;
        self.bias_m += bias * off;
        self.scale += scale * off;
        self.bias_variance -= bias * by_bias;
        self.covariance -= bias * by_scale;
        self.scale_variance -= scale * by_scale;
    }
}

/// Estimates of the height.
#[derive(Clone, Copy, Debug, Default)]
pub struct Heights {
    altitude: Option<Altitude>,
    offset: Option<AltitudeError>,
    /// Instant of the last match with a scale.
    confirmed_at: Option<Micros>,
    /// Bias by the last refused scale, and how many in a row agree with it.
    refused: Option<(f32, u8)>,
    /// Range of the newest frame, and the number of consecutive matches that contradict ranges. After [`REFUSED_MAX`] ranges are ignored
    /// until a match's scale agrees with one, since a frozen laser does not recover while nothing is matched. Where there is no other
    /// height a range is used nevertheless.
    range: Option<Height>,
    contradicted: u8,
}

impl Heights {
    /// Nothing known.
    pub const fn new() -> Self {
        Heights { altitude: None, offset: None, confirmed_at: None, refused: None, range: None, contradicted: 0 }
    }

    /// Takes an altitude of the autopilot.
    pub fn reported(&mut self, altitude: Altitude) {
        if altitude.metres.is_finite() && altitude.climb_m_per_s.is_finite() {
            self.altitude = Some(altitude);
        }
    }

    /// Altitude above the elevation `ground_m` at an instant.
    fn above_m(&self, at: Micros, ground_m: f32) -> Option<f32> {
        let altitude = self.altitude?;
        let age_us = at.since(altitude.at);
        let above_m = altitude.metres + altitude.climb_m_per_s * age_us as f32 * 1e-6 - ground_m;
        (age_us.abs() <= AGE_MAX_US).then_some(above_m)
    }

    /// The state, or its prior; `None` where neither the ground's elevation nor that of the take-off position is known. The latter counts
    /// as long as there has been no range.
    fn offset(&self, at: Micros, expected: &AltitudePrior) -> Option<AltitudeError> {
        let beforehand = || {
            if expected.has_elevation {
                return Some(expected.offset(at));
            }
            let home_m = self.altitude.filter(|_| !expected.has_ranges)?.home_m?;
            Some(expected.offset(at).above(home_m))
        };
        self.offset.or_else(beforehand)
    }

    /// Height without a range; `None` where it is unknown or too uncertain.
    pub fn known(&self, at: Micros, ground_m: f32, expected: &AltitudePrior) -> Option<Height> {
        let above_m = self.above_m(at, ground_m)?;
        let height = self.offset(at, expected)?.height(above_m);
        (height.sigma_m < SHARE_MAX * height.metres).then_some(height)
    }

    /// Height to rectify a frame with, from its range and the altitude; `None` without either.
    pub fn best(&self, at: Micros, range: Option<Height>, ground_m: f32, expected: &AltitudePrior) -> Option<Height> {
        let Some(range) = range else { return self.known(at, ground_m, expected) };
        let Some(known) = self.known(at, ground_m, expected) else { return Some(range) };
        let spot = range.with_spot_noise();
        match (self.is_range_valid(at, spot, known), expected.has_elevation) {
            (false, _) => Some(known),
            // The laser measures the ground itself.
            (true, false) => Some(range),
            (true, true) => {
                let (own, other) = (squared(spot.sigma_m), squared(known.sigma_m));
                let metres = (range.metres * other + known.metres * own) / (own + other);
                Some(Height { metres, sigma_m: sqrt(own * other / (own + other)) })
            }
        }
    }

    /// Whether a match has found the scale within [`CONFIRMED_US`].
    fn is_confirmed(&self, at: Micros) -> bool {
        self.confirmed_at.is_some_and(|seen_at| (0..=CONFIRMED_US).contains(&at.since(seen_at)))
    }

    /// Whether a range is plausible against recent matches, and ranges are not ignored.
    fn is_range_valid(&self, at: Micros, range: Height, known: Height) -> bool {
        self.contradicted < REFUSED_MAX && (!self.is_confirmed(at) || range.agrees(known))
    }

    /// Updates the state by a frame's range, and propagates it by time and distance (speed in m/s). To be called once a frame.
    pub fn frame(
        &mut self,
        at: Micros,
        range: Option<Height>,
        (ground_m, m_per_s): (f32, f32),
        expected: &AltitudePrior,
    ) {
        if !expected.has_elevation {
            // From here on the take-off position is not below any more.
            self.offset = self.offset(at, expected);
        }
        let above_m = self.above_m(at, ground_m);
        if let Some(offset) = &mut self.offset {
            let seconds = at.since(offset.at).max(0) as f32 * 1e-6;
            let by_way = if expected.has_elevation { DRIFT_BY_WAY } else { DRIFT_BY_WAY_LEVEL };
            let distance_m = m_per_s * seconds;
            let drift = squared(DRIFT_M_PER_ROOT_S) * seconds + squared(by_way) * distance_m * distance_m.min(SLOPE_M);
            let height = above_m.map(|above_m| offset.height(above_m)).filter(|_| !expected.has_elevation);
            let most = |height: Height| (squared(LEVEL_SHARE * height.metres) - squared(height.sigma_m)).max(0.0);
            offset.bias_variance += height.map_or(drift, |height| drift.min(most(height)));
            offset.at = at;
        }
        self.range = range.map(Height::with_spot_noise);
        let Some((range, above_m)) = self.range.zip(above_m) else { return };
        let known = self.known(at, ground_m, expected);
        let is_confirmed = self.is_confirmed(at);
        if let Some(known) = known.filter(|_| is_confirmed && self.contradicted < REFUSED_MAX) {
            self.contradicted = if range.agrees(known) { 0 } else { self.contradicted + 1 };
        }
        match known {
            // Over unknown ground a range with a small error would pull the bias along, slope by slope.
            Some(known) if is_confirmed && !expected.has_elevation || !self.is_range_valid(at, range, known) => {}
            Some(_) => {
                let mut offset = self.offset.unwrap_or(expected.offset(at));
                offset.update(above_m, range.metres, squared(range.sigma_m));
                self.offset = Some(offset);
            }
            // The first range, or no other height.
            None => {
                self.contradicted = 0;
                let bias_m = range.metres - above_m;
                self.offset =
                    Some(AltitudeError { bias_m, bias_variance: squared(range.sigma_m), ..expected.offset(at) });
            }
        }
    }

    /// Whether a match's scale is plausible: how much larger than expected from the height `used` it finds the picture. Some consecutive
    /// refused ones that agree with each other replace the state, and the range is not used.
    pub fn is_plausible(
        &mut self,
        at: Micros,
        used: Height,
        scale: Observed,
        ground_m: f32,
        expected: &AltitudePrior,
    ) -> bool {
        if scale.with_sigma(MAP_SCALE_SIGMA).is_plausible(squared(used.with_spot_noise().sigma_m / used.metres)) {
            self.refused = None;
            return true;
        }
        if let Some(above_m) = self.above_m(at, ground_m) {
            self.count_refused(at, above_m, used.rescaled(scale), expected);
        }
        false
    }

    /// Updates the state by the scale of an accepted match.
    pub fn update_scale(&mut self, at: Micros, used: Height, scale: Observed, ground_m: f32, expected: &AltitudePrior) {
        let Some(above_m) = self.above_m(at, ground_m) else { return };
        if let Some(mut offset) = self.offset(at, expected) {
            let seen = used.rescaled(scale);
            if self.range.is_some_and(|range| range.agrees(seen)) {
                self.contradicted = 0;
            }
            offset.update(above_m, seen.metres, squared(seen.sigma_m));
            (self.offset, self.confirmed_at) = (Some(offset), Some(at));
        }
    }

    /// Counts a refused scale; some in a row that agree replace the state.
    fn count_refused(&mut self, at: Micros, above_m: f32, seen: Height, expected: &AltitudePrior) {
        let bias_m = seen.metres - above_m;
        let agrees = |(other_m, _): &(f32, u8)| (bias_m - other_m).abs() <= SIGMAS * seen.sigma_m;
        let count = self.refused.filter(agrees).map_or(1, |(_, count)| count + 1);
        self.refused = Some((bias_m, count));
        if count == REFUSED_MAX {
            let bias_variance = squared(seen.sigma_m);
            (self.refused, self.confirmed_at) = (None, Some(at));
            self.offset = Some(AltitudeError { bias_m, bias_variance, ..expected.offset(at) });
        }
    }
}

impl Height {
    /// Height by the scale that a match finds.
    fn rescaled(self, scale: Observed) -> Height {
        let Observed { off, variance } = scale.with_sigma(MAP_SCALE_SIGMA);
        Height { metres: self.metres * (1.0 + off), sigma_m: self.metres * sqrt(variance) }
    }

    /// Whether two heights agree within the gate.
    fn agrees(self, other: Height) -> bool {
        (self.metres - other.metres).abs() <= SIGMAS * hypot(self.sigma_m, other.sigma_m)
    }

    /// A range as the mean height of the ground around.
    fn with_spot_noise(self) -> Height {
        Height { sigma_m: hypot(self.sigma_m, SPOT_SHARE * self.metres), ..self }
    }
}

impl AltitudePrior {
    fn offset(&self, at: Micros) -> AltitudeError {
        AltitudeError {
            bias_m: 0.0,
            scale: 0.0,
            bias_variance: squared(self.bias_m),
            scale_variance: squared(self.scale),
            covariance: 0.0,
            at,
        }
    }
}

#[cfg(test)]
mod tests;
