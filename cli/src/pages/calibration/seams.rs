//! How far the heads are expected to put one direction apart in the virtual image, by the covariance of their unknowns.

use super::propagate::Propagated;
use nalgebra::Vector3;
use plumbline_survey::adjust::rig::{HEAD, LENS};
use plumbline_survey::calibrate::seam::{Virtual, mismatches, ray_of};
use plumbline_survey::calibrate::{Block, Calibration, Observations, Symmetrised, camera_file, mount};

/// Places across the virtual image.
const COLUMNS: f64 = 100.0;
/// Points of a side of a head's outline.
const SIDE: usize = 24;

/// A direction that two heads see.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    /// The two heads.
    pub heads: [usize; 2],
    /// Where in the virtual image, x right and y up, pixels.
    pub at_px: [f64; 2],
    /// Root of the expected square of the mismatch, pixels.
    pub sigma_px: f64,
}

/// The seams of a calibrated camera.
#[derive(Clone, Debug)]
pub struct Seams {
    /// The virtual image.
    pub view: Virtual,
    /// Side of a cell of the grid, pixels.
    pub step_px: f64,
    /// Every head's border in the virtual image; empty where it cannot be told.
    pub outlines: Vec<Vec<[f64; 2]>>,
    /// Where two heads see.
    pub places: Vec<Place>,
    /// What the block did not say, and what was taken instead.
    pub assumed: Vec<String>,
}

impl Seams {
    /// Seams of symmetrised heads over a grid of the virtual image.
    #[must_use]
    pub fn new(
        block: &Block,
        observations: &Observations,
        calibration: &Calibration,
        symmetrised: &Symmetrised,
    ) -> Self {
        let (view, assumed) = view(block, observations, calibration);
        let f_px = view.f_px;
        let outlines = symmetrised.heads.iter().map(|head| outline(head, view.head_half_px, f_px)).collect();
        let step_px = 2.0 * view.half_px[0] / COLUMNS;
        let places = places(calibration, symmetrised, &view, step_px);
        Seams { view, step_px, outlines, places, assumed }
    }

    /// Pairs of heads that see something in common.
    #[must_use]
    pub fn pairs(&self) -> Vec<[usize; 2]> {
        let mut pairs: Vec<_> = self.places.iter().map(|place| place.heads).collect();
        pairs.sort_unstable();
        pairs.dedup();
        pairs
    }

    /// Root mean square and largest of a pair, or of all.
    #[must_use]
    pub fn rms_and_max(&self, pair: Option<[usize; 2]>) -> Option<(f64, f64)> {
        let of = self.places.iter().filter(|place| pair.is_none_or(|pair| pair == place.heads));
        rms_and_max(of.map(|place| place.sigma_px))
    }
}

/// Root mean square and largest; `None` of nothing.
pub fn rms_and_max(lengths: impl Iterator<Item = f64>) -> Option<(f64, f64)> {
    let (count, squares, max) =
        lengths.fold((0_u32, 0.0, 0.0_f64), |(n, sum, max), length| (n + 1, sum + length * length, max.max(length)));
    (count > 0).then(|| ((squares / f64::from(count)).sqrt(), max))
}

/// The virtual image of the camera file, and what had to be assumed for it. Heads that no picture holds have none, of no size.
fn view(block: &Block, observations: &Observations, calibration: &Calibration) -> (Virtual, Vec<String>) {
    let half = |cols: u32, rows: u32| [cols, rows].map(|side| 0.5 * f64::from(side));
    let c_px = calibration.heads[0][LENS];
    match camera_file(block, observations, calibration) {
        Ok(file) => {
            let camera = &file.camera;
            let half_px = half(camera.cols, camera.rows);
            let (f_px, head_half_px) = match camera.heads.first() {
                Some(head) => (half_px[0] / (0.5 * camera.fov_h_deg.to_radians()).tan(), half(head.cols, head.rows)),
                None => (c_px, half_px),
            };
            let assumed = file.assumed.iter().map(|assumed| format!("The block has {assumed}.")).collect();
            (Virtual { f_px, half_px, head_half_px }, assumed)
        }
        Err(error) => {
            let head_half_px = farthest(observations.seen.iter().map(|seen| seen.image_px));
            (Virtual { f_px: c_px, half_px: [0.0; 2], head_half_px }, vec![format!("No seams: {error}.")])
        }
    }
}

/// The mismatch of every place: that of heads one sigma off against the calibrated ones, combined by the covariance. Steps are
/// made before the heads are symmetrised, since that is what the covariance is of.
fn places(calibration: &Calibration, symmetrised: &Symmetrised, view: &Virtual, step_px: f64) -> Vec<Place> {
    let against = |heads: &[[f64; HEAD]]| mismatches(&symmetrised.heads, heads, view, step_px);
    if !(step_px.is_finite() && step_px > 0.0) {
        return Vec::new();
    }
    let base = against(&symmetrised.heads);
    let propagated = Propagated::new(calibration, |heads| {
        let moved = against(&Symmetrised::new(heads).heads);
        // The places are those the calibrated heads see, whatever was moved, unless a lens cannot be undone.
        (moved.len() == base.len()).then(|| moved.iter().flat_map(|mismatch| mismatch.by_px).collect())
    });
    let Some(propagated) = propagated.filter(|_| !calibration.unknowns.is_empty()) else { return Vec::new() };
    let sigma = |k: usize| (propagated.variance(2 * k) + propagated.variance(2 * k + 1)).sqrt();
    base.iter()
        .enumerate()
        .map(|(k, mismatch)| Place { heads: mismatch.heads, at_px: mismatch.at_px, sigma_px: sigma(k) })
        .collect()
}

/// Largest distance from the centre in x and in y.
fn farthest(points: impl Iterator<Item = [f64; 2]>) -> [f64; 2] {
    points.fold([0.0, 0.0], |[x, y], [a, b]| [f64::max(x, a.abs()), f64::max(y, b.abs())])
}

/// A frame's border in the virtual image, of distant ground.
fn outline(head: &[f64; HEAD], [x, y]: [f64; 2], f_px: f64) -> Vec<[f64; 2]> {
    let corners = [[-x, -y], [x, -y], [x, y], [-x, y]];
    let border = (0..4 * SIDE).map(|k| {
        let (from, to) = (corners[k / SIDE], corners[(k / SIDE + 1) % 4]);
        let part = (k % SIDE) as f64 / SIDE as f64;
        [0, 1].map(|i| from[i] + part * (to[i] - from[i]))
    });
    let in_virtual = |image| on_plane(&(mount(head) * ray_of(head, image)?), f_px);
    border.map(in_virtual).collect::<Option<_>>().unwrap_or_default()
}

/// Where the virtual image shows a direction.
pub fn on_plane(ray: &Vector3<f64>, f_px: f64) -> Option<[f64; 2]> {
    (ray.z < 0.0).then(|| [-f_px * ray.x / ray.z, -f_px * ray.y / ray.z])
}
