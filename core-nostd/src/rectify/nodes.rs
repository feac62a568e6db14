//! The corners of a patch's cells in the frame.

use super::curvature::CurvatureBound;
use super::scanline::ScanlineMap;
use crate::homography::FrameFromPatch;
use crate::reduce::Reduction;
use core::ops::Range;
use fixed::types::{I8F24, I16F16};

/// A corner between cells of the patch, and the integrals along the borders that begin there.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(C)]
pub struct Node {
    /// (x, y) from the upper left corner of the boxes, Q8 of a box.
    pub at: [i32; 2],
    /// To the next node of its line, and to the node below.
    pub integrals: [u32; 2],
}

impl Node {
    /// One that is nowhere.
    pub const NOWHERE: Node = Node { at: [0; 2], integrals: [0; 2] };
}

/// Shortest stretch of a line of nodes between two that are computed exactly, in cells: each takes two exact positions, its
/// middle and its end, so a shorter one saves nothing.
const SHORTEST: u16 = 2;
/// Position error allowed between them, boxes. Over five attitudes with tilts of up to 25°, from a sixteenth to a quarter one
/// cell in 8,000 differs from exact nodes, by a grey level.
const TOLERANCE: f32 = 1.0 / 16.0;
/// Positions beyond this and steps above that, in boxes, are refused. Q16 holds positions up to 32,768 and Q24 steps up to
/// 128: a quarter and a half of that, so that no sum on the way leaves them. A frame has 8,192 boxes at most.
const FAR: f32 = 8_000.0;
const STEP_MAX: f32 = 60.0;
/// What truncated steps of the longest stretch may add up to, boxes: over 257 nodes 257/2¹⁶ by the steps and 257²/2²⁵ by
/// their growth, 0.006 in all; ten times as much is allowed for.
const TRUNCATION_MAX: f32 = 1.0 / 16.0;

/// How every line of nodes of a patch is cut.
#[derive(Clone, Copy, Debug)]
pub(super) struct Lines {
    reduction: Reduction,
    /// Cells a stretch, one where even the shortest is too far from its parabola, near the horizon: then each node is the
    /// start of a stretch that has no length.
    cells: u16,
    /// Cells a stretch; 0 without a length.
    length: f32,
    /// One over it, or 0.
    per: f32,
}

impl Lines {
    /// The fewest stretches of equal length whose parabolas stay within a sixteenth of a box.
    pub(super) fn plan(map: &FrameFromPatch<'_>, reduction: Reduction) -> Self {
        let (cols, size, factor) = (map.size().0, reduction.size(), reduction.factor() as f32);
        let curvature = CurvatureBound::new(map, (size.0 as f32 * factor, size.1 as f32 * factor));
        // There is one node more than cells.
        let nodes = cols.saturating_add(1);
        let lengths = (1..=nodes).map(|count| nodes.div_ceil(count)).take_while(|&cells| cells >= SHORTEST);
        let near = |&cells: &u16| curvature.parabola_error(cells as f32) <= TOLERANCE * factor;
        let cells = lengths.into_iter().find(near);
        let length = cells.map_or(0.0, |cells| cells as f32);
        Lines { reduction, cells: cells.unwrap_or(1), length, per: if length > 0.0 { 1.0 / length } else { 0.0 } }
    }

    /// The nodes above patch row `row`, from the left border of the first cell to the right one of the last; which of them
    /// lie in the frame. The frame is convex, so they are neighbours; where a distortion bends the line out of it and in
    /// again, they end where it leaves.
    pub(super) fn nodes(&self, map: &FrameFromPatch<'_>, row: u16, nodes: &mut [Node]) -> Range<usize> {
        let per_factor = 1.0 / self.reduction.factor() as f32;
        let line = ScanlineMap::along(map, row as f32 - 0.5);
        let position = |col: f32| {
            let (x, y) = line.position(col - 0.5)?;
            Some([(x + 0.5) * per_factor, (y + 0.5) * per_factor])
        };
        let (cells, length) = (self.cells as usize, self.length);
        let mut inside = 0..0;
        let mut start = position(0.0);
        for (index, nodes) in nodes.chunks_mut(cells.max(1)).enumerate() {
            let first = (index * cells) as f32;
            // The last stretch may end beyond the patch: the geometry goes on there.
            let middle = position(first + 0.5 * length);
            let end = position(first + length);
            let own = match start.zip(middle).zip(end) {
                Some(((start, middle), end)) => self.follow([start, middle, end], nodes),
                None => 0..0,
            };
            let own = index * cells + own.start..index * cells + own.end;
            if inside.is_empty() {
                inside = own;
            } else if inside.end == own.start {
                inside.end = own.end;
            }
            start = if length > 0.0 { end } else { position(first + 1.0) };
        }
        inside
    }

    /// The nodes of a stretch from the first of three positions on, where the second is half of its length and the third all
    /// of it further, in boxes; which of them lie in the frame.
    #[inline(never)]
    fn follow(&self, [start, middle, end]: [[f32; 2]; 3], nodes: &mut [Node]) -> Range<usize> {
        let (cols, rows) = self.reduction.size();
        let steps = (self.length, self.per);
        let x = Axis::through(start[0], middle[0], end[0], steps, cols as f32);
        let y = Axis::through(start[1], middle[1], end[1], steps, rows as f32);
        let Some((mut x, mut y)) = x.zip(y) else { return 0..0 };
        for node in nodes.iter_mut() {
            node.at = [x.next(), y.next()];
        }
        if x.is_inside && y.is_inside {
            return 0..nodes.len();
        }
        // As unsigned numbers, negative ones are large.
        let is_inside =
            |node: &Node| (node.at[0] as u32) < (cols as u32) << 8 && (node.at[1] as u32) < (rows as u32) << 8;
        let first = nodes.iter().take_while(|node| !is_inside(node)).count();
        first..first + nodes.iter().skip(first).take_while(|node| is_inside(node)).count()
    }
}

/// Coordinates at equal steps along a parabola, boxes.
struct Axis {
    at: I16F16,
    step: I8F24,
    growth: I8F24,
    /// Whether all of them lie in the frame.
    is_inside: bool,
}

impl Axis {
    /// From the first of three coordinates through the second, after `steps` at the third; `per` is one over them. `None`
    /// where any of it is so far away that numbers do not hold it; the frame, of 0 to `limit`, ends long before.
    #[inline(never)]
    fn through(start: f32, middle: f32, end: f32, (steps, per): (f32, f32), limit: f32) -> Option<Axis> {
        let growth = 4.0 * (start - 2.0 * middle + end) * (per * per);
        let step = (4.0 * middle - 3.0 * start - end) * per + 0.5 * growth;
        let (least, most) = if start < end { (start, end) } else { (end, start) };
        let slow = step.abs() < STEP_MAX && (step + steps * growth).abs() < STEP_MAX;
        // With slow steps the middle is not far where the ends are not.
        if !(least > -FAR && most < FAR && slow) {
            return None;
        }
        // A parabola is off its chord by an eighth of its growth over all steps; truncation takes less than the rest.
        let margin = 0.125 * (growth * steps * steps).abs() + TRUNCATION_MAX;
        // A cast is one instruction, the crate's own conversion a hundred.
        let q24 = |boxes: f32| I8F24::from_bits((boxes * 16_777_216.0) as i32);
        Some(Axis {
            at: I16F16::from_bits((start * 65536.0) as i32),
            step: q24(step),
            growth: q24(growth),
            is_inside: least >= margin && most + margin < limit,
        })
    }

    /// The coordinate in Q8, and one step on.
    #[inline(always)]
    fn next(&mut self) -> i32 {
        let at = self.at.to_bits() >> 8;
        self.at += I16F16::from_bits(self.step.to_bits() >> 8);
        self.step += self.growth;
        at
    }
}
