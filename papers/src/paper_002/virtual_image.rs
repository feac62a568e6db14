//! The virtual image itself: frames of the true heads over procedural ground, stitched by the calibrated ones, beside what one
//! ideal camera sees.

use super::methods;
use super::world::{F_PX, HEAD_PX, HEIGHT_M, InteriorError, NOISE_PX, VIRTUAL_PX, World};
use nalgebra::Vector3;
use plumbline_sim::camera::render::Station;
use plumbline_sim::camera::stitch::{Simulated, simulate};
use plumbline_sim::noise::stream;
use plumbline_sim::world::procedural;
use plumbline_survey::adjust::rig::HEAD;
use plumbline_survey::adjust::{Options, SolveError, rotation};
use plumbline_survey::calibrate::{Calibration, Symmetrised, mount};
use plumbline_survey::camera_file::{CameraFile, Head};
use plumbline_survey::error::InputError;

/// Pixels are so much larger than the paper's: the picture is rendered ray by ray.
pub const LARGER: f64 = 10.0;
/// Grey noise of the frames, and its seed.
const NOISE: (f64, u64) = (2.0, 5);

/// Why there is no image.
#[derive(Debug)]
pub enum VirtualError {
    /// The calibration failed.
    Solve(SolveError),
    /// The heads or frames were refused.
    Input(InputError),
}

impl From<SolveError> for VirtualError {
    fn from(error: SolveError) -> Self {
        VirtualError::Solve(error)
    }
}

impl From<InputError> for VirtualError {
    fn from(error: InputError) -> Self {
        VirtualError::Input(error)
    }
}

/// Calibrates the heads of a block and stitches one exposure of the true ones by them.
///
/// # Errors
/// None for these blocks; the adjustment's and the stitching's own are passed on.
pub fn stitched(seed: u64, points: usize) -> Result<Simulated, VirtualError> {
    let world = World::calibration(seed, points, InteriorError::default());
    let mut rng = stream(seed, methods::CONSTRAINED);
    let observations = world.observed(&mut rng, NOISE_PX);
    let rig = world.start(&mut rng).rig(&observations.seen);
    let calibrated = Calibration::of_rig(&rig, &Options::default(), &mut |_, _| {})?.heads;
    let turned = Symmetrised::new(&calibrated);
    let q = turned.platform_from_virtual.transpose();
    let truth: Vec<[f64; HEAD]> = world
        .heads
        .iter()
        .map(|head| {
            let mut turned = *head;
            turned[..3].copy_from_slice(&rotation::angles_rad(&(q * mount(head))));
            turned[3..6].copy_from_slice((q * Vector3::new(head[3], head[4], head[5])).as_slice());
            turned
        })
        .collect();
    let ground = procedural(1);
    let [east_m, north_m] = ground.bounds().centre();
    let station = Station { east_m, north_m, up_m: HEIGHT_M, ..Station::default() };
    let (truth, known) = (camera(&truth), camera(&turned.heads));
    simulate(&ground, &station, (&truth, &known), Some(HEIGHT_M), NOISE).map_err(VirtualError::from)
}

/// Heads as a camera file with larger pixels.
fn camera(heads: &[[f64; HEAD]]) -> CameraFile {
    let f_px = F_PX / LARGER;
    let [cols, rows] = HEAD_PX.map(|side| (side / LARGER).round() as u32);
    let size = VIRTUAL_PX.map(|side| (side / LARGER).round());
    let fov_deg = size.map(|side| 2.0 * (0.5 * side / f_px).atan().to_degrees());
    let head = |head: &[f64; HEAD]| Head {
        cols,
        rows,
        f_px,
        offset_m_px: 0.0,
        offset_n_px: 0.0,
        distortion: None,
        rotation_deg: [0, 1, 2].map(|k| head[k].to_degrees()),
        d_m: [head[3], head[4], head[5]],
    };
    let mut file = CameraFile::new((size[0] as u32, size[1] as u32), (fov_deg[0], fov_deg[1]));
    file.heads = heads.iter().map(head).collect();
    file
}
