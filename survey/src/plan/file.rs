//! `plan.json`: what was planned, for flying it, for other programs, for the page.
//!
//! Coordinates `x`, `y` are those of the elevation model's reference system (degrees, longitude first, where it is
//! geographic; local metres where it has none), `z` metres above its height datum.

mod check;
mod numbers;
mod vertical;

use crate::camera_file::{CameraFile, Distortion};
use crate::dem::Doubt;
use serde::{Deserialize, Serialize};

pub use vertical::{Datum, Vertical, above_the_sea};

/// Version of the file that is written, and the only one that is read.
pub const VERSION: u32 = 1;

/// A whole plan.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PlanFile {
    /// [`VERSION`].
    pub version: u32,
    /// The elevation model, as it was named.
    pub dem: String,
    /// Reference system of all x and y; `None` is local metres.
    pub epsg: Option<u32>,
    /// Latitude and longitude (WGS 84, degrees) of the local grid's x = 0, y = 0, where they were given.
    pub origin_deg: Option<[f64; 2]>,
    /// The camera.
    pub camera: Camera,
    /// Flying height above the base plane, H.
    pub height_m: f64,
    /// Height of the base plane above the height datum.
    pub base_height_m: f64,
    /// Ground sample distance on the base plane, across.
    pub gsd_m: f64,
    /// Direction of the strips, clockwise from grid north, 0 to below 180.
    pub strip_heading_deg: f64,
    /// Ground speed.
    pub speed_m_s: f64,
    /// Least time between two exposures.
    pub min_interval_s: f64,
    /// Tilt of the camera to any side for which the overlap is kept; 0 in files of older versions.
    #[serde(default)]
    pub tilt_deg: f64,
    /// Overlap that was asked for, shares of 1.
    pub overlap_wanted: Overlap,
    /// Smallest overlap of any pair on commonly seen ground; `None` where there is no pair.
    pub overlap_min: OverlapMin,
    /// Photos of all strips.
    pub photo_count: usize,
    /// Shortest base of any strip, metres.
    pub base_min_m: f64,
    /// Time for that base at the ground speed, seconds.
    pub interval_min_s: f64,
    /// Corners of the area, the first not repeated.
    pub area: Vec<[f64; 2]>,
    /// Strips in the order of flight.
    pub strips: Vec<StripFile>,
    /// Noise that the predicted accuracy is for.
    pub noise: Noise,
    /// Predicted accuracy; `None` where no cell is seen twice.
    pub accuracy: Option<Accuracy>,
    /// What else was checked.
    pub checks: Checks,
    /// The cheapest constant bases that guarantee the same overlap; `None` where none of less than half a million photos do.
    pub constant_base: Option<ConstantBase>,
    /// All combinations that were looked at, side overlap before forward overlap, ascending; empty without `--optimise`.
    pub combinations: Vec<Combination>,
    /// The exposures in the order of flight: index of the strip, and of the photo within it. Empty in files of older versions.
    #[serde(default)]
    pub flight_order: Vec<[usize; 2]>,
    /// Smallest width that neighbouring strips truly see in common.
    #[serde(default)]
    pub swath_min: SwathMin,
    /// How flying heights follow the ground; `None` where all photos have one height.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub follow: Option<FollowFile>,
    /// The elevation model's absolute path and the SHA-256 of its file; `None` in files of older versions.
    #[serde(default)]
    pub dem_path: Option<String>,
    #[serde(default)]
    #[expect(missing_docs, reason = "stated with the path")]
    pub dem_sha256: Option<String>,
    /// What all z are above; `None` where the plan's place on Earth is not known, and in files of older versions.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub vertical: Option<Vertical>,
}

/// The camera of a plan.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Camera {
    /// Columns, across the flight.
    pub cols: u32,
    /// Rows, along the flight.
    pub rows: u32,
    /// Full field of view across.
    pub fov_h_deg: f64,
    /// Full field of view along.
    pub fov_v_deg: f64,
    /// Principal point right of the centre.
    pub offset_m_px: f64,
    /// Principal point forward of the centre.
    pub offset_n_px: f64,
    /// Side of a pixel.
    pub pixel_mm: Option<f64>,
    /// k1, k2, k3, p1, p2.
    pub distortion: Option<[f64; 5]>,
}

impl From<&CameraFile> for Camera {
    fn from(camera: &CameraFile) -> Self {
        Camera {
            cols: camera.cols,
            rows: camera.rows,
            fov_h_deg: camera.fov_h_deg,
            fov_v_deg: camera.fov_v_deg,
            offset_m_px: camera.offset_m_px,
            offset_n_px: camera.offset_n_px,
            pixel_mm: camera.pixel_mm,
            distortion: camera.distortion.map(|d| [d.k1, d.k2, d.k3, d.p1, d.p2]),
        }
    }
}

impl From<&Camera> for CameraFile {
    fn from(camera: &Camera) -> Self {
        CameraFile {
            offset_m_px: camera.offset_m_px,
            offset_n_px: camera.offset_n_px,
            pixel_mm: camera.pixel_mm,
            distortion: camera.distortion.map(|[k1, k2, k3, p1, p2]| Distortion { k1, k2, k3, p1, p2 }),
            ..CameraFile::new((camera.cols, camera.rows), (camera.fov_h_deg, camera.fov_v_deg))
        }
    }
}

/// Shares of a footprint, 0 to 1.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Overlap {
    /// Along the strip.
    pub forward: f64,
    /// Between strips.
    pub side: f64,
}

/// Smallest overlaps on commonly seen ground: the share of a photo whose ground its neighbour sees too, at the highest
/// terrain that both see. `None` where there is no pair to have one.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct OverlapMin {
    /// Along the strip.
    pub forward: Option<f64>,
    /// Between strips.
    pub side: Option<f64>,
}

/// Smallest width of ground that neighbouring strips truly see in common, along rays to the terrain, as a share of the wider
/// of their swaths there. Terrain that falls away towards the neighbour makes it smaller than the overlap.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct SwathMin {
    /// Between strips; `None` where there is one line alone.
    pub side: Option<f64>,
}

/// A strip, from its low end (low x; low y where it runs north), whatever its direction of flight.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct StripFile {
    /// Number of the line it lies on, from 0; a concave area may part a line into several strips.
    pub line: usize,
    /// Direction in which it is flown, clockwise from grid north, 0 to below 360.
    pub heading_deg: f64,
    /// Exposures.
    pub photos: Vec<Photo>,
    /// Waypoints where the ground is followed, from the low end too, a turn's radius before the first photo and behind the last; the height
    /// changes evenly between them.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub way: Vec<Photo>,
}

/// An exposure.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Photo {
    /// East, or longitude.
    pub x: f64,
    /// North, or latitude.
    pub y: f64,
    /// Above the height datum.
    pub z: f64,
    /// WGS 84, degrees, where the place on Earth is known.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub lat: Option<f64>,
    /// WGS 84, degrees.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub lon: Option<f64>,
}

/// Standard deviations of what is measured.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Noise {
    /// Of an image coordinate.
    pub image_px: f64,
    /// Of each coordinate of a projection centre.
    pub position_m: f64,
    /// Of each angle.
    pub attitude_deg: f64,
}

/// Root mean squares over the area's cells.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Accuracy {
    /// Horizontal, both coordinates together, from the covariance.
    pub plan_m: f64,
    /// Height.
    pub height_m: f64,
    /// Horizontal, from intersections with simulated noise.
    pub simulated_plan_m: f64,
    /// Height, from simulated noise.
    pub simulated_height_m: f64,
    /// Largest predicted horizontal standard deviation of a cell.
    pub plan_max_m: f64,
    /// Largest of the height.
    pub height_max_m: f64,
    /// Cells that were looked at.
    pub cells: usize,
    /// Cells that fewer than two photos of one strip see.
    pub gaps: usize,
    /// Seed of the noise.
    pub seed: u64,
}

/// Clearance, blur, time.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Checks {
    /// Least height above the ground along strips and turns.
    pub clearance_min_m: f64,
    /// Most that the picture moves during an exposure over the highest ground.
    pub smear_px: f64,
    /// Longest exposure that stays within half a pixel there.
    pub exposure_max_s: f64,
    /// Exposure that the smear is for.
    pub exposure_s: f64,
    /// Length of strips and turns.
    pub length_m: f64,
    /// Time for them.
    pub flight_time_s: f64,
    /// Radius of the turns.
    pub turn_radius_m: f64,
    /// Photos whose frames look beyond the elevation model, where nothing is known.
    pub photos_beyond_dem: usize,
    /// Clearance that was asked for; 0 in files of older versions.
    #[serde(default)]
    pub clearance_wanted_m: f64,
    /// Whether strips or turns pass over posts whose height is unknown: then the clearance is, too.
    #[serde(default)]
    pub passes_unknown: bool,
    /// Whether strips or turns reach beyond the elevation model: what is there nobody looked at.
    #[serde(default)]
    pub leaves_model: bool,
    /// Strips that leave the elevation model: all of their photos, or two that follow each other, are taken beyond it.
    #[serde(default)]
    pub strips_off_dem: usize,
    /// Steepest climb or descent on strips and turns, in percent of the way.
    #[serde(default)]
    pub climb_percent: f64,
    /// The steepest that was allowed; 0 where all is flown at one height.
    #[serde(default)]
    pub climb_wanted_percent: f64,
    /// Where the flight comes nearest to the ground; `None` where no ground is known, and in files of older versions.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub nearest: Option<Nearest>,
    /// Least height of what is flown beyond the elevation model above the highest ground of the model, metres: what is beyond is not known,
    /// and may be as high. `None` where nothing is flown there, and in files of older versions.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub beyond_m: Option<f64>,
    /// Why the heights of the elevation model are probably none of ground in metres.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub heights_doubt: Option<Doubt>,
}

/// The post of the elevation model that a flight passes with the least clearance, and from where.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Nearest {
    /// East of the post, or its longitude.
    pub x: f64,
    /// North of the post, or its latitude.
    pub y: f64,
    /// Its height.
    pub ground_m: f64,
    /// The least height that is flown there.
    pub flown_m: f64,
    /// The strip, from 1 in the order of flight; of a turn the one before it.
    pub strip: usize,
    /// Whether it is on the turn behind that strip.
    pub is_turn: bool,
}

impl Nearest {
    /// On which part of the flight: `strip 3`, `the turn from strip 3 to strip 4`.
    #[must_use]
    pub fn part(&self) -> String {
        let strip = self.strip;
        if self.is_turn {
            format!("the turn from strip {strip} to strip {}", strip + 1)
        } else {
            format!("strip {strip}")
        }
    }
}

/// How flying heights follow the ground.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct FollowFile {
    /// How far the height above the ground straight below may be off `height_m`, but where the climb allowed keeps it higher.
    pub tolerance_m: f64,
    /// The least height above the ground straight below, from a strip's first photo to its last.
    pub above_ground_min_m: f64,
    /// The greatest.
    pub above_ground_max_m: f64,
}

/// What constant bases would cost.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct ConstantBase {
    /// Base along the strips.
    pub base_m: f64,
    /// Distance of the strips.
    pub spacing_m: f64,
    /// Lines.
    pub lines: usize,
    /// Photos.
    pub photos: usize,
    /// How many photos the variable bases save.
    pub photos_saved: i64,
}

/// One combination of overlaps.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Combination {
    /// What was asked for.
    pub forward: f64,
    /// What was asked for.
    pub side: f64,
    /// Lines.
    pub lines: usize,
    /// Photos.
    pub photos: usize,
    /// Shortest time between exposures.
    pub interval_min_s: f64,
    /// Cells that fewer than two photos of one strip see.
    pub gaps: usize,
    /// Horizontal accuracy, from the covariance; `None` where no cell is seen twice.
    pub plan_m: Option<f64>,
    /// Height.
    pub height_m: Option<f64>,
    /// Which limit rules it out first; `None` where none does.
    pub ruled_out: Option<Limit>,
    /// Whether it is the one.
    pub chosen: bool,
}

/// What rules a combination out, in the order of looking.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Limit {
    /// Cells without a stereo pair.
    Gap,
    /// Exposures follow each other too fast.
    Interval,
    /// Plan or height accuracy.
    Accuracy,
    /// More photos than a plan may have.
    Photos,
}

#[cfg(test)]
pub(super) mod tests;
