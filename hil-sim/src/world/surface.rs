//! Following a line of sight to a bilinear height surface.
//!
//! The surface is cut into tiles of 16 x 16 cells, and these into tiles of 4 x 4, each with its lowest and highest point. A ray
//! from above meets the ground between the highest and the lowest point of what it passes over, which narrows from level to
//! level until a few cells are left. A ray that passes over many tiles on its way down steps over them, skips those it passes
//! above, and inside the others steps cell by cell. In a cell height minus ray is a quadratic along the ray, so the crossing is
//! exact: no march step to choose, no thin wall to step over.

use super::grid::Grid;
use rayon::prelude::*;

/// Cells a side of a tile, coarse and fine.
const TILE: usize = 16;
const FINE: usize = 4;
/// How far below the lowest point a ray is followed, metres, so that rounding cannot end it just above a flat ground.
const SLACK_M: f64 = 1e-6;

/// Tiles that a ray, and rays beside each other, are looked for in at once. Chosen: more are sooner stepped over.
const PASSED: usize = 6;
const PASSED_TOGETHER: usize = 30;
/// So few rays are followed one by one where the ground below them is not level. Chosen.
const ALONE: usize = 8;

#[derive(Clone, Debug)]
pub(super) struct Surface {
    grid: Grid,
    /// Pixels a metre.
    per_m: f64,
    coarse: Tiles,
    fine: Tiles,
    lowest: f64,
    highest: f64,
}

/// Lowest and highest point of each square of cells.
#[derive(Clone, Debug)]
struct Tiles {
    /// Cells a side.
    side: usize,
    across: usize,
    ranges: Vec<[f32; 2]>,
}

impl Tiles {
    fn new(grid: &Grid, side: usize) -> Self {
        let (across, down) = ((grid.cols - 1).div_ceil(side), (grid.rows - 1).div_ceil(side));
        let range = |tile: usize| {
            // A tile owns its cells, so both border rows and columns of nodes count.
            let (col, row) = (tile % across * side, tile / across * side);
            let cols = (side + 1).min(grid.cols - col);
            (row..(row + side + 1).min(grid.rows))
                .flat_map(|row| &grid.data[row * grid.cols + col..][..cols])
                .fold([f32::MAX, f32::MIN], |[low, high], &h| [low.min(h), high.max(h)])
        };
        Tiles { side, across, ranges: (0..across * down).into_par_iter().map(range).collect() }
    }

    fn range(&self, [col, row]: [usize; 2]) -> [f64; 2] {
        self.ranges[row * self.across + col].map(f64::from)
    }

    /// Lowest and highest point of the tiles of a box of the raster, corner by corner; `None` where these are more than `most`.
    #[inline]
    fn within(&self, one: [f64; 2], other: [f64; 2], cells: [usize; 2], most: usize) -> Option<[f64; 2]> {
        let [cols, rows] = std::array::from_fn(|axis| {
            let tile = |at: f64| (at as i32 as usize).min(cells[axis] - 1) / self.side;
            let (one, other) = (tile(one[axis]), tile(other[axis]));
            (one.min(other), one.max(other))
        });
        if (cols.1 - cols.0 + 1) * (rows.1 - rows.0 + 1) > most {
            return None;
        }
        let mut all = [f32::MAX, f32::MIN];
        for row in rows.0..=rows.1 {
            for &[low, high] in &self.ranges[row * self.across + cols.0..=row * self.across + cols.1] {
                all = [if low < all[0] { low } else { all[0] }, if high > all[1] { high } else { all[1] }];
            }
        }
        Some(all.map(f64::from))
    }
}

/// A ray in pixel coordinates of the surface: `(col, row, up) + t * rate`.
#[derive(Clone, Copy, Debug)]
struct Ray {
    start: [f64; 3],
    rate: [f64; 3],
}

impl Ray {
    fn at(&self, axis: usize, t: f64) -> f64 {
        self.start[axis] + self.rate[axis] * t
    }
}

impl Surface {
    pub(super) fn new(grid: Grid) -> Self {
        let [coarse, fine] = [TILE, FINE].map(|side| Tiles::new(&grid, side));
        let [lowest, highest] = coarse
            .ranges
            .iter()
            .fold([f32::MAX, f32::MIN], |[low, high], range| [low.min(range[0]), high.max(range[1])]);
        let (lowest, highest) = (lowest.into(), highest.into());
        Surface { per_m: 1.0 / grid.step_m, grid, coarse, fine, lowest, highest }
    }

    pub(super) fn grid(&self) -> &Grid {
        &self.grid
    }

    pub(super) fn height(&self, east_m: f64, north_m: f64) -> f64 {
        let (col, row) = self.grid.pixel(east_m, north_m);
        self.grid.bilinear(col, row)
    }

    /// How far along `direction` the surface is first met from above.
    pub(super) fn intersect(&self, origin: [f64; 3], direction: [f64; 3]) -> Option<f64> {
        self.intersect_between(origin, direction, [self.lowest, self.highest], &[&self.coarse, &self.fine])
    }

    /// Where the lowest and the highest point of what the ray passes over are known; `levels`: tiles that narrow that.
    fn intersect_between(
        &self,
        origin: [f64; 3],
        direction: [f64; 3],
        heights: [f64; 2],
        levels: &[&Tiles],
    ) -> Option<f64> {
        let (col, row) = self.grid.pixel(origin[0], origin[1]);
        let rate = [direction[0] * self.per_m, -direction[1] * self.per_m, direction[2]];
        let ray = Ray { start: [col, row, origin[2]], rate };
        match self.narrowed(&ray, heights, levels) {
            Some((from, to)) if from == to => Some(from),
            Some((from, to)) => {
                let last = self.cells().map(|cells| cells - 1);
                walk(&ray, 1, [0, 0], last, from, to, |cell, from, to| self.cross(&ray, cell, from, to))
            }
            None => self.followed(&ray),
        }
    }

    /// Cells across and down.
    fn cells(&self) -> [usize; 2] {
        [self.grid.cols - 1, self.grid.rows - 1]
    }

    /// As [`Surface::intersect`] for rays beside each other from one place: how far along each, NaN where it meets nothing.
    pub(super) fn intersect_all(&self, origin: [f64; 3], directions: &[[f64; 3]], along: &mut [f64]) {
        let heights = self.heights_below(origin, directions);
        if let Some([low, high]) = heights
            && low == high
        {
            for (along, direction) in along.iter_mut().zip(directions) {
                *along = (low - origin[2]) / direction[2];
            }
        } else if directions.len() > ALONE {
            let half = directions.len() / 2;
            let (these, those) = along.split_at_mut(half);
            self.intersect_all(origin, &directions[..half], these);
            self.intersect_all(origin, &directions[half..], those);
        } else {
            for (along, &direction) in along.iter_mut().zip(directions) {
                let met = match heights {
                    Some(heights) => self.intersect_between(origin, direction, heights, &[&self.fine]),
                    None => self.intersect(origin, direction),
                };
                *along = met.unwrap_or(f64::NAN);
            }
        }
    }

    /// Lowest and highest point of what rays from above pass over; `None` where that is not on the raster, or too much at once.
    fn heights_below(&self, origin: [f64; 3], directions: &[[f64; 3]]) -> Option<[f64; 2]> {
        let above = origin[2] - self.lowest;
        if origin[2] < self.highest || directions.iter().any(|direction| direction[2] >= 0.0) {
            return None;
        }
        // Where they would meet the lowest level. On the highest they are nearer to the foot by a known part.
        let (mut low, mut high) = ([f64::MAX; 2], [f64::MIN; 2]);
        for direction in directions {
            let along = -above / direction[2];
            for axis in 0..2 {
                let reach = along * direction[axis];
                low[axis] = if reach < low[axis] { reach } else { low[axis] };
                high[axis] = if reach > high[axis] { reach } else { high[axis] };
            }
        }
        let part = (origin[2] - self.highest) / above;
        let (near, far) = (
            [low[0].min(part * low[0]), high[1].max(part * high[1])],
            [high[0].max(part * high[0]), low[1].min(part * low[1])],
        );
        let [one, other] = [near, far].map(|[east, north]| {
            let (col, row) = self.grid.pixel(origin[0] + east, origin[1] + north);
            [col, row]
        });
        if !self.grid.covers(one[0], one[1]) || !self.grid.covers(other[0], other[1]) {
            return None;
        }
        let within = |tiles: &Tiles| tiles.within(one, other, self.cells(), PASSED_TOGETHER);
        let roughly = within(&self.coarse)?;
        if roughly[0] == roughly[1] { Some(roughly) } else { within(&self.fine).or(Some(roughly)) }
    }

    /// The part of a ray from above in which it meets the ground, a point where that is flat; `None` where it is not a few cells
    /// on the raster.
    fn narrowed(&self, ray: &Ray, [lowest, highest]: [f64; 2], levels: &[&Tiles]) -> Option<(f64, f64)> {
        if ray.start[2] < self.highest || ray.rate[2] >= 0.0 {
            return None;
        }
        let at_height = |height: f64| (height - ray.start[2]) / ray.rate[2];
        let mut part = (at_height(highest), at_height(lowest - SLACK_M));
        for tiles in levels {
            let [one, other] = [part.0, part.1].map(|t| [ray.at(0, t), ray.at(1, t)]);
            if !self.grid.covers(one[0], one[1]) || !self.grid.covers(other[0], other[1]) {
                return None;
            }
            let [low, high] = tiles.within(one, other, self.cells(), PASSED)?;
            let from = at_height(high);
            if low == high {
                return Some((from, from));
            }
            part = (from.max(part.0), at_height(low - SLACK_M).min(part.1));
        }
        Some(part)
    }

    /// Where a ray that passes over more of the raster, or comes in from beside it, first meets the ground from above.
    fn followed(&self, ray: &Ray) -> Option<f64> {
        let (from, to) = self.stretch(ray)?;
        // Only a ray that starts, or comes in from the side, below the highest point can be under the ground already.
        let sight = ray.at(2, from);
        if sight < self.highest && self.grid.bilinear(ray.at(0, from), ray.at(1, from)) > sight + 1e-9 {
            return None;
        }
        let cells = self.cells();
        let last_tile = cells.map(|cells| cells.div_ceil(TILE) - 1);
        walk(ray, TILE, [0, 0], last_tile, from, to, |tile, from, to| {
            let [lowest, highest] = self.coarse.range(tile);
            let from = below(ray, highest, from, to)?;
            if lowest == highest {
                return Some(from);
            }
            let first = tile.map(|index| index * TILE);
            let last = [(first[0] + TILE).min(cells[0]) - 1, (first[1] + TILE).min(cells[1]) - 1];
            walk(ray, 1, first, last, from, to, |cell, from, to| self.cross(ray, cell, from, to))
        })
    }

    /// The part of the ray over the raster and between its lowest and highest value; nothing can be hit elsewhere.
    fn stretch(&self, ray: &Ray) -> Option<(f64, f64)> {
        let last = [(self.grid.cols - 1) as f64, (self.grid.rows - 1) as f64];
        let limits = [[0.0, last[0]], [0.0, last[1]], [self.lowest - SLACK_M, self.highest]];
        let (mut from, mut to) = (0.0f64, f64::INFINITY);
        for (axis, [low, high]) in limits.into_iter().enumerate() {
            let (start, rate) = (ray.start[axis], ray.rate[axis]);
            if rate == 0.0 {
                if !(start >= low && start <= high) {
                    return None;
                }
                continue;
            }
            let (a, b) = ((low - start) / rate, (high - start) / rate);
            from = from.max(a.min(b));
            to = to.min(a.max(b));
        }
        (from <= to && to.is_finite()).then_some((from, to))
    }

    /// The first crossing inside one cell between `from` and `to`, if any.
    fn cross(&self, ray: &Ray, [col, row]: [usize; 2], from: f64, to: f64) -> Option<f64> {
        let nw = self.grid.at(col, row);
        let (ne, sw) = (self.grid.at(col + 1, row), self.grid.at(col, row + 1));
        let se = self.grid.at(col + 1, row + 1);
        let lowest_sight = ray.at(2, from).min(ray.at(2, to));
        if nw.max(ne).max(sw).max(se) < lowest_sight {
            return None;
        }
        // height(u, v) = nw + a u + b v + c u v on the cell; u and v are linear along the ray.
        let (a, b, c) = (ne - nw, sw - nw, nw - ne - sw + se);
        let (u, v) = (ray.at(0, from) - col as f64, ray.at(1, from) - row as f64);
        let [du, dv, dz] = ray.rate;
        let constant = nw + a * u + b * v + c * u * v - ray.at(2, from);
        if constant >= 0.0 {
            return Some(from);
        }
        let linear = a * du + b * dv + c * (u * dv + v * du) - dz;
        let quadratic = c * du * dv;
        let discriminant = linear * linear - 4.0 * quadratic * constant;
        if discriminant < 0.0 {
            return None;
        }
        // Both roots without cancellation; a vanishing quadratic term gives one infinite root, which is out of range.
        let q = -0.5 * (linear + discriminant.sqrt().copysign(linear));
        let inside = |s: f64| (s >= 0.0 && s <= to - from).then_some(s);
        let first = match (inside(q / quadratic), inside(constant / q)) {
            (Some(one), Some(other)) => one.min(other),
            (one, other) => one.or(other)?,
        };
        Some(from + first)
    }
}

/// The earliest instant from which the ray is at or below `height` between `from` and `to`.
fn below(ray: &Ray, height: f64, from: f64, to: f64) -> Option<f64> {
    if ray.at(2, from) <= height {
        return Some(from);
    }
    let reached = (height - ray.start[2]) / ray.rate[2];
    (reached >= from && reached <= to).then_some(reached)
}

/// Visits the squares of `size` pixels the ray crosses between `from` and `to`, in order, with the part of the ray in each,
/// until one answers (Amanatides and Woo, Eurographics 1987). Squares `first` to `last` inclusive.
fn walk(
    ray: &Ray,
    size: usize,
    first: [usize; 2],
    last: [usize; 2],
    from: f64,
    to: f64,
    mut visit: impl FnMut([usize; 2], f64, f64) -> Option<f64>,
) -> Option<f64> {
    let size_px = size as f64;
    let mut square: [usize; 2] = std::array::from_fn(|axis| {
        // Cut off, and 0 below it.
        ((ray.at(axis, from) / size_px) as usize).clamp(first[axis], last[axis])
    });
    let mut entered = from;
    loop {
        let leaves: [f64; 2] = std::array::from_fn(|axis| {
            let rate = ray.rate[axis];
            let border = square[axis] + usize::from(rate > 0.0);
            if rate == 0.0 { f64::INFINITY } else { (border as f64 * size_px - ray.start[axis]) / rate }
        });
        let axis = usize::from(leaves[1] < leaves[0]);
        let left = leaves[axis].min(to).max(entered);
        if let Some(answer) = visit(square, entered, left) {
            return Some(answer);
        }
        if leaves[axis] >= to {
            return None;
        }
        if ray.rate[axis] > 0.0 {
            if square[axis] == last[axis] {
                return None;
            }
            square[axis] += 1;
        } else {
            if square[axis] == first[axis] {
                return None;
            }
            square[axis] -= 1;
        }
        entered = left;
    }
}

#[cfg(test)]
mod tests;
