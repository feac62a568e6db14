//! The loops on any machine, several pixels in a word where their sums fit.

use super::COLS;

/// Bytes of a row of pixels: one more than values to each side, in whole words.
const WIDTH: usize = COLS + 4;
/// The even bytes of a word, each with room for a sum.
const EVEN: u32 = 0x00FF_00FF;

/// Four bytes of a row from column `at` on, the even ones and the odd ones.
#[inline(always)]
fn four<const N: usize>(row: &[u8; N], word: usize) -> (u32, u32) {
    let four = row.as_chunks::<4>().0.get(word).map_or(0, |four| u32::from_le_bytes(*four));
    (four & EVEN, four >> 8 & EVEN)
}

/// Weighted sums of columns, 1 2 1, of four of them.
#[inline(always)]
fn columns<const N: usize>(rows: [&[u8; N]; 3], word: usize) -> (u32, u32) {
    let [above, own, below] = rows.map(|row| four(row, word));
    (above.0 + 2 * own.0 + below.0, above.1 + 2 * own.1 + below.1)
}

/// Sobel's gradients along the row in the middle, for the first `count` values.
#[inline(always)]
fn gradients(rows: [&[u8; WIDTH]; 3], count: usize, mut each: impl FnMut(usize, i32, i32)) {
    /// Makes differences of bytes positive.
    const BIAS: u32 = 0x0100_0100;
    let differences = |word: usize| {
        let (above, below) = (four(rows[0], word), four(rows[2], word));
        (below.0 + BIAS - above.0, below.1 + BIAS - above.1)
    };
    // Sums and biased differences of four columns, and of the next four: values 0 to 3 lie at columns 1 to 4.
    let (mut sums, mut falls) = (columns(rows, 0), differences(0));
    for word in 0..count.div_ceil(4) {
        let (next_sums, next_falls) = (columns(rows, word + 1), differences(word + 1));
        // At columns 1 and 3, and at 2 and 4, a half of a word each: 16 bits of two's complement.
        let right = |now: u32, next: u32| now >> 16 | next << 16;
        let (sums_2, sums_3) = (right(sums.0, next_sums.0), right(sums.1, next_sums.1));
        let x = (halves_less(sums_2, sums.0), halves_less(sums_3, sums.1));
        let (falls_2, falls_3) = (right(falls.0, next_falls.0), right(falls.1, next_falls.1));
        let y = (falls.0 + 2 * falls.1 + falls_2, falls.1 + 2 * falls_2 + falls_3);
        let at = 4 * word;
        let low = |half: u32| half as u16 as i16 as i32;
        let high = |half: u32| (half >> 16) as u16 as i16 as i32;
        // Four times the bias of a difference.
        let fall = |half: i32| half - 0x400;
        each(at, low(x.0), fall(low(y.0)));
        each(at + 1, low(x.1), fall(low(y.1)));
        each(at + 2, high(x.0), fall(high(y.0)));
        each(at + 3, high(x.1), fall(high(y.1)));
        (sums, falls) = (next_sums, next_falls);
    }
}

/// Differences of both halves, of numbers below 2^15.
#[inline(always)]
fn halves_less(a: u32, b: u32) -> u32 {
    const TOP: u32 = 0x8000_8000;
    ((a | TOP) - b) ^ TOP
}

/// m² of the row in the middle, for the first `count` values.
#[inline(always)]
pub(crate) fn energies(rows: [&[u8; WIDTH]; 3], count: usize, out: &mut [u32; COLS]) {
    gradients(rows, count, |at, x, y| {
        if let Some(out) = out.get_mut(at) {
            *out = (x * x + y * y) as u32;
        }
    });
}

/// Both channels of the row in the middle, at least the first `count` of them, 128 more than they are: ±127 for a length of 1, rounded to
/// nearest.
#[inline(always)]
pub(crate) fn directions(rows: [&[u8; WIDTH]; 3], energy: f32, count: usize, out: &mut [[u8; COLS]; 2]) {
    let [first, second] = out;
    // A positive number is rounded by its whole part.
    let rounded = |value: f32| (value + 128.5) as u32 as u8;
    gradients(rows, count, |at, x, y| {
        if let (Some(first), Some(second)) = (first.get_mut(at), second.get_mut(at)) {
            let (xx, yy) = (x * x, y * y);
            let per = 127.0 / ((xx + yy) as f32 + energy);
            *first = rounded((xx - yy) as f32 * per);
            *second = rounded((2 * x * y) as f32 * per);
        }
    });
}

/// Words of values, four by four from `first` on, each with its surroundings weighed by 1 2 1 along both axes, rounded to nearest; of values
/// that are 128 more than they are, bytes of two's complement. Value 0 lies at column 1.
#[inline(always)]
pub(crate) fn smooth(rows: [&[u8; COLS]; 3], first: usize, out: &mut [[u8; 4]]) {
    /// Half of the sum of weights, in both halves.
    const HALF: u32 = 0x0008_0008;
    const SIGNS: u32 = 0x8080_8080;
    let mut now = columns(rows, first);
    for (word, out) in (first + 1..).zip(out) {
        let next = columns(rows, word);
        let right = |now: u32, next: u32| now >> 16 | next << 16;
        let (two, three) = (right(now.0, next.0), right(now.1, next.1));
        // Columns 1 and 3, and 2 and 4.
        let even = (now.0 + 2 * now.1 + two + HALF) >> 4 & EVEN;
        let odd = (now.1 + 2 * two + three + HALF) >> 4 & EVEN;
        *out = ((even | odd << 8) ^ SIGNS).to_le_bytes();
        now = next;
    }
}
