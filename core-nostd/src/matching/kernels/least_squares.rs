//! The inner loops of least-squares matching, over pairs of pixels.

pub(crate) mod portable;
#[cfg(feature = "dsp")]
pub(crate) mod armv7em;

#[cfg(feature = "dsp")]
pub(in crate::matching) use armv7em::{weigh_residuals, weigh_rows, weighed_products, weighed_sums};
#[cfg(not(feature = "dsp"))]
pub(in crate::matching) use portable::{weigh_residuals, weigh_rows, weighed_products, weighed_sums};

/// The numbers of two pixels, two columns apart.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[repr(C)]
pub(crate) struct Pair {
    /// Grey difference of the neighbours along columns.
    pub(crate) x: u32,
    /// Grey difference of the neighbours along rows.
    pub(crate) y: u32,
    /// Grey.
    pub(crate) p: u32,
    /// Weight.
    pub(crate) w: u32,
    /// Weight times residual.
    pub(crate) we: u32,
    /// Residual.
    pub(crate) e: u32,
}

/// How a residual follows from a pixel, and its weight from that.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Weighing<'a> {
    /// Weights of four columns, two a word.
    pub(crate) across: [u32; 2],
    /// Taken off for each grey level of the patch, and added to all.
    pub(crate) gain: i32,
    /// What is added to all.
    pub(crate) rest: i32,
    /// Bins per residual, Q16.
    pub(crate) bins: i32,
    /// Weights of the bins from −128 to 127.
    pub(crate) weights: &'a [u8; 256],
}

#[cfg(test)]
mod tests {
    use super::{Pair, Weighing, weigh_residuals, weigh_rows, weighed_products, weighed_sums};
    use crate::packed::{high, low, pack};

    /// Numbers of pixels, which have nothing to do with each other.
    fn pairs() -> [Pair; 6] {
        let number = |i: usize, most: i32| (i as i32 * 7919 + 13 * (i * i) as i32).rem_euclid(2 * most + 1) - most;
        core::array::from_fn(|i| {
            let two = |k: usize, most| [number(12 * i + k, most), number(12 * i + k + 5, most)];
            let (x, y, p, e) = (two(0, 255), two(1, 255), two(2, 128), two(3, 500));
            let w = two(4, 32).map(|w| w + 32);
            let we = [w[0] * e[0], w[1] * e[1]];
            let [x, y, p, w, we, e] = [x, y, p, w, we, e].map(|[first, second]| pack(first, second));
            Pair { x, y, p, w, we, e }
        })
    }

    #[test]
    fn sums_are_over_all_pixels() {
        let (mut products, mut sums) = ([0; 6], [0; 9]);
        let pairs = pairs();
        for pair in &pairs {
            for half in [low, high] {
                let [x, y, p, w, e] = [pair.x, pair.y, pair.p, pair.w, pair.e].map(half);
                for (sum, term) in products.iter_mut().zip([x * x, x * y, x * p, y * y, y * p, p * p]) {
                    *sum += w * term;
                }
                for (sum, term) in sums.iter_mut().zip([x, y, p, 1, e * x, e * y, e * p, e, e * e]) {
                    *sum += w * term;
                }
            }
        }
        assert_eq!((weighed_products(&pairs), weighed_sums(&pairs)), (products, sums));
        assert_eq!((weighed_products(&[]), weighed_sums(&[])), ([0; 6], [0; 9]));
    }

    #[test]
    fn rows_and_residuals_are_weighed() {
        const STRIDE: usize = 17;
        let pixels: [u8; 4 * STRIDE] = core::array::from_fn(|i| (i * i * 31 + 7 * i) as u8);
        let (down, across) = ([10, 150, 90, 6], [40, 160, 50, 6]);
        let mut columns = [[0; 2]; 4];
        assert_eq!(weigh_rows(&pixels, STRIDE, down, &mut columns), Some(()));
        assert_eq!(weigh_rows(&pixels, STRIDE, down, &mut [[0; 2]; 5]), None, "a row too short");
        let column =
            |col: usize| (0..4).map(|row| down[row] as i32 * pixels[row * STRIDE + col] as i32).sum::<i32>() - 32_768;
        for col in 0..16 {
            let word = columns[col / 4][col % 4 / 2];
            assert_eq!([low(word), high(word)][col % 2], column(col), "column {col}");
        }
        let weights = core::array::from_fn(|i| 64 - (i as i32 - 128).unsigned_abs() as u8 / 2);
        let weighing = Weighing {
            across: [pack(across[0], across[1]), pack(across[2], across[3])],
            gain: 70_000,
            rest: -100_000,
            bins: 9_000,
            weights: &weights,
        };
        let mut fours = *pairs().as_chunks::<2>().0.first_chunk::<3>().unwrap();
        weigh_residuals(&mut fours, &columns, &weighing);
        for col in 0..12 {
            let (pair, half) = (&fours[col / 4][col % 2], if col % 4 < 2 { low } else { high });
            let read: i32 = (0..4).map(|i| across[i] * column(col + i)).sum();
            let e = ((read - 100_000 - 70_000 * half(pair.p)) >> 12).clamp(-4096, 4095);
            let w = weights[(((e * 9_000) >> 16).clamp(-128, 127) + 128) as usize] as i32;
            assert_eq!((half(pair.e), half(pair.w), half(pair.we)), (e, w, w * e), "pixel {col}");
        }
    }
}
