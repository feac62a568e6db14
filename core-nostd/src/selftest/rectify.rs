//! Border integrals, means of cells, bilinear readings.

use super::inputs::{Aligned, Inputs};
use super::{Outcome, same};
use crate::rectify::kernels::{armv7em, portable};
use crate::rectify::nodes::Node;
use crate::rectify::stretch::{Draft, Frame, Stretch};
use crate::rectify::table::Table;
use crate::reduce::Reduction;

/// Nodes of a line: one more than the largest length.
const NODES: usize = 32;

/// Nodes anywhere in `size` boxes.
#[inline]
fn nodes<const N: usize>(inputs: &mut Inputs, size: (u16, u16)) -> [Node; N] {
    let mut at = |boxes: u16| inputs.below((boxes as usize) << 8) as i32;
    let positions: [[i32; 2]; N] = core::array::from_fn(|_| [at(size.0), at(size.1)]);
    positions.map(|at| Node { at, integrals: [inputs.word(), inputs.word()] })
}

#[inline]
fn integrals(nodes: &[Node; 2 * NODES]) -> [u32; 4 * NODES] {
    core::array::from_fn(|i| nodes[i / 2].integrals[i % 2])
}

#[inline]
pub(super) fn border_integrals(inputs: &mut Inputs) -> Outcome {
    // Few long rows or more short ones; two bytes a box and four a row.
    let size = if inputs.below(2) == 0 { (254, 3) } else { (14, 48) };
    let sums: Aligned<1536> = inputs.bytes();
    let reduction = Reduction::choose(size, 3.0, usize::MAX).map_err(|_| (0, 0, 0))?;
    let table = Table::new(&sums.0[..reduction.bytes()], reduction).ok_or((0, 0, 0))?;
    let before = nodes::<{ 2 * NODES }>(inputs, size);
    let count = inputs.length();
    // To the next node, to the line below, to the line above.
    for (first, border) in [(0, (false, 1)), (0, (true, NODES as isize)), (NODES, (true, -(NODES as isize)))] {
        let (mut expected, mut found) = (before, before);
        let is_whole = portable::border_integrals(&table, &mut expected, first, border, count);
        let was_whole = armv7em::border_integrals(&table, &mut found, first, border, count);
        same(&integrals(&expected), &integrals(&found))?;
        same(&[u32::from(is_whole)], &[u32::from(was_whole)])?;
    }
    Ok(())
}

#[inline]
pub(super) fn cell_means(inputs: &mut Inputs) -> Outcome {
    // Small cells as in a patch, or any.
    let size = if inputs.below(2) == 0 { (2, 2) } else { (256, 256) };
    let (upper, lower) = (nodes::<NODES>(inputs, size), nodes::<NODES>(inputs, size));
    let shift = inputs.below(9) as u32;
    let (mut expected, mut found) = ([0x55; NODES], [0x55; NODES]);
    let count = inputs.length();
    let nodes = (count + 1).saturating_sub(usize::from(inputs.below(8) == 0));
    let areas = portable::cell_means(&upper[..nodes], &lower, shift, &mut expected[..count]);
    let areas_found = armv7em::cell_means(&upper[..nodes], &lower, shift, &mut found[..count]);
    same(&expected, &found)?;
    same(&[areas], &[areas_found])
}

/// Columns and rows of the frame.
const FRAME: (u16, u16) = (37, 20);

/// A stretch of `count` readings in the frame at `turns` steps; one that stays where it begins, if what was tried leaves it.
#[inline]
fn stretch(inputs: &mut Inputs, (turns, count): (usize, usize)) -> Option<Stretch> {
    for _ in 0..8 {
        let mut draft = Draft::new();
        for (axis, pixels) in [FRAME.0, FRAME.1].into_iter().enumerate() {
            let end = (pixels as usize - 1) << 16;
            let (from, to) = (inputs.below(end) as i32, inputs.below(end) as i32);
            // Steps are Q24; they change by up to an eighth on the way.
            let step = ((to - from) as i64 * 256 / count.max(1) as i64) as i32;
            let growth = inputs.around_zero(step.abs() / (8 * turns.max(1) as i32) + 1);
            draft.set(axis, [from, step, growth], turns, count, pixels);
        }
        let found = draft.checked();
        if found.is_some() {
            return found;
        }
    }
    let mut draft = Draft::new();
    draft.set(0, [9 << 16, 0, 0], turns, count, FRAME.0);
    draft.set(1, [5 << 16, 0, 0], turns, count, FRAME.1);
    draft.checked()
}

#[inline]
pub(super) fn blend_along(inputs: &mut Inputs) -> Outcome {
    let pixels: Aligned<{ FRAME.0 as usize * FRAME.1 as usize }> = inputs.bytes();
    let frame = Frame::new(&pixels.0, Reduction::none(FRAME)).map_err(|_| (0, 0, 0))?;
    let fours = inputs.length();
    let stretch = stretch(inputs, (2 * fours, 4 * fours)).ok_or((0, 0, 0))?;
    let (mut expected, mut found) = ([[0x55; 4]; 32], [[0x55; 4]; 32]);
    portable::blend_along(&frame, &stretch, &mut expected[..fours]);
    armv7em::blend_along(&frame, &stretch, &mut found[..fours]);
    same(expected.as_flattened(), found.as_flattened())
}

#[inline]
pub(super) fn blend_steeply(inputs: &mut Inputs) -> Outcome {
    let pixels: Aligned<{ FRAME.0 as usize * FRAME.1 as usize }> = inputs.bytes();
    let frame = Frame::new(&pixels.0, Reduction::none(FRAME)).map_err(|_| (0, 0, 0))?;
    let count = 4 * inputs.length() + inputs.below(4);
    let stretch = stretch(inputs, (count, count)).ok_or((0, 0, 0))?;
    let (mut expected, mut found) = ([0x55; 128], [0x55; 128]);
    portable::blend_steeply(&frame, &stretch, &mut expected[..count]);
    armv7em::blend_steeply(&frame, &stretch, &mut found[..count]);
    same(&expected, &found)
}
