//! How far the reported heading is off, by the turn that matches find.
//!
//! A compass is off by what the iron around it makes of the field: steady as long as the vehicle flies one way, and another one when it
//! has turned. So the error is a Gauss-Markov process over time and over the angle turned, whose sigma the settings state. What
//! matches find is the turn of the picture about the plumb line; an error of the follow-up angle looks the same, and is taken for it.
//!
//! Cost: some 60 instructions a frame.

use super::observed::Observed;
use crate::math::squared;
use crate::units::{Micros, Radians};

/// Time, and angle turned, over which the error becomes another one, seconds and radians. Chosen: half a minute as the drift of an
/// attitude, a radian as a dipole's field along the vehicle's axes.
const TIME_S: f32 = 30.0;
const TURN_RAD: f32 = 1.0;
/// One sigma of the turn of the map against the ground, and of what frames of the same ground share, radians. Chosen: a pixel over the
/// length of a patch of 64 would be 0.016, its least squares find a tenth of that.
const MAP_RAD: f32 = 0.002;
/// Consecutive turns that may not be after which nothing is known of the error any more.
const REFUSED_MAX: u8 = 5;

/// The error of the azimuth: what is reported less what is true, radians.
#[derive(Clone, Copy, Debug, Default)]
pub struct Azimuth {
    off_rad: f32,
    variance: f32,
    newest: Option<(Micros, Radians)>,
    refused: u8,
}

impl Azimuth {
    /// Nothing known.
    pub const fn new() -> Self {
        Azimuth { off_rad: 0.0, variance: 0.0, newest: None, refused: 0 }
    }

    /// The error, radians.
    pub fn off_rad(&self) -> f32 {
        self.off_rad
    }

    /// Its variance.
    pub fn variance(&self) -> f32 {
        self.variance
    }

    /// Carried on to an instant at which this heading is reported. `sigma_rad`: of the error where nothing is known of it.
    #[must_use]
    pub fn at(self, at: Micros, heading: Radians, sigma_rad: f32) -> Self {
        let keeps = |(before, was): (Micros, Radians)| {
            let seconds = at.since(before).max(0) as f32 * 1e-6;
            let turned = Radians(heading.0 - was.0).wrapped().0.abs();
            1.0 / (1.0 + seconds / TIME_S + turned / TURN_RAD)
        };
        let kept = self.newest.map_or(0.0, keeps);
        Azimuth {
            off_rad: kept * self.off_rad,
            variance: squared(kept) * self.variance + (1.0 - squared(kept)) * squared(sigma_rad),
            newest: Some((at, heading)),
            ..self
        }
    }

    /// How far clockwise from the heading less [`Azimuth::off_rad`] a match is that finds the picture turned by so much from what the
    /// heading `used` made of it.
    fn beyond(&self, used: Radians, turn: Observed, sigma_rad: f32) -> Observed {
        let reported = self.newest.map_or(used.0 + self.off_rad, |(_, heading)| heading.0);
        let off = Radians(used.0 + turn.off - (reported - self.off_rad)).wrapped().0;
        Observed { off, ..turn }.beside(sigma_rad).beside(MAP_RAD)
    }

    /// Whether a match may find the picture turned clockwise by so much from what the heading `used` made of it. Where it often may
    /// not, nothing is known of the error any more. `sigma_rad`: what is new in every frame beside the error.
    pub fn may_be(&mut self, used: Radians, turn: Observed, sigma_rad: f32) -> bool {
        let may_be = self.beyond(used, turn, sigma_rad).may_be(self.variance);
        self.refused = if may_be { 0 } else { self.refused + 1 };
        if self.refused == REFUSED_MAX {
            *self = Azimuth::new();
        }
        may_be
    }

    /// A match that counts has found it turned by so much.
    pub fn turned(&mut self, used: Radians, turn: Observed, sigma_rad: f32) {
        let turn = self.beyond(used, turn, sigma_rad);
        let gain = self.variance / (self.variance + turn.variance);
        // True is further clockwise: less is reported beyond it.
        self.off_rad -= gain * turn.off;
        self.variance = ((1.0 - gain) * self.variance).max(squared(MAP_RAD).min(self.variance));
    }
}

#[cfg(test)]
mod tests {
    use super::Azimuth;
    use crate::navigation::observed::Observed;
    use crate::units::{Micros, Radians};

    /// A compass that is off by so much; what is thought of it after so many frames, four a second.
    fn after(frames: u32, off_rad: f32, sigma_rad: f32) -> (Azimuth, u32) {
        let (mut azimuth, mut refused) = (Azimuth::new(), 0);
        for frame in 0..frames {
            azimuth = azimuth.at(Micros(250_000 * u64::from(frame)), Radians(1.0), sigma_rad);
            // What flies north-east reports more than that, and is rectified with less again.
            let used = Radians(1.0 - azimuth.off_rad());
            let turn = Observed { off: 1.0 - off_rad - used.0, variance: 1e-5 };
            if azimuth.may_be(used, turn, 0.002) {
                azimuth.turned(used, turn, 0.002);
            } else {
                refused += 1;
            }
        }
        (azimuth, refused)
    }

    #[test]
    fn an_error_within_its_sigma_is_found() {
        let (azimuth, refused) = after(20, -0.17, 0.09);
        assert_eq!(refused, 0);
        assert!((azimuth.off_rad() + 0.17).abs() < 0.01, "{azimuth:?}");
        assert!(azimuth.variance() < 0.01 * 0.01);
    }

    #[test]
    fn an_error_beyond_is_refused_for_ever() {
        let (azimuth, refused) = after(40, 0.17, 0.01);
        assert_eq!(refused, 40);
        assert_eq!(azimuth.off_rad(), 0.0);
    }

    #[test]
    fn a_vehicle_that_turns_knows_less_of_it() {
        let (azimuth, _) = after(20, 0.1, 0.09);
        let turned = azimuth.at(Micros(6_000_000), Radians(-2.0), 0.09);
        assert!(turned.variance() > 0.09 * 0.09 * 0.9 && turned.off_rad() < 0.03, "{turned:?}");
    }
}
