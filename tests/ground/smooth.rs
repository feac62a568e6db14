//! The fit of paper 001 on the ground (f64) against its golden values, a dense solution, other authors' smoothers, and
//! what holds for every fit.

mod bridging;
mod dense;
mod others;
mod properties;
mod refused;
mod scatter;

use plumbline_survey::smooth::{Alpha, Epochs, Fit, Options, Order, smooth};
use plumbline_tests::track;
use plumbline_tests::vectors::{list, number, rows, table};
use serde_json::Value;

/// What the golden values' nine decimals leave, and the rounding of 500 m at a condition number of 64,000.
const GOLDEN: f64 = 1e-8;

/// The order of a row.
pub fn order(row: &Value) -> Order {
    order_of(row["d"].as_u64().expect("an order") as usize)
}

/// The order with `d` differences.
pub fn order_of(d: usize) -> Order {
    match d {
        2 => Order::Second,
        3 => Order::Third,
        other => panic!("no order {other}"),
    }
}

/// A fit with unit weights that has to be possible.
pub fn fitted(t_s: &[f64], values: &[f64], d: usize, alpha: Alpha) -> Fit {
    let epochs = Epochs::new(t_s.to_vec()).expect("good times");
    smooth(&epochs, values, &vec![1.0; values.len()], &Options::new(order_of(d), alpha)).expect("good samples")
}

/// 0, 1, 2 ..
pub fn counted(n: usize) -> Vec<f64> {
    (0..n).map(|i| i as f64).collect()
}

fn alpha(row: &Value) -> Alpha {
    Alpha::Given(number(row, "alpha"))
}

/// Fails with `what` unless both numbers are so near.
#[track_caller]
pub fn near(found: f64, wanted: f64, tolerance: f64, what: &str) {
    assert!((found - wanted).abs() <= tolerance, "{what}: {found} instead of {wanted}");
}

#[test]
fn golden_short() {
    for row in rows("001", "S_short") {
        let y: [f64; 7] = list(&row, "y");
        let fit = fitted(&counted(7), &y, order(&row).differences(), alpha(&row));
        for (found, wanted) in fit.values.iter().zip(list::<7>(&row, "g")) {
            near(*found, wanted, GOLDEN, &row.to_string());
        }
        let trend = fit.trend();
        near(trend.constant, number(&row, "constant"), 1e-14, "constant");
        near(trend.line.at_zero, number(&row, "at_zero"), 1e-14, "line at zero");
        near(trend.line.slope, number(&row, "slope"), 1e-14, "slope");
    }
}

#[test]
fn golden_track() {
    let track = track::golden();
    let given = table("001", "S_samples");
    for (i, key) in [(0, "y0"), (1, "y1"), (300, "y300")] {
        near(track.observed[i], number(&given, key), 1e-9, key);
    }
    for row in rows("001", "S_track") {
        let fit = fitted(&track.t_s, &track.observed, order(&row).differences(), alpha(&row));
        for (i, key) in [(0, "first"), (150, "middle"), (300, "last")] {
            near(fit.values[i], number(&row, key), GOLDEN, &row.to_string());
        }
        near(fit.vpv, number(&row, "vv"), GOLDEN, "vv");
        near(fit.edf, number(&row, "edf"), GOLDEN, "edf");
        near(fit.trend().constant, number(&given, "constant"), GOLDEN, "constant");
        if !row["gcv"].is_null() {
            near(fit.gcv, number(&row, "gcv"), GOLDEN, "gcv");
            let squares = fit.values.iter().zip(&track.truth).map(|(g, truth)| (g - truth).powi(2));
            near((squares.sum::<f64>() / 301.0).sqrt(), number(&row, "rms_m"), GOLDEN, "rms");
        }
    }
}

#[test]
fn golden_between() {
    let track = track::golden();
    let fit = fitted(&track.t_s, &track.observed, 2, Alpha::Given(100.0));
    for row in rows("001", "S_between") {
        near(fit.at(number(&row, "t")).expect("inside").value, number(&row, "value"), GOLDEN, &row.to_string());
    }
    // A straight line between the values is something else.
    let row = &rows("001", "S_between")[1];
    near(0.5 * (fit.values[50] + fit.values[51]), number(row, "linear"), GOLDEN, "linear");
}

/// The row for the board is made of this fit: unit samples, and the cubic through four values of the curve.
#[test]
fn golden_fir() {
    let row = table("001", "S_fir");
    for (sample, wanted) in list::<11>(&row, "row").into_iter().enumerate() {
        let mut unit = [0.0; 11];
        unit[sample] = 1.0;
        let g = fitted(&counted(11), &unit, 2, alpha(&row)).values;
        near((9.0 * (g[7] + g[8]) - g[6] - g[9]) / 16.0, wanted, GOLDEN, &format!("sample {sample}"));
    }
}

/// At a condition number c the fit loses c 2^-53 of what is not a polynomial: 10 m here.
#[test]
fn stiff_curves_keep_their_digits() {
    for row in rows("001", "S_stiff") {
        let d = order(&row).differences();
        let y: Vec<f64> =
            (0..60).map(|i| 500.0 + 10.0 * (0.3 * f64::from(i)).sin() + f64::from(7919 * i % 13 - 6) / 10.0).collect();
        let fit = fitted(&counted(60), &y, d, alpha(&row));
        let lost = 4f64.powi(d as i32) * number(&row, "alpha") * 2f64.powi(-53);
        for (i, key) in [(0, "first"), (30, "middle"), (59, "last")] {
            near(fit.values[i], number(&row, key), 1e-12 + 10.0 * lost, &row.to_string());
        }
        near(fit.edf, number(&row, "edf"), 1e-12 + 60.0 * lost, &row.to_string());
    }
}
