//! The figures of several flights together.

use super::flight::{Fix, Flown};
use crate::bootstrap;
use plumbline_sim::score::protection::{Placed, protection, radii};
use std::cmp::Reverse;
use std::collections::BTreeMap;

/// Within this time from a fault's end fixes are to come again, seconds.
pub const AGAIN_S: f64 = 2.0;
/// Squared errors of two degrees of freedom that 1 % of normal ones exceed, and five sigmas.
pub const TAILS: [f64; 2] = [9.21, 25.0];

/// The fixes of several flights.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Fixes {
    /// Flights.
    pub flights: usize,
    /// Frames.
    pub frames: usize,
    /// Fixes.
    pub fixes: usize,
    /// Of these wrong ones.
    pub wrong: usize,
    /// Of these beyond the protection level.
    pub beyond: usize,
    /// The largest error, pixels.
    pub largest_px: f64,
    /// Root mean square error, pixels.
    pub rms_px: f64,
    /// Median of the stated sigmas, pixels.
    pub sigma_px: f64,
    /// Mean squared error over the covariance, two degrees of freedom.
    pub nees: f64,
    /// Fixes beyond each of [`TAILS`].
    pub tails: [usize; 2],
    /// Ends of faults, and behind how many of them there was a fix within [`AGAIN_S`].
    pub again: [usize; 2],
    /// The longest time from an end to a fix, seconds; infinite where there was none.
    pub again_s: f64,
    /// Frames without a fix by the reason, the most frequent one first.
    pub refused: Vec<(&'static str, usize)>,
}

impl Fixes {
    /// Of all flights.
    #[must_use]
    pub fn of(flights: &[&Flown]) -> Self {
        let frames = flights.iter().flat_map(|flown| &flown.frames);
        let fixes: Vec<Fix> = frames.clone().filter_map(|frame| frame.fix).collect();
        let mean = |pick: fn(&Fix) -> f64| fixes.iter().map(pick).sum::<f64>() / fixes.len() as f64;
        let count = |wanted: &dyn Fn(&Fix) -> bool| fixes.iter().filter(|fix| wanted(fix)).count();
        let ends = flights.iter().flat_map(|flown| &flown.recovery_s);
        let ends: Vec<f64> = ends.map(|end| end.unwrap_or(f64::INFINITY)).collect();
        let mut sigmas: Vec<f64> = fixes.iter().map(|fix| fix.sigma_px).collect();
        sigmas.sort_by(f64::total_cmp);
        let mut refused = BTreeMap::new();
        for reason in frames.clone().filter_map(|frame| frame.reason) {
            *refused.entry(reason).or_insert(0) += 1;
        }
        let mut refused: Vec<(&str, usize)> = refused.into_iter().collect();
        refused.sort_by_key(|&(_, count)| Reverse(count));
        Fixes {
            refused,
            flights: flights.len(),
            frames: frames.count(),
            fixes: fixes.len(),
            wrong: count(&|fix| fix.is_wrong),
            beyond: count(&|fix| fix.is_beyond),
            largest_px: fixes.iter().map(|fix| fix.off_px).fold(0.0, f64::max),
            rms_px: mean(|fix| fix.off_px * fix.off_px).sqrt(),
            sigma_px: sigmas.get(sigmas.len().saturating_sub(1) / 2).copied().unwrap_or(f64::NAN),
            nees: mean(|fix| fix.nees),
            tails: TAILS.map(|tail| count(&|fix| fix.nees > tail)),
            again: [ends.len(), ends.iter().filter(|&&end_s| end_s <= AGAIN_S).count()],
            again_s: ends.iter().copied().fold(0.0, f64::max),
        }
    }
}

/// Where the boards of several flights believed to be, against the truth.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Places {
    /// Root mean square error, metres.
    pub rms_m: f64,
    /// Squared error over the variance, a degree of freedom.
    pub nees: f64,
    /// Median radius of 95 % of normal errors, metres.
    pub median_m: f64,
    /// Shares within the radii of 95, 99 and 99.9 % and within the protection level, each with the interval that holds 95 % of drawings of as
    /// many flights out of these (bootstrap).
    pub held: [[f64; 3]; 4],
}

impl Places {
    /// Of all flights; nothing where none states a place.
    #[must_use]
    pub fn of(flights: &[&Flown]) -> Option<Self> {
        let places: Vec<Placed> =
            flights.iter().flat_map(|flown| &flown.frames).filter_map(|frame| frame.place).collect();
        let (all, normal) = (protection(&places)?, radii(&places)?);
        let own: Vec<([f64; 4], usize)> =
            flights.iter().map(|flown| held(flown)).filter(|(_, places)| *places > 0).collect();
        let interval = |level: usize| {
            let counts: Vec<(f64, f64)> =
                own.iter().map(|&(shares, places)| (shares[level] * places as f64, places as f64)).collect();
            bootstrap::interval(&counts)
        };
        let [of_95, of_99, of_999] = normal.held;
        let shares = [of_95, of_99, of_999, all.held];
        let held = std::array::from_fn(|level| {
            let [low, high] = interval(level);
            [shares[level], low, high]
        });
        Some(Places { rms_m: all.rms_m, nees: all.nees, median_m: normal.median_m, held })
    }
}

/// The shares of one flight, and how many places they are of.
fn held(flown: &Flown) -> ([f64; 4], usize) {
    let places: Vec<Placed> = flown.frames.iter().filter_map(|frame| frame.place).collect();
    let [of_95, of_99, of_999] = radii(&places).map_or([0.0; 3], |radii| radii.held);
    ([of_95, of_99, of_999, protection(&places).map_or(0.0, |all| all.held)], places.len())
}

#[cfg(test)]
mod tests {
    use super::super::flight::Frame;
    use super::*;

    fn fix(off_px: f64, sigma_px: f64) -> Fix {
        Fix { off_px, sigma_px, nees: (off_px / sigma_px).powi(2), is_wrong: off_px > 3.0, is_beyond: off_px > 2.0 }
    }

    fn flight(fixes: &[Option<Fix>], places: &[Placed], recovery_s: Vec<Option<f64>>) -> Flown {
        let frames = fixes.iter().enumerate().map(|(second, &fix)| Frame {
            at_s: second as f64,
            fix,
            reason: None,
            place: places.get(second).copied(),
        });
        Flown { seed: 1, pair: String::new(), frames: frames.collect(), recovery_s }
    }

    #[test]
    fn fixes_of_two_flights() {
        let one = flight(&[Some(fix(3.0, 0.5)), None, Some(fix(4.0, 4.0))], &[], vec![Some(0.5), None]);
        let other = flight(&[Some(fix(0.0, 1.0))], &[], vec![Some(2.5)]);
        let of = Fixes::of(&[&one, &other]);
        assert_eq!((of.flights, of.frames, of.fixes, of.wrong, of.beyond), (2, 4, 3, 1, 2));
        assert_eq!((of.largest_px, of.sigma_px, of.nees, of.tails), (4.0, 1.0, 37.0 / 3.0, [1, 1]));
        assert!((of.rms_px - (25.0f64 / 3.0).sqrt()).abs() < 1e-12);
        assert_eq!((of.again, of.again_s), ([3, 1], f64::INFINITY));
        assert_eq!((Fixes::of(&[]).fixes, Fixes::of(&[]).largest_px), (0, 0.0));
    }

    /// One flight is always within, one never: drawings of two hold nothing, a half or all.
    #[test]
    fn an_interval_is_over_flights() {
        let place = |off_m: f64| Placed { at_s: 0.0, off_m: [off_m, 0.0], sigma_m: [1.0; 2], protection_m: 5.0 };
        let one = flight(&[None; 3], &[place(0.1); 3], Vec::new());
        let other = flight(&[None; 3], &[place(9.0); 3], Vec::new());
        let of = Places::of(&[&one, &other]).expect("places");
        assert_eq!(of.held, [[0.5, 0.0, 1.0]; 4]);
        assert!((of.median_m - 2.4477).abs() < 1e-3 && (of.nees - 0.5 * 40.505).abs() < 1e-9);
        assert!(Places::of(&[&flight(&[None], &[], Vec::new())]).is_none());
    }
}
