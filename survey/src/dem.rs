//! Digital elevation models, as much of them as an area needs.
//!
//! [`DemFile`] is the file: opened, it knows its size, place and reference system. [`Frame`] says in which metres one works
//! on it. [`DemFile::window`] reads a part into a [`Dem`], whose heights are looked up in those metres.

mod ascii;
mod file;
mod frame;
mod geoid;
mod over;
mod plausible;
mod prj;
mod tokens;
mod wkt;

pub use file::DemFile;
pub use frame::Frame;
pub use geoid::Geoid;
pub use over::Heights;
pub use plausible::Doubt;

/// How far (in steps) a place may lie off a post and still be taken as on it: sums of coordinates do not come out
/// exactly, and beside a post there may be nothing. At 10^7 m an `f64` is good to 2e-9 m.
const ROUNDING: f64 = 1e-7;

/// Heights on a regular grid of posts, in memory.
///
/// Rows run north: row 0 is the southern one, as lines are counted from low y.
#[derive(Debug, Clone, PartialEq)]
pub struct Dem {
    /// Posts eastward.
    pub cols: usize,
    /// Posts northward.
    pub rows: usize,
    /// East of the posts of column 0, working metres.
    pub west_m: f64,
    /// North of the posts of row 0, working metres.
    pub south_m: f64,
    /// From a post to the next one east and north, both positive.
    pub step_m: [f64; 2],
    /// Heights, metres: `heights[row * cols + col]`; NaN where unknown.
    pub heights: Vec<f64>,
}

impl Dem {
    /// A synthetic model: `height` at each post's position.
    #[must_use]
    pub fn from_fn(
        (cols, rows): (usize, usize),
        [west_m, south_m]: [f64; 2],
        step_m: [f64; 2],
        height: impl Fn(f64, f64) -> f64,
    ) -> Self {
        let post = |index: usize| {
            let (col, row) = ((index % cols) as f64, (index / cols) as f64);
            height(west_m + col * step_m[0], south_m + row * step_m[1])
        };
        Self { cols, rows, west_m, south_m, step_m, heights: (0..cols * rows).map(post).collect() }
    }

    /// The height of a post; NaN where it is unknown, and outside.
    #[must_use]
    pub fn at(&self, col: usize, row: usize) -> f64 {
        if col >= self.cols {
            return f64::NAN;
        }
        self.heights.get(row * self.cols + col).copied().unwrap_or(f64::NAN)
    }

    /// The height of a place, bilinear between the four posts around it. `None` outside the outermost posts, and where one
    /// of the posts that count there is unknown.
    #[must_use]
    pub fn height(&self, x_m: f64, y_m: f64) -> Option<f64> {
        let (col, u) = place((x_m - self.west_m) / self.step_m[0], self.cols)?;
        let (row, v) = place((y_m - self.south_m) / self.step_m[1], self.rows)?;
        let mut height = 0.0;
        for (right, across) in [(0, 1.0 - u), (1, u)] {
            for (up, along) in [(0, 1.0 - v), (1, v)] {
                let weight = across * along;
                if weight > 0.0 {
                    height += weight * self.at(col + right, row + up);
                }
            }
        }
        height.is_finite().then_some(height)
    }

    /// Lowest and highest known height; `None` where nothing is known.
    #[must_use]
    pub fn range_m(&self) -> Option<[f64; 2]> {
        range_of(self.heights.iter().copied().filter(|height| height.is_finite()))
    }

    /// Its outermost posts: x0, y0, x1, y1 in working metres.
    #[must_use]
    pub fn bounds(&self) -> [f64; 4] {
        let [width_m, height_m] =
            [(self.cols, 0), (self.rows, 1)].map(|(count, axis)| count.saturating_sub(1) as f64 * self.step_m[axis]);
        [self.west_m, self.south_m, self.west_m + width_m, self.south_m + height_m]
    }
}

/// The lowest and the highest of heights; `None` of none.
fn range_of(heights: impl Iterator<Item = f64>) -> Option<[f64; 2]> {
    heights.map(|height| [height; 2]).reduce(|[low, high], [one, other]| [low.min(one), high.max(other)])
}

/// The post before a place along an axis of `count` posts, and how far beyond it the place is, 0 to 1; `None` outside.
fn place(steps: f64, count: usize) -> Option<(usize, f64)> {
    let end = count.checked_sub(1)? as f64;
    if !(-ROUNDING < steps && steps < end + ROUNDING) {
        return None;
    }
    let nearest = steps.round();
    let steps = if (steps - nearest).abs() < ROUNDING { nearest } else { steps };
    let post = steps.floor();
    Some((post as usize, steps - post))
}

#[cfg(test)]
mod tests;
