//! From a match to a position with its covariance.

use crate::homography::Placement;
use crate::image::Run;
use crate::matching::{Carried, Shift};
use crate::tile::{Geographic, Local, Tile};
use nalgebra::{Matrix2, Vector2};

/// A position fix at mid-exposure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fix {
    /// WGS84 position of the point that the navigation's positions refer to: the camera's nadir point, less the lever arm.
    pub position: Geographic,
    /// That point in grid metres from the tile's centre.
    pub local: Local,
    /// Covariance of (east, north), square metres.
    pub covariance: Matrix2<f32>,
    /// Its part by the tilt's drift, common to fixes seconds apart. The map's own offset, also common, is not
    /// observable and not included.
    pub tilt_drift_covariance: Matrix2<f32>,
    /// Its part by a map of another year, each axis, square metres, common to neighbouring fixes as well.
    pub map_variance_m2: f32,
}

/// Sigmas of a fix's sources other than the match.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Uncertainty {
    /// Of pitch and roll at mid-exposure, each, radians.
    pub tilt_rad: f32,
    /// Its drifting part, radians.
    pub tilt_drift_rad: f32,
    /// Height above ground, metres.
    pub height_m: f32,
    /// RMS of the ground's heights about the plane that the picture was rectified onto, metres.
    pub relief_m: f32,
    /// Displacement of the vehicle, east and north, in one sigma of the stamp, metres.
    pub along_m: [f32; 2],
}

/// Moments of the valid pixels about the nadir.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Footprint {
    /// Mean of x (columns) and y (northwards), pixels.
    pub centre: (f32, f32),
    /// Mean of x², square pixels.
    pub xx: f32,
    /// Mean of xy.
    pub xy: f32,
    /// Mean of y².
    pub yy: f32,
    /// Valid pixels.
    pub count: u32,
}

/// Effective share of the relief about the least-squares plane in a match's error, relative to all of the ground on one
/// side of the nadir being off the plane alike. Measured by the errors of flights over real elevation models (jacksboro
/// 0.12, 1,600 errors; austria 0.16, 230): that of some forty independent pieces of ground.
const RELIEF_SHARE: f32 = 0.15;

impl Footprint {
    /// Of the valid `runs` of a patch.
    pub fn of(runs: &[Run], placement: &Placement) -> Self {
        let Placement { size, aside } = *placement;
        let mut sums = Footprint::default();
        for run in runs {
            let count = run.end.saturating_sub(run.start) as f32;
            // Sums over a run in closed form: mean of x, and mean of x² = mean² + (n² − 1)/12.
            let (x, y) =
                crate::frames::centred(0.5 * (run.start as f32 + run.end as f32 - 1.0), run.row as f32, size.0, size.1);
            let (x, y) = (x + aside.0 as f32, y + aside.1 as f32);
            sums.centre.0 += count * x;
            sums.centre.1 += count * y;
            sums.xx += count * (x * x + (count * count - 1.0) / 12.0);
            sums.xy += count * x * y;
            sums.yy += count * y * y;
            sums.count += count as u32;
        }
        let scale = 1.0 / (sums.count.max(1) as f32);
        let centre = (sums.centre.0 * scale, sums.centre.1 * scale);
        Footprint { centre, xx: sums.xx * scale, xy: sums.xy * scale, yy: sums.yy * scale, count: sums.count }
    }

    /// Covariance of a match's error by the relief, for ground that is `lean` heights off the plane, square units of a
    /// pixel's `lean`.
    ///
    /// A point (x, y) that is δ above the plane is displaced by δ/H (x, y). The plane is the least-squares one, so the
    /// means of δ, δ x and δ y over the footprint are zero, and so is the mean shift if all ground weighs the same.
    /// With texture it does not: a match's shift is the sum of w δ/H (x, y) over pieces of ground of random weights w,
    /// whose covariance is a share of that of δ/H (x, y).
    fn relief(&self, lean: f32) -> Matrix2<f32> {
        Matrix2::new(self.xx, self.xy, self.xy, self.yy) * (lean * lean)
    }

    /// Displacement of the measured nadir by a small tilt about the axis across (`east`, `north`), one of which is 1
    /// and the other 0, pixels per radian. `height`: of the camera, pixels.
    ///
    /// A tilt δ along x displaces the ground point (x, y) by δ (H + x²/H, xy/H). The match's shift is the mean over the
    /// footprint: for a 60° lens 11 % more than H δ. Off the nadir the field also rotates and scales the picture, as a
    /// similarity fitted to its gradient; the share of rotation and scale that the match estimated from the picture
    /// displaces the nadir with it.
    fn nadir_shift(&self, (east, north): (f32, f32), height: f32, carried: Carried) -> Vector2<f32> {
        let (x, y) = self.centre;
        let along = Vector2::new(east, north);
        let mean =
            along * height + Vector2::new(self.xx * east + self.xy * north, self.xy * east + self.yy * north) / height;
        let spread = Matrix2::new(self.xx - x * x, self.xy - x * y, self.xy - x * y, self.yy - y * y);
        let over = spread.trace() * height;
        if over <= 0.0 {
            return mean;
        }
        // Gradient of (x, y)(x east + y north), and the similarity fitted to it with the pixels' second moments as
        // weights.
        let gradient = Matrix2::new(2.0 * x * east + y * north, x * north, y * east, x * east + 2.0 * y * north);
        let projected = gradient * spread;
        let (scale, turn) = (projected.trace() / over, (projected[(1, 0)] - projected[(0, 1)]) / over);
        mean - Vector2::new(x, y) * (scale * carried.scale) - Vector2::new(-y, x) * (turn * carried.turn)
    }
}

/// The fix of a match around pixel `window` (col, row) of `tile`, the predicted nadir, for a camera of this height
/// above ground and this offset (east, north) from the point that positions refer to, metres.
///
/// Covariance: the match's own, which contains heading and height by [`crate::matching::Prior`], the tilt's, the
/// stamp's and the relief's.
pub fn fix(
    tile: &Tile<'_>,
    window: (f32, f32),
    shift: &Shift,
    footprint: &Footprint,
    (height_m, [offset_east_m, offset_north_m]): (f32, [f32; 2]),
    uncertainty: Uncertainty,
) -> Fix {
    let nadir = tile.local(window.0 + shift.d_col, window.1 + shift.d_row);
    let local = Local { east_m: nadir.east_m - offset_east_m, north_m: nadir.north_m - offset_north_m };
    let resolution = tile.resolution().0;
    let per_px = tile.ground_resolution().0;
    let moved = [(1.0, 0.0), (0.0, 1.0)].map(|along| footprint.nadir_shift(along, height_m / per_px, shift.carried));
    let tilts = |sigma_rad: f32| {
        let [east, north] = moved.map(|moved| moved * (per_px * sigma_rad));
        east * east.transpose() + north * north.transpose()
    };
    // Rows run south, so the covariance's off-diagonal term changes its sign.
    let c = &shift.covariance;
    let matched = Matrix2::new(c[(0, 0)], -c[(0, 1)], -c[(1, 0)], c[(1, 1)]) * (resolution * resolution);
    // The fix is at the true mid-exposure; it is reported for the stamped one.
    let along = Vector2::from(uncertainty.along_m);
    let relief = footprint.relief(RELIEF_SHARE * uncertainty.relief_m * per_px / height_m);
    let covariance = matched + tilts(uncertainty.tilt_rad) + along * along.transpose() + relief;
    let tilt_drift_covariance = tilts(uncertainty.tilt_drift_rad);
    let map_variance_m2 = shift.map_variance * resolution * resolution;
    Fix { position: tile.georeference().geographic(local), local, covariance, tilt_drift_covariance, map_variance_m2 }
}

#[cfg(test)]
mod tests {
    use super::Footprint;
    use crate::homography::Placement;
    use crate::image::Run;
    use crate::matching::Carried;
    use nalgebra::{Matrix4, Vector4};

    extern crate std;
    use std::vec::Vec;

    /// A similarity fitted to how a small tilt moves each pixel, by least squares over all of them in f64, and where it takes the
    /// nadir. Without a share of its own, turn or scale stay what they were.
    fn fitted(pixels: &[(f64, f64)], height: f64, (east, north): (f64, f64), free: [bool; 2]) -> [f64; 2] {
        let count = pixels.len() as f64;
        let centre = pixels.iter().fold((0.0, 0.0), |sum, p| (sum.0 + p.0 / count, sum.1 + p.1 / count));
        let (mut normal, mut right) = (Matrix4::<f64>::zeros(), Vector4::<f64>::zeros());
        for &(x, y) in pixels {
            let leans = x * east + y * north;
            let moved = [height * east + x * leans / height, height * north + y * leans / height];
            let (u, v) = (x - centre.0, y - centre.1);
            let [turns, scales] = free.map(f64::from);
            let rows = [Vector4::new(1.0, 0.0, -v * turns, u * scales), Vector4::new(0.0, 1.0, u * turns, v * scales)];
            for (row, value) in rows.iter().zip(moved) {
                normal += row * row.transpose();
                right += row * value;
            }
        }
        for (axis, is_free) in [(2, free[0]), (3, free[1])] {
            normal[(axis, axis)] += if is_free { 0.0 } else { 1.0 };
        }
        let solution = normal.cholesky().expect("spread").solve(&right);
        let (turn, scale) = (solution[2], solution[3]);
        [solution[0] - scale * centre.0 + turn * centre.1, solution[1] - scale * centre.1 - turn * centre.0]
    }

    #[test]
    fn a_tilt_moves_the_nadir_as_a_similarity_of_the_footprint_does() {
        let (size, height) = ((64u16, 48u16), 60.0);
        for (aside, slant) in [((0, 0), 0), ((67, 0), 0), ((-40, 52), 1), ((12, -70), 2)] {
            // Rows that begin later and later: no axis of symmetry.
            let runs: Vec<Run> = (0..48).map(|row| Run { row, start: row * slant / 2, end: 64 }).collect();
            let placement = Placement { size, aside };
            let footprint = Footprint::of(&runs, &placement);
            let pixels: Vec<(f64, f64)> = runs
                .iter()
                .flat_map(|run| (run.start..run.end).map(move |col| (col, run.row)))
                .map(|(col, row)| {
                    (f64::from(col) - 31.5 + f64::from(aside.0), 23.5 - f64::from(row) + f64::from(aside.1))
                })
                .collect();
            for (along, free) in [((1.0f32, 0.0f32), [true; 2]), ((0.0, 1.0), [true; 2]), ((1.0, 0.0), [false; 2])] {
                let [turn, scale] = free.map(|is_free| if is_free { 1.0 } else { 0.0 });
                let moved = footprint.nadir_shift(along, height, Carried { turn, scale });
                let expected = fitted(&pixels, f64::from(height), (along.0.into(), along.1.into()), free);
                // The field's curvature over the footprint is left out, by which third moments count: 4 % for a triangle.
                let bound = if slant == 0 { 1e-3 } else { 0.05 } * expected[0].hypot(expected[1]);
                let off = (f64::from(moved[0]) - expected[0]).hypot(f64::from(moved[1]) - expected[1]);
                assert!(off < bound, "{aside:?} {along:?} {free:?}: {moved:?} {expected:?}");
            }
        }
    }
}
