//! What matching would give without rectification: the raw frame averaged to the reference's resolution, as if the
//! camera looked straight down, and the whole-pixel peak.

use crate::camera::core_camera;
use crate::flight::TrueState;
use crate::stage::Stage;
use crate::still::{Target, rectify};
use plumbline_core::homography::Homography;
use plumbline_core::matching::View;
use plumbline_core::matching::search::{room, search};
use plumbline_core::tilt::EquivalentTilt;
use plumbline_firmware::wire::telemetry::FrameReport;
use plumbline_survey::picture::Picture;

/// Where the raw frame was found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RawMatch {
    /// Matched centre minus true nadir, (columns, rows) pixels of the reference.
    pub error_px: [f64; 2],
}

/// Matches a raw frame around the predicted position, or around the true one where the firmware predicted none.
/// `None` where the window leaves the reference or nothing can be correlated.
pub fn match_raw(stage: &Stage, truth: &TrueState, pixels: &[u8], report: Option<&FrameReport>) -> Option<RawMatch> {
    let camera = core_camera(&stage.camera).ok()?;
    let frame = Picture { cols: camera.cols() as usize, rows: camera.rows() as usize, pixels: pixels.to_vec() };
    let resolution_m = stage.scenario.resolution_m;
    let height_m = truth.up_m - stage.ground.height(truth.east_m, truth.north_m);
    let level = Homography::simplified(EquivalentTilt::default(), &camera);
    let patch = rectify(&camera, &frame, level, &Target { height_m, resolution_m, size: None }).ok()?;

    let size = stage.flash.head.size;
    let tile = View::new(&stage.flash.tile, size)?;
    let true_m = [truth.east_m - stage.tile_centre[0], truth.north_m - stage.tile_centre[1]];
    let around = report.and_then(|r| r.predicted).map_or(true_m, |p| p.map(f64::from));
    let tile_pixel = |m: [f64; 2]| {
        [m[0] / resolution_m + 0.5 * (f64::from(size.0) - 1.0), 0.5 * (f64::from(size.1) - 1.0) - m[1] / resolution_m]
    };
    let radius = stage.scenario.search_px;
    let window_size = (patch.picture.cols as u16 + 2 * radius, patch.picture.rows as u16 + 2 * radius);
    let around = tile_pixel(around);
    let half = |side: u16| 0.5 * (f64::from(side) - 1.0);
    let corner = [(around[0] - half(window_size.0)).round(), (around[1] - half(window_size.1)).round()];
    let window = tile.window(corner[0] as i32, corner[1] as i32, window_size)?;
    let view = View::new(&patch.picture.pixels, (patch.picture.cols as u16, patch.picture.rows as u16))?;
    let mut scores = vec![0; (2 * radius as usize + 1).pow(2)];
    let mut bytes = vec![0; room(window_size)];
    let peak = search(&view, &patch.runs, &window, radius, &mut bytes, &mut scores).ok()?;
    let truth = tile_pixel(true_m);
    Some(RawMatch {
        error_px: [
            corner[0] + half(window_size.0) + f64::from(peak.d_col) - truth[0],
            corner[1] + half(window_size.1) + f64::from(peak.d_row) - truth[1],
        ],
    })
}
