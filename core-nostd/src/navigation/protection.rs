//! Protection level of the position.
//!
//! A radius that holds the true position except for a stated risk has to hold under each hypothesis: the filter's errors are as its
//! covariance says; its newest match is wrong though accepted; one of the other tracks is right. It is the largest of the radii under these
//! hypotheses, as in satellite receivers with integrity monitoring (solution separation: Brown and McBurney 1988, Blanch et al. 2012): the
//! distance of the two estimates plus as many sigmas of the alternative as its own risk allows.
//!
//! It cannot contain what no match observes: a map error beyond its stated sigma.

use crate::math::{hypot, sqrt, squared};
use crate::tile::Local;
use nalgebra::{Matrix2, Vector2};

/// Risk that the true position is outside the radius. Chosen: a flight of an hour with two frames a second has 7,200 frames.
pub const RISK: f32 = 1e-5;
/// Radius of a normal error in its larger sigmas, √(−2 ln r), for [`RISK`].
const SIGMAS: f32 = 4.798_6;
/// Radius for a risk of a hundredth: the newest match is wrong with a probability of a thousandth, so that a hundredth is left for the
/// estimate without it. Chosen: over ground of the reference's own year none of 20,000 fixes was wrong, over ground of another year one in
/// four; the gates of the filter are in between.
const SIGMAS_WITHOUT: f32 = 3.034_9;

/// Position by the filter with its protection level.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    /// Metres from the tile's centre.
    pub local: Local,
    /// Covariance of (east, north), square metres.
    pub covariance: Matrix2<f32>,
    /// Protection level for [`RISK`], metres.
    pub protection_m: f32,
}

/// The larger sigma of a covariance, metres; infinite for invalid numbers.
pub fn larger_sigma_m(covariance: &Matrix2<f32>) -> f32 {
    let (east, cross, north) = (covariance[(0, 0)], covariance[(0, 1)], covariance[(1, 1)]);
    let larger = 0.5 * (east + north) + hypot(0.5 * (east - north), cross);
    // Invalid numbers mean that nothing is known.
    if larger >= 0.0 { sqrt(larger) } else { f32::INFINITY }
}

/// Maximum of the radii over all hypotheses.
#[derive(Clone, Copy, Debug)]
pub struct Protection {
    place: Place,
}

impl Protection {
    /// Starts from the filter's position, with its own errors.
    pub fn around(local: Local, covariance: Matrix2<f32>) -> Self {
        let protection_m = SIGMAS * larger_sigma_m(&covariance);
        Protection { place: Place { local, covariance, protection_m } }
    }

    fn at_least(self, radius_m: f32) -> Self {
        let radius_m = if radius_m.is_nan() { f32::INFINITY } else { radius_m };
        let protection_m = self.place.protection_m.max(radius_m);
        Protection { place: Place { protection_m, ..self.place } }
    }

    /// The newest match is wrong. `off_m`: position without it less position with it, metres east and north; `sigma_m`: its larger sigma.
    #[must_use]
    pub fn without(self, off_m: Vector2<f32>, sigma_m: f32) -> Self {
        self.at_least(off_m.norm() + SIGMAS_WITHOUT * sigma_m)
    }

    /// Another track is right. `sigma_m`: its larger sigma.
    #[must_use]
    pub fn or_alternative(self, other: Local, sigma_m: f32) -> Self {
        self.at_least(other.off_m(self.place.local) + SIGMAS * sigma_m)
    }

    /// Includes a fix that was sent from here, for a user who takes it alone.
    #[must_use]
    pub fn with_fix(self, covariance: &Matrix2<f32>) -> Self {
        self.at_least(SIGMAS * larger_sigma_m(covariance))
    }

    /// Adds the map's error, one sigma of each axis, metres.
    #[must_use]
    pub fn with_map_sigma(self, sigma_m: f32) -> Place {
        let Place { local, covariance, protection_m } = self.place;
        let covariance = covariance + Matrix2::identity() * squared(sigma_m);
        Place { local, covariance, protection_m: hypot(protection_m, SIGMAS * sigma_m) }
    }
}

#[cfg(test)]
mod tests {
    use super::{Protection, larger_sigma_m};
    use crate::tile::Local;
    use nalgebra::{Matrix2, Vector2};

    const HERE: Local = Local { east_m: 10.0, north_m: -20.0 };

    #[test]
    fn the_larger_sigma_is_that_of_the_long_axis() {
        // 3 m along 30 degrees, 1 m across.
        let (sin, cos) = core::f32::consts::FRAC_PI_6.sin_cos();
        let turn = Matrix2::new(cos, -sin, sin, cos);
        let covariance = turn * Matrix2::new(9.0, 0.0, 0.0, 1.0) * turn.transpose();
        assert!((larger_sigma_m(&covariance) - 3.0).abs() < 1e-5);
    }

    /// Of a million normal errors the stated share is outside, within four sigmas of that count.
    #[test]
    fn the_radius_holds_normal_errors() {
        let covariance = Matrix2::identity() * 4.0f32;
        let radius_m = Protection::around(HERE, covariance).with_map_sigma(0.0).protection_m;
        let mut state = 1u64;
        let mut uniform = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1u64 << 53) as f64
        };
        let outside = (0..1_000_000).filter(|_| {
            // Box and Muller: the length of two normal numbers.
            let length = 2.0 * (-2.0 * (1.0 - uniform()).ln()).sqrt();
            length > f64::from(radius_m)
        });
        let count = outside.count();
        assert!((1..=23).contains(&count), "{count} of 1,000,000 where 10 are expected");
    }

    #[test]
    fn it_is_the_largest_of_what_may_be() {
        let own = Protection::around(HERE, Matrix2::identity());
        let alone_m = own.with_map_sigma(0.0).protection_m;
        assert!((alone_m - 4.8).abs() < 0.01);
        // A match that confirms the prediction adds nothing, one that moves it by 20 m nearly all of that.
        assert_eq!(own.without(Vector2::new(0.1, 0.0), 1.2).with_map_sigma(0.0).protection_m, alone_m);
        assert!((own.without(Vector2::new(12.0, 16.0), 1.0).with_map_sigma(0.0).protection_m - 23.03).abs() < 0.01);
        let other = Local { east_m: 13.0, north_m: -24.0 };
        assert!((own.or_alternative(other, 2.0).with_map_sigma(0.0).protection_m - 14.6).abs() < 0.01);
        assert!((own.with_fix(&(Matrix2::identity() * 9.0)).with_map_sigma(0.0).protection_m - 14.4).abs() < 0.01);
        let place = own.with_map_sigma(2.0);
        assert!((place.protection_m - 4.8 * 5f32.sqrt()).abs() < 0.01 && place.covariance[(0, 0)] == 5.0);
        let nothing = own.or_alternative(HERE, f32::NAN).or_alternative(HERE, 1.0).with_map_sigma(0.0);
        assert!(nothing.protection_m.is_infinite());
        assert!(
            Protection::around(HERE, Matrix2::identity() * f32::NAN).with_map_sigma(0.0).protection_m.is_infinite()
        );
    }
}
