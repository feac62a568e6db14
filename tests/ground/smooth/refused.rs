//! What is refused, by name.

use super::{counted, order_of};
use plumbline_survey::smooth::{Alpha, Epochs, Options, SmoothError, smooth};

const GOOD: [f64; 8] = [0.0, 1.0, 0.0, 1.0, 0.0, 3.0, 2.0, 2.5];

fn refused(values: &[f64], weights: &[f64], d: usize, alpha: Alpha) -> SmoothError {
    let epochs = Epochs::new(counted(values.len())).expect("forward");
    smooth(&epochs, values, weights, &Options::new(order_of(d), alpha)).expect_err("refused")
}

#[test]
fn samples() {
    let one = Alpha::Given(1.0);
    let all = [1.0; 8];
    let said = |values: &[f64], weights: &[f64], d, alpha| refused(values, weights, d, alpha).to_string();
    assert_eq!(said(&[0.0, 1.0], &[1.0; 2], 2, one), "2 samples, but order 2 needs 3 at least");
    assert_eq!(said(&[0.0, 1.0, 0.0], &[1.0; 3], 3, one), "3 samples, but order 3 needs 4 at least");
    let mut spoilt = GOOD;
    for value in [f64::NAN, f64::INFINITY] {
        spoilt[4] = value;
        assert_eq!(said(&spoilt, &all, 2, one), "sample 5: the value is not a finite number");
    }
    spoilt[4] = 1e200;
    assert!(matches!(refused(&spoilt, &all, 2, one), SmoothError::NotFinite { sample: 4, .. }));
    let tiny = GOOD.map(|value| 1e-200 * value);
    assert!(matches!(refused(&tiny, &all, 2, one), SmoothError::ValuesTooSmall { .. }));
    let mut few = [0.0; 8];
    (few[1], few[6]) = (1.0, 1.0);
    assert_eq!(said(&GOOD, &few, 2, one), "rank-deficient: 2 samples have a weight above 0, order 2 needs 3");
    for weight in [-1.0, f64::NAN, f64::INFINITY, 1e-9, 1e12] {
        let mut weights = all;
        weights[2] = weight;
        assert!(matches!(refused(&GOOD, &weights, 2, one), SmoothError::BadWeight { .. }), "{weight}");
    }
    for alpha in [one, Alpha::Gcv] {
        assert_eq!(
            said(&[7.5; 8], &all, 2, alpha),
            "all samples are equal (7.5): a stuck sensor, whose noise cannot be estimated"
        );
    }
}

#[test]
fn smoothing_factors() {
    let all = [1.0; 8];
    for alpha in [0.0, -1.0, f64::NAN, -0.0] {
        assert!(
            matches!(refused(&GOOD, &all, 2, Alpha::Given(alpha)), SmoothError::AlphaNotPositive { .. }),
            "{alpha}"
        );
    }
    for alpha in [1e-11, 1e-300] {
        assert!(matches!(refused(&GOOD, &all, 2, Alpha::Given(alpha)), SmoothError::AlphaTooSmall { .. }), "{alpha}");
    }
    for (d, limit) in [(2, 6.25e11), (3, 1.5625e11)] {
        for alpha in [1.001 * limit, 1e300, f64::INFINITY] {
            assert!(
                matches!(refused(&GOOD, &all, d, Alpha::Given(alpha)), SmoothError::AlphaTooLarge { .. }),
                "{alpha}"
            );
        }
        let epochs = Epochs::new(counted(8)).expect("forward");
        assert!(smooth(&epochs, &GOOD, &all, &Options::new(order_of(d), Alpha::Given(0.999 * limit))).is_ok());
    }
    for n in [4usize, 8, 301, 20_000] {
        let line: Vec<f64> = (0..n).map(|i| 1e6 + 0.7 * i as f64 / 3.0).collect();
        assert!(matches!(refused(&line, &vec![1.0; n], 2, Alpha::Gcv), SmoothError::NothingToWeigh { .. }), "{n}");
        // A gate finds no outliers in rounding.
        let epochs = Epochs::new(counted(n)).expect("forward");
        let options = Options { gate: Some(1.0), ..Options::new(order_of(2), Alpha::Given(1.0)) };
        assert!(smooth(&epochs, &line, &vec![1.0; n], &options).expect("a line").rejected.is_empty(), "{n}");
        // A hundred-millionth of the value is no rounding.
        let bent: Vec<f64> = line.iter().enumerate().map(|(i, y)| y + 1e-2 * (i % 3) as f64).collect();
        assert!(smooth(&epochs, &bent, &vec![1.0; n], &Options::new(order_of(2), Alpha::Gcv)).is_ok(), "{n}");
    }
    assert!(matches!(refused(&GOOD[..4], &all[..4], 3, Alpha::Gcv), SmoothError::TooFewForGcv { .. }));
}

#[test]
fn a_gate_that_rejects_everything_is_no_gate() {
    let epochs = Epochs::new(counted(8)).expect("forward");
    let options = Options { gate: Some(0.01), ..Options::new(order_of(2), Alpha::Given(1.0)) };
    let error = smooth(&epochs, &GOOD, &[1.0; 8], &options).expect_err("refused");
    assert!(matches!(error, SmoothError::GateRejects { .. }), "{error}");
}

/// Nothing is extrapolated.
#[test]
fn instants_outside() {
    let epochs = Epochs::new(counted(8)).expect("forward");
    let fit = smooth(&epochs, &GOOD, &[1.0; 8], &Options::new(order_of(2), Alpha::Given(1.0))).expect("good");
    for t_s in [-1e-9, 7.000_001, f64::NAN, f64::INFINITY] {
        assert!(fit.at(t_s).is_err(), "{t_s}");
    }
    assert!(fit.at(0.0).is_ok() && fit.at(7.0).is_ok());
}
