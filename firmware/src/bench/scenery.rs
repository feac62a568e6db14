//! A frame as a tilted camera takes it of flat ground: a ray a pixel, by this file's own geometry, so that the core does
//! not judge itself.

use super::poses::Pose;
use super::texture::hash;
use plumbline_core::math::sin_cos;

/// Ground and camera of a case.
#[derive(Clone, Copy, Debug)]
pub struct Scene<'a> {
    /// The ground, row 0 north: as many columns as rows.
    pub tile: &'a [u8],
    /// Its side, pixels.
    pub tile_side: usize,
    /// Metres a pixel of it.
    pub resolution_m: f32,
    /// Side of the frame, pixels.
    pub frame_side: usize,
    /// Tangent of half the field of view.
    pub half_fov_tangent: f32,
    /// Height above the centre of the tile, metres.
    pub height_m: f32,
}

/// Grey levels of noise in a frame, and what a camera makes of the ground's contrast.
const NOISE: f32 = 6.0;
const GAIN: f32 = 0.8;

impl Scene<'_> {
    /// Takes the frame.
    pub fn render(&self, pose: &Pose, seed: u32, frame: &mut [u8]) {
        let [forward, right, down] = camera_axes(pose);
        let centre = 0.5 * (self.frame_side as f32 - 1.0);
        let tangent_per_px = self.half_fov_tangent / (0.5 * self.frame_side as f32);
        for (row, line) in frame.chunks_mut(self.frame_side).take(self.frame_side).enumerate() {
            let ahead = (centre - row as f32) * tangent_per_px;
            for (col, pixel) in line.iter_mut().enumerate() {
                let aside = (col as f32 - centre) * tangent_per_px;
                let along = |axis: usize| down[axis] + ahead * forward[axis] + aside * right[axis];
                // Towards or above the horizon there is nothing but haze.
                let scale = self.height_m / along(2).max(0.05);
                let grey = self.ground(scale * along(0), scale * along(1));
                let noise = NOISE * ((hash(col as u32, row as u32, seed) >> 16) as f32 / 65536.0 - 0.5);
                *pixel = (20.0 + GAIN * grey + noise + 0.5) as u8;
            }
        }
    }

    /// Grey of the ground, between pixels bilinear; beyond the tile its border goes on.
    fn ground(&self, north_m: f32, east_m: f32) -> f32 {
        let last = (self.tile_side - 1) as f32;
        let centre = 0.5 * last;
        let at = |metres: f32| (centre + metres / self.resolution_m).clamp(0.0, last - 0.01);
        let (col, row) = (at(east_m), at(-north_m));
        let (left, top) = (col as usize, row as usize);
        let (across, along) = (col - left as f32, row - top as f32);
        let grey = |col: usize, row: usize| f32::from(self.tile.get(row * self.tile_side + col).copied().unwrap_or(0));
        let line = |row: usize| grey(left, row) + across * (grey(left + 1, row) - grey(left, row));
        line(top) + along * (line(top + 1) - line(top))
    }
}

/// The camera's forward, right and down as (north, east, down). Body axes by heading, pitch and roll as everywhere in
/// aviation; the camera turned in the body by the follow-up angle, counter-clockwise seen from above.
fn camera_axes(pose: &Pose) -> [[f32; 3]; 3] {
    let attitude = pose.attitude();
    let (sin_h, cos_h) = sin_cos(attitude.heading.0);
    let (sin_p, cos_p) = sin_cos(attitude.pitch.0);
    let (sin_r, cos_r) = sin_cos(attitude.roll.0);
    let forward = [cos_p * cos_h, cos_p * sin_h, -sin_p];
    let right = [sin_r * sin_p * cos_h - cos_r * sin_h, sin_r * sin_p * sin_h + cos_r * cos_h, sin_r * cos_p];
    let down = [cos_r * sin_p * cos_h + sin_r * sin_h, cos_r * sin_p * sin_h - sin_r * cos_h, cos_r * cos_p];
    let (sin_b, cos_b) = sin_cos(pose.follow_up().0);
    let turned = |a: [f32; 3], b: [f32; 3], (s, c): (f32, f32)| core::array::from_fn(|n| c * a[n] + s * b[n]);
    [turned(forward, right, (-sin_b, cos_b)), turned(right, forward, (sin_b, cos_b)), down]
}
