//! Gradients and their doubled angles, a row at a time.

pub(crate) mod portable;

pub(in crate::matching) use portable::{directions, energies, smooth};

/// Pixels of a row that are made at a time: what a strip takes fits a kilobyte of stack.
pub(crate) const STRIP: usize = 64;
/// Those and one more to each side, in whole words.
pub(crate) const COLS: usize = STRIP + 4;

#[cfg(test)]
mod tests {
    use super::{COLS, STRIP, directions, energies, smooth};

    fn rows() -> [[u8; COLS + 4]; 3] {
        core::array::from_fn(|row| {
            core::array::from_fn(|col| ((row * 97 + col * 57) as u8).wrapping_mul(col as u8 | 1))
        })
    }

    /// The gradient at a column of a strip, by Sobel's two masks.
    fn gradient(rows: &[[u8; COLS + 4]; 3], col: usize) -> (f64, f64) {
        let mut sum = (0.0, 0.0);
        for (row, weight) in [1.0, 2.0, 1.0].into_iter().enumerate() {
            for (other, side) in [-1.0, 0.0, 1.0].into_iter().enumerate() {
                sum.0 += weight * side * f64::from(rows[row][col + other]);
                sum.1 += weight * side * f64::from(rows[other][col + row]);
            }
        }
        sum
    }

    #[test]
    fn angles_are_doubled_and_lengths_bounded() {
        let rows = rows();
        let lines = [&rows[0], &rows[1], &rows[2]];
        let (mut out, mut sizes) = ([[0; COLS]; 2], [0; COLS]);
        energies(lines, COLS, &mut sizes);
        directions(lines, 5000.0, COLS, &mut out);
        for col in 0..COLS {
            let (x, y) = gradient(&rows, col);
            let energy = x * x + y * y;
            assert_eq!(f64::from(sizes[col]), energy);
            let length = 127.0 * energy / (energy + 5000.0);
            let expected = (2.0 * y.atan2(x)).sin_cos();
            let found = out.map(|values| f64::from(values[col]) - 128.0);
            assert!((found[0] - length * expected.1).abs() < 0.502, "{col}");
            assert!((found[1] - length * expected.0).abs() < 0.502, "{col}");
        }
    }

    #[test]
    fn surroundings_are_weighed_by_1_2_1() {
        let rows: [[u8; COLS]; 3] = core::array::from_fn(|row| core::array::from_fn(|col| (row * 41 + col * 77) as u8));
        for first in [0, 5] {
            let mut out = [[0; 4]; STRIP / 4 - 5];
            smooth([&rows[0], &rows[1], &rows[2]], first, &mut out);
            for (at, &value) in out.as_flattened().iter().enumerate() {
                let weights = [1.0, 2.0, 1.0];
                let own = |i: usize| f64::from(rows[i / 3][4 * first + at + i % 3]) - 128.0;
                let sum: f64 = (0..9).map(|i| weights[i / 3] * weights[i % 3] * own(i)).sum();
                assert!((f64::from(value as i8) - sum / 16.0).abs() <= 0.5, "{at}");
            }
        }
    }
}
