//! Gradients and their directions.

use super::inputs::{Aligned, Inputs};
use super::{Outcome, same};
use crate::matching::kernels::gradients::{CHANNELS, FOURS, Four, WIDTH, armv7em, portable};

type Line = [[Four; CHANNELS]; FOURS];

/// What is not written stays that.
const BEFORE: Line = [[[0x5555_5555; 2]; CHANNELS]; FOURS];

fn same_lines(expected: &Line, found: &Line) -> Outcome {
    same(expected.as_flattened().as_flattened(), found.as_flattened().as_flattened())
}

/// Gradients of any pixels, the first so many fours.
fn line(inputs: &mut Inputs, count: usize) -> ([[u8; WIDTH]; 3], Line) {
    let bytes: Aligned<{ 3 * WIDTH }> = inputs.bytes();
    let mut rows = [[0; WIDTH]; 3];
    rows.as_flattened_mut().copy_from_slice(&bytes.0);
    let mut line = BEFORE;
    portable::gradients(rows.each_ref(), &mut line[..count]);
    (rows, line)
}

#[inline]
pub(super) fn gradients(inputs: &mut Inputs) -> Outcome {
    let count = inputs.below(FOURS + 1);
    let (rows, expected) = line(inputs, count);
    let mut found = BEFORE;
    armv7em::gradients(rows.each_ref(), &mut found[..count]);
    same_lines(&expected, &found)
}

#[inline]
pub(super) fn directions(inputs: &mut Inputs) -> Outcome {
    let count = inputs.below(FOURS + 1);
    let (_, mut expected) = line(inputs, FOURS);
    let mut found = expected;
    let energy = (1 + inputs.word() % (1 << 23)) >> inputs.below(20);
    portable::directions(&mut expected[..count], energy.max(1));
    armv7em::directions(&mut found[..count], energy.max(1));
    same_lines(&expected, &found)
}

#[inline]
pub(super) fn smooth(inputs: &mut Inputs) -> Outcome {
    let mut lines = [BEFORE; 3];
    lines.as_flattened_mut().as_flattened_mut().as_flattened_mut().fill_with(|| inputs.word());
    let (channel, first, count) = (inputs.below(CHANNELS), inputs.below(FOURS + 1), inputs.below(FOURS + 1));
    let (mut expected, mut found) = ([[0x55; 4]; FOURS], [[0x55; 4]; FOURS]);
    let rows = lines.each_ref().map(|line| line.as_slice());
    portable::smooth(rows, channel, first, &mut expected[..count]);
    armv7em::smooth(rows, channel, first, &mut found[..count]);
    same(expected.as_flattened(), found.as_flattened())
}
