//! The rectification alone: reduction and resampling of a frame of 512 x 512.

use super::poses::Pose;
use super::region::{Stand, region};
use core::hint::black_box;
use heapless::Vec;
use plumbline_core::camera::Camera;
use plumbline_core::homography::FrameFromPatch;
use plumbline_core::image::Run;
use plumbline_core::pipeline::Situation;
use plumbline_core::rectify::{Node, RectifyError, Source, rectify_into};
use plumbline_core::reduce::{ReduceError, Reducer, Reduction};
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
    /// What is kept of the frame.
    pub keeps: Keeps,
}

/// What is kept of a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Keeps {
    /// As the core chooses in the memory that there is.
    Chosen,
    /// Boxes of so many pixels a side, in as much memory as they take.
    Boxes(u16),
    /// The frame itself, where it stands.
    Frame,
}

/// The cases. 439.6 m and 5 m make 64 pixels of the whole footprint of 40°, a quarter of the resolution 256.
pub const CASES: [Case; 3] = [
    TO_64,
    Case {
        name: "rectify 512x512 to 35x35",
        fov_deg: 60.0,
        height_resolution_m: (150.0, 5.0),
        patch_px: 35,
        keeps: Keeps::Chosen,
    },
    Case {
        name: "rectify 512x512 to 256x256",
        height_resolution_m: (439.6, 1.25),
        patch_px: PATCH_PX,
        keeps: Keeps::Frame,
        ..TO_64
    },
];

const TO_64: Case = Case {
    name: "rectify 512x512 to 64x64",
    fov_deg: 40.0,
    height_resolution_m: (439.6, 5.0),
    patch_px: 64,
    keeps: Keeps::Chosen,
};

/// The first case by other boxes than those that the board's memory holds, and by one reading: what they would cost.
pub const BESIDES: [Case; 4] = [
    Case { name: "boxes of 1x1, 512x512 to 64x64", keeps: Keeps::Boxes(1), ..TO_64 },
    Case { name: "boxes of 2x2, 512x512 to 64x64", keeps: Keeps::Boxes(2), ..TO_64 },
    Case { name: "boxes of 8x8, 512x512 to 64x64", keeps: Keeps::Boxes(8), ..TO_64 },
    Case { name: "one reading, 512x512 to 64x64", keeps: Keeps::Frame, ..TO_64 },
];
/// Bytes that they keep at most: boxes of one pixel each.
pub const BESIDES_BYTES: usize = 2 * (FRAME_PX as usize + 2) * FRAME_PX as usize;

/// Working space beside frame and patch.
#[derive(Debug)]
pub struct Space {
    nodes: [Node; 2 * (PATCH_PX as usize + 1)],
    runs: Vec<Run, { PATCH_PX as usize + 16 }>,
}

impl Space {
    /// All zeros.
    pub const fn new() -> Self {
        Space { nodes: [Node::NOWHERE; 2 * (PATCH_PX as usize + 1)], runs: Vec::new() }
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

/// Runs a case in every pose. `frame`: 512 x 512; `patch`: 256 x 256; `memory`: what is kept of the frame.
///
/// # Errors
/// [`CaseError`].
pub fn run(
    case: &Case,
    stand: &mut impl Stand,
    (frame, patch, memory): (&[u8], &mut [u8], &mut [u8]),
    space: &mut Space,
) -> Result<(), CaseError> {
    let size = (FRAME_PX, FRAME_PX);
    let fov = Radians::from_degrees(black_box(case.fov_deg));
    let camera = Camera::new(size, (fov, fov), (0.0, 0.0), None).map_err(|_| CaseError::Camera)?;
    let (height_m, resolution_m) = case.height_resolution_m;
    let ratio = camera.ratio(height_m, resolution_m);
    let reduction = match case.keeps {
        Keeps::Chosen => Reduction::choose(size, ratio, memory.len()),
        // The core's own choice for cells of three boxes.
        Keeps::Boxes(factor) => Reduction::choose(size, 3.0 * f32::from(factor), memory.len()),
        Keeps::Frame => Ok(Reduction::none(size)),
    };
    let reduction = reduction.map_err(CaseError::Reduce)?;
    let kept = if reduction.is_boxes() {
        region(stand, (case.name, "reduce"), "any", || reduce(reduction, frame, memory))?;
        memory.get(..reduction.bytes()).ok_or(CaseError::Reduce(ReduceError::Capacity))?
    } else {
        frame
    };
    for pose in Pose::all() {
        let situation = situation(&pose, height_m);
        region(stand, (case.name, "rectify"), pose, || {
            resample(case, &camera, &situation, (kept, reduction), (patch, space))
        })
        .map_err(CaseError::Rectify)?;
        if space.runs.is_empty() {
            return Err(CaseError::Empty);
        }
    }
    Ok(())
}

/// The reduction of a whole frame. Not inlined, as [`resample`] is not, so that their size can be read from the image.
#[inline(never)]
fn reduce(reduction: Reduction, frame: &[u8], memory: &mut [u8]) -> Result<(), CaseError> {
    let mut reducer = Reducer::new(reduction, (FRAME_PX, FRAME_PX));
    reducer.take(frame, memory).map_err(CaseError::Reduce)
}

/// From what is kept of the frame to the patch.
#[inline(never)]
fn resample(
    case: &Case,
    camera: &Camera,
    situation: &Situation,
    (kept, reduction): (&[u8], Reduction),
    (patch, space): (&mut [u8], &mut Space),
) -> Result<(), RectifyError> {
    let (height_m, resolution_m) = case.height_resolution_m;
    let size = (case.patch_px, case.patch_px);
    let source = Source::new(kept, reduction)?;
    let map = FrameFromPatch::new(situation.homography(camera), camera, (height_m, resolution_m), size);
    let Space { nodes, runs } = space;
    rectify_into(&map, source, patch, nodes, runs)
}

/// What the map depends on; the rest does not matter here.
fn situation(pose: &Pose, height_m: f32) -> Situation {
    Situation::exact(Micros(0), pose.attitude(), (pose.follow_up(), pose.is_followed), height_m)
}
