//! The loops on any machine.

use super::{CHANNELS, Four, RECIPROCALS, WIDTH};
use core::array::from_fn;

/// Weights of three neighbours.
const WEIGHTS: [i32; 3] = [1, 2, 1];

/// The numbers of four pixels, in their order.
#[inline(always)]
pub(crate) fn unpacked([even, odd]: Four) -> [i32; 4] {
    [even as i16, odd as i16, (even >> 16) as i16, (odd >> 16) as i16].map(i32::from)
}

#[inline(always)]
fn packed(four: [i32; 4]) -> Four {
    let both = |low: i32, high: i32| u32::from(low as u16) | (high as u32) << 16;
    [both(four[0], four[2]), both(four[1], four[3])]
}

/// The sum of three neighbours of every four of six, weighed.
#[inline(always)]
fn weighed(six: [i32; 6]) -> [i32; 4] {
    from_fn(|i| WEIGHTS[0] * six[i] + WEIGHTS[1] * six[i + 1] + WEIGHTS[2] * six[i + 2])
}

/// Sobel's gradients of the row in the middle: along the row, and downwards. Value 0 lies at column 1.
#[inline(always)]
pub(crate) fn gradients(rows: [&[u8; WIDTH]; 3], out: &mut [[Four; 2]]) {
    for (word, out) in out.iter_mut().take(WIDTH / 4 - 1).enumerate() {
        let [above, own, below] = rows.map(|row| from_fn::<_, 6, _>(|col| i32::from(row[4 * word + col])));
        let sums: [i32; 6] = from_fn(|i| WEIGHTS[0] * above[i] + WEIGHTS[1] * own[i] + WEIGHTS[2] * below[i]);
        let down = weighed(from_fn(|i| below[i] - above[i]));
        *out = [packed(from_fn(|i| sums[i + 2] - sums[i])), packed(down)];
    }
}

/// m² of gradients.
#[inline(always)]
pub(crate) fn energies([x, y]: [Four; 2]) -> [u32; 4] {
    let (x, y) = (unpacked(x), unpacked(y));
    from_fn(|i| (x[i] * x[i] + y[i] * y[i]) as u32)
}

/// Makes of gradients both channels, [`super::ONE`] for a length of 1. `energy` is at least 1 and at most 2^23.
#[inline(always)]
pub(crate) fn directions(line: &mut [[Four; CHANNELS]], energy: u32) {
    for four in line {
        let [x, y] = four.map(unpacked);
        let of: [[i32; CHANNELS]; 4] = from_fn(|i| {
            let (xx, yy) = (x[i] * x[i], y[i] * y[i]);
            let length = (xx + yy) as u32 + energy;
            // From 2^31 on; the bit on top goes without saying.
            let zeros = length.leading_zeros();
            let per = RECIPROCALS[(length << zeros << 1 >> 24) as usize];
            // Of twice x y half as much, as the shift is by one less.
            [(xx - yy) << (zeros - 1), (x[i] * y[i]) << zeros]
                .map(|part| ((i64::from(part) * i64::from(per)) >> 48) as i32)
        });
        *four = from_fn(|channel| packed(of.map(|values| values[channel])));
    }
}

/// Words of values, four by four from `first` on, each with its surroundings weighed by 1 2 1 along both axes, 127 for [`super::ONE`],
/// rounded to nearest: bytes of two's complement. Value 0 lies at column 1.
#[inline(always)]
pub(crate) fn smooth(rows: [&[[Four; CHANNELS]]; 3], channel: usize, first: usize, out: &mut [[u8; 4]]) {
    /// Half of what the last byte begins with.
    const HALF: i32 = 1 << 7;
    let last = rows.iter().map(|row| row.len()).min().unwrap_or(0);
    let count = out.len().min(last.saturating_sub(first + 1));
    for (word, out) in (first..).zip(out.iter_mut().take(count)) {
        let of = |word: usize| {
            let [above, own, below] = rows.map(|row| unpacked(row[word][channel % CHANNELS]));
            from_fn::<_, 4, _>(|i| WEIGHTS[0] * above[i] + WEIGHTS[1] * own[i] + WEIGHTS[2] * below[i])
        };
        let ([a, b, c, d], [e, f, ..]) = (of(word), of(word + 1));
        *out = weighed([a, b, c, d, e, f]).map(|sum| ((sum + HALF) >> 8) as u8);
    }
}
