//! The smoother's equations written out in full and inverted by Gauss and Jordan.

use super::{near, order_of};
use plumbline_survey::smooth::{Alpha, Epochs, Options, smooth};
use plumbline_tests::seeded::Random;

type Matrix = Vec<Vec<f64>>;

fn zero(rows: usize, cols: usize) -> Matrix {
    vec![vec![0.0; cols]; rows]
}

fn product(a: &Matrix, b: &Matrix) -> Matrix {
    let entry = |row: &Vec<f64>, col: usize| row.iter().zip(b).map(|(x, below)| x * below[col]).sum();
    a.iter().map(|row| (0..b[0].len()).map(|col| entry(row, col)).collect()).collect()
}

fn transposed(a: &Matrix) -> Matrix {
    (0..a[0].len()).map(|col| a.iter().map(|row| row[col]).collect()).collect()
}

/// Gauss and Jordan with the largest pivot of a column.
fn inverse(a: &Matrix) -> Matrix {
    let n = a.len();
    let mut left = a.clone();
    let mut right = zero(n, n);
    (0..n).for_each(|i| right[i][i] = 1.0);
    for col in 0..n {
        let pivot = (col..n).max_by(|&i, &j| left[i][col].abs().total_cmp(&left[j][col].abs())).expect("a row");
        left.swap(col, pivot);
        right.swap(col, pivot);
        let scale = left[col][col];
        for matrix in [&mut left, &mut right] {
            matrix[col].iter_mut().for_each(|entry| *entry /= scale);
        }
        for row in (0..n).filter(|&row| row != col) {
            let share = left[row][col];
            for matrix in [&mut left, &mut right] {
                let from = matrix[col].clone();
                matrix[row].iter_mut().zip(from).for_each(|(entry, from)| *entry -= share * from);
            }
        }
    }
    right
}

/// Penalty of differences: each row once more the difference of the row's neighbours over their distance.
fn roughness(t: &[f64], d: usize, h: f64) -> Matrix {
    let n = t.len();
    let mut rows = zero(n, n);
    (0..n).for_each(|i| rows[i][i] = 1.0);
    for step in 1..=d {
        let next = |i: usize| -> Vec<f64> {
            let over = (t[i + step] - t[i]) / (step as f64 * h);
            rows[i + 1].iter().zip(&rows[i]).map(|(after, before)| (after - before) / over).collect()
        };
        rows = (0..n - step).map(next).collect();
    }
    for (i, row) in rows.iter_mut().enumerate() {
        let share = ((t[i + d] - t[i]) / (d as f64 * h)).sqrt();
        row.iter_mut().for_each(|entry| *entry *= share);
    }
    product(&transposed(&rows), &rows)
}

/// (P + alpha R)^-1.
fn covariance(weights: &[f64], roughness: &Matrix, alpha: f64) -> Matrix {
    let mut all = roughness.clone();
    for (i, row) in all.iter_mut().enumerate() {
        row.iter_mut().for_each(|entry| *entry *= alpha);
        row[i] += weights[i];
    }
    inverse(&all)
}

fn times(matrix: &Matrix, weights: &[f64], y: &[f64]) -> Vec<f64> {
    let entry = |row: &Vec<f64>| row.iter().zip(weights).zip(y).map(|((entry, weight), y)| entry * weight * y).sum();
    matrix.iter().map(entry).collect()
}

/// Uneven instants, weights between 0.5 and 2 of which some are 0, and samples.
fn example(random: &mut Random, n: usize, uniform: bool) -> [Vec<f64>; 3] {
    let mut t = 100.0;
    let times = (0..n).map(|_| {
        t += if uniform { 0.5 } else { random.between(0.1, 0.9) };
        t
    });
    let times: Vec<f64> = times.collect();
    let weights = (0..n).map(|i| if i % 5 == 3 { 0.0 } else { random.between(0.5, 2.0) }).collect();
    let values = times.iter().map(|t| t.sin() + 0.3 * random.normal()).collect();
    [times, weights, values]
}

#[test]
fn bands_and_full_matrices_agree() {
    let mut random = Random::new(11);
    for n in [6, 7, 12, 40] {
        for (uniform, d) in [(true, 2), (true, 3), (false, 2), (false, 3)] {
            for alpha in [0.01, 1.0, 100.0] {
                let [times, weights, values] = example(&mut random, n, uniform);
                let epochs = Epochs::new(times.clone()).expect("forward");
                assert_eq!(epochs.is_uniform(), uniform);
                let fit = smooth(&epochs, &values, &weights, &Options::new(order_of(d), Alpha::Given(alpha)));
                let fit = fit.expect("good samples");
                let full = covariance(&weights, &roughness(&times, d, epochs.spacing_s()), alpha);
                let g = self::times(&full, &weights, &values);
                let what = format!("n {n}, d {d}, alpha {alpha}, uniform {uniform}");
                let (mut edf, mut vpv) = (0.0, 0.0);
                for i in 0..n {
                    near(fit.values[i], g[i], 1e-9, &what);
                    edf += weights[i] * full[i][i];
                    vpv += weights[i] * (g[i] - values[i]).powi(2);
                }
                let freedom = weights.iter().filter(|&&weight| weight > 0.0).count() as f64 - edf;
                near(fit.edf, edf, 1e-9, &what);
                near(fit.sigma0, (vpv / freedom).sqrt(), 1e-9, &what);
                for (i, row) in full.iter().enumerate() {
                    near(fit.at_sample(i).sigma, fit.sigma0 * row[i].sqrt(), 1e-9, &what);
                }
            }
        }
    }
}

/// Between samples: the curve is linear in g, so unit curves give the factors of its variance.
#[test]
fn sigma_between_samples() {
    let mut random = Random::new(12);
    for d in [2, 3] {
        let [times, weights, values] = example(&mut random, 30, false);
        let epochs = Epochs::new(times.clone()).expect("forward");
        let fit = smooth(&epochs, &values, &weights, &Options::new(order_of(d), Alpha::Given(3.0))).expect("good");
        let full = covariance(&weights, &roughness(&times, d, epochs.spacing_s()), 3.0);
        for at in [times[0] + 0.05, times[4] + 0.03, 0.5 * (times[14] + times[15]), times[29] - 0.02] {
            let factors: Vec<f64> = (0..30)
                .map(|knot| {
                    let mut unit = vec![0.0; 30];
                    unit[knot] = 1.0;
                    natural(&times, &unit, at)
                })
                .collect();
            let g: f64 = factors.iter().zip(&fit.values).map(|(w, g)| w * g).sum();
            let variance: f64 =
                (0..30).map(|i| (0..30).map(|j| factors[i] * full[i][j] * factors[j]).sum::<f64>()).sum();
            let found = fit.at(at).expect("inside");
            near(found.value, g, 1e-10, "value");
            near(found.sigma, fit.sigma0 * variance.sqrt(), 1e-10, "sigma");
        }
    }
}

/// Stiff curves tie samples far apart: beside a sample sigma is the sample's own, which comes from the inverse's diagonal.
#[test]
fn sigma_beside_samples_of_stiff_curves() {
    let mut random = Random::new(14);
    let [times, weights, values] = example(&mut random, 600, true);
    let epochs = Epochs::new(times.clone()).expect("forward");
    for d in [2, 3] {
        let fit = smooth(&epochs, &values, &weights, &Options::new(order_of(d), Alpha::Given(1e6))).expect("good");
        for i in [0, 1, 57, 300, 598] {
            near(fit.at(times[i] + 1e-9).expect("inside").sigma, fit.at_sample(i).sigma, 1e-8, &format!("d {d}, {i}"));
        }
    }
}

/// The natural cubic spline through `y` at `at`, its second derivatives from full equations.
fn natural(t: &[f64], y: &[f64], at: f64) -> f64 {
    let n = t.len();
    let mut equations = zero(n, n);
    let mut right = vec![0.0; n];
    (equations[0][0], equations[n - 1][n - 1]) = (1.0, 1.0);
    for i in 1..n - 1 {
        let (before, after) = (t[i] - t[i - 1], t[i + 1] - t[i]);
        equations[i][i - 1] = before;
        equations[i][i] = 2.0 * (before + after);
        equations[i][i + 1] = after;
        right[i] = 6.0 * ((y[i + 1] - y[i]) / after - (y[i] - y[i - 1]) / before);
    }
    let bends = times(&inverse(&equations), &vec![1.0; n], &right);
    let i = (0..n - 1).find(|&i| at <= t[i + 1]).expect("inside");
    let (h, x) = (t[i + 1] - t[i], at - t[i]);
    let slope = (y[i + 1] - y[i]) / h - h * (2.0 * bends[i] + bends[i + 1]) / 6.0;
    y[i] + x * (slope + x * (bends[i] / 2.0 + x * (bends[i + 1] - bends[i]) / (6.0 * h)))
}

/// What each sample is predicted by the others, with the sample really taken away.
#[test]
fn leaving_out_is_leaving_out() {
    let mut random = Random::new(13);
    for d in [2, 3] {
        let [times, weights, values] = example(&mut random, 25, false);
        let epochs = Epochs::new(times).expect("forward");
        let options = Options::new(order_of(d), Alpha::Given(5.0));
        let fit = smooth(&epochs, &values, &weights, &options).expect("good");
        for i in 0..25 {
            let mut without = weights.clone();
            without[i] = 0.0;
            let other = smooth(&epochs, &values, &without, &options).expect("good");
            near(fit.left_out(i), other.values[i], 1e-11, &format!("d {d}, sample {i}"));
        }
    }
}
