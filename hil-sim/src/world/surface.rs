//! Following a line of sight to a bilinear height surface.
//!
//! The surface is cut into tiles of 16 x 16 cells, each with its lowest and highest point. A ray steps over tiles, skips
//! those it passes above, and inside the others steps cell by cell. In a cell height minus ray is a quadratic along the ray,
//! so the crossing is exact: no march step to choose, no thin wall to step over.

use super::grid::Grid;

const TILE: usize = 16;

#[derive(Clone, Debug)]
pub(super) struct Surface {
    grid: Grid,
    tiles_across: usize,
    /// Lowest and highest point of each tile.
    tile_range: Vec<[f64; 2]>,
    lowest: f64,
    highest: f64,
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
        let (tiles_across, tiles_down) = ((grid.cols - 1).div_ceil(TILE), (grid.rows - 1).div_ceil(TILE));
        let mut tile_range = Vec::with_capacity(tiles_across * tiles_down);
        for tile_row in 0..tiles_down {
            for tile_col in 0..tiles_across {
                // A tile owns its cells, so both border rows and columns of nodes count.
                let cols = tile_col * TILE..((tile_col + 1) * TILE + 1).min(grid.cols);
                let rows = tile_row * TILE..((tile_row + 1) * TILE + 1).min(grid.rows);
                let nodes = rows.flat_map(|row| cols.clone().map(move |col| (col, row)));
                let heights = nodes.map(|(col, row)| grid.at(col, row));
                tile_range.push(heights.fold([f64::MAX, f64::MIN], |[low, high], h| [low.min(h), high.max(h)]));
            }
        }
        let lowest = tile_range.iter().fold(f64::MAX, |low, range| low.min(range[0]));
        let highest = tile_range.iter().fold(f64::MIN, |high, range| high.max(range[1]));
        Surface { grid, tiles_across, tile_range, lowest, highest }
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
        let (col, row) = self.grid.pixel(origin[0], origin[1]);
        let step = self.grid.step_m;
        let ray = Ray { start: [col, row, origin[2]], rate: [direction[0] / step, -direction[1] / step, direction[2]] };
        let (from, to) = self.stretch(&ray)?;
        // Only a ray that starts, or comes in from the side, below the highest point can be under the ground already.
        let sight = ray.at(2, from);
        if sight < self.highest && self.grid.bilinear(ray.at(0, from), ray.at(1, from)) > sight + 1e-9 {
            return None;
        }
        let cells = [self.grid.cols - 1, self.grid.rows - 1];
        let last_tile = [cells[0].div_ceil(TILE) - 1, cells[1].div_ceil(TILE) - 1];
        walk(&ray, TILE, [0, 0], last_tile, from, to, |tile, from, to| {
            let [lowest, highest] = self.tile_range[tile[1] * self.tiles_across + tile[0]];
            let from = below(&ray, highest, from, to)?;
            if lowest == highest {
                return Some(from);
            }
            let first = tile.map(|index| index * TILE);
            let last = [(first[0] + TILE).min(cells[0]) - 1, (first[1] + TILE).min(cells[1]) - 1];
            walk(&ray, 1, first, last, from, to, |cell, from, to| self.cross(&ray, cell, from, to))
        })
    }

    /// The part of the ray over the raster and between its lowest and highest value; nothing can be hit elsewhere.
    fn stretch(&self, ray: &Ray) -> Option<(f64, f64)> {
        let last = [(self.grid.cols - 1) as f64, (self.grid.rows - 1) as f64];
        // A micrometre below the lowest point, so that rounding cannot end the ray just above a flat ground.
        let limits = [[0.0, last[0]], [0.0, last[1]], [self.lowest - 1e-6, self.highest]];
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
        ((ray.at(axis, from) / size_px).floor().max(0.0) as usize).clamp(first[axis], last[axis])
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
