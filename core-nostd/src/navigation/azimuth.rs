//! Error of the reported heading, from the rotation that matches find.
//!
//! A compass is off by the magnetic field of the iron around it: constant on one heading, and different after a turn. So the error is a
//! Gauss-Markov process over time and over the angle turned, with the configured sigma. Matches find the rotation of the picture about the
//! plumb line; an error of the follow-up angle looks the same, and is taken for it.
//!
//! Cost: some 60 instructions a frame.

use super::observed::Observed;
use crate::math::squared;
use crate::units::{Micros, Radians};

/// Time constant and angle constant of the process, seconds and radians. Chosen: half a minute as the drift of an attitude, a radian as the
/// field of a dipole along the vehicle's axes.
const TIME_S: f32 = 30.0;
const TURNED_RAD: f32 = 1.0;
/// Rotation of the map against the ground, common to frames of the same ground, one sigma, radians. Chosen: a pixel over the length of a
/// patch of 64 would be 0.016, of which least squares find a tenth.
const MAP_SIGMA_RAD: f32 = 0.002;
/// Consecutive refused rotations after which the estimate is reset.
const REFUSED_MAX: u8 = 5;

/// Estimate of the heading's error, reported less true, radians.
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

    /// The error, radians, reported less true.
    pub fn off_rad(&self) -> f32 {
        self.off_rad
    }

    /// Its variance, square radians.
    pub fn variance(&self) -> f32 {
        self.variance
    }

    /// Propagated to an instant with its reported heading. `sigma_rad`: stationary sigma of the error.
    #[must_use]
    pub fn at(self, at: Micros, heading: Radians, sigma_rad: f32) -> Self {
        let keeps = |(before, was): (Micros, Radians)| {
            let seconds = at.since(before).max(0) as f32 * 1e-6;
            let turned = Radians(heading.0 - was.0).wrapped().0.abs();
            1.0 / (1.0 + seconds / TIME_S + turned / TURNED_RAD)
        };
        let kept = self.newest.map_or(0.0, keeps);
        Azimuth {
            off_rad: kept * self.off_rad,
            variance: squared(kept) * self.variance + (1.0 - squared(kept)) * squared(sigma_rad),
            newest: Some((at, heading)),
            ..self
        }
    }

    /// Innovation of a match, clockwise: the heading that it finds, `used` plus its rotation, less the corrected reported one.
    fn innovation(&self, used: Radians, turn: Observed, sigma_rad: f32) -> Observed {
        let reported = self.newest.map_or(used.0 + self.off_rad, |(_, heading)| heading.0);
        let off = Radians(used.0 + turn.off - (reported - self.off_rad)).wrapped().0;
        Observed { off, ..turn }.with_sigma(sigma_rad).with_sigma(MAP_SIGMA_RAD)
    }

    /// Whether a match's rotation, clockwise against the heading `used`, is plausible. Several refused ones in a row reset the estimate.
    /// `sigma_rad`: white noise of the heading besides the error.
    pub fn is_plausible(&mut self, used: Radians, turn: Observed, sigma_rad: f32) -> bool {
        let is_plausible = self.innovation(used, turn, sigma_rad).is_plausible(self.variance);
        self.refused = if is_plausible { 0 } else { self.refused + 1 };
        if self.refused == REFUSED_MAX {
            *self = Azimuth::new();
        }
        is_plausible
    }

    /// Update by the rotation of an accepted match.
    pub fn update(&mut self, used: Radians, turn: Observed, sigma_rad: f32) {
        let turn = self.innovation(used, turn, sigma_rad);
        let gain = self.variance / (self.variance + turn.variance);
        // A true heading further clockwise means a smaller error.
        self.off_rad -= gain * turn.off;
        self.variance = ((1.0 - gain) * self.variance).max(squared(MAP_SIGMA_RAD).min(self.variance));
    }
}

#[cfg(test)]
mod tests {
    use super::Azimuth;
    use crate::navigation::observed::Observed;
    use crate::units::{Micros, Radians};

    /// The estimate of a constant error after so many frames, four a second, and the number of refused rotations.
    fn after(frames: u32, off_rad: f32, sigma_rad: f32) -> (Azimuth, u32) {
        let (mut azimuth, mut refused) = (Azimuth::new(), 0);
        for frame in 0..frames {
            azimuth = azimuth.at(Micros(250_000 * u64::from(frame)), Radians(1.0), sigma_rad);
            // The frame is rectified with the corrected heading.
            let used = Radians(1.0 - azimuth.off_rad());
            let turn = Observed { off: 1.0 - off_rad - used.0, variance: 1e-5 };
            if azimuth.is_plausible(used, turn, 0.002) {
                azimuth.update(used, turn, 0.002);
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
