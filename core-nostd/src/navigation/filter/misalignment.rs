//! A misalignment: a constant error of pitch and roll that is larger than was stated for the attitude.
//!
//! The filter believes what was stated, and takes what a larger error moves its matches by for wander and for the velocity's error. But
//! then its innovations have the same sign in turn after turn. A constant bias enters them linearly, ν = S b + white noise, and S follows
//! from the filter's own gains (the separate bias of Friedland, "Treatment of bias in recursive filtering", IEEE Trans. Automatic Control
//! 14, 1969): b and its covariance are what a filter with two more states would have. How much more likely the innovations are with such
//! a bias than without says whether there is one (the likelihood ratio of Willsky and Jones, IEEE Trans. Automatic Control 21, 1976).

use super::estimate::{Estimate, Innovation, STATES, TILT, VELOCITY, WANDER, keeps, symmetric};
use super::found::{Found, moved_by_tilt};
use crate::math::{exp, ln, sqrt, squared};
use nalgebra::{ArrayStorage, Matrix2, SMatrix, Vector2};

/// One sigma of a misalignment that nobody has stated, each axis, radians. Chosen: one degree, what a camera that was mounted by eye and an
/// accelerometer that was levelled on a table have.
const SIGMA_RAD: f32 = 0.0175;
/// Chance that there is one. Chosen: one vehicle in ten.
const CHANCE: f32 = 0.1;

/// What matches say of one.
#[derive(Clone, Copy, Debug)]
pub(super) struct Misalignment {
    /// By how much the estimate is off for each radian of it, pitch and roll: what is true less what is estimated.
    pub(super) moved: SMatrix<f32, STATES, 2>,
    /// Sums over innovations: Sᵀ W⁻¹ S and Sᵀ W⁻¹ ν, W their covariance.
    information: Matrix2<f32>,
    score: Vector2<f32>,
    /// Probability that there is one.
    chance: f32,
    /// One sigma of it when it was taken into the estimate, the larger one, radians.
    found_rad: Option<f32>,
}

impl Misalignment {
    /// Nothing known.
    pub(super) const fn new() -> Self {
        Misalignment {
            moved: SMatrix::from_array_storage(ArrayStorage([[0.0; STATES]; 2])),
            information: Matrix2::new(0.0, 0.0, 0.0, 0.0),
            score: Vector2::new(0.0, 0.0),
            chance: CHANCE,
            found_rad: None,
        }
    }

    /// An estimate begins from a match: it moves the position by all that it moves the match by.
    pub(super) fn begun(&mut self, found: &Found) {
        *self = Misalignment::new();
        self.moved.fixed_view_mut::<2, 2>(0, 0).copy_from(&-moved_by_tilt(found));
    }

    /// The estimate is carried on ([`Estimate::carry`]): what it is off by grows and fades with its states.
    pub(super) fn carry(&mut self, seconds: f32, forgets_tilt: bool) {
        let [keeps_velocity, knows_tilt, keeps_wander] = keeps(seconds);
        let keeps_tilt = if forgets_tilt { knows_tilt } else { 1.0 };
        for mut moved in self.moved.column_iter_mut() {
            for axis in 0..2 {
                moved[axis] -= moved[VELOCITY + axis] * seconds;
                moved[VELOCITY + axis] *= keeps_velocity;
                moved[TILT + axis] *= keeps_tilt;
                moved[WANDER + axis] *= keeps_wander;
            }
        }
    }

    /// The estimate has taken a match by this innovation.
    pub(super) fn matched(&mut self, found: &Found, innovation: &Innovation) {
        let tilted = moved_by_tilt(found);
        let own = |states: usize| self.moved.fixed_view::<2, 2>(states, 0);
        let seen = own(0) + tilted * own(TILT) + own(WANDER) * found.height_m + tilted;
        let weighed = seen.transpose() * innovation.inverse;
        self.information += weighed * seen;
        self.score += weighed * innovation.off;
        self.moved -= innovation.seen * (innovation.inverse * seen);
        self.chance = self.likely();
    }

    /// What it is, pitch and roll in radians, and the covariance of that, if there is one.
    fn told(&self) -> (Vector2<f32>, Matrix2<f32>) {
        let information = self.information + Matrix2::identity() / squared(SIGMA_RAD);
        let covariance = information.try_inverse().unwrap_or_default();
        (covariance * self.score, covariance)
    }

    /// Probability that there is one: normal innovations are more likely by e^(bᵀ y / 2) √det(P / σ²), y the score and P the covariance of b.
    fn likely(&self) -> f32 {
        let (rad, covariance) = self.told();
        let spread = ln((covariance / squared(SIGMA_RAD)).determinant().max(f32::MIN_POSITIVE));
        let log_ratio = 0.5 * (self.score.dot(&rad) + spread);
        1.0 / (1.0 + (1.0 - CHANCE) / CHANCE * exp(-log_ratio))
    }

    /// What pitch and roll may be off by it beside what was stated, radians: the mean square of what it is, where it is, and of nothing, where
    /// it is not. What was stated counts as long as matches do not make one more likely than it was before.
    pub(super) fn doubt_rad(&self) -> Vector2<f32> {
        let more = ((self.chance - CHANCE) / (1.0 - CHANCE)).max(0.0);
        if self.found_rad.is_some() { Vector2::zeros() } else { self.told().0 * sqrt(more) }
    }

    /// By that the position of the estimate may be off, east and north, metres.
    pub(super) fn doubt_m(&self) -> Vector2<f32> {
        self.moved.fixed_view::<2, 2>(0, 0) * self.doubt_rad()
    }

    /// One sigma of what is left of one that is in the estimate, when it was taken into it, radians.
    pub(super) fn left_rad(&self) -> f32 {
        self.found_rad.unwrap_or(0.0)
    }

    /// Takes it into the estimate's tilt where it is more likely than not; whether it has.
    pub(super) fn find(&mut self, estimate: &mut Estimate) -> bool {
        if self.found_rad.is_some() || self.chance <= 0.5 {
            return false;
        }
        let (rad, covariance) = self.told();
        self.found_rad = Some(sqrt(covariance.diagonal().max()));
        let mut moved = self.moved;
        moved[(TILT, 0)] += 1.0;
        moved[(TILT + 1, 1)] += 1.0;
        estimate.state += moved * rad;
        estimate.covariance = symmetric(&(estimate.covariance + moved * covariance * moved.transpose()));
        true
    }
}
