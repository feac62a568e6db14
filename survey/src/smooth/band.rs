//! Symmetric positive definite band matrices of half-width 2 or 3: factors, solution, and the band of the inverse, each in
//! O(n).

/// Entries of a column that are kept: the diagonal and three below it.
const KEPT: usize = 4;

/// A symmetric matrix that is zero beyond its half-width.
#[derive(Clone, Debug)]
pub struct Band {
    /// Entries below the diagonal that may differ from zero, 3 at most.
    half_width: usize,
    /// `columns[i][k]` is the entry in row i + k and column i.
    columns: Vec<[f64; KEPT]>,
}

impl Band {
    /// All zero, `n` x `n`. `half_width` is 2 or 3.
    pub fn zero(n: usize, half_width: usize) -> Self {
        debug_assert!(half_width < KEPT, "a wider band than is kept");
        Band { half_width, columns: vec![[0.0; KEPT]; n] }
    }

    /// Adds `value` to the entry in `row` and `col`, row not above col, and to its mirror image.
    pub fn add(&mut self, row: usize, col: usize, value: f64) {
        self.columns[col][row - col] += value;
    }

    /// Largest sum of a row's amounts: a bound of the largest eigenvalue.
    pub fn norm(&self) -> f64 {
        let n = self.columns.len();
        let row = |i: usize| {
            let below: f64 = self.columns[i].iter().map(|entry| entry.abs()).sum();
            let above: f64 = (1..=self.half_width.min(i)).map(|k| self.columns[i - k][k].abs()).sum();
            below + above
        };
        (0..n).map(row).fold(0.0, f64::max)
    }

    /// L D L' = diag(`diagonal`) + `factor` times this matrix; `None` where that is not positive definite.
    pub fn factored(&self, diagonal: &[f64], factor: f64) -> Option<Factors> {
        let n = self.columns.len();
        let w = self.half_width;
        let mut lower = vec![[0.0; KEPT]; n];
        let mut pivots = vec![0.0; n];
        for i in 0..n {
            let mut column = self.columns[i].map(|entry| factor * entry);
            column[0] += diagonal[i];
            for k in 1..=w.min(i) {
                let left = lower[i - k];
                let scaled = left[k] * pivots[i - k];
                for j in 0..=w - k {
                    column[j] -= scaled * left[j + k];
                }
            }
            if column[0].is_nan() || column[0] <= 0.0 {
                return None;
            }
            pivots[i] = column[0];
            for j in 1..=w {
                lower[i][j] = column[j] / column[0];
            }
        }
        Some(Factors { half_width: w, lower, pivots })
    }
}

/// L D L' of a band matrix: L has ones on its diagonal and the band's half-width, D is diagonal and positive.
#[derive(Clone, Debug)]
pub struct Factors {
    half_width: usize,
    /// `lower[i][k]` is L in row i + k and column i; `lower[i][0]` is not used.
    lower: Vec<[f64; KEPT]>,
    pivots: Vec<f64>,
}

impl Factors {
    /// The solution x of L D L' x = b.
    pub fn solved(&self, b: &[f64]) -> Vec<f64> {
        let (n, w) = (self.pivots.len(), self.half_width);
        let mut x = b.to_vec();
        for i in 0..n {
            for k in 1..=w.min(i) {
                x[i] -= self.lower[i - k][k] * x[i - k];
            }
        }
        for i in (0..n).rev() {
            x[i] /= self.pivots[i];
            for k in 1..=w.min(n - 1 - i) {
                x[i] -= self.lower[i][k] * x[i + k];
            }
        }
        x
    }

    /// The diagonal of the inverse, from the last row upwards, with no entry outside the band ever formed (Hutchinson and
    /// de Hoog, Smoothing noisy data with spline functions, Numerische Mathematik 47, 1985).
    ///
    /// Z = L'^-1 D^-1 - (L' - I) Z has, above its diagonal, nothing of the first term; so column by column the band of Z
    /// follows from the part of the band that lies below.
    pub fn inverse_diagonal(&self) -> Vec<f64> {
        let (n, w) = (self.pivots.len(), self.half_width);
        // z[i][k] is the inverse in row i + k and column i.
        let mut z = vec![[0.0; KEPT]; n];
        for i in (0..n).rev() {
            let reach = w.min(n - 1 - i);
            let lower = self.lower[i];
            for j in 1..=reach {
                let sum: f64 = (1..=reach).map(|k| lower[k] * z[i + k.min(j)][k.abs_diff(j)]).sum();
                z[i][j] = -sum;
            }
            let sum: f64 = (1..=reach).map(|k| lower[k] * z[i][k]).sum();
            z[i][0] = 1.0 / self.pivots[i] - sum;
        }
        z.iter().map(|column| column[0]).collect()
    }

    /// w' (L D L')^-1 w for a w that is zero but for `part`, which begins at `from`.
    ///
    /// It is the sum of y^2 / D over L y = w. Behind `part` y decays; the sum ends where the newest terms no longer change
    /// it.
    pub fn quadratic_form(&self, from: usize, part: &[f64]) -> f64 {
        let w = self.half_width;
        let mut recent = [0.0; KEPT - 1];
        let mut terms = [0.0; KEPT - 1];
        let mut sum = 0.0;
        for i in from..self.pivots.len() {
            let mut y = part.get(i - from).copied().unwrap_or(0.0);
            for k in 1..=w.min(i - from) {
                y -= self.lower[i - k][k] * recent[k - 1];
            }
            let term = y * y / self.pivots[i];
            sum += term;
            recent = [y, recent[0], recent[1]];
            terms = [term, terms[0], terms[1]];
            if i >= from + part.len() + w && terms.iter().all(|&term| term < 1e-20 * sum) {
                break;
            }
        }
        sum
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A diagonally dominant band and the same as a full matrix.
    fn example(n: usize, half_width: usize) -> (Band, Vec<Vec<f64>>) {
        let mut band = Band::zero(n, half_width);
        let mut full = vec![vec![0.0; n]; n];
        let within = (0..n).flat_map(|col| (col..n.min(col + half_width + 1)).map(move |row| (row, col)));
        for (row, col) in within {
            let value = if row == col { 9.0 + col as f64 } else { ((3 * row + 5 * col) % 7) as f64 / 4.0 - 0.7 };
            band.add(row, col, value);
            (full[row][col], full[col][row]) = (value, value);
        }
        (band, full)
    }

    #[test]
    fn the_solution_solves_and_the_inverse_is_the_inverse() {
        for half_width in [2, 3] {
            for n in [1, 2, 3, 4, 9] {
                let (band, full) = example(n, half_width);
                let factors = band.factored(&vec![0.0; n], 1.0).expect("dominant");
                let diagonal = factors.inverse_diagonal();
                for i in 0..n {
                    let mut unit = vec![0.0; n];
                    unit[i] = 1.0;
                    let column = factors.solved(&unit);
                    assert!((column[i] - diagonal[i]).abs() < 1e-14, "{n} {half_width} {i}");
                    for (j, row) in full.iter().enumerate() {
                        let product: f64 = row.iter().zip(&column).map(|(a, x)| a * x).sum();
                        assert!((product - unit[j]).abs() < 1e-14, "{n} {half_width} {i} {j}");
                    }
                    assert!((factors.quadratic_form(i, &[1.0]) - diagonal[i]).abs() < 1e-14, "{n} {half_width} {i}");
                }
                let all: f64 = factors.solved(&vec![1.0; n]).iter().sum();
                assert!((factors.quadratic_form(0, &vec![1.0; n]) - all).abs() < 1e-13);
            }
        }
    }

    #[test]
    fn what_is_not_positive_definite_is_not_factored() {
        let (band, _) = example(5, 2);
        assert!(band.factored(&[0.0; 5], -1.0).is_none());
        assert!(Band::zero(5, 2).factored(&[1.0, 1.0, 0.0, 1.0, 1.0], 1.0).is_none());
        assert!(band.factored(&[f64::NAN; 5], 1.0).is_none());
    }
}
