//! The ground under the next frame: the plane of the elevation model, and the height above it.

use super::{FollowUpMode, Pipeline};
use crate::budget::PATCH_MAX_PX;
use crate::elevation::Plane;
use crate::tile::Local;
use crate::tilt::{Attitude, follow_up_command};
use crate::units::Radians;

/// Share of the way from the nadir to the ground point of the optical axis at which the middle of a footprint lies that
/// is clipped by a patch around the nadir: both reach half a side from their middles.
const SHARED: f32 = 0.5;

impl Pipeline<'_> {
    /// The plane under the footprint of a frame that begins, by the newest samples: the pose at mid-exposure is known
    /// only after the rows, and the plane changes little over metres. `None` without an elevation model or heights.
    // Inlined, its working memory would lie on the stack below that of a frame.
    #[inline(never)]
    pub(super) fn plane_below(&self, slant_m: f32) -> Option<Plane> {
        let elevation = self.tile().elevation()?;
        let (at, attitude) = self.streams.attitude.history().newest()?;
        let camera_at = self.camera_at(at)?;
        let nadir = Local { east_m: camera_at.east_m, north_m: camera_at.north_m };
        let cos_tilt = attitude.cos_tilt();
        if !attitude.looks_down() || cos_tilt < super::situate::COS_TILT_MIN {
            return None;
        }
        let height_m = slant_m * cos_tilt;
        let (middle, half_m) = self.footprint(attitude, height_m)?;
        elevation.plane(nadir.moved(middle), half_m)
    }

    /// Middle of the footprint, metres east and north of the nadir, and half its side, over level ground.
    fn footprint(&self, attitude: Attitude, height_m: f32) -> Option<([f32; 2], f32)> {
        let settings = self.settings();
        let follow_up = match settings.follow_up {
            FollowUpMode::Followed => follow_up_command(attitude),
            FollowUpMode::Fixed => Radians(0.0),
            FollowUpMode::Measured => self.streams.follow_up.history().newest()?.1,
        };
        let a = settings.mount.camera_from_local(attitude, follow_up);
        let resolution_m = self.tile().ground_resolution().0;
        let (cols, rows) = settings.camera.patch_size(height_m, resolution_m);
        let side = |px: f32| 0.5 * resolution_m * px.min(PATCH_MAX_PX as f32);
        let half_m = 0.5 * (side(cols) + side(rows));
        let depth = a[(1, 1)];
        if depth < super::situate::COS_TILT_MIN {
            return None;
        }
        let axis = [-a[(1, 2)], -a[(1, 0)]].map(|part| part * height_m / depth);
        let is_around_nadir = !settings.mount.looks_aside() && axis.iter().all(|part| part.abs() < half_m);
        let share = if is_around_nadir { SHARED } else { 1.0 };
        Some((axis.map(|part| share * part), half_m))
    }

    /// Height above the plane at the nadir, of a camera beside a laser that measures `slant_m` along the follow-up
    /// axis.
    ///
    /// The beam lands s sin t from the nadir, where the ground is higher than the plane at the nadir by the slope times
    /// that distance and by the residual of the plane. H = s cos t + ground there − plane at the nadir.
    #[inline(never)]
    pub(super) fn height_above(&self, plane: &Plane, slant_m: f32, attitude: Attitude, nadir: Local) -> f32 {
        let landing = nadir.moved(attitude.axis().map(|part| part * slant_m));
        let ground_m = self.tile().elevation().and_then(|model| model.height_m(landing));
        slant_m * attitude.cos_tilt() + ground_m.unwrap_or(plane.height_m(landing)) - plane.height_m(nadir)
    }
}
