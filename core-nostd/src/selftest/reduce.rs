//! Sums of boxes, of 0 to 256 in a row.

use super::inputs::{Aligned, Inputs};
use super::{Outcome, same};
use crate::reduce::kernels::{armv7em, portable};

/// Most boxes of a row.
const BOXES: usize = 256;

/// Prefix sums of rows of boxes.
type Prefix<const ROWS: usize> = fn([&[u8]; ROWS], &mut [[u8; 2]]) -> (usize, i32);

/// Compares on `ROWS` rows of boxes as wide as high, with lengths and places of each row that differ a little.
#[inline]
fn compare<const ROWS: usize, const BYTES: usize>(
    inputs: &mut Inputs,
    portable: Prefix<ROWS>,
    armv7em: Prefix<ROWS>,
) -> Outcome {
    let rows: [Aligned<BYTES>; ROWS] = core::array::from_fn(|_| inputs.bytes());
    // Three quarters begin at words.
    let at = if inputs.below(4) == 0 { inputs.below(4) } else { 0 };
    let boxes = 8 * inputs.length() + inputs.below(9);
    let rows = rows.each_ref().map(|row| &row.0[at..at + ROWS * boxes + inputs.below(4)]);
    let mut sums = [[[0x55; 2]; BOXES + 2]; 2];
    let count = (boxes + 2).saturating_sub(inputs.below(4));
    let [expected, found] = &mut sums;
    let expected_end = portable(rows, &mut expected[..count]);
    let found_end = armv7em(rows, &mut found[..count]);
    same(expected.as_flattened(), found.as_flattened())?;
    same(&[expected_end.0 as i32, expected_end.1], &[found_end.0 as i32, found_end.1])
}

#[inline]
pub(super) fn prefix_pairs(inputs: &mut Inputs) -> Outcome {
    compare::<2, { 2 * BOXES + 8 }>(inputs, portable::prefix_pairs, armv7em::prefix_pairs)
}

#[inline]
pub(super) fn prefix_fours(inputs: &mut Inputs) -> Outcome {
    compare::<4, { 4 * BOXES + 8 }>(inputs, portable::prefix_fours, armv7em::prefix_fours)
}
