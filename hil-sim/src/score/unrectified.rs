//! What matching would give without rectification: the raw frame averaged to the reference's resolution, as if the
//! camera looked straight down, and the whole-pixel peak.

use crate::camera::core_camera;
use crate::camera::still::{Target, rectify};
use crate::run::{FrameRecord, Observer};
use crate::setup::Setup;
use crate::vehicle::motion::TrueState;
use plumbline_core::homography::Homography;
use plumbline_core::image::View;
use plumbline_core::matching::search::{search, working_bytes};
use plumbline_core::tilt::EquivalentTilt;
use plumbline_firmware::wire::telemetry::FrameReport;
use plumbline_survey::io::picture::Picture;
use std::collections::BTreeMap;

/// Watches a flight and matches its raw frames.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Unrectified {
    /// Of each frame that could be matched: matched centre minus true nadir, (columns, rows) pixels of the reference.
    pub errors_px: BTreeMap<u32, [f64; 2]>,
}

impl Observer for Unrectified {
    fn finished(&mut self, setup: &Setup, record: &FrameRecord) {
        let Some(pixels) = &record.frame else { return };
        let error_px = match_raw(setup, &record.truth, pixels, record.report.as_ref());
        self.errors_px.extend(error_px.map(|error_px| (record.exposure.frame, error_px)));
    }
}

/// Matches a raw frame around the predicted position, or around the true one where the firmware predicted none.
/// `None` where the window leaves the reference or nothing can be correlated.
fn match_raw(setup: &Setup, truth: &TrueState, pixels: &[u8], report: Option<&FrameReport>) -> Option<[f64; 2]> {
    let camera = core_camera(&setup.payload.camera).ok()?;
    let frame = Picture { cols: camera.cols() as usize, rows: camera.rows() as usize, pixels: pixels.to_vec() };
    let resolution_m = setup.scenario.vehicle.resolution_m;
    let height_m = truth.up_m - setup.ground.height(truth.east_m, truth.north_m);
    let level = Homography::simplified(EquivalentTilt::default(), &camera);
    let patch = rectify(&camera, &frame, level, &Target { height_m, resolution_m, size: None }).ok()?;

    let size = setup.flash.head.size;
    let tile = View::new(&setup.flash.tile, size)?;
    let true_m = [truth.east_m - setup.tile_centre[0], truth.north_m - setup.tile_centre[1]];
    let around = report.and_then(|r| r.predicted).map_or(true_m, |p| [p.east_m, p.north_m].map(f64::from));
    let tile_pixel = |m: [f64; 2]| {
        [m[0] / resolution_m + 0.5 * (f64::from(size.0) - 1.0), 0.5 * (f64::from(size.1) - 1.0) - m[1] / resolution_m]
    };
    let radius = setup.scenario.vehicle.search_px;
    let window_size = (patch.picture.cols as u16 + 2 * radius, patch.picture.rows as u16 + 2 * radius);
    let around = tile_pixel(around);
    let half = |side: u16| 0.5 * (f64::from(side) - 1.0);
    let corner = [(around[0] - half(window_size.0)).round(), (around[1] - half(window_size.1)).round()];
    let window = tile.window(corner[0] as i32, corner[1] as i32, window_size)?;
    let view = View::new(&patch.picture.pixels, (patch.picture.cols as u16, patch.picture.rows as u16))?;
    let mut scores = vec![0; (2 * radius as usize + 1).pow(2)];
    let mut bytes = vec![0; working_bytes(window_size)];
    let peak = search(&view, &patch.runs, &window, radius, &mut bytes, &mut scores).ok()?;
    let truth = tile_pixel(true_m);
    Some([
        corner[0] + half(window_size.0) + f64::from(peak.d_col) - truth[0],
        corner[1] + half(window_size.1) + f64::from(peak.d_row) - truth[1],
    ])
}
