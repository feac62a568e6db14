//! The loops on any machine.

use super::{Pair, Weighing};
use crate::arch::portable::dot;
use crate::packed::{ONES, SIGNS, across as shifted, bytes, high, low, pack};

/// Σ w of the products of (x, y, p): xx, xy, xp, yy, yp, pp; products with a weight fit 16 bits.
#[inline(always)]
pub(crate) fn weighed_products(pairs: &[Pair]) -> [i32; 6] {
    let mut sums = [0; 6];
    for &Pair { x, y, p, w, .. } in pairs {
        let weigh = |z: u32| pack(low(w) * low(z), high(w) * high(z));
        let (wx, wy, wp) = (weigh(x), weigh(y), weigh(p));
        for (sum, (a, b)) in sums.iter_mut().zip([(wx, x), (wx, y), (wx, p), (wy, y), (wy, p), (wp, p)]) {
            *sum = dot(a, b, *sum);
        }
    }
    sums
}

/// Σ w x, Σ w y, Σ w p, Σ w, then Σ w e of x, y, p, 1 and e.
#[inline(always)]
pub(crate) fn weighed_sums(pairs: &[Pair]) -> [i32; 9] {
    let mut sums = [0; 9];
    for &Pair { x, y, p, w, we, e } in pairs {
        let terms = [(w, x), (w, y), (w, p), (w, ONES), (we, x), (we, y), (we, p), (we, ONES), (we, e)];
        for (sum, (a, b)) in sums.iter_mut().zip(terms) {
            *sum = dot(a, b, *sum);
        }
    }
    sums
}

/// Four rows of a picture, `stride` bytes apart, the first at `pixels`, weighed by `weights` of at most 256 in all and
/// less 2^15: columns 0 and 1 of each four in a word, then 2 and 3. `None` where there are no such pixels.
#[inline(always)]
pub(crate) fn weigh_rows(pixels: &[u8], stride: usize, weights: [u32; 4], out: &mut [[u32; 2]]) -> Option<()> {
    let needed = stride.checked_mul(3)?.checked_add(4 * out.len())?;
    if pixels.len() < needed {
        return None;
    }
    for (index, out) in out.iter_mut().enumerate() {
        let rows = [0, 1, 2, 3].map(|row| {
            let four = pixels[row * stride + 4 * index..].first_chunk().copied().unwrap_or_default();
            bytes(u32::from_le_bytes(four))
        });
        let sum = |i: usize| rows.iter().zip(weights).map(|(row, weight)| row[i] * weight).sum::<u32>() ^ SIGNS;
        let (even, odd) = (sum(0), sum(1));
        *out = [(even & 0xffff) | odd << 16, even >> 16 | (odd & 0xffff_0000)];
    }
    Some(())
}

/// e, w and their product for fours of pixels, pixels 0 and 2, then 1 and 3. `columns`: of the reference, two a word, one
/// four more than pixels. e is limited to 13 bits.
#[inline(always)]
pub(crate) fn weigh_residuals(fours: &mut [[Pair; 2]], columns: &[[u32; 2]], weighing: &Weighing<'_>) {
    if columns.len() <= fours.len() {
        return;
    }
    let &Weighing { across, gain, rest, bins, weights } = weighing;
    for ([even, odd], columns) in fours.iter_mut().zip(columns.windows(2)) {
        // Columns 0 1, 2 3 and 4 5, then 1 2, 3 4 and 5 6.
        let ([a, b], [c, d]) = (columns[0], columns[1]);
        let (ab, bc, cd) = (shifted(a, b), shifted(b, c), shifted(c, d));
        for (pair, (first, second, third)) in [(even, (a, b, c)), (odd, (ab, bc, cd))] {
            let e = [(low(pair.p), first, second), (high(pair.p), second, third)].map(|(p, first, second)| {
                let rest = rest.wrapping_sub(gain.wrapping_mul(p));
                (dot(second, across[1], dot(first, across[0], rest)) >> 12).clamp(-4096, 4095)
            });
            let w = e.map(|e| {
                let bin = (e.wrapping_mul(bins) >> 16).clamp(-128, 127);
                weights[(bin + 128) as usize] as i32
            });
            (pair.w, pair.we, pair.e) = (pack(w[0], w[1]), pack(w[0] * e[0], w[1] * e[1]), pack(e[0], e[1]));
        }
    }
}
