//! Exact area averages of cells by integrals along their borders.
//!
//! The integral of the boxes over a cell is, by Green's theorem, ∮ F dy around it, where F(x, y) is the sum of the row of
//! boxes at y up to x: the table that the reducer has made. Two neighbours share a border, so each is integrated once.
//! A border is cut where it passes from one row of boxes to the next, and F is read at the middle of each piece. What is
//! rounded is the node, to 1/256 of a box, and F between the borders of a box; a picture of one grey comes out exactly.
//!
//! Readings spread over the cell would have to be four times as many, and would still blur by the pixel that each of
//! them blends.

use super::RectifyError;
use super::kernels::{border_integrals, cell_means};
use super::nodes::{Lines, Node};
use super::table::Table;
use crate::homography::FrameFromPatch;
use crate::image::Run;
use heapless::VecView;

/// [`border_integrals`] of nodes that lie in the table; `false` where they are not all there, or too far apart for the
/// numbers, which in a row of up to 256 boxes no two are.
fn integrate(table: &Table<'_>, nodes: &mut [Node], first: usize, border: (bool, isize), count: usize) -> bool {
    let line = |first: usize| nodes.get(first..first + count);
    let Some((from, to)) = line(first).zip(first.checked_add_signed(border.1).and_then(line)) else { return false };
    (table.reduction().size().0 <= WIDEST || are_near(from, to)) && border_integrals(table, nodes, first, border, count)
}

/// Boxes of a row across which borders may lead anywhere.
const WIDEST: u16 = 256;

/// Whether each two nodes lie less than [`WIDEST`] boxes apart along rows.
#[inline(never)]
fn are_near(from: &[Node], to: &[Node]) -> bool {
    from.iter().zip(to).all(|(a, b)| a.at[0].abs_diff(b.at[0]) < (WIDEST as u32) << 8)
}

/// Bit that no cell's area has, Q15 of the area of a box: 128 boxes.
const AREA_MAX: u32 = 128 << 15;

/// Rectifies into `patch`, row-major, `map.size()` pixels, row 0 north: each the average over its cell. Pixels outside
/// every run are 0; a cell is valid when it lies wholly in the frame. `nodes`: scratch.
///
/// # Errors
/// [`RectifyError::Capacity`] for fewer than two nodes a patch column and two more.
pub(super) fn rectify(
    map: &FrameFromPatch<'_>,
    table: Table<'_>,
    patch: &mut [u8],
    nodes: &mut [Node],
    runs: &mut VecView<Run>,
) -> Result<(), RectifyError> {
    let (cols, rows) = (map.size().0 as usize, map.size().1);
    let nodes = nodes.get_mut(..2 * (cols + 1)).ok_or(RectifyError::Capacity)?;
    let (mut upper, mut lower) = (0, cols + 1);
    let lines = Lines::plan(map, table.reduction());
    let shift = table.reduction().shift();
    let line = |row: u16, first: usize, nodes: &mut [Node]| {
        let inside = lines.nodes(map, row, nodes.get_mut(first..first + cols + 1).unwrap_or(&mut []));
        // The last one has no next one.
        let borders = inside.len().saturating_sub(1);
        if integrate(&table, nodes, first + inside.start, (false, 1), borders) { inside } else { 0..0 }
    };
    let mut above = line(0, upper, nodes);
    for (row, out) in (0..rows).zip(patch.chunks_exact_mut(cols)) {
        let below = line(row + 1, lower, nodes);
        let both = above.start.max(below.start)..above.end.min(below.end);
        out.fill(0);
        // One cell fewer than nodes.
        if both.len() > 1 {
            let further = lower as isize - upper as isize;
            let is_whole = integrate(&table, nodes, upper + both.start, (true, further), both.len());
            let part = |first: usize| nodes.get(first + both.start..first + both.end).unwrap_or(&[]);
            let cells = both.start..both.end - 1;
            let means = out.get_mut(cells.clone()).unwrap_or(&mut []);
            let sound = is_whole && cell_means(part(upper), part(lower), shift, means) < AREA_MAX;
            let run = Run { row, start: cells.start as u16, end: cells.end as u16 };
            // Invalid pixels are 0 without exception.
            if !sound || runs.push(run).is_err() {
                out.fill(0);
            }
        }
        core::mem::swap(&mut upper, &mut lower);
        above = below;
    }
    Ok(())
}
