//! Matches with correlated errors.

use super::{HEIGHT_M, UNKNOWN};
use crate::navigation::filter::{Filter, Measurement};
use crate::navigation::reckoning::Moment;
use crate::tile::Local;
use crate::units::Micros;
use nalgebra::Matrix2;

/// Four matches a second with correlated errors weigh as one in eight seconds.
#[test]
fn matches_that_are_off_alike_count_as_one() {
    let at = |ms: u64| Micros(1_000_000 + 1000 * ms);
    let sigma_m = |by_place_m2: f32| {
        let mut filter = Filter::new();
        let mut inflation_m2 = std::vec::Vec::new();
        for ms in (0..20_000).step_by(250) {
            filter.reported(Moment { at: at(ms), velocity_m_per_s: [0.0; 2] }, &UNKNOWN);
            filter.propagate(at(ms), &UNKNOWN);
            inflation_m2.push(filter.inflation_m2(by_place_m2));
            let measurement = Measurement {
                nadir: Local { east_m: 0.0, north_m: 0.0 },
                covariance: Matrix2::identity() * 9.0,
                inflation_m2: inflation_m2[inflation_m2.len() - 1],
                transient_rad: 0.0,
                corrected_tilt_rad: [0.0; 2],
                height_m: HEIGHT_M,
                heading_rad: 0.0,
            };
            filter.matched(&measurement, None, &UNKNOWN);
        }
        assert!((inflation_m2[5] - 31.0 * by_place_m2).abs() <= 1e-3 * by_place_m2, "{inflation_m2:?}");
        let sigma_m = filter.position().expect("it was found").1[(0, 0)].sqrt();
        filter.propagate(at(28_000), &UNKNOWN);
        assert_eq!(filter.inflation_m2(by_place_m2), 0.0);
        sigma_m
    };
    // A common error of three metres stays three metres.
    let (white, correlated) = (sigma_m(0.0), sigma_m(9.0));
    assert!(white < 2.8 && correlated > 3.0, "{white} {correlated}");
}
