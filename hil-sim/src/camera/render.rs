//! Frames by casting rays: what a camera in a given place and attitude sees of the ground.
//!
//! This is a code path of its own. It does not use the matrices of paper 003: the three axes of the camera are turned
//! ACTIVELY, one after the other, in east-north-up, and every sub-pixel sends a ray along them to the ground. So a sign that
//! is wrong in the rectification cannot be wrong here in the same way.
//!
//! Axes of the camera: forward (up in the frame, row 0), right (columns), down (the optical axis). Frame pixel centres are
//! integers; `m` counts columns to the right and `n` rows forward from the centre `(cols - 1) / 2`, `(rows - 1) / 2`.

use super::lens::{distorted, undistorted};
use crate::noise::pixels::{add_noise, to_grey};
use crate::world::{Ground, Moment};
use rayon::prelude::*;

/// The camera as the renderer needs it. Angles in radians, offsets in pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RenderCamera {
    /// Columns of the frame (across track).
    pub cols: usize,
    /// Rows of the frame (along track).
    pub rows: usize,
    /// Full field of view across, over all columns.
    pub fov_h_rad: f64,
    /// Full field of view along, over all rows.
    pub fov_v_rad: f64,
    /// Principal point offset to the right, added after distortion.
    pub offset_m_px: f64,
    /// Principal point offset forward, added after distortion.
    pub offset_n_px: f64,
    /// Brown-Conrady `k1 k2 k3 p1 p2` in OpenCV's convention: normalised coordinates, x right, y DOWN in the picture (so
    /// backward), ideal to distorted.
    pub distortion: Option<[f64; 5]>,
}

/// Place and attitude of the camera at one instant. Metres and radians.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Station {
    /// East coordinate of the projection centre.
    pub east_m: f64,
    /// North coordinate of the projection centre.
    pub north_m: f64,
    /// Height of the projection centre.
    pub up_m: f64,
    /// Heading, clockwise from grid north.
    pub heading_rad: f64,
    /// Pitch, nose up positive.
    pub pitch_rad: f64,
    /// Roll, right wing down positive.
    pub roll_rad: f64,
    /// Turn of the camera against the body about the body's up axis, counter-clockwise seen from above.
    pub follow_up_rad: f64,
    /// Turn of the camera against where the follow-up axis has it look: heading, pitch, roll, as of an aircraft.
    pub boresight_rad: [f64; 3],
}

/// A frame.
#[derive(Clone, Debug, PartialEq)]
pub struct Rendered {
    /// Grey values row by row, row 0 forward, columns to the right.
    pub pixels: Vec<u8>,
    /// Samples below the horizon that met no ground or no known albedo; they count as grey 0. Zero for a frame to be trusted.
    pub outside: usize,
}

/// The camera's axes as unit vectors `[east, north, up]`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CameraAxes {
    /// Towards row 0.
    pub forward: [f64; 3],
    /// Towards the last column.
    pub right: [f64; 3],
    /// The optical axis.
    pub down: [f64; 3],
}

impl Station {
    /// The camera's axes in the world: start level and facing north, then turn the aircraft by heading about up, by pitch
    /// about its own right axis, by roll about its own forward axis, then the camera about the aircraft's up axis, and at
    /// last by its boresight about its own axes as the aircraft about its.
    pub fn axes(&self) -> CameraAxes {
        let level = CameraAxes { forward: [0.0, 1.0, 0.0], right: [1.0, 0.0, 0.0], down: [0.0, 0.0, -1.0] };
        let body = level.turned([self.heading_rad, self.pitch_rad, self.roll_rad]);
        body.about(body.down, -self.follow_up_rad).turned(self.boresight_rad)
    }

    /// The ground point plumb below the camera, `[east, north, up]`.
    pub fn nadir(&self, ground: &Ground) -> [f64; 3] {
        [self.east_m, self.north_m, ground.height(self.east_m, self.north_m)]
    }
}

impl CameraAxes {
    /// Turned by heading, pitch and roll, each about its own axis as the turns before it have left that.
    fn turned(self, [heading, pitch, roll]: [f64; 3]) -> Self {
        let headed = self.about(self.down, heading); // right-handed about DOWN = clockwise seen from above
        let pitched = headed.about(headed.right, pitch);
        pitched.about(pitched.forward, roll)
    }

    fn about(self, axis: [f64; 3], angle: f64) -> Self {
        let [forward, right, down] = [self.forward, self.right, self.down].map(|v| rotated(v, axis, angle));
        CameraAxes { forward, right, down }
    }
}

/// Sine over cosine of the angle below the horizon down to which there is nothing but haze: ground ten heights away. Chosen:
/// 1.2 km from 120 m, so that no ground has to reach to the horizon.
const HAZE_SLOPE: f64 = 0.1;
/// Grey of the haze: a bright sky's. Chosen.
const HAZE: f64 = 200.0;

/// Pixels of a row that are looked at together. Chosen: the ground below them is mostly of one height.
const RUN: usize = 32;

/// What is seen along a direction that leads above the horizon, or to the haze below it.
fn haze([east, north, up]: [f64; 3]) -> Option<f64> {
    // Squares, since every ray asks.
    (up >= 0.0 || up * up < HAZE_SLOPE * HAZE_SLOPE * (east * east + north * north)).then_some(HAZE)
}

/// What rays from `origin` see that meet the ground so far `along` their directions; NaN where there is nothing.
fn look(ground: &Ground, origin: [f64; 3], directions: &[[f64; 3]], along: &[f64], seen: &mut [f64]) {
    let east = |i: usize| origin[0] + along[i] * directions[i][0];
    let north = |i: usize| origin[1] + along[i] * directions[i][1];
    let fours = along.len() / 4 * 4;
    for from in (0..fours).step_by(4) {
        let albedos = ground.four_albedos([0, 1, 2, 3].map(|i| east(from + i)), [0, 1, 2, 3].map(|i| north(from + i)));
        seen[from..from + 4].copy_from_slice(&albedos);
    }
    for (i, seen) in seen.iter_mut().enumerate().skip(fours) {
        *seen = ground.albedo(east(i), north(i)).unwrap_or(f64::NAN);
    }
    for (&direction, seen) in directions.iter().zip(seen) {
        if let Some(haze) = haze(direction) {
            *seen = haze;
        }
    }
}

/// Rodrigues: `vector` turned right-handedly by `angle` about the unit vector `about`.
fn rotated(vector: [f64; 3], about: [f64; 3], angle: f64) -> [f64; 3] {
    let (sin, cos) = angle.sin_cos();
    let along = dot(about, vector) * (1.0 - cos);
    let cross = [
        about[1] * vector[2] - about[2] * vector[1],
        about[2] * vector[0] - about[0] * vector[2],
        about[0] * vector[1] - about[1] * vector[0],
    ];
    std::array::from_fn(|i| vector[i] * cos + cross[i] * sin + about[i] * along)
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// A camera made ready to render many frames: the undistorted ray of every sub-pixel is computed once.
#[derive(Clone, Debug)]
pub struct Renderer {
    camera: RenderCamera,
    samples: usize,
    /// Ray of each sample as (right, forward) at down = 1, pixel by pixel; NaN where the distortion cannot be undone.
    rays: Vec<[f64; 2]>,
}

impl Renderer {
    /// `samples` x `samples` rays a pixel (2 is the usual), at the centres of equal parts of the pixel; 0 counts as 1.
    pub fn new(camera: RenderCamera, samples: usize) -> Self {
        let samples = samples.max(1);
        let ray_of = |row: usize, col: usize, k: usize| {
            let part = |i: usize| (i as f64 + 0.5) / samples as f64 - 0.5;
            camera.ray(col as f64 + part(k % samples), row as f64 + part(k / samples)).unwrap_or([f64::NAN; 2])
        };
        let rays = (0..camera.rows)
            .into_par_iter()
            .flat_map_iter(|row| {
                (0..camera.cols).flat_map(move |col| (0..samples * samples).map(move |k| ray_of(row, col, k)))
            })
            .collect();
        Renderer { camera, samples, rays }
    }

    /// The camera it was made for.
    pub fn camera(&self) -> &RenderCamera {
        &self.camera
    }

    /// One frame of an instant: the mean of the albedo the sub-pixels see (a gain of 1), plus normal noise of `noise_dn`
    /// from the ChaCha stream (`seed`, `frame_index`), rounded and clamped. The same arguments give the same bytes, on
    /// any number of threads.
    pub fn render(&self, ground: &Ground, exposure: &Station, noise_dn: f64, seed: u64, frame_index: u64) -> Rendered {
        self.render_rows(ground, &|_| vec![*exposure], (1.0, noise_dn), seed, frame_index)
    }

    /// One frame during which the camera moves: row r is the mean over the stations `row_stations(r)`, evenly spread
    /// over that row's exposure; at least one. The mean is multiplied by the gain, which stands for light and exposure; noise is
    /// that of reading out, and added once, after that.
    pub fn render_rows(
        &self,
        ground: &Ground,
        row_stations: &(dyn Fn(usize) -> Vec<Station> + Sync),
        (gain, noise_dn): (f64, f64),
        seed: u64,
        frame_index: u64,
    ) -> Rendered {
        self.render_through((ground, &Moment::default()), row_stations, (gain, noise_dn), seed, frame_index)
    }

    /// As [`Renderer::render_rows`], through the weather of that moment.
    pub fn render_through(
        &self,
        (ground, weather): (&Ground, &Moment<'_>),
        row_stations: &(dyn Fn(usize) -> Vec<Station> + Sync),
        (gain, noise_dn): (f64, f64),
        seed: u64,
        frame_index: u64,
    ) -> Rendered {
        let light = |row: usize, values: &mut [f64]| {
            let stations = row_stations(row);
            let add = |station| self.add_row((ground, weather), station, row, values);
            let outside = stations.iter().map(add).sum::<usize>();
            for value in values {
                *value = *value / stations.len() as f64 * gain;
            }
            outside
        };
        self.exposed(&light, noise_dn, seed, frame_index)
    }

    /// The frame of a lens that is covered: noise alone.
    pub fn black(&self, noise_dn: f64, seed: u64, frame_index: u64) -> Rendered {
        self.exposed(&|_, _| 0, noise_dn, seed, frame_index)
    }

    /// A frame of what `light` puts into each of its rows; it says how many samples met nothing.
    fn exposed(
        &self,
        light: &(dyn Fn(usize, &mut [f64]) -> usize + Sync),
        noise_dn: f64,
        seed: u64,
        frame_index: u64,
    ) -> Rendered {
        let cols = self.camera.cols;
        let mut pixels = vec![0u8; cols * self.camera.rows];
        let render_row = |(row, line): (usize, &mut [u8])| {
            let mut values = vec![0.0; cols];
            let outside = light(row, &mut values);
            add_noise(&mut values, noise_dn, seed, frame_index, row);
            for (pixel, value) in line.iter_mut().zip(values) {
                *pixel = to_grey(value);
            }
            outside
        };
        let outside = if cols == 0 { 0 } else { pixels.par_chunks_mut(cols).enumerate().map(render_row).sum() };
        Rendered { pixels, outside }
    }

    /// Adds what the row `row` sees from `station` to `values`; how many rays met nothing.
    fn add_row(
        &self,
        (ground, weather): (&Ground, &Moment<'_>),
        station: &Station,
        row: usize,
        values: &mut [f64],
    ) -> usize {
        let axes = station.axes();
        let origin = [station.east_m, station.north_m, station.up_m];
        let (cols, per_pixel) = (self.camera.cols, self.samples * self.samples);
        let mut outside = 0;
        let rays = &self.rays[row * cols * per_pixel..][..cols * per_pixel];
        let (mut directions, mut along, mut seen) = (Vec::new(), Vec::new(), Vec::new());
        for (values, rays) in values.chunks_mut(RUN).zip(rays.chunks(RUN * per_pixel)) {
            directions.clear();
            directions.extend(rays.iter().map(|&[right, forward]| -> [f64; 3] {
                std::array::from_fn(|i| right * axes.right[i] + forward * axes.forward[i] + axes.down[i])
            }));
            along.resize(directions.len(), f64::NAN);
            ground.intersect_all(origin, &directions, &mut along);
            seen.resize(directions.len(), f64::NAN);
            look(ground, origin, &directions, &along, &mut seen);
            weather.pass(origin, &directions, &along, &mut seen);
            for (value, seen) in values.iter_mut().zip(seen.chunks_exact(per_pixel)) {
                let mut sum = 0.0;
                for &seen in seen {
                    let is_known = !seen.is_nan();
                    sum += if is_known { seen } else { 0.0 };
                    outside += usize::from(!is_known);
                }
                *value += sum / per_pixel as f64;
            }
        }
        outside
    }

    /// Where a world point appears in the frame, fractional `(col, row)`. None behind the camera.
    pub fn project(&self, exposure: &Station, point: [f64; 3]) -> Option<(f64, f64)> {
        let axes = exposure.axes();
        let sight = [point[0] - exposure.east_m, point[1] - exposure.north_m, point[2] - exposure.up_m];
        let depth = dot(sight, axes.down);
        (depth > 0.0).then(|| self.camera.pixel([dot(sight, axes.right) / depth, dot(sight, axes.forward) / depth]))
    }

    /// Where the point plumb below the camera appears in the frame, fractional `(col, row)`; its height does not matter.
    pub fn nadir_px(&self, exposure: &Station) -> Option<(f64, f64)> {
        self.project(exposure, [exposure.east_m, exposure.north_m, exposure.up_m - 1.0])
    }
}

/// One frame with 2 x 2 rays a pixel. For many frames of one camera make a [`Renderer`] once.
pub fn render(
    camera: &RenderCamera,
    ground: &Ground,
    exposure: &Station,
    noise_dn: f64,
    seed: u64,
    frame_index: u64,
) -> Rendered {
    Renderer::new(*camera, 2).render(ground, exposure, noise_dn, seed, frame_index)
}

impl RenderCamera {
    /// Tangent per pixel across and along.
    pub(crate) fn tangent_per_px(&self) -> [f64; 2] {
        [
            (self.fov_h_rad / 2.0).tan() / (self.cols as f64 / 2.0),
            (self.fov_v_rad / 2.0).tan() / (self.rows as f64 / 2.0),
        ]
    }

    /// Tangent of the angle between the axis and the ray of the farthest corner that has one.
    pub(crate) fn widest(&self) -> f64 {
        let [right, below] = [self.cols as f64 - 0.5, self.rows as f64 - 0.5];
        let corners = [(-0.5, -0.5), (right, -0.5), (-0.5, below), (right, below)];
        let rays = corners.into_iter().filter_map(|(col, row)| self.ray(col, row));
        rays.map(|[right, forward]| right.hypot(forward)).fold(0.0, f64::max)
    }

    /// Frame pixel to ideal ray (right, forward) at down = 1. None where the distortion has no inverse.
    pub(crate) fn ray(&self, col: f64, row: f64) -> Option<[f64; 2]> {
        let [across, along] = self.tangent_per_px();
        let m = col - (self.cols as f64 - 1.0) / 2.0 - self.offset_m_px;
        let n = (self.rows as f64 - 1.0) / 2.0 - row - self.offset_n_px;
        let distorted = [m * across, -n * along];
        let [x, y] = match &self.distortion {
            Some(coefficients) => undistorted(coefficients, distorted)?,
            None => distorted,
        };
        Some([x, -y])
    }

    /// Ideal ray (right, forward) at down = 1 to frame pixel `(col, row)`.
    pub(crate) fn pixel(&self, [right, forward]: [f64; 2]) -> (f64, f64) {
        let ideal = [right, -forward];
        let [x, y] = self.distortion.as_ref().map_or(ideal, |coefficients| distorted(coefficients, ideal));
        let [across, along] = self.tangent_per_px();
        let (m, n) = (x / across + self.offset_m_px, -y / along + self.offset_n_px);
        (m + (self.cols as f64 - 1.0) / 2.0, (self.rows as f64 - 1.0) / 2.0 - n)
    }
}

#[cfg(test)]
mod tests;
