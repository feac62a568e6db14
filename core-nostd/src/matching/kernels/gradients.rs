//! Gradients and their doubled angles, a row at a time.

pub(crate) mod portable;
#[cfg(feature = "dsp")]
pub(crate) mod armv7em;

#[cfg(feature = "dsp")]
pub(in crate::matching) use armv7em::{directions, gradients, smooth};
pub(in crate::matching) use portable::energies;
#[cfg(not(feature = "dsp"))]
pub(in crate::matching) use portable::{directions, gradients, smooth};

/// Values of a pixel.
pub(crate) const CHANNELS: usize = 2;
/// Pixels of a row that are made at a time: what a strip takes fits a kilobyte of stack.
pub(crate) const STRIP: usize = 64;
/// Those and one more to each side, four by four.
pub(crate) const FOURS: usize = STRIP / 4 + 1;
/// Bytes of a row of pixels: one more than values to each side, in whole words.
pub(crate) const WIDTH: usize = 4 * (FOURS + 1);

/// Numbers of four neighbouring pixels: of the first and the third, and of the second and the fourth, in the halves of a word each, two's
/// complement.
pub(crate) type Four = [u32; 2];

/// A channel of a gradient whose length is 1 before it is smoothed: 16 times as fine as after that, and sixteen of it fit a half of a word.
pub(crate) const ONE: u32 = 127 << 4;
/// [`ONE`] · 2^18 over numbers from 1 to 2 of eight binary digits, which they begin with: over the middle of what each stands for, they
/// are off by a fifth of a percent at most.
static RECIPROCALS: [i32; 256] = {
    let mut table = [0; 256];
    let mut at = 0;
    while at < table.len() {
        let middle = 2 * at as u64 + 513;
        table[at] = (((ONE as u64) << 27) / middle) as i32;
        at += 1;
    }
    table
};

#[cfg(test)]
mod tests {
    use super::portable::unpacked;
    use super::{FOURS, Four, ONE, STRIP, WIDTH, directions, energies, gradients, smooth};

    fn rows() -> [[u8; WIDTH]; 3] {
        core::array::from_fn(|row| {
            core::array::from_fn(|col| ((row * 97 + col * 57) as u8).wrapping_mul(col as u8 | 1))
        })
    }

    /// The gradient at a column of a strip, by Sobel's two masks.
    fn gradient(rows: &[[u8; WIDTH]; 3], col: usize) -> (f64, f64) {
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
        for energy in [4, 5000, 3_000_000] {
            let mut line = [[[0; 2]; 2]; FOURS];
            gradients([&rows[0], &rows[1], &rows[2]], &mut line);
            let sizes = line.map(energies);
            directions(&mut line, energy);
            for col in 0..4 * FOURS {
                let (x, y) = gradient(&rows, col);
                let square = x * x + y * y;
                assert_eq!(f64::from(sizes[col / 4][col % 4]), square);
                let length = f64::from(ONE) * square / (square + f64::from(energy));
                let expected = (2.0 * y.atan2(x)).sin_cos();
                let found = line[col / 4].map(|four: Four| f64::from(unpacked(four)[col % 4]));
                // A fifth of a percent, and what is below a whole number.
                assert!((found[0] - length * expected.1).abs() < 0.002 * length + 1.0, "{col}");
                assert!((found[1] - length * expected.0).abs() < 0.002 * length + 1.0, "{col}");
            }
        }
    }

    #[test]
    fn surroundings_are_weighed_by_1_2_1() {
        let value = |row: usize, col: usize| ((row * 731 + col * 977) % (2 * ONE as usize)) as i32 - ONE as i32;
        let lines: [[[Four; 2]; FOURS]; 3] = core::array::from_fn(|row| {
            core::array::from_fn(|four| {
                let half = |col: usize| u32::from(value(row, 4 * four + col) as u16);
                [[0; 2], [half(0) | half(2) << 16, half(1) | half(3) << 16]]
            })
        });
        for first in [0, 5] {
            let mut out = [[0; 4]; STRIP / 4 - 5];
            smooth([&lines[0], &lines[1], &lines[2]], 1, first, &mut out);
            for (at, &byte) in out.as_flattened().iter().enumerate() {
                let weights = [1.0, 2.0, 1.0];
                let own = |i: usize| f64::from(value(i / 3, 4 * first + at + i % 3)) / 16.0;
                let sum: f64 = (0..9).map(|i| weights[i / 3] * weights[i % 3] * own(i)).sum();
                assert!((f64::from(byte as i8) - sum / 16.0).abs() <= 0.5, "{at}");
            }
        }
    }
}
