//! Which frames, sizes and attitudes.

use super::pictures::{self, SIDE};
use super::view::{Ground, Pose};
use super::{Failure, Grey};
use plumbline_firmware::bench::rectify::CASES;

/// A frame and what it is resampled to, at several attitudes.
#[derive(Clone, Debug)]
pub struct Case {
    /// The picture's name.
    pub picture: &'static str,
    /// What the frame shows.
    pub frame: Grey,
    /// Camera, height, cells.
    pub ground: Ground,
    /// The attitudes.
    pub poses: Vec<Pose>,
    /// Limits on it; none where it is only told.
    pub limits: Option<Limits>,
    /// Whether it is there to see that all mean the same place; else it is scored and timed.
    pub is_smooth: bool,
}

/// What a case must reach, and what is wished for: `(must, goal)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    /// Root mean square of what flies against the exact average, grey levels.
    pub rms: (f64, f64),
    /// Its time over that of OpenCV's full-size warp with INTER_AREA behind it.
    pub time: (f64, f64),
}

/// The texture's name.
pub const PROTOTYPE: &str = "prototype texture";
/// The orthophoto's.
pub const VIENNA: &str = "Vienna";
/// The smooth picture's.
pub const SMOOTH: &str = "smooth";

/// The case with limits: what flies, 512 x 512 to 64 x 64.
const LIMITED_CELLS: u16 = 64;
/// Of the times.
const TIME: (f64, f64) = (1.0, 0.33);

/// Pitch 8, roll 10 as everywhere; a camera fixed to the body, so that the patch is turned in the frame, and one that
/// follows.
const POSES: [Pose; 4] = [pose(0.0, false), pose(30.0, false), pose(137.0, false), pose(30.0, true)];

const fn pose(heading_deg: f64, is_followed: bool) -> Pose {
    Pose { heading_deg, pitch_deg: 8.0, roll_deg: 10.0, is_followed }
}

/// The bench's sizes on every picture. Without the real data a case is missing, and the names say which.
///
/// # Errors
/// A sentence on real data that cannot be used.
pub fn all() -> Result<(Vec<Case>, Vec<&'static str>), Failure> {
    let mut named = vec![(PROTOTYPE, pictures::prototype(), Some((1.0, 0.6)))];
    let mut skipped = Vec::new();
    match pictures::vienna()? {
        Some(frame) => named.push((VIENNA, frame, Some((0.7, 0.4)))),
        None => skipped.push(VIENNA),
    }
    named.push((SMOOTH, pictures::smooth((SIDE, SIDE)), None));
    let grounds = CASES.map(|case| Ground {
        fov_deg: case.fov_deg.into(),
        height_m: case.height_resolution_m.0.into(),
        resolution_m: case.height_resolution_m.1.into(),
        cells: (case.patch_px, case.patch_px),
    });
    let case = |(picture, frame, rms): &(&'static str, Grey, Option<_>), ground: Ground| Case {
        picture,
        frame: frame.clone(),
        ground,
        poses: POSES.to_vec(),
        limits: rms.filter(|_| ground.cells.0 == LIMITED_CELLS).map(|rms| Limits { rms, time: TIME }),
        is_smooth: *picture == SMOOTH,
    };
    Ok((grounds.iter().flat_map(|&ground| named.iter().map(move |named| case(named, ground))).collect(), skipped))
}
