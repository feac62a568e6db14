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

/// Columns between exact positions, and between them steps: less than a hundredth of a tile's pixel from exact.
const SPAN: usize = 16;
/// Largest position on a tile: what lies further, or above the horizon, is drawn with the tile's border.
const FAR_PX: f32 = 10_000.0;

impl Scene<'_> {
    /// Takes the frame: 0.8 of the ground's contrast, and three bits of noise. In integers, but for the exact positions,
    /// since an emulator takes its time over floating point.
    pub fn render(&self, pose: &Pose, seed: u32, frame: &mut [u8]) {
        let axes = camera_axes(pose);
        for (row, line) in frame.chunks_mut(self.frame_side).take(self.frame_side).enumerate() {
            let mut from = self.position(&axes, 0, row);
            for (n, pixels) in line.chunks_mut(SPAN).enumerate() {
                let to = self.position(&axes, (n + 1) * SPAN, row);
                let step = [(to[0] - from[0]) / SPAN as i32, (to[1] - from[1]) / SPAN as i32];
                let mut noise = 0;
                for (col, pixel) in pixels.iter_mut().enumerate() {
                    if col % 8 == 0 {
                        noise = hash((n * SPAN + col) as u32, row as u32, seed);
                    }
                    *pixel = (20 + self.ground(from) * 4 / 5 + (noise & 7)) as u8;
                    noise >>= 4;
                    from = [from[0] + step[0], from[1] + step[1]];
                }
                from = to;
            }
        }
    }

    /// Where the ray of a pixel meets the ground: (column, row) of the tile in Q16.
    fn position(&self, [forward, right, down]: &[[f32; 3]; 3], col: usize, row: usize) -> [i32; 2] {
        let centre = 0.5 * (self.frame_side as f32 - 1.0);
        let tangent_per_px = self.half_fov_tangent / (0.5 * self.frame_side as f32);
        let (ahead, aside) = ((centre - row as f32) * tangent_per_px, (col as f32 - centre) * tangent_per_px);
        let along = |axis: usize| down[axis] + ahead * forward[axis] + aside * right[axis];
        let px = self.height_m / along(2).max(0.05) / self.resolution_m;
        let middle = 0.5 * (self.tile_side as f32 - 1.0);
        let fixed = |at: f32| (at.clamp(-FAR_PX, FAR_PX) * 65536.0) as i32;
        [fixed(middle + px * along(1)), fixed(middle - px * along(0))]
    }

    /// Grey of the ground at a position in Q16, between pixels bilinear; beyond the tile its border goes on.
    fn ground(&self, position: [i32; 2]) -> u32 {
        let [col, row] = position.map(|at| at.clamp(0, ((self.tile_side as i32 - 1) << 16) - 1) as u32);
        let (across, along) = (col >> 8 & 255, row >> 8 & 255);
        let at = (row >> 16) as usize * self.tile_side + (col >> 16) as usize;
        let line = |at: usize| match self.tile.get(at..at + 2) {
            Some(&[left, right]) => u32::from(left) * (256 - across) + u32::from(right) * across,
            _ => 0,
        };
        (line(at) * (256 - along) + line(at + self.tile_side) * along) >> 16
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
