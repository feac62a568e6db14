//! The rectification alone: reduction and resampling of a frame of 512 x 512.

use super::poses::Pose;
use super::region::{Stand, region};
use core::hint::black_box;
use heapless::{Vec, VecView};
use plumbline_core::budget::{REDUCED_MAX_AREA, REDUCED_MAX_COLS};
use plumbline_core::camera::Camera;
use plumbline_core::homography::FrameFromPatch;
use plumbline_core::pipeline::{Prediction, Situation};
use plumbline_core::rectify::{RectifyError, Run, Sampling, Source, rectify_into};
use plumbline_core::reduce::{ReduceError, Reducer, Reduction};
use plumbline_core::tile::Local;
use plumbline_core::units::{Micros, Radians};

/// Side of the frame, pixels.
pub const FRAME_PX: u16 = 512;
/// Side of the largest patch, pixels.
pub const PATCH_PX: u16 = 256;

/// A camera over ground at a resolution.
#[derive(Clone, Copy, Debug)]
pub struct Case {
    /// Its name.
    pub name: &'static str,
    /// Field of view, degrees.
    pub fov_deg: f32,
    /// Height above ground and resolution, metres.
    pub height_resolution_m: (f32, f32),
    /// Side of the patch, pixels.
    pub patch_px: u16,
    /// Whether cells are averages of the reduced frame; else each is one bilinear reading of the frame as it is.
    pub averages: bool,
}

/// The cases. 439.6 m and 5 m make 64 pixels of the whole footprint of 40°, a quarter of the resolution 256.
pub const CASES: [Case; 3] = [
    Case {
        name: "rectify 512x512 to 64x64",
        fov_deg: 40.0,
        height_resolution_m: (439.6, 5.0),
        patch_px: 64,
        averages: true,
    },
    Case {
        name: "rectify 512x512 to 35x35",
        fov_deg: 60.0,
        height_resolution_m: (150.0, 5.0),
        patch_px: 35,
        averages: true,
    },
    Case {
        name: "rectify 512x512 to 256x256",
        fov_deg: 40.0,
        height_resolution_m: (439.6, 1.25),
        patch_px: PATCH_PX,
        averages: false,
    },
];

/// Working space beside frame and patch.
#[derive(Debug)]
pub struct Space {
    reduced: [u8; REDUCED_MAX_AREA],
    row_sums: [u16; REDUCED_MAX_COLS],
    cell_sums: [u32; PATCH_PX as usize],
    runs: Vec<Run, { PATCH_PX as usize + 16 }>,
}

impl Space {
    /// All zeros.
    pub const fn new() -> Self {
        Space {
            reduced: [0; REDUCED_MAX_AREA],
            row_sums: [0; REDUCED_MAX_COLS],
            cell_sums: [0; PATCH_PX as usize],
            runs: Vec::new(),
        }
    }
}

impl Default for Space {
    fn default() -> Self {
        Space::new()
    }
}

/// Why a case cannot run: the bench and the core do not agree.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CaseError {
    /// Not with these sizes.
    Reduce(ReduceError),
    /// Nor with these.
    Rectify(RectifyError),
    /// No camera like this.
    Camera,
    /// Nothing was rectified.
    Empty,
}

/// Runs a case in every pose. `frame`: 512 x 512; `patch`: room for 256 x 256.
///
/// # Errors
/// [`CaseError`].
pub fn run(
    case: &Case,
    stand: &mut impl Stand,
    (frame, patch): (&[u8], &mut [u8]),
    space: &mut Space,
) -> Result<(), CaseError> {
    let size = (FRAME_PX, FRAME_PX);
    let fov = Radians::from_degrees(black_box(case.fov_deg));
    let camera = Camera::new(size, (fov, fov), (0.0, 0.0), None).map_err(|_| CaseError::Camera)?;
    let (height_m, resolution_m) = case.height_resolution_m;
    // A patch pixel of one frame pixel asks for no reduction.
    let (ratio, capacity) =
        if case.averages { (camera.ratio(height_m, resolution_m), REDUCED_MAX_AREA) } else { (1.0, usize::MAX) };
    let reduction = Reduction::choose(size, ratio, capacity).map_err(CaseError::Reduce)?;
    let Space { reduced, row_sums, cell_sums, runs } = space;
    let pixels = if case.averages {
        region(stand, (case.name, "reduce"), "any", || reduce(reduction, frame, row_sums, reduced))?;
        let (cols, rows) = reduction.size();
        &reduced[..cols as usize * rows as usize]
    } else {
        frame
    };
    for pose in Pose::all() {
        let situation = situation(&pose, height_m);
        region(stand, (case.name, "rectify"), pose, || {
            resample(case, &camera, &situation, (pixels, reduction, ratio), (patch, cell_sums, runs))
        })
        .map_err(CaseError::Rectify)?;
        if runs.is_empty() {
            return Err(CaseError::Empty);
        }
    }
    Ok(())
}

/// The reduction of a whole frame. Not inlined, as [`resample`] is not, so that their size can be read from the image.
#[inline(never)]
fn reduce(reduction: Reduction, frame: &[u8], sums: &mut [u16], reduced: &mut [u8]) -> Result<(), CaseError> {
    let mut reducer = Reducer::new(reduction, (FRAME_PX, FRAME_PX));
    let mut rows = frame.chunks_exact(FRAME_PX as usize);
    rows.try_for_each(|row| reducer.take(row, sums, reduced)).map_err(CaseError::Reduce)
}

/// From the reduced frame to the patch.
#[inline(never)]
fn resample(
    case: &Case,
    camera: &Camera,
    situation: &Situation,
    (pixels, reduction, ratio): (&[u8], Reduction, f32),
    (patch, sums, runs): (&mut [u8], &mut [u32], &mut VecView<Run>),
) -> Result<(), RectifyError> {
    let (height_m, resolution_m) = case.height_resolution_m;
    let size = (case.patch_px, case.patch_px);
    let source = Source::new(pixels, reduction)?;
    let map = FrameFromPatch::new(situation.homography(camera), camera, (height_m, resolution_m), size);
    let sampling = Sampling::choose(ratio, &reduction);
    rectify_into(&map, source, sampling, patch, sums, runs)
}

/// What the map depends on; the rest does not matter here.
fn situation(pose: &Pose, height_m: f32) -> Situation {
    Situation {
        mid_exposure_at: Micros(0),
        attitude: pose.attitude(),
        follow_up: pose.follow_up(),
        followed: pose.is_followed,
        height_m,
        prediction: Prediction { local: Local::default() },
        sigma_tilt_rad: 0.0,
        sigma_heading_rad: 0.0,
        sigma_height_m: 0.0,
    }
}
