//! A frame of which position and attitude are known, rectified over its terrain.
//!
//! The kernels on board map planes; over relief a plane at the mean height is off by height over it times the tangent of the ray. Here
//! each corner of a patch's pixels is projected on its own, in f64 by the collinearity equations, and a pixel is the mean of
//! the frame within its corners.

use super::render::RenderCamera;
use super::still::{PATCH_MAX_PX, Patch, runs_of};
use plumbline_core::tilt::{Attitude, camera_from_local};
use plumbline_core::units::Radians;
use plumbline_survey::dem::Heights;
use plumbline_survey::error::InputError;
use plumbline_survey::io::picture::Picture;
use rayon::prelude::*;

/// Samples of a pixel along an axis at most: so many frame pixels wide a patch pixel is averaged without gaps.
const SAMPLES_MAX: f64 = 64.0;
/// Steps along a line of sight, of the posts' spacing. Chosen: a crest of a single post is met four times.
const HIDING_STEP: f64 = 0.5;
/// A ray further off the axis than the frame's corners by this factor has folded over in the lens model.
const BEYOND_CORNERS: f64 = 1.02;

/// Exterior orientation of a frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Exterior {
    /// Projection centre: east, north, up, metres.
    pub position: [f64; 3],
    /// Rows right, forward, up of the camera, columns east, north, up of the ground.
    camera_from_ground: [[f64; 3]; 3],
}

impl Exterior {
    /// By ω, φ, κ, radians: R = R_ω R_φ R_κ turns the camera's axes (x right, y up in the picture, z backwards) to the ground's
    /// (east, north, up), as aerotriangulation states it (Kraus, Photogrammetry, 2007, B 3.4).
    pub fn photogrammetric(position: [f64; 3], [omega, phi, kappa]: [f64; 3]) -> Self {
        let ((so, co), (sp, cp), (sk, ck)) = (omega.sin_cos(), phi.sin_cos(), kappa.sin_cos());
        // The transposed of R, row by row.
        let camera_from_ground = [
            [cp * ck, co * sk + so * sp * ck, so * sk - co * sp * ck],
            [-cp * sk, co * ck - so * sp * sk, so * ck + co * sp * sk],
            [sp, -so * cp, co * cp],
        ];
        Exterior { position, camera_from_ground }
    }

    /// By a vehicle's attitude on the grid and its follow-up angle (paper 003, eq. 1).
    pub fn of_vehicle(position: [f64; 3], attitude: Attitude, follow_up: Radians) -> Self {
        // Rows forward, up, right and columns north, up, east.
        let a = camera_from_local(attitude, follow_up);
        let row = |row: usize| [2, 0, 1].map(|col| f64::from(a[(row, col)]));
        Exterior { position, camera_from_ground: [row(2), row(0), row(1)] }
    }

    /// The ray to a point, (right, forward) at down = 1; `None` for a point that is not below the camera's horizon.
    fn ray(&self, point: [f64; 3]) -> Option<[f64; 2]> {
        let to: [f64; 3] = std::array::from_fn(|axis| point[axis] - self.position[axis]);
        let [right, forward, up] = self.camera_from_ground.map(|row| row[0] * to[0] + row[1] * to[1] + row[2] * to[2]);
        (up < -1e-9 * to[2].abs()).then(|| [right / -up, forward / -up])
    }

    /// Where a ray, (right, forward) at down = 1, meets level ground at a height; `None` for one that does not lead down.
    fn ground(&self, [right, forward]: [f64; 2], up_m: f64) -> Option<[f64; 2]> {
        let [a, b, c] = self.camera_from_ground;
        let [east, north, up]: [f64; 3] = std::array::from_fn(|axis| right * a[axis] + forward * b[axis] - c[axis]);
        let times = (up_m - self.position[2]) / up;
        (up < 0.0).then(|| [self.position[0] + times * east, self.position[1] + times * north])
    }
}

/// The ground that is seen.
#[derive(Clone, Copy, Debug)]
pub enum Terrain<'a> {
    /// Level, at a height.
    Plane(f64),
    /// An elevation model.
    Model(&'a Heights),
}

impl Terrain<'_> {
    /// The height of a place; `None` where it is not known.
    pub fn height(&self, east_m: f64, north_m: f64) -> Option<f64> {
        match self {
            Terrain::Plane(height) => Some(*height),
            Terrain::Model(heights) => heights.at(east_m, north_m),
        }
    }

    /// Whether higher ground stands between a point on the ground and the camera.
    fn hides(&self, point: [f64; 3], camera: [f64; 3]) -> bool {
        let Terrain::Model(heights) = self else { return false };
        let Some([_, highest]) = heights.range_m() else { return false };
        let to: [f64; 3] = std::array::from_fn(|axis| camera[axis] - point[axis]);
        let away_m = to[0].hypot(to[1]);
        let clear = if to[2] > 0.0 { ((highest - point[2]) / to[2]).clamp(0.0, 1.0) } else { 1.0 };
        let steps = (away_m * clear / (HIDING_STEP * heights.step_m())).ceil().min(1e5);
        (1..=steps as u32).any(|step| {
            let share = clear * f64::from(step) / steps;
            let [east, north, up] = std::array::from_fn(|axis| point[axis] + share * to[axis]);
            heights.at(east, north).is_some_and(|height| height > up)
        })
    }
}

/// The cells that a frame is rectified to, north up around a centre.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cells {
    /// East and north of the middle.
    pub centre: [f64; 2],
    /// (cols, rows), at most [`PATCH_MAX_PX`] each.
    pub size: (usize, usize),
    /// Side of a cell, metres.
    pub resolution_m: f64,
}

impl Cells {
    /// West, south, east, north of their outer edges.
    pub fn bounds(&self) -> [f64; 4] {
        let half = [self.size.0, self.size.1].map(|count| 0.5 * count as f64 * self.resolution_m);
        let [east, north] = self.centre;
        [east - half[0], north - half[1], east + half[0], north + half[1]]
    }

    /// East and north of a corner: that of column 0 and row 0 is the north-western one.
    fn corner(&self, col: usize, row: usize) -> [f64; 2] {
        let [west, _, _, north] = self.bounds();
        [west + col as f64 * self.resolution_m, north - row as f64 * self.resolution_m]
    }
}

/// Rectifies a frame of the camera's size. A pixel is valid where all of its corners are seen by the frame, and nothing stands between.
///
/// # Errors
/// One sentence where the frame has another size, the cells are none or too many, or nothing of them is seen.
pub fn rectify(
    camera: &RenderCamera,
    frame: &Picture,
    exterior: &Exterior,
    terrain: Terrain<'_>,
    cells: &Cells,
) -> Result<Patch, InputError> {
    let (cols, rows) = cells.size;
    if (frame.cols, frame.rows) != (camera.cols, camera.rows) {
        let sizes = format!("{} x {} pixels, the camera {} x {}", frame.cols, frame.rows, camera.cols, camera.rows);
        return Err(InputError::new(format!("the frame has {sizes}")));
    }
    if !(1..=PATCH_MAX_PX).contains(&cols) || !(1..=PATCH_MAX_PX).contains(&rows) {
        let wanted = format!("the patch would have {cols} x {rows} pixels");
        return Err(InputError::new(format!("{wanted}, 1 x 1 to {PATCH_MAX_PX} x {PATCH_MAX_PX} are made")));
    }
    let widest = camera.widest();
    let seen = |col: usize, row: usize| {
        let [east, north] = cells.corner(col, row);
        let point = [east, north, terrain.height(east, north)?];
        let ray = exterior.ray(point).filter(|[right, forward]| right.hypot(*forward) <= BEYOND_CORNERS * widest)?;
        let pixel = camera.pixel(ray);
        (within(pixel, frame) && !terrain.hides(point, exterior.position)).then_some(pixel)
    };
    let corners: Vec<Option<(f64, f64)>> =
        (0..(cols + 1) * (rows + 1)).into_par_iter().map(|at| seen(at % (cols + 1), at / (cols + 1))).collect();
    let corner = |col: usize, row: usize| corners.get(row * (cols + 1) + col).copied().flatten();
    let cell = |at: usize| {
        let (col, row) = (at % cols, at / cols);
        let of = [corner(col, row)?, corner(col + 1, row)?, corner(col, row + 1)?, corner(col + 1, row + 1)?];
        Some(mean(frame, of))
    };
    let values: Vec<Option<u8>> = (0..cols * rows).into_par_iter().map(cell).collect();
    let mask = Picture { cols, rows, pixels: values.iter().map(|value| u8::from(value.is_some())).collect() };
    let runs = runs_of(&mask);
    if runs.is_empty() {
        return Err(InputError::new("nothing of the patch is seen by the frame"));
    }
    Ok(Patch { picture: Picture { pixels: values.iter().map(|value| value.unwrap_or(0)).collect(), ..mask }, runs })
}

/// Places of a frame along an axis that are asked for the ground they show.
const PLACES: usize = 100;

/// Share of the frame whose ground, level at a height, lies within the cells. What looks to the horizon does not.
pub fn shown(camera: &RenderCamera, exterior: &Exterior, up_m: f64, cells: &Cells) -> f64 {
    let [west, south, east, north] = cells.bounds();
    let is_within = |at: usize| {
        let place = |index: usize, count: usize| (index as f64 + 0.5) * count as f64 / PLACES as f64 - 0.5;
        let (col, row) = (place(at % PLACES, camera.cols), place(at / PLACES, camera.rows));
        let ground = camera.ray(col, row).and_then(|ray| exterior.ground(ray, up_m));
        ground.is_some_and(|[x, y]| (west..=east).contains(&x) && (south..=north).contains(&y))
    };
    (0..PLACES * PLACES).filter(|at| is_within(*at)).count() as f64 / (PLACES * PLACES) as f64
}

/// Within the frame's outermost pixel borders.
fn within((col, row): (f64, f64), frame: &Picture) -> bool {
    (-0.5..=frame.cols as f64 - 0.5).contains(&col) && (-0.5..=frame.rows as f64 - 0.5).contains(&row)
}

/// The mean of the frame within four corners: left and right above, left and right below.
fn mean(frame: &Picture, [a, b, c, d]: [(f64, f64); 4]) -> u8 {
    let side = |from: (f64, f64), to: (f64, f64)| (to.0 - from.0).hypot(to.1 - from.1);
    let longest = side(a, b).max(side(c, d)).max(side(a, c)).max(side(b, d));
    let samples = longest.ceil().clamp(1.0, SAMPLES_MAX) as u32;
    let place = |index: u32| (f64::from(index) + 0.5) / f64::from(samples);
    let mut sum = 0.0;
    for v in (0..samples).map(place) {
        for u in (0..samples).map(place) {
            let of = |a: f64, b: f64, c: f64, d: f64| (a + u * (b - a)) * (1.0 - v) + (c + u * (d - c)) * v;
            sum += bilinear(frame, (of(a.0, b.0, c.0, d.0), of(a.1, b.1, c.1, d.1)));
        }
    }
    (sum / f64::from(samples * samples)).round() as u8
}

/// Between the four pixels around; beyond the outermost centres as at these.
fn bilinear(frame: &Picture, (col, row): (f64, f64)) -> f64 {
    let along = |at: f64, count: usize| {
        let at = at.clamp(0.0, (count - 1) as f64);
        let first = (at as usize).min(count.saturating_sub(2));
        (first, (first + 1).min(count - 1), at - first as f64)
    };
    let ((left, right, u), (above, below, v)) = (along(col, frame.cols), along(row, frame.rows));
    let at = |col: usize, row: usize| frame.pixels.get(row * frame.cols + col).copied().map_or(0.0, f64::from);
    let upper = at(left, above) * (1.0 - u) + at(right, above) * u;
    let lower = at(left, below) * (1.0 - u) + at(right, below) * u;
    upper * (1.0 - v) + lower * v
}

#[cfg(test)]
mod tests;
