//! What the board's own filter is worth: where it says that the vehicle is against where that was, and how often it was within the radii
//! that it promises.

use super::matching::length;
use super::statistics::{mean, percentile};
use crate::run::FrameRecord;
use plumbline_firmware::wire::telemetry::PlaceReport;
use serde::Serialize;

/// The board's place at a frame, against the truth at the middle of its exposure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placed {
    /// The true middle of the exposure, seconds of the simulated time.
    pub at_s: f64,
    /// Stated minus true place of the antenna, east and north, metres.
    pub off_m: [f64; 2],
    /// Its stated sigmas, east and north, metres.
    pub sigma_m: [f64; 2],
    /// Its protection level, metres.
    pub protection_m: f64,
}

impl Placed {
    /// `true_m`: the antenna, east and north of the tile's centre.
    #[must_use]
    pub fn new(at_s: f64, place: &PlaceReport, true_m: [f64; 2]) -> Self {
        let [east_m, north_m] = [place.east_m, place.north_m].map(f64::from);
        Placed {
            at_s,
            off_m: [east_m - true_m[0], north_m - true_m[1]],
            sigma_m: [place.sigma_east_m, place.sigma_north_m].map(f64::from),
            protection_m: f64::from(place.protection_m),
        }
    }

    /// Horizontal error, metres.
    #[must_use]
    pub fn error_m(&self) -> f64 {
        length(self.off_m)
    }

    /// Whether the truth was within the protection level; not where that is no number.
    #[must_use]
    pub fn is_held(&self) -> bool {
        self.error_m() <= self.protection_m
    }

    /// Error squared in units of the stated sigmas, a degree of freedom.
    fn nees(&self) -> f64 {
        let [east, north] = [0, 1].map(|axis| self.off_m[axis] / self.sigma_m[axis]);
        0.5 * (east * east + north * north)
    }

    /// Radius of a circle that holds at least this share of normal errors: the radius of a Rayleigh distribution of the larger sigma.
    fn radius_m(&self, share: f64) -> f64 {
        (-2.0 * (1.0 - share).ln()).sqrt() * self.sigma_m[0].max(self.sigma_m[1])
    }
}

/// The place of a frame, where the board stated one. `true_m`: the antenna, east and north of the tile's centre.
pub(super) fn placed(record: &FrameRecord, true_m: [f64; 2]) -> Option<Placed> {
    let place = record.instant?.place?;
    Some(Placed::new(1e-6 * record.exposure.mid_us() as f64, &place, true_m))
}

/// `protection` of `report.json`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Protection {
    /// Share of the places whose error was within their protection level.
    pub held: f64,
    /// Median of the protection levels.
    pub median_m: f64,
    /// Root mean square horizontal error.
    pub rms_m: f64,
    /// Normalised error squared, a degree of freedom: 1 where the filter knows how wrong it is.
    pub nees: f64,
    /// Frames with a place.
    pub frames: usize,
}

/// The figures of all places; nothing without one.
#[must_use]
pub fn protection(places: &[Placed]) -> Option<Protection> {
    let of = |pick: fn(&Placed) -> f64| places.iter().map(pick).collect::<Vec<f64>>();
    Some(Protection {
        held: held_share(places, |place| place.protection_m)?,
        median_m: percentile(&of(|place| place.protection_m), 0.5)?,
        rms_m: mean(&of(|place| place.error_m().powi(2)))?.sqrt(),
        nees: mean(&of(Placed::nees))?,
        frames: places.len(),
    })
}

/// How the errors spread against the stated sigmas.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Radii {
    /// Shares of the places whose error was within the radius of 95, 99 and 99.9 % of normal errors.
    pub held: [f64; 3],
    /// Median of the radii of 95 %, metres.
    pub median_m: f64,
}

/// Errors against the sigmas alone; nothing without a place.
#[must_use]
pub fn radii(places: &[Placed]) -> Option<Radii> {
    let of_95: Vec<f64> = places.iter().map(|place| place.radius_m(0.95)).collect();
    let held = |share: f64| held_share(places, |place| place.radius_m(share));
    Some(Radii { held: [held(0.95)?, held(0.99)?, held(0.999)?], median_m: percentile(&of_95, 0.5)? })
}

fn held_share(places: &[Placed], radius_m: impl Fn(&Placed) -> f64) -> Option<f64> {
    mean(&places.iter().map(|place| f64::from(u8::from(place.error_m() <= radius_m(place)))).collect::<Vec<_>>())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Sigmas of 1 m and 2 m; true place 100 m east and 50 m south of the tile's centre.
    fn off(east_m: f32, north_m: f32, protection_m: f32) -> Placed {
        let place = PlaceReport {
            east_m: 100.0 + east_m,
            north_m: -50.0 + north_m,
            sigma_east_m: 1.0,
            sigma_north_m: 2.0,
            protection_m,
        };
        Placed::new(0.0, &place, [100.0, -50.0])
    }

    #[test]
    fn a_place_against_its_truth() {
        let place = off(3.0, -4.0, 5.0);
        assert_eq!((place.off_m, place.error_m(), place.is_held()), ([3.0, -4.0], 5.0, true));
        // 3 sigmas east, 2 north.
        assert_eq!(place.nees(), 6.5);
        assert!(!off(3.0, -4.0, 4.99).is_held() && !off(0.0, 0.0, f32::NAN).is_held());
        // Of the Rayleigh distribution: 2.4477, 3.0349 and 3.7169 sigmas.
        for (share, sigmas) in [(0.95, 2.4477), (0.99, 3.0349), (0.999, 3.7169)] {
            assert!((place.radius_m(share) - 2.0 * sigmas).abs() < 2e-4, "{share}");
        }
    }

    #[test]
    fn figures_of_four_places() {
        let places = [off(3.0, 4.0, 6.0), off(0.0, 6.5, 6.0), off(0.0, 5.0, 20.0), off(0.0, 0.0, 8.0)];
        let of = protection(&places).expect("places");
        assert_eq!((of.held, of.median_m, of.frames), (0.75, 6.0, 4));
        assert!((of.rms_m - (92.25f64 / 4.0).sqrt()).abs() < 1e-12);
        assert_eq!(of.nees, (6.5 + 0.5 * 3.25 * 3.25 + 0.5 * 2.5 * 2.5) / 4.0);
        assert_eq!(protection(&[]), None);
    }

    /// Off by 4, 5, 6.5 and 8 m, where 4.90, 6.07 and 7.43 m are the radii.
    #[test]
    fn shares_within_the_radii_of_a_normal_error() {
        let places = [off(0.0, 4.0, 1.0), off(0.0, -5.0, 1.0), off(0.0, 6.5, 1.0), off(0.0, 8.0, 1.0)];
        let of = radii(&places).expect("places");
        assert_eq!(of.held, [0.25, 0.5, 0.75]);
        assert!((of.median_m - 4.8955).abs() < 1e-3);
        assert_eq!(radii(&[]), None);
    }
}
