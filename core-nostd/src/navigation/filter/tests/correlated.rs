//! Matches with correlated errors.

use super::{CONSUMER, HEIGHT_M, UNKNOWN};
use crate::navigation::filter::{Filter, Measurement, PriorSigmas};
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

/// Neighbouring matches have most of their errors in common: one that is two and a half of its sigmas off the one before has jumped, though
/// it is within the prediction's gate.
#[test]
fn a_match_far_off_its_neighbour_is_a_jump() {
    let at = |ms: u64| Micros(1_000_000 + 1000 * ms);
    let known = PriorSigmas { velocity_m_per_s: 0.3, ..CONSUMER };
    let unexplained_rad = |off_m: f32, gap_ms: u64, common_m2: f32| {
        let mut filter = Filter::new();
        let mut newest = 0.0;
        for ms in (0..5_000).step_by(250).chain([4_750 + gap_ms]) {
            (0..=ms).step_by(250).for_each(|ms| {
                if at(ms).since(filter.reported.at) > 0 {
                    filter.reported(Moment { at: at(ms), velocity_m_per_s: [20.0, 0.0] }, &known);
                }
            });
            filter.propagate(at(ms), &known);
            let north_m = if ms > 4_750 { off_m } else { 0.0 };
            let measurement = Measurement {
                nadir: Local { east_m: 0.02 * ms as f32, north_m },
                covariance: Matrix2::identity() * 9.0,
                inflation_m2: filter.inflation_m2(common_m2),
                transient_rad: 0.0,
                corrected_tilt_rad: [0.0; 2],
                height_m: HEIGHT_M,
                heading_rad: 0.0,
            };
            newest = filter.matched(&measurement, None, &known);
        }
        newest
    };
    assert_eq!(unexplained_rad(6.5, 250, 9.0), 0.0);
    assert!(unexplained_rad(8.0, 250, 9.0) > 0.02, "{}", unexplained_rad(8.0, 250, 9.0));
    // Too long after it for the errors to be the same, and with errors that are not.
    assert_eq!([unexplained_rad(8.0, 2_250, 9.0), unexplained_rad(8.0, 250, 0.0)], [0.0; 2]);
}
