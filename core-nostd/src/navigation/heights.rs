//! The height above ground: by the autopilot's altitude less the ground's elevation, by a laser range, and by the scale that matches
//! find.
//!
//! An altitude is off by a bias, since a barometer's zero moves and so does the datum of an elevation model, and by a scale, since
//! the air is not that of the standard atmosphere: H = (1 + k) a + b, where a is the altitude less the elevation. Both are
//! estimated by a Kalman filter of two states. What flies level cannot tell them apart; their sum is what counts, and its sigma is
//! right. A laser serves where it does not contradict what matches have found lately: one that sees a roof, that hangs or is
//! calibrated wrongly is found out by the picture's scale.
//!
//! Without an elevation model the ground is taken to be level, and b is the elevation as well: it begins with the first range, or, where
//! there has never been one, with the place that the vehicle took off from, and drifts with the way flown.
//!
//! Cost: some 200 instructions a frame.

use super::observed::Observed;
use crate::math::{hypot, sqrt, squared};
use crate::units::Micros;

/// An altitude as the autopilot reports it, and how it changes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Altitude {
    /// Of the report.
    pub at: Micros,
    /// Above the datum of the elevation model, as far as the autopilot knows, metres.
    pub metres: f32,
    /// Upwards, m/s.
    pub climb_m_per_s: f32,
    /// That of the place that it took off from, metres, where it is known.
    pub home_m: Option<f32>,
}

/// Oldest altitude that is carried on, microseconds.
const AGE_MAX_US: i32 = 2_000_000;
/// What the bias drifts by: in a second, as a random walk, of a barometer in gusts and turns; and in a metre flown, of ground under
/// an elevation model and of ground taken to be level. Chosen: an autopilot whose altitude follows satellites, and then a barometer
/// alone, moves it by some metres in ten seconds; slopes of 15 % are seldom exceeded.
const DRIFT_M_PER_ROOT_S: f32 = 1.0;
const DRIFT_BY_WAY: f32 = 0.01;
const DRIFT_BY_WAY_LEVEL: f32 = 0.15;
/// So far a slope goes on, metres: over a longer way without a frame the ground wanders by one after another. Chosen.
const SLOPE_M: f32 = 100.0;
/// Ground that is taken to be level wanders by no more than such a share of the height, one sigma: without a frame for minutes nothing else
/// would be known of it, and nothing could be found any more. Chosen: as far as pictures are tried with other scales.
const LEVEL_SHARE: f32 = 0.15;
/// A laser sees a spot, and the picture all of the ground around it: one sigma between the two, as a share of the height. Chosen:
/// half a metre at 100 m, as over fields and roads; over forest and roofs it is more, and the range is out of the gate.
const SPOT: f32 = 0.005;
/// One sigma of the scale of the map against the ground, and of what frames of the same ground share. Chosen: as [`SPOT`].
const MAP_SCALE: f32 = 0.005;
/// A range is out of the gate beyond so many sigmas. Chosen.
const SIGMAS: f32 = 4.0;
/// For so long after a match matches are what a laser is held against, microseconds.
const CONFIRMED_US: i32 = 3_000_000;
/// A height whose sigma is a larger share of it is none.
const SHARE_MAX: f32 = 0.3;
/// Consecutive scales that may not be, and agree with each other, after which they count and the range does not; and times that matches contradict
/// ranges one after another until these have been found out. Chosen: what is matched by chance has any scale, and an echo of a bird any range.
const REFUSED_MAX: u8 = 3;

/// A height above ground, metres, and its sigma.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Height {
    /// Of the camera above the ground at its nadir.
    pub metres: f32,
    /// One sigma.
    pub sigma_m: f32,
}

/// What is known of the altitude before any range or match, one sigma each.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Expected {
    /// Of the bias, metres.
    pub bias_m: f32,
    /// Of the scale.
    pub scale: f32,
    /// Whether the elevation of the ground is known.
    pub has_elevation: bool,
    /// Whether there has been a range.
    pub has_ranges: bool,
}

/// Bias and scale.
#[derive(Clone, Copy, Debug)]
struct Offset {
    bias_m: f32,
    scale: f32,
    /// Variances of the bias and the scale, and their covariance.
    bias_variance: f32,
    scale_variance: f32,
    both: f32,
    at: Micros,
}

impl Offset {
    /// Of what is this much above the ground when it is `ground_m` above the datum, and beforehand.
    fn above(self, ground_m: f32) -> Self {
        // H = (1 + k) (a - ground) + b = (1 + k) a + (b - (1 + k) ground).
        let both = -ground_m * self.scale_variance;
        Offset { bias_m: self.bias_m - ground_m, bias_variance: self.bias_variance - ground_m * both, both, ..self }
    }

    fn height(&self, above_m: f32) -> Height {
        let variance = self.bias_variance + above_m * (2.0 * self.both + above_m * self.scale_variance);
        let metres = above_m * (1.0 + self.scale) + self.bias_m;
        Height { metres, sigma_m: sqrt(variance.max(0.0)) }
    }

    /// A height was measured.
    fn measured(&mut self, above_m: f32, height_m: f32, variance: f32) {
        let expected = self.height(above_m);
        let by_bias = self.bias_variance + above_m * self.both;
        let by_scale = self.both + above_m * self.scale_variance;
        let all = squared(expected.sigma_m) + variance;
        let (bias, scale) = (by_bias / all, by_scale / all);
        let off = height_m - expected.metres;
        self.bias_m += bias * off;
        self.scale += scale * off;
        self.bias_variance -= bias * by_bias;
        self.both -= bias * by_scale;
        self.scale_variance -= scale * by_scale;
    }
}

/// What is known of the height.
#[derive(Clone, Copy, Debug, Default)]
pub struct Heights {
    altitude: Option<Altitude>,
    offset: Option<Offset>,
    /// When a match has found the scale last.
    confirmed_at: Option<Micros>,
    /// The bias that the last scale that may not be makes, and how many in a row have agreed with it.
    refused: Option<(f32, u8)>,
    /// The newest frame's range, and how often matches have contradicted ranges one after another. Once these have been found out so, they are until
    /// a match's own scale agrees with one: one that hangs does not come right where nothing is matched any more. Where nothing else says
    /// how high, a range counts all the same.
    range: Option<Height>,
    contradicted: u8,
}

impl Heights {
    /// Nothing known.
    pub const fn new() -> Self {
        Heights { altitude: None, offset: None, confirmed_at: None, refused: None, range: None, contradicted: 0 }
    }

    /// The autopilot reports its altitude.
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

    /// Bias and scale as they are known, or as they are beforehand: nothing where neither the ground's elevation is known nor that of the
    /// place that it took off from, which counts as long as no range has been there.
    fn offset(&self, at: Micros, expected: &Expected) -> Option<Offset> {
        let beforehand = || {
            if expected.has_elevation {
                return Some(expected.offset(at));
            }
            let home_m = self.altitude.filter(|_| !expected.has_ranges)?.home_m?;
            Some(expected.offset(at).above(home_m))
        };
        self.offset.or_else(beforehand)
    }

    /// The height without a range; nothing where it is not known at all, or hardly.
    pub fn known(&self, at: Micros, ground_m: f32, expected: &Expected) -> Option<Height> {
        let above_m = self.above_m(at, ground_m)?;
        let height = self.offset(at, expected)?.height(above_m);
        (height.sigma_m < SHARE_MAX * height.metres).then_some(height)
    }

    /// The height that a frame is rectified with, of a range's and what is known without: nothing where there is neither.
    pub fn best(&self, at: Micros, range: Option<Height>, ground_m: f32, expected: &Expected) -> Option<Height> {
        let Some(range) = range else { return self.known(at, ground_m, expected) };
        let Some(known) = self.known(at, ground_m, expected) else { return Some(range) };
        let spot = range.at_the_spot();
        match (self.counts(at, spot, known), expected.has_elevation) {
            (false, _) => Some(known),
            // The laser sees the ground as it is.
            (true, false) => Some(range),
            (true, true) => {
                let (own, other) = (squared(spot.sigma_m), squared(known.sigma_m));
                let metres = (range.metres * other + known.metres * own) / (own + other);
                Some(Height { metres, sigma_m: sqrt(own * other / (own + other)) })
            }
        }
    }

    /// Whether matches have found the scale lately.
    fn is_confirmed(&self, at: Micros) -> bool {
        self.confirmed_at.is_some_and(|seen_at| (0..=CONFIRMED_US).contains(&at.since(seen_at)))
    }

    /// Whether a range may be, against what matches have found lately, and ranges have not been found out.
    fn counts(&self, at: Micros, range: Height, known: Height) -> bool {
        self.contradicted < REFUSED_MAX && (!self.is_confirmed(at) || range.is_like(known))
    }

    /// A frame was taken, with this range, at so many m/s. To be called once for each.
    pub fn frame(&mut self, at: Micros, range: Option<Height>, (ground_m, m_per_s): (f32, f32), expected: &Expected) {
        if !expected.has_elevation {
            // From here on the ground is another one.
            self.offset = self.offset(at, expected);
        }
        let above_m = self.above_m(at, ground_m);
        if let Some(offset) = &mut self.offset {
            let seconds = at.since(offset.at).max(0) as f32 * 1e-6;
            let by_way = if expected.has_elevation { DRIFT_BY_WAY } else { DRIFT_BY_WAY_LEVEL };
            let way_m = m_per_s * seconds;
            let drift = squared(DRIFT_M_PER_ROOT_S) * seconds + squared(by_way) * way_m * way_m.min(SLOPE_M);
            let height = above_m.map(|above_m| offset.height(above_m)).filter(|_| !expected.has_elevation);
            let most = |height: Height| (squared(LEVEL_SHARE * height.metres) - squared(height.sigma_m)).max(0.0);
            offset.bias_variance += height.map_or(drift, |height| drift.min(most(height)));
            offset.at = at;
        }
        self.range = range.map(Height::at_the_spot);
        let Some((range, above_m)) = self.range.zip(above_m) else { return };
        let known = self.known(at, ground_m, expected);
        let is_confirmed = self.is_confirmed(at);
        if let Some(known) = known.filter(|_| is_confirmed && self.contradicted < REFUSED_MAX) {
            self.contradicted = if range.is_like(known) { 0 } else { self.contradicted + 1 };
        }
        match known {
            // Over ground that is not known a range that is wrong by little would take the bias along with it, slope by slope.
            Some(known) if is_confirmed && !expected.has_elevation || !self.counts(at, range, known) => {}
            Some(_) => {
                let mut offset = self.offset.unwrap_or(expected.offset(at));
                offset.measured(above_m, range.metres, squared(range.sigma_m));
                self.offset = Some(offset);
            }
            // The first one, or nothing else says how high.
            None => {
                self.contradicted = 0;
                let bias_m = range.metres - above_m;
                self.offset = Some(Offset { bias_m, bias_variance: squared(range.sigma_m), ..expected.offset(at) });
            }
        }
    }

    /// Whether a match may find the picture so much larger than the height `used` made it. Where some in a row may not, and agree
    /// with each other, they are what counts from then on, and the range does not.
    pub fn may_be(&mut self, at: Micros, used: Height, scale: Observed, ground_m: f32, expected: &Expected) -> bool {
        if scale.beside(MAP_SCALE).may_be(squared(used.at_the_spot().sigma_m / used.metres)) {
            self.refused = None;
            return true;
        }
        if let Some(above_m) = self.above_m(at, ground_m) {
            self.doubt(at, above_m, used.seen(scale), expected);
        }
        false
    }

    /// A match that counts has found it larger by so much.
    pub fn scaled(&mut self, at: Micros, used: Height, scale: Observed, ground_m: f32, expected: &Expected) {
        let Some(above_m) = self.above_m(at, ground_m) else { return };
        if let Some(mut offset) = self.offset(at, expected) {
            let seen = used.seen(scale);
            if self.range.is_some_and(|range| range.is_like(seen)) {
                self.contradicted = 0;
            }
            offset.measured(above_m, seen.metres, squared(seen.sigma_m));
            (self.offset, self.confirmed_at) = (Some(offset), Some(at));
        }
    }

    /// A scale that may not be: where some in a row agree, they are what is right.
    fn doubt(&mut self, at: Micros, above_m: f32, seen: Height, expected: &Expected) {
        let bias_m = seen.metres - above_m;
        let agrees = |(other_m, _): &(f32, u8)| (bias_m - other_m).abs() <= SIGMAS * seen.sigma_m;
        let count = self.refused.filter(agrees).map_or(1, |(_, count)| count + 1);
        self.refused = Some((bias_m, count));
        if count == REFUSED_MAX {
            let bias_variance = squared(seen.sigma_m);
            (self.refused, self.confirmed_at) = (None, Some(at));
            self.offset = Some(Offset { bias_m, bias_variance, ..expected.offset(at) });
        }
    }
}

impl Height {
    /// What a picture that is larger by so much makes of it.
    fn seen(self, scale: Observed) -> Height {
        let Observed { off, variance } = scale.beside(MAP_SCALE);
        Height { metres: self.metres * (1.0 + off), sigma_m: self.metres * sqrt(variance) }
    }

    /// Whether it and another may be the same.
    fn is_like(self, other: Height) -> bool {
        (self.metres - other.metres).abs() <= SIGMAS * hypot(self.sigma_m, other.sigma_m)
    }

    /// A range's, as the height of the ground around.
    fn at_the_spot(self) -> Height {
        Height { sigma_m: hypot(self.sigma_m, SPOT * self.metres), ..self }
    }
}

impl Expected {
    fn offset(&self, at: Micros) -> Offset {
        Offset {
            bias_m: 0.0,
            scale: 0.0,
            bias_variance: squared(self.bias_m),
            scale_variance: squared(self.scale),
            both: 0.0,
            at,
        }
    }
}

#[cfg(test)]
mod tests;
