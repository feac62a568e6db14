//! A misalignment: a constant error of pitch and roll that is larger than was stated for the attitude.
//!
//! The filter believes what was stated, and takes what a larger error moves its matches by for wander and for the velocity's error. But
//! then its innovations have the same sign in turn after turn. A constant bias enters them linearly, ν = S b + white noise, and S follows
//! from the filter's own gains (the separate bias of Friedland, "Treatment of bias in recursive filtering", IEEE Trans. Automatic Control
//! 14, 1969): b and its covariance are what a filter with two more states would have. How much more likely the innovations are with such
//! a bias than without says whether there is one (the likelihood ratio of Willsky and Jones, IEEE Trans. Automatic Control 21, 1976).

use super::estimate::{Estimate, Innovation, STATES, TILT, WANDER, carry_along};
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
    /// What the tilt goes back to, where it was found; sums are of what is left of it.
    found_rad: Option<[f32; 2]>,
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

    /// An estimate begins from a match: it moves the position by all that it moves the match by. What was found stays known as well as it was.
    pub(super) fn begun(&mut self, found: &Found) {
        let known = if self.is_found() { *self } else { Misalignment::new() };
        let mut moved = SMatrix::<f32, STATES, 2>::zeros();
        moved.fixed_view_mut::<2, 2>(0, 0).copy_from(&-moved_by_tilt(found));
        *self = Misalignment { moved, ..known };
    }

    /// The estimate is carried on ([`Estimate::carry`]): what it is off by grows and fades with its states.
    pub(super) fn propagate(&mut self, seconds: f32, forgets_tilt: bool) {
        carry_along(&mut self.moved, seconds, forgets_tilt);
    }

    /// The estimate has taken a match by this innovation. `tells`: no jump has changed the tilt.
    pub(super) fn matched(&mut self, found: &Found, innovation: &Innovation, tells: bool) {
        let tilted = moved_by_tilt(found);
        let own = |states: usize| self.moved.fixed_view::<2, 2>(states, 0);
        let seen = own(0) + tilted * own(TILT) + own(WANDER) * found.height_m + tilted;
        self.moved -= innovation.seen * (innovation.inverse * seen);
        if tells {
            let weighed = seen.transpose() * innovation.inverse;
            self.information += weighed * seen;
            self.score += weighed * innovation.off;
            self.chance = self.likely();
        }
    }

    /// What it is, pitch and roll in radians, and the covariance of that, if there is one. Made anew where it is asked for: kept it would not fit
    /// the flight computer's memory.
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

    /// Covariance of what pitch and roll may be off by it beside what was stated, square radians: of what is left of one that was found; else
    /// as far as matches make one more likely than it was before, the square of what it would be, so that what was stated counts while
    /// nothing speaks against it.
    fn doubt(&self) -> Matrix2<f32> {
        if !self.is_found() && self.chance <= CHANCE {
            return Matrix2::zeros();
        }
        let (rad, covariance) = self.told();
        if self.is_found() {
            return covariance;
        }
        let more = ((self.chance - CHANCE) / (1.0 - CHANCE)).max(0.0);
        rad * rad.transpose() * more
    }

    /// One sigma of that, the larger one, radians.
    pub(super) fn doubt_rad(&self) -> f32 {
        sqrt(self.doubt().diagonal().max().max(0.0))
    }

    /// What the position of the estimate may be off by it, square metres.
    pub(super) fn doubt_m2(&self) -> Matrix2<f32> {
        let moved = self.moved.fixed_view::<2, 2>(0, 0);
        moved * self.doubt() * moved.transpose()
    }

    /// Whether it is in the estimate.
    pub(super) fn is_found(&self) -> bool {
        self.found_rad.is_some()
    }

    /// What the tilt goes back to by it, pitch and roll in radians. Where a jump has been told meanwhile that is another tilt, and nothing is told of this one any more.
    pub(super) fn usual_rad(&self) -> [f32; 2] {
        self.found_rad.unwrap_or_default()
    }

    /// Takes it into the estimate, where it is more likely than not, and what has been learnt of it since; whether it has.
    pub(super) fn find(&mut self, estimate: &mut Estimate) -> bool {
        // No number is not likely.
        let is_likely = self.is_found() || self.chance > 0.5;
        if !is_likely {
            return false;
        }
        let (rad, _) = self.told();
        let mut moved = self.moved;
        moved[(TILT, 0)] += 1.0;
        moved[(TILT + 1, 1)] += 1.0;
        estimate.state += moved * rad;
        // What is left is nothing, known to the same covariance.
        self.score = Vector2::zeros();
        let [pitch, roll] = self.usual_rad();
        self.found_rad = Some([pitch + rad[0], roll + rad[1]]);
        true
    }
}
