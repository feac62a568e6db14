//! From a match to a position with its covariance.

use crate::image::Run;
use crate::homography::Placement;
use crate::matching::Shift;
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
    /// The part of it that fixes seconds apart share: that of the tilt's drift. What else they may share, the map's own
    /// offset, no picture tells.
    pub correlated: Matrix2<f32>,
}

/// One sigma of what a fix rests on beside the picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Uncertainty {
    /// Of pitch and roll at mid-exposure, each, radians.
    pub tilt_rad: f32,
    /// Its part that drifts, radians.
    pub tilt_drift_rad: f32,
    /// Height above ground, metres.
    pub height_m: f32,
    /// How far the vehicle flies, east and north, in one sigma of the stamp, metres.
    pub along_m: [f32; 2],
}

/// Second moments of the valid pixels about the nadir, square pixels: how the footprint lies.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Footprint {
    /// Mean of x² (columns).
    pub xx: f32,
    /// Mean of xy, y northwards.
    pub xy: f32,
    /// Mean of y².
    pub yy: f32,
    /// Valid pixels.
    pub count: u32,
}

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
            sums.xx += count * (x * x + (count * count - 1.0) / 12.0);
            sums.xy += count * x * y;
            sums.yy += count * y * y;
            sums.count += count as u32;
        }
        let scale = 1.0 / (sums.count.max(1) as f32);
        Footprint { xx: sums.xx * scale, xy: sums.xy * scale, yy: sums.yy * scale, count: sums.count }
    }
}

/// The fix for a match that predicted the nadir at pixel `window` (col, row) of `tile`, of a camera so high above ground and so
/// far (east, north) off the point that positions refer to, metres.
///
/// Covariance: the match's own (which holds heading and height through [`crate::matching::Prior`]) plus the tilt's. A tilt
/// error δ about the axis across x moves the ground point (x, y) by δ (H + x²/H, xy/H): not by H δ alone, but by the mean
/// over the footprint, 11 % more for a 60° lens.
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
    let moment = |pixels: f32| pixels * per_px * per_px / height_m;
    let tilts = |sigma_rad: f32| {
        let east = Vector2::new(height_m + moment(footprint.xx), moment(footprint.xy)) * sigma_rad;
        let north = Vector2::new(moment(footprint.xy), height_m + moment(footprint.yy)) * sigma_rad;
        east * east.transpose() + north * north.transpose()
    };
    // Rows run south: the sign of the cross term turns.
    let c = &shift.covariance;
    let matched = Matrix2::new(c[(0, 0)], -c[(0, 1)], -c[(1, 0)], c[(1, 1)]) * (resolution * resolution);
    // The fix is where the picture was taken; it is reported for the stamp's instant, which may be another.
    let along = Vector2::from(uncertainty.along_m);
    let covariance = matched + tilts(uncertainty.tilt_rad) + along * along.transpose();
    let correlated = tilts(uncertainty.tilt_drift_rad);
    Fix { position: tile.georeference().geographic(local), local, covariance, correlated }
}
