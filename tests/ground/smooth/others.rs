//! Smoothers of other authors on the same samples.

use super::{counted, fitted, near};
use plumbline_survey::smooth::{Alpha, Epochs, Options, Order, smooth};
use plumbline_tests::track;
use whittaker_eilers::WhittakerSmoother;

/// Whittaker's smoother in Eilers' form has the same equations on even samples.
#[test]
fn whittaker_and_eilers() {
    let track = track::golden();
    let n = track.t_s.len();
    let weights: Vec<f64> = (0..n).map(|i| if i % 7 < 2 { 0.0 } else { 1.0 + (i % 3) as f64 }).collect();
    let epochs = Epochs::new(counted(n)).expect("forward");
    for (d, order) in [(2, Order::Second), (3, Order::Third)] {
        for alpha in [0.5, 10.0, 1000.0] {
            for weights in [vec![1.0; n], weights.clone()] {
                let theirs = WhittakerSmoother::new(alpha, d, n, None, Some(&weights)).expect("a smoother");
                let theirs = theirs.smooth(&track.observed).expect("smooth");
                let options = Options::new(order, Alpha::Given(alpha));
                let ours = smooth(&epochs, &track.observed, &weights, &options).expect("good");
                for (ours, theirs) in ours.values.iter().zip(&theirs) {
                    // 500 m at their condition number, 64,000, which they do not take the mean off for.
                    near(*ours, *theirs, 1e-8, &format!("d {d}, alpha {alpha}"));
                }
            }
        }
    }
}

/// Reinsch's smoothing spline (lambda = alpha h³) is what order 2 with even samples stands for: 0.000363 m rms apart on the
/// golden track, 0.001741 m at most, as the reference has measured.
#[test]
fn reinsch() {
    let track = track::golden();
    let theirs = spline_of_reinsch(&track.t_s, &track.observed, 100.0 * 0.2f64.powi(3));
    let ours = fitted(&track.t_s, &track.observed, 2, Alpha::Given(100.0)).values;
    let off: Vec<f64> = ours.iter().zip(&theirs).map(|(ours, theirs)| (ours - theirs).abs()).collect();
    let rms = (off.iter().map(|off| off * off).sum::<f64>() / off.len() as f64).sqrt();
    near(rms, 0.000_363, 1e-6, "rms");
    near(off.iter().copied().fold(0.0, f64::max), 0.001_741, 1e-6, "at most");
}

/// On uneven samples, which stand for the same integral: with the curve bending over 30 samples the two sums for it agree
/// to a small part of what is smoothed away.
#[test]
fn reinsch_on_uneven_samples() {
    let track = track::golden();
    let t_s: Vec<f64> = track.t_s.iter().enumerate().map(|(i, t)| t + 0.07 * (i % 3) as f64).collect();
    let epochs = Epochs::new(t_s.clone()).expect("forward");
    assert!(!epochs.is_uniform());
    let ours = fitted(&t_s, &track.observed, 2, Alpha::Given(100.0));
    let theirs = spline_of_reinsch(&t_s, &track.observed, 100.0 * epochs.spacing_s().powi(3));
    let off = ours.values.iter().zip(&theirs).map(|(ours, theirs)| (ours - theirs).powi(2)).sum::<f64>();
    let smoothed = ours.vpv;
    assert!(off < 1e-3 * smoothed, "{off} of {smoothed}");
}

/// Minimum of Σ (g - y)² + lambda ∫ g''²: (R + lambda Q'Q) gamma = Q'y, g = y - lambda Q gamma, in full and by Gauss.
fn spline_of_reinsch(t: &[f64], y: &[f64], lambda: f64) -> Vec<f64> {
    let n = t.len();
    let h: Vec<f64> = t.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let q = |j: usize| [(j, 1.0 / h[j]), (j + 1, -1.0 / h[j] - 1.0 / h[j + 1]), (j + 2, 1.0 / h[j + 1])];
    let m = n - 2;
    let mut a = vec![vec![0.0; m + 1]; m];
    for j in 0..m {
        a[j][j] += (h[j] + h[j + 1]) / 3.0;
        if j + 1 < m {
            a[j][j + 1] += h[j + 1] / 6.0;
            a[j + 1][j] += h[j + 1] / 6.0;
        }
        for (other, entry) in a[j].iter_mut().enumerate().take(m.min(j + 3)).skip(j.saturating_sub(2)) {
            for (row, value) in q(j) {
                let other_value = q(other).into_iter().find(|(other_row, _)| *other_row == row).map_or(0.0, |(_, v)| v);
                *entry += lambda * value * other_value;
            }
        }
        a[j][m] = q(j).into_iter().map(|(row, value)| value * y[row]).sum();
    }
    for col in 0..m {
        let pivot_row = a[col].clone();
        for row in a.iter_mut().skip(col + 1).take(2) {
            let share = row[col] / pivot_row[col];
            row.iter_mut().zip(&pivot_row).skip(col).for_each(|(entry, pivot)| *entry -= share * pivot);
        }
    }
    let mut gamma = vec![0.0; m];
    for row in (0..m).rev() {
        let rest: f64 = (row + 1..m.min(row + 3)).map(|col| a[row][col] * gamma[col]).sum();
        gamma[row] = (a[row][m] - rest) / a[row][row];
    }
    let mut g = y.to_vec();
    for (j, gamma) in gamma.iter().enumerate() {
        q(j).into_iter().for_each(|(row, value)| g[row] -= lambda * value * gamma);
    }
    g
}
