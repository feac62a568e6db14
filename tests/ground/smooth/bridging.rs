//! Gaps, missing samples, outliers.

use super::{fitted, near, order_of};
use plumbline_survey::smooth::{Alpha, Epochs, Options, smooth};
use plumbline_tests::track;

/// A missing sample is the same as a row that is not there: the grid's plain differences with weight 0, or divided ones.
/// The two sums for the integral differ where the samples are missing only.
#[test]
fn weight_zero_and_missing_rows_agree() {
    let track = track::golden();
    let missing = |i: usize| (100..104).contains(&i);
    let weights: Vec<f64> = (0..301).map(|i| if missing(i) { 0.0 } else { 1.0 }).collect();
    let epochs = Epochs::new(track.t_s.clone()).expect("forward");
    let kept: Vec<usize> = (0..301).filter(|&i| !missing(i)).collect();
    for d in [2, 3] {
        let alpha = Alpha::Given(30.0);
        let zero = smooth(&epochs, &track.observed, &weights, &Options::new(order_of(d), alpha)).expect("good");
        let of = |all: &[f64]| -> Vec<f64> { kept.iter().map(|&i| all[i]).collect() };
        let without = fitted(&of(&track.t_s), &of(&track.observed), d, alpha);
        for (place, &i) in kept.iter().enumerate() {
            let far = i.abs_diff(102) > 30;
            let (a, b) = (zero.at_sample(i), without.at_sample(place));
            near(a.value, b.value, if far { 1e-4 } else { 0.05 }, &format!("d {d}, sample {i}"));
        }
        // In the gap both follow the curve to what they say, and say that they know less.
        for i in 100..104 {
            let (a, b) = (zero.at_sample(i), without.at(track.t_s[i]).expect("inside"));
            for estimate in [a, b] {
                assert!((estimate.value - track.truth[i]).abs() < 4.0 * estimate.sigma, "{estimate:?}");
            }
        }
        assert!(zero.at_sample(102).sigma > 1.2 * zero.at_sample(50).sigma);
    }
}

#[test]
fn the_gate_finds_outliers_and_leaves_good_samples() {
    let track = track::golden();
    let epochs = Epochs::new(track.t_s.clone()).expect("forward");
    let mut observed = track.observed.clone();
    let wrong = [3, 40, 41, 150, 299];
    for (k, &i) in wrong.iter().enumerate() {
        observed[i] += if k % 2 == 0 { 20.0 } else { -8.0 };
    }
    for d in [2, 3] {
        for alpha in [Alpha::Gcv, Alpha::Given(10.0)] {
            let options = Options { gate: Some(6.0), ..Options::new(order_of(d), alpha) };
            let fit = smooth(&epochs, &observed, &vec![1.0; 301], &options).expect("good");
            assert_eq!(fit.rejected, wrong, "d {d}, {alpha:?}");
            let clean = smooth(&epochs, &track.observed, &vec![1.0; 301], &options).expect("good");
            assert!(clean.rejected.is_empty());
            near(fit.sigma0, clean.sigma0, 0.01, "sigma0");
            let none = fitted(&track.t_s, &observed, d, alpha);
            assert!(none.rejected.is_empty() && none.sigma0 > 3.0 * clean.sigma0);
        }
    }
}

#[test]
fn a_longer_gap_may_be_allowed_and_is_named() {
    let track = track::golden();
    let kept = |all: &[f64]| -> Vec<f64> { [&all[..100], &all[140..]].concat() };
    let (t_s, observed) = (kept(&track.t_s), kept(&track.observed));
    let epochs = Epochs::new(t_s).expect("forward");
    let weights = vec![1.0; observed.len()];
    let fit = |gap_s| {
        let options = Options { gap_s, ..Options::new(order_of(2), Alpha::Given(10.0)) };
        smooth(&epochs, &observed, &weights, &options)
    };
    let error = fit(None).expect_err("8.2 s").to_string();
    assert_eq!(error, "sample 101: gap longer than the limit of 4 s: 8.200 s at 19.8");
    assert!(fit(Some(8.0)).is_err());
    let allowed = fit(Some(9.0)).expect("allowed");
    let gaps: Vec<_> = allowed.gaps.iter().map(|gap| (gap.from_s, gap.to_s)).collect();
    assert_eq!(gaps, [(track.t_s[99], track.t_s[140])]);
    let middle = allowed.at(24.0).expect("inside");
    assert!(middle.sigma > 5.0 * allowed.at_sample(50).sigma, "{middle:?}");
}
