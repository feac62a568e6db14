//! The highest point of the terrain within a zone, quickly.
//!
//! A zone is a rectangle along a strip's axes. It takes in every cell of the elevation model that it touches, with all four
//! posts, so that the bilinear ground inside it is nowhere higher. Along the grid's own axes that is the rule of paper 004's
//! clean form: posts floor(x0/d) to floor(x1/d) + 1, clipped to the model.
//!
//! Cells are gathered in blocks of 8 x 8, those in blocks of 8 x 8 again, and so on, each with its highest post. A search
//! descends only into blocks that the zone's border cuts and that are higher than the best so far.

use super::axes::Axes;
use crate::dem::Dem;

/// Blocks of a level make one of the next, along each side.
const FACTOR: usize = 8;
/// Positions closer to a post than this share of a cell are taken to be on it: 0.1 + 0.2 is no reason for another row.
pub(super) const SNAP: f64 = 1e-9;

/// A rectangle along the axes of strips, metres.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Zone {
    /// From and to, along.
    pub along: [f64; 2],
    /// From and to, across.
    pub across: [f64; 2],
}

/// Blocks of one size.
#[derive(Debug)]
struct Level {
    /// Side of a block, cells.
    size: usize,
    cols: usize,
    highest: Vec<f64>,
}

/// The terrain, searchable.
#[derive(Debug)]
pub struct Terrain<'d> {
    dem: &'d Dem,
    /// From the smallest blocks to one that holds all.
    levels: Vec<Level>,
}

impl<'d> Terrain<'d> {
    /// Gathers the blocks: one pass over the posts. The model has at least 2 x 2 posts.
    #[must_use]
    pub fn new(dem: &'d Dem) -> Self {
        let [cols, rows] = [dem.cols - 1, dem.rows - 1];
        let mut levels = vec![Level::first(dem, cols, rows)];
        while let Some(last) = levels.last()
            && last.highest.len() > 1
        {
            let next = last.gathered();
            levels.push(next);
        }
        Terrain { dem, levels }
    }

    /// The terrain itself.
    #[must_use]
    pub fn dem(&self) -> &'d Dem {
        self.dem
    }

    /// The highest known post of all.
    #[must_use]
    pub fn highest(&self) -> Option<f64> {
        self.levels.last().and_then(|level| level.highest.first()).copied().filter(|h| h.is_finite())
    }

    /// The highest known post of the cells that the zone touches. Along the grid's axes a zone outside the model meets its
    /// border; askew it meets nothing. `None` where nothing is known.
    #[must_use]
    pub fn highest_in(&self, axes: &Axes, zone: &Zone) -> Option<f64> {
        let region = self.region(axes, zone);
        let mut best = f64::NEG_INFINITY;
        let top = self.levels.len() - 1;
        self.search(top, [0, 0], &region, &mut best);
        best.is_finite().then_some(best)
    }

    /// The largest of `least` and what `view` says of any cell. `view(first, last, highest, single)` is asked for blocks of
    /// cells too, first to last, and must not say less of a block than of any cell in it.
    pub(super) fn steepest_view(
        &self,
        least: f64,
        view: &mut dyn FnMut([usize; 2], [usize; 2], f64, bool) -> f64,
    ) -> f64 {
        let mut best = least;
        self.look(self.levels.len() - 1, [0, 0], view, &mut best);
        best
    }

    fn look(
        &self,
        level: usize,
        [col, row]: [usize; 2],
        view: &mut dyn FnMut([usize; 2], [usize; 2], f64, bool) -> f64,
        best: &mut f64,
    ) {
        let blocks = &self.levels[level];
        let (first, last) = self.cells_of(blocks, [col, row]);
        let most = view(first, last, blocks.highest[row * blocks.cols + col], false);
        if most.is_nan() || most <= *best {
            return;
        }
        if level == 0 {
            for row in first[1]..=last[1] {
                for col in first[0]..=last[0] {
                    *best = best.max(view([col, row], [col, row], cell(self.dem, col, row), true));
                }
            }
            return;
        }
        let size = self.levels[level - 1].size;
        for row in first[1] / size..=last[1] / size {
            for col in first[0] / size..=last[0] / size {
                self.look(level - 1, [col, row], view, best);
            }
        }
    }

    /// First and last cell of a block.
    fn cells_of(&self, blocks: &Level, [col, row]: [usize; 2]) -> ([usize; 2], [usize; 2]) {
        let first = [col * blocks.size, row * blocks.size];
        let ends = [self.dem.cols - 2, self.dem.rows - 2];
        (first, [0, 1].map(|axis| (first[axis] + blocks.size - 1).min(ends[axis])))
    }

    fn region(&self, axes: &Axes, zone: &Zone) -> Region {
        let cells = |from: f64, to: f64, origin: f64, step: f64, posts: usize| {
            let clip = |at: f64| ((at - origin) / step + SNAP).floor().clamp(0.0, (posts - 2) as f64) as usize;
            [clip(from), clip(to)]
        };
        let Dem { cols, rows, west_m, south_m, step_m: [dx, dy], .. } = *self.dem;
        if let Some(along_y) = axes.along_y() {
            let (x, y) = if along_y { (zone.across, zone.along) } else { (zone.along, zone.across) };
            return Region {
                cols: cells(x[0], x[1], west_m, dx, cols),
                rows: cells(y[0], y[1], south_m, dy, rows),
                askew: None,
            };
        }
        let corners = [[0, 0], [0, 1], [1, 0], [1, 1]].map(|[i, j]| axes.point([zone.along[i], zone.across[j]]));
        let span = |axis: usize| {
            let range = corners.iter().map(|corner| corner[axis]);
            [range.clone().fold(f64::INFINITY, f64::min), range.fold(f64::NEG_INFINITY, f64::max)]
        };
        let ([x0, x1], [y0, y1]) = (span(0), span(1));
        let [west, south, east, north] = self.dem.bounds();
        if x1 < west || x0 > east || y1 < south || y0 > north {
            return Region { cols: [1, 0], rows: [1, 0], askew: None };
        }
        Region {
            cols: cells(x0, x1, west_m, dx, cols),
            rows: cells(y0, y1, south_m, dy, rows),
            askew: Some((*axes, *zone)),
        }
    }

    fn search(&self, level: usize, [col, row]: [usize; 2], region: &Region, best: &mut f64) {
        let blocks = &self.levels[level];
        let highest = blocks.highest[row * blocks.cols + col];
        // NaN is nothing known.
        if highest.is_nan() || highest <= *best {
            return;
        }
        let (first, last) = self.cells_of(blocks, [col, row]);
        match region.meets(self.dem, first, last) {
            Meets::Apart => {}
            Meets::Inside => *best = highest,
            Meets::Cut if level > 0 => {
                let below = &self.levels[level - 1];
                let cells = region.clip(first, last);
                for row in cells[1][0] / below.size..=cells[1][1] / below.size {
                    for col in cells[0][0] / below.size..=cells[0][1] / below.size {
                        self.search(level - 1, [col, row], region, best);
                    }
                }
            }
            Meets::Cut => {
                let [cols, rows] = region.clip(first, last);
                for row in rows[0]..=rows[1] {
                    for col in cols[0]..=cols[1] {
                        if region.askew.is_none() || region.meets(self.dem, [col, row], [col, row]) != Meets::Apart {
                            *best = best.max(cell(self.dem, col, row));
                        }
                    }
                }
            }
        }
    }
}

/// The cells that a zone touches: a range of columns and rows, both ends included, and where it lies askew a finer look.
struct Region {
    cols: [usize; 2],
    rows: [usize; 2],
    askew: Option<(Axes, Zone)>,
}

#[derive(PartialEq)]
enum Meets {
    Apart,
    Inside,
    Cut,
}

impl Region {
    /// How a block of cells, first to last, lies to the region.
    fn meets(&self, dem: &Dem, first: [usize; 2], last: [usize; 2]) -> Meets {
        let ranges = [self.cols, self.rows];
        if (0..2).any(|axis| last[axis] < ranges[axis][0] || first[axis] > ranges[axis][1]) {
            return Meets::Apart;
        }
        let inside = (0..2).all(|axis| first[axis] >= ranges[axis][0] && last[axis] <= ranges[axis][1]);
        let Some((axes, zone)) = &self.askew else {
            return if inside { Meets::Inside } else { Meets::Cut };
        };
        // Two rectangles are apart if they are along an axis of one of them; the grid's own were looked at above.
        let [dx, dy] = dem.step_m;
        let corner = |col: usize, row: usize| axes.of([dem.west_m + col as f64 * dx, dem.south_m + row as f64 * dy]);
        let corners = [
            corner(first[0], first[1]),
            corner(last[0] + 1, first[1]),
            corner(first[0], last[1] + 1),
            corner(last[0] + 1, last[1] + 1),
        ];
        let mut within = true;
        for (axis, [from, to]) in [zone.along, zone.across].into_iter().enumerate() {
            let range = corners.iter().map(|corner| corner[axis]);
            let low = range.clone().fold(f64::INFINITY, f64::min);
            let high = range.fold(f64::NEG_INFINITY, f64::max);
            if high < from || low > to {
                return Meets::Apart;
            }
            within &= low >= from && high <= to;
        }
        if within { Meets::Inside } else { Meets::Cut }
    }

    /// The part of a block's cells within the ranges; the block meets them.
    fn clip(&self, first: [usize; 2], last: [usize; 2]) -> [[usize; 2]; 2] {
        [
            [first[0].max(self.cols[0]), last[0].min(self.cols[1])],
            [first[1].max(self.rows[0]), last[1].min(self.rows[1])],
        ]
    }
}

/// Highest known post of a cell.
fn cell(dem: &Dem, col: usize, row: usize) -> f64 {
    dem.at(col, row).max(dem.at(col + 1, row)).max(dem.at(col, row + 1)).max(dem.at(col + 1, row + 1))
}

impl Level {
    fn first(dem: &Dem, cols: usize, rows: usize) -> Self {
        let (across, down) = (cols.div_ceil(FACTOR), rows.div_ceil(FACTOR));
        let mut highest = vec![f64::NAN; across * down];
        // A post belongs to the blocks of all cells around it: two where it lies on a border.
        for row in 0..dem.rows {
            let blocks_down = row.saturating_sub(1) / FACTOR..=(row / FACTOR).min(down - 1);
            for col in 0..dem.cols {
                let height = dem.at(col, row);
                let blocks_across = col.saturating_sub(1) / FACTOR..=(col / FACTOR).min(across - 1);
                for block_row in blocks_down.clone() {
                    for block_col in blocks_across.clone() {
                        let block = &mut highest[block_row * across + block_col];
                        *block = block.max(height);
                    }
                }
            }
        }
        Level { size: FACTOR, cols: across, highest }
    }

    fn gathered(&self) -> Self {
        let rows = self.highest.len() / self.cols;
        let (across, down) = (self.cols.div_ceil(FACTOR), rows.div_ceil(FACTOR));
        let mut highest = vec![f64::NAN; across * down];
        for (index, height) in self.highest.iter().enumerate() {
            let block = &mut highest[index / self.cols / FACTOR * across + index % self.cols / FACTOR];
            *block = block.max(*height);
        }
        Level { size: self.size * FACTOR, cols: across, highest }
    }
}

#[cfg(test)]
mod tests;
