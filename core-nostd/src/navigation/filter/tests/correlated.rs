//! Matches with correlated errors.

use super::{CONSUMER, UNKNOWN};
use crate::navigation::filter::{Filter, Measurement, PriorSigmas};
use crate::navigation::reckoning::Moment;
use crate::tile::Local;
use crate::units::Micros;
use nalgebra::Matrix2;

/// Matches of three metres, over a map of another year by the part `map_variance_m2`, every `every_ms`: the inflation of the sixth, and the
/// sigma of the position in the end, metres.
fn in_a_row(every_ms: usize, map_variance_m2: f32) -> (f32, f32) {
    let at = |ms: u64| Micros(1_000_000 + 1000 * ms);
    let covariance = Matrix2::identity() * 9.0;
    let mut filter = Filter::new();
    let mut inflations_m2 = std::vec::Vec::new();
    for ms in (0..20_000).step_by(every_ms) {
        filter.reported(Moment { at: at(ms), velocity_m_per_s: [0.0; 2] }, &UNKNOWN);
        filter.propagate(at(ms), &UNKNOWN);
        let inflation_m2 = filter.inflation_m2(&covariance, map_variance_m2);
        inflations_m2.push(inflation_m2);
        let measurement =
            Measurement { covariance, map_variance_m2, inflation_m2, ..Measurement::level(Local::default(), 0.0) };
        filter.matched(&measurement, None, &UNKNOWN);
    }
    let sigma_m = filter.position().expect("it was found").1[(0, 0)].sqrt();
    filter.propagate(at(29_000), &UNKNOWN);
    assert_eq!(filter.inflation_m2(&covariance, map_variance_m2), 0.0, "far apart");
    (inflations_m2[5], sigma_m)
}

/// Four matches a second over a map of another year weigh as one in eight seconds.
#[test]
fn matches_that_are_off_alike_count_as_one() {
    let (inflation_m2, sigma_m) = in_a_row(250, 9.0);
    assert!((inflation_m2 - 31.0 * 9.0).abs() <= 1e-3 * 9.0, "{inflation_m2}");
    // A common error of three metres stays three metres.
    assert!(sigma_m > 3.0, "{sigma_m}");
    assert!(in_a_row(250, 0.0).1 < 2.8);
}

/// Over a map of the same year the mean of many is as uncertain as that of errors of which two fifths are a Markov process of one second, by
/// the sum of its autocorrelation, (1 + φ) / (1 − φ).
#[test]
fn the_mean_of_neighbours_is_as_uncertain_as_that_of_a_markov_process() {
    for every_ms in [100, 250, 500, 1000] {
        let kept = (-1e-3 * every_ms as f32).exp();
        let expected_m2 = 9.0 * (0.6 + 0.4 * (1.0 + kept) / (1.0 - kept));
        let (inflation_m2, _) = in_a_row(every_ms, 0.0);
        assert!((9.0 + inflation_m2 - expected_m2).abs() < 0.05 * expected_m2, "{every_ms} ms: {inflation_m2}");
    }
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
                map_variance_m2: common_m2,
                inflation_m2: filter.inflation_m2(&(Matrix2::identity() * 9.0), common_m2),
                ..Measurement::level(Local { east_m: 0.02 * ms as f32, north_m }, 9.0)
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
