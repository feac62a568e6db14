//! The loops on any machine.

use super::blend;
use crate::rectify::nodes::Node;
use crate::rectify::stretch::{Frame, Stretch};
use crate::rectify::table::Table;

/// Integral along one border of each of `count` nodes from `first` on, the upper one or, where `is_left`, the left one:
/// ∫ F dy from the node to the one `further` behind it, in 2⁻¹⁵ of a grey level times the area of a box, modulo 2^32.
/// F(x, y) is the sum of the boxes left of x in the row at y, read from `table`.
///
/// The border is cut where it passes from one row of boxes to the next, and F read at the middle of each piece.
///
/// `false` where `nodes` does not hold all of them. All lie in the table, and no two that are connected lie 256 boxes apart
/// along a row.
pub(crate) fn border_integrals(
    table: &Table<'_>,
    nodes: &mut [Node],
    first: usize,
    (is_left, further): (bool, isize),
    count: usize,
) -> bool {
    for index in first..first + count {
        let other = index.checked_add_signed(further).and_then(|other| nodes.get(other)).copied();
        let (Some(node), Some(other)) = (nodes.get_mut(index), other) else { return false };
        node.integrals[usize::from(is_left)] = if other.at[1] >> 8 >= node.at[1] >> 8 {
            border_integral(table, node.at, other.at)
        } else {
            border_integral(table, other.at, node.at).wrapping_neg()
        };
    }
    true
}

/// One of [`border_integrals`], from `a` to `b`, which is not in a row above.
fn border_integral(table: &Table<'_>, [ax, ay]: [i32; 2], [bx, by]: [i32; 2]) -> u32 {
    // 128 F in a row at x, Q16 of a box.
    let read = |row: i32, x: i64| {
        let sums = table.sums_from(row as usize, (x >> 16) as usize);
        let both = sums.first_chunk::<4>().copied().unwrap_or_default();
        let (left, right) = (i16::from_le_bytes([both[0], both[1]]), i16::from_le_bytes([both[2], both[3]]));
        let share = (x >> 9) as i32 & 0x7f;
        (left as i32 * (128 - share) + right as i32 * share) as u32
    };
    let (first, rows, dy) = (ay >> 8, (by >> 8) - (ay >> 8), by - ay);
    if rows == 0 {
        return read(first, (ax as i64 + bx as i64) << 7).wrapping_mul(dy as u32);
    }
    let slope = ((bx as i64 - ax as i64) << 15) / dy as i64;
    let (upper, lower) = ((256 - (ay & 0xff)) as i64, (by & 0xff) as i64);
    let (from, to) = ((ax as i64) << 8, (bx as i64) << 8);
    let mut total = read(first, from + ((slope * upper) >> 8)).wrapping_mul(upper as u32);
    let whole = from + ((slope * (upper + 128)) >> 7);
    for row in 1..rows {
        total = total.wrapping_add(read(first + row, whole + 2 * slope * (row as i64 - 1)) << 8);
    }
    total.wrapping_add(read(first + rows, to - ((slope * lower) >> 8)).wrapping_mul(lower as u32))
}

/// The means of the cells between an upper and a lower line of nodes, one more than `means`, from the integrals along their
/// borders, which are 2^`shift` times what is given; and the areas of all of them, each in Q15 of that of a box, ORed.
///
/// A mean is valid where the OR is below 2^22: a cell of no area, a twisted one and one of more than 128 boxes has a
/// higher bit in it. None is made where a line is too short.
pub(crate) fn cell_means(upper: &[Node], lower: &[Node], shift: u32, means: &mut [u8]) -> u32 {
    if upper.len() <= means.len() || lower.len() <= means.len() {
        return u32::MAX;
    }
    let mut areas = 0;
    for ((mean, upper), lower) in means.iter_mut().zip(upper.windows(2)).zip(lower.windows(2)) {
        let ([a, b], [c, d]) = ([upper[0], upper[1]], [lower[0], lower[1]]);
        let falling = [d.at[0] - a.at[0], d.at[1] - a.at[1]];
        let rising = [c.at[0] - b.at[0], c.at[1] - b.at[1]];
        let product = falling[0].wrapping_mul(rising[1]).wrapping_sub(falling[1].wrapping_mul(rising[0]));
        let area = (product >> 2) as u32 | 1;
        areas |= area;
        let right = a.integrals[0].wrapping_add(b.integrals[1]);
        let around = right.wrapping_sub(c.integrals[0]).wrapping_sub(a.integrals[1]);
        // Rounded to nearest; the boxes are 128 grey levels brighter.
        let total = (around << shift).wrapping_add(area << 7).wrapping_add(area >> 1);
        // A black cell may come out a trifle below black.
        *mean = (total as i32).wrapping_div(area as i32).clamp(0, 255) as u8;
    }
    areas
}

/// [`blend`]ed readings of `frame` along `stretch`; two share a step.
pub(crate) fn blend_along(frame: &Frame<'_>, stretch: &Stretch, out: &mut [[u8; 4]]) {
    let ([mut x, mut y], [mut dx, mut dy], growth) = stretch.parts();
    for pair in out.as_flattened_mut().as_chunks_mut::<2>().0 {
        for pixel in pair {
            *pixel = blend_at(frame, x, y);
            (x, y) = (x.wrapping_add(dx >> 8), y.wrapping_add(dy >> 8));
        }
        (dx, dy) = (dx.wrapping_add(growth[0]), dy.wrapping_add(growth[1]));
    }
}

/// [`blend_along`] for a map that bends too much for that: the step grows after every reading.
pub(crate) fn blend_steeply(frame: &Frame<'_>, stretch: &Stretch, out: &mut [u8]) {
    let ([mut x, mut y], [mut dx, mut dy], growth) = stretch.parts();
    for pixel in out {
        *pixel = blend_at(frame, x, y);
        (x, y) = (x.wrapping_add(dx >> 8), y.wrapping_add(dy >> 8));
        (dx, dy) = (dx.wrapping_add(growth[0]), dy.wrapping_add(growth[1]));
    }
}

/// One reading at (`x`, `y`), Q16; 0 outside the frame.
#[inline(always)]
fn blend_at(frame: &Frame<'_>, x: i32, y: i32) -> u8 {
    let four = frame.four((x >> 16) as usize, (y >> 16) as usize).unwrap_or_default();
    blend(u32::from_le_bytes(four), (x as u32 >> 8) & 0xff, y as u32 & 0xffff)
}
