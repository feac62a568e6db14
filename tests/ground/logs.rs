//! Real flight logs: every second attitude left out and predicted by the fit on the ground, and by straight lines.
//!
//! What is logged is a filter's output, smooth but for rounding. GCV finds that and hardly smooths (alpha at the lower end
//! of its range), so what is gained here is what the cubic gains over lines.

use plumbline_survey::io::data;
use plumbline_survey::smooth::{Alpha, Epochs, Fit, Options, Order, Samples, smooth, unwrap_turns};
use std::io::Write;
use std::path::PathBuf;

const COLUMNS: [&str; 3] = ["roll_deg", "pitch_deg", "yaw_deg"];
/// Angles are logged in hundredths of a degree, times in milliseconds.
const STEP_DEG: f64 = 0.01;
/// See [`STEP_DEG`].
const STEP_S: f64 = 1e-3;
/// Longest distance of two samples that one between them is predicted from, seconds: the gaps are left out.
const CLOSE_S: f64 = 0.2;

/// A line that shows without `--nocapture` too.
fn say(line: &str) {
    writeln!(std::io::stderr(), "{line}").expect("stderr takes a line");
}

/// A log of attitudes, or `None` after one line.
fn log(flight: &str, test: &str) -> Option<PathBuf> {
    data::for_test(test, &format!("flights/{flight}/att.csv"))
}

fn read(path: &std::path::Path) -> Samples {
    let mut samples = Samples::read(path, "t_s", &COLUMNS, None).expect("a good log");
    unwrap_turns(&mut samples.channels[2], 360.0).expect("a vehicle that does not spin");
    samples
}

fn fitted(t_s: &[f64], values: &[f64], order: Order, gap_s: Option<f64>) -> Result<Fit, String> {
    let epochs = Epochs::new(t_s.to_vec()).expect("forward");
    let options = Options { gap_s, ..Options::new(order, Alpha::Gcv) };
    smooth(&epochs, values, &vec![1.0; values.len()], &options).map_err(|error| error.to_string())
}

/// How far off the left-out samples of a column are predicted, degrees rms.
struct Predicted {
    fit: f64,
    lines: f64,
    /// What rounded angles and times add to it.
    rounding: f64,
    alpha: f64,
}

/// Fits samples 0, 2, 4 .. and predicts 1, 3, 5 ..
fn every_second(t: &[f64], y: &[f64], order: Order) -> Predicted {
    let kept = |all: &[f64]| -> Vec<f64> { all.iter().copied().step_by(2).collect() };
    let fit = fitted(&kept(t), &kept(y), order, Some(2.0)).expect("a good log");
    let (mut by_fit, mut by_lines, mut rates, mut count) = (0.0, 0.0, 0.0, 0.0);
    for i in (1..t.len() - 1).step_by(2) {
        let span_s = t[i + 1] - t[i - 1];
        if span_s > CLOSE_S {
            continue;
        }
        let rate = (y[i + 1] - y[i - 1]) / span_s;
        by_fit += (fit.value(t[i]).expect("inside") - y[i]).powi(2);
        by_lines += (y[i - 1] + rate * (t[i] - t[i - 1]) - y[i]).powi(2);
        rates += rate * rate;
        count += 1.0;
    }
    // A rounded angle is off by step / √12, a rounded time by as much times the rate; the sample left out has this error
    // and so have its neighbours, which the cubic spline half-way weighs with factors whose squares add up to 0.8.
    let rounding = 1.8 * (STEP_DEG.powi(2) + STEP_S.powi(2) * rates / count) / 12.0;
    let rms = |sum: f64| (sum / count).sqrt();
    Predicted { fit: rms(by_fit), lines: rms(by_lines), rounding: rounding.sqrt(), alpha: fit.alpha }
}

impl Predicted {
    /// Beside what rounding does, lines lose 1 - cos(w H / 2) of a wave half-way between samples H apart, the cubic spline
    /// 1 - (46 cos x + 2 cos 3x) / (16 (2 + cos 2x)), x = w H / 2. At H = 40 ms the latter is less than 0.55 of the former
    /// for every wave below 10 Hz, and multirotors do not turn faster.
    fn bound(&self) -> f64 {
        let noise = self.rounding.powi(2);
        (noise + 0.55f64.powi(2) * (self.lines.powi(2) - noise)).sqrt()
    }

    fn factor(&self) -> f64 {
        self.lines / self.fit
    }

    fn tell(&self, flight: &str, column: &str, order: Order) {
        say(&format!(
            "{flight}, {column}, every second sample left out: lines {:.2} mdeg, order {order} {:.2} mdeg (alpha {:.1e}), \
             factor {:.2}; rounding {:.2} mdeg",
            1e3 * self.lines,
            1e3 * self.fit,
            self.alpha,
            self.factor(),
            1e3 * self.rounding
        ));
    }
}

/// The share that the bound rests on.
#[test]
fn what_a_cubic_spline_loses_of_a_wave() {
    let mut last = 0.0;
    for tenth_hz in 1..=100 {
        let x = std::f64::consts::PI * 0.1 * f64::from(tenth_hz) * 0.04;
        let spline = 1.0 - (46.0 * x.cos() + 2.0 * (3.0 * x).cos()) / (16.0 * (2.0 + (2.0 * x).cos()));
        let share = spline / (1.0 - x.cos());
        assert!(share < 0.55 && share + 1e-6 > last, "{tenth_hz}: {share}");
        last = share;
    }
}

#[test]
fn every_second_attitude_of_the_quadrotor() {
    let Some(path) = log("quad_range", "every_second_attitude_of_the_quadrotor") else { return };
    let samples = read(&path);
    for order in [Order::Second, Order::Third] {
        let (mut by_fit, mut by_lines) = (0.0, 0.0);
        for (column, values) in COLUMNS.into_iter().zip(&samples.channels) {
            let predicted = every_second(&samples.t_s, values, order);
            predicted.tell("quad_range", column, order);
            by_fit += predicted.fit.powi(2);
            by_lines += predicted.lines.powi(2);
            if column == "yaw_deg" {
                // The filter of this vehicle corrects its heading in steps: 1 % of the samples have 55 % of all squared
                // second differences (26 % in roll and pitch). No smoothness is there to be used.
                assert!(predicted.factor() > 1.0, "{column}: {}", predicted.factor());
            } else {
                assert!(predicted.fit < predicted.bound(), "{column}: {} {}", predicted.fit, predicted.bound());
            }
        }
        let factor = (by_lines / by_fit).sqrt();
        say(&format!("quad_range, all three angles, order {order}: factor {factor:.2}"));
        assert!(factor > 1.5, "{factor}");
    }
}

/// The part that the autopilot flies: banks of up to 51 degrees, entered in half a second.
#[test]
fn every_second_attitude_of_the_plane() {
    let Some(path) = log("plane_auto_aerobatic", "every_second_attitude_of_the_plane") else { return };
    let samples = read(&path);
    let place = |t_s: f64| samples.t_s.partition_point(|t| *t < t_s);
    let flown = place(243.4)..place(297.7);
    for order in [Order::Second, Order::Third] {
        for (column, values) in COLUMNS.into_iter().zip(&samples.channels) {
            let predicted = every_second(&samples.t_s[flown.clone()], &values[flown.clone()], order);
            predicted.tell("plane_auto_aerobatic in AUTO", column, order);
            assert!(predicted.factor() > 1.0, "{column}: {}", predicted.factor());
        }
    }
}

/// Three times the log stops for half a second and more. Nobody gets a number for these without asking.
#[test]
fn gaps_are_flagged() {
    let Some(path) = log("quad_range", "gaps_are_flagged") else { return };
    let samples = read(&path);
    let gaps = [(427.679, 0.465), (428.375, 0.818), (429.422, 0.769)];
    for values in &samples.channels {
        let error = fitted(&samples.t_s, values, Order::Second, None).expect_err("gaps");
        for (at_s, length_s) in gaps {
            assert!(error.contains(&format!("{length_s} s at {at_s}")), "{error}");
        }
    }
    let fit = fitted(&samples.t_s, &samples.channels[0], Order::Second, Some(1.0)).expect("allowed");
    assert_eq!(fit.gaps.len(), gaps.len());
    for (gap, (at_s, length_s)) in fit.gaps.iter().zip(gaps) {
        assert!((gap.from_s - at_s).abs() < 1e-9 && (gap.length_s() - length_s).abs() < 1e-9, "{gap:?}");
        // In its middle the curve knows far less than beside it.
        let [middle, beside] = [gap.from_s + 0.5 * length_s, gap.from_s].map(|t_s| fit.at(t_s).expect("inside").sigma);
        assert!(middle > 5.0 * beside, "{gap:?}: {middle} {beside}");
    }
}
