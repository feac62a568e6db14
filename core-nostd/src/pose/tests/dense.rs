//! The penalised least squares of paper 001 as it is written, in double precision with full matrices: the judge of the core's
//! band.

use std::vec;
use std::vec::Vec;

/// (P + α D'D) g = P `values` at unit spacing, by Gaussian elimination with pivots.
pub fn fitted(values: &[f64], weights: &[f64], order: usize, alpha: f64) -> Vec<f64> {
    let n = values.len();
    let row: &[f64] = if order == 2 { &[1.0, -2.0, 1.0] } else { &[-1.0, 3.0, -3.0, 1.0] };
    let mut a = vec![vec![0.0; n + 1]; n];
    for i in 0..n {
        a[i][i] = weights[i];
        a[i][n] = weights[i] * values[i];
    }
    for first in 0..n - order {
        for (i, left) in row.iter().enumerate() {
            for (j, right) in row.iter().enumerate() {
                a[first + i][first + j] += alpha * left * right;
            }
        }
    }
    eliminated(a)
}

fn eliminated(mut a: Vec<Vec<f64>>) -> Vec<f64> {
    let n = a.len();
    for column in 0..n {
        let pivot = (column..n).max_by(|i, j| a[*i][column].abs().total_cmp(&a[*j][column].abs())).expect("rows");
        a.swap(column, pivot);
        let top = a[column].clone();
        for row in &mut a[column + 1..] {
            let factor = row[column] / top[column];
            for (value, above) in row.iter_mut().zip(&top).skip(column) {
                *value -= factor * above;
            }
        }
    }
    let mut x = vec![0.0; n];
    for row in (0..n).rev() {
        let rest: f64 = (row + 1..n).map(|k| a[row][k] * x[k]).sum();
        x[row] = (a[row][n] - rest) / a[row][row];
    }
    x
}

/// The cubic through the four of `fitted` around `at`, by Neville's scheme.
pub fn between(fitted: &[f64], at: f64) -> f64 {
    let first = ((at.floor() as usize).max(1) - 1).min(fitted.len() - 4);
    let mut p: Vec<f64> = fitted[first..first + 4].to_vec();
    for level in 1..4 {
        for i in 0..4 - level {
            let (left, right) = ((first + i) as f64, (first + i + level) as f64);
            p[i] = ((right - at) * p[i] + (at - left) * p[i + 1]) / (right - left);
        }
    }
    p[0]
}

/// Splitmix64 noise of the reference: uniform within ±0.25.
pub struct Uniform(pub u64);

impl Uniform {
    /// Within 0 to 1.
    pub fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// The reference's e.
    pub fn noise(&mut self) -> f64 {
        -0.25 + 0.5 * self.unit()
    }
}
