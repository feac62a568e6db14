//! The elevation model: ground heights on a grid of posts, and the plane fitted to those under a footprint.
//!
//! The posts lie on the tile's grid, row 0 north, the grid's centre over the tile's; they are coarser than its pixels,
//! 30 m apart if they are from a global model. A height is `base + step x i16`, metres above the vertical datum of the
//! EPSG code. They are read in flash without copying, at any alignment.
//!
//! Between posts heights are bilinear; off the grid, and in a cell with a [`VOID`] post, there are none.

use crate::frames::{self, Local};
use crate::math;

/// A post without a height.
pub const VOID: i16 = i16::MIN;
/// Bytes of a post.
pub const POST_BYTES: usize = 2;
/// Largest step between heights, metres. Chosen: global models are rounded to whole metres.
const STEP_MAX_M: f32 = 1.0;
/// Largest base, metres above or below the datum. Chosen: more than any ground.
const BASE_MAX_M: f32 = 20_000.0;
/// Heights a side for the fit of a plane: 49, each in the middle of a seventh of the square's side. A square of 140 m
/// has them 20 m apart, closer than posts. Chosen.
const SIDE: u8 = 7;
/// Steepest plane, rise over run: a homography onto a steeper one could fold. Chosen: 45 degrees.
pub const SLOPE_MAX: f32 = 1.0;

/// Geometry and encoding of the posts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Posts {
    /// (cols, rows).
    pub size: (u16, u16),
    /// Grid metres from post to post.
    pub spacing_m: f32,
    /// Metres per unit of a post's number.
    pub step_m: f32,
    /// Height of a post with number 0, metres above the datum.
    pub base_m: f32,
    /// EPSG code of the vertical datum, such as 5773 (EGM96 height) or 3855 (EGM2008 height); 0 if unknown.
    pub vertical_epsg: u32,
}

impl Posts {
    /// Their size in bytes.
    pub fn bytes(&self) -> usize {
        self.size.0 as usize * self.size.1 as usize * POST_BYTES
    }

    /// Whether every number is valid.
    fn is_sound(&self) -> bool {
        // False for a NaN as well.
        self.size.0 >= 2
            && self.size.1 >= 2
            && self.spacing_m > 0.0
            && self.spacing_m.is_finite()
            && self.step_m > 0.0
            && self.step_m <= STEP_MAX_M
            && self.base_m.abs() <= BASE_MAX_M
    }

    /// Whether they extend to `(east_m, north_m)` from their centre, both ways.
    pub(crate) fn reach(&self, (east_m, north_m): (f32, f32)) -> bool {
        let half = |count: u16| 0.5 * (count as f32 - 1.0) * self.spacing_m;
        half(self.size.0) >= east_m && half(self.size.1) >= north_m
    }
}

/// Checked posts.
#[derive(Clone, Copy, Debug)]
pub struct Elevation<'a> {
    /// Little-endian, row-major.
    bytes: &'a [u8],
    posts: Posts,
}

/// A plane fitted to the ground under a footprint.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Plane {
    /// Reference point: the middle of the square that it was fitted to.
    pub middle: Local,
    /// Height there, metres above the datum.
    pub height_m: f32,
    /// Rise to the east and to the north, metres a metre of the grid.
    pub slope: [f32; 2],
    /// RMS of the heights about it, the residual relief, metres.
    pub relief_m: f32,
}

impl Plane {
    /// Its height at `local`, metres above the datum.
    pub fn height_m(&self, local: Local) -> f32 {
        let [east, north] = self.slope;
        self.height_m + east * (local.east_m - self.middle.east_m) + north * (local.north_m - self.middle.north_m)
    }
}

impl<'a> Elevation<'a> {
    /// Checks posts: `bytes` are little-endian i16, row-major, row 0 north. `None` for another number of bytes or
    /// invalid parameters.
    pub fn new(bytes: &'a [u8], posts: Posts) -> Option<Self> {
        (posts.is_sound() && bytes.len() == posts.bytes()).then_some(Elevation { bytes, posts })
    }

    /// Geometry and encoding of the posts.
    pub fn posts(&self) -> &Posts {
        &self.posts
    }

    /// Height of the ground at `local`, metres above the datum: bilinear between four posts. `None` off the grid and
    /// next to a [`VOID`].
    ///
    /// Cost: four loads and some 30 operations.
    pub fn height_m(&self, local: Local) -> Option<f32> {
        let Posts { size, spacing_m, step_m, base_m, .. } = self.posts;
        let (col, row) = frames::pixel(local.east_m / spacing_m, local.north_m / spacing_m, size.0, size.1);
        let last = |count: u16| count as f32 - 1.0;
        // False for a NaN as well.
        if !(col >= 0.0 && row >= 0.0 && col <= last(size.0) && row <= last(size.1)) {
            return None;
        }
        // The last post belongs to the cell before it.
        let first = |at: f32, count: u16| (at as usize).min(count as usize - 2);
        let (c, r) = (first(col, size.0), first(row, size.1));
        let (u, v) = (col - c as f32, row - r as f32);
        let at = (r * size.0 as usize + c) * POST_BYTES;
        let [nw, ne] = self.pair(at)?;
        let [sw, se] = self.pair(at + size.0 as usize * POST_BYTES)?;
        let (north, south) = (nw + u * (ne - nw), sw + u * (se - sw));
        Some(base_m + step_m * (north + v * (south - north)))
    }

    /// Two neighbouring posts, from byte `at`.
    fn pair(&self, at: usize) -> Option<[f32; 2]> {
        let &[a, b, c, d] = self.bytes.get(at..)?.first_chunk()?;
        let (west, east) = (i16::from_le_bytes([a, b]), i16::from_le_bytes([c, d]));
        (west != VOID && east != VOID).then_some([west.into(), east.into()])
    }

    /// The least-squares plane over a square of ±`half_side_m` around `middle`. `None` if a height is missing, or
    /// steeper than [`SLOPE_MAX`].
    ///
    /// The heights are those in the middles of 7 x 7 equal parts, so that each represents the same area. About their
    /// centre east and north are uncorrelated, and the normal equations are three quotients.
    ///
    /// Cost: 49 heights and three sums, some 3,000 instructions; no memory.
    pub fn plane(&self, middle: Local, half_side_m: f32) -> Option<Plane> {
        let apart_m = 2.0 * half_side_m / SIDE as f32;
        let step = |index: u8| index as f32 - 0.5 * (SIDE as f32 - 1.0);
        let about = self.height_m(middle)?;
        let (mut sum, mut squares, mut along) = (0.0f32, 0.0f32, [0.0f32; 2]);
        for row in 0..SIDE {
            for col in 0..SIDE {
                let (x, y) = (step(col), -step(row));
                let height = self.height_m(middle.moved([x * apart_m, y * apart_m]))? - about;
                sum += height;
                squares += height * height;
                along[0] += x * height;
                along[1] += y * height;
            }
        }
        let count = (SIDE as f32) * (SIDE as f32);
        // Sum of x² over the parts: each row's n (n² − 1)/12, n rows.
        let spread = count * (count - 1.0) / 12.0;
        let (mean, rise) = (sum / count, along.map(|along| along / spread));
        let explained = mean * mean + (rise[0] * rise[0] + rise[1] * rise[1]) * (spread / count);
        let slope = rise.map(|rise| rise / apart_m);
        let relief_m = math::sqrt((squares / count - explained).max(0.0));
        // False for a NaN as well.
        let is_meant = slope[0] * slope[0] + slope[1] * slope[1] <= SLOPE_MAX * SLOPE_MAX;
        is_meant.then_some(Plane { middle, height_m: about + mean, slope, relief_m })
    }
}

#[cfg(test)]
mod tests;
