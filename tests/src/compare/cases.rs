//! Which frames, sizes and attitudes.

use super::Failure;
use super::case::{Case, Limits, Purpose};
use super::matched;
use super::pictures::{self, SIDE};
use super::view::{Ground, Pose};
use plumbline_core::budget::PATCH_MAX_PX;
use plumbline_firmware::bench::rectify::CASES;

/// The texture's name.
pub const PROTOTYPE: &str = "prototype texture";
/// The made-up ground's.
pub const LAND: &str = "made-up ground";
/// The orthophoto's.
pub const VIENNA: &str = "Vienna";
/// The smooth picture's.
pub const SMOOTH: &str = "smooth";

/// The case with limits: what flies, 512 x 512 to 64 x 64.
pub const LIMITED_CELLS: u16 = 64;
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
    let vienna = pictures::vienna()?;
    let skipped = if vienna.is_none() { vec![VIENNA] } else { Vec::new() };
    let mut shown = vec![(PROTOTYPE, pictures::prototype(), Some((1.0, 0.6)))];
    shown.extend(vienna.as_ref().map(|land| (VIENNA, pictures::middle(land), Some((0.7, 0.4)))));
    shown.push((SMOOTH, pictures::smooth((SIDE, SIDE)), None));
    let mut lands = vec![(LAND, pictures::land())];
    lands.extend(vienna.map(|land| (VIENNA, land)));

    let mut cases = Vec::new();
    for case in CASES {
        let ground = Ground {
            fov_deg: case.fov_deg.into(),
            height_m: case.height_resolution_m.0.into(),
            resolution_m: case.height_resolution_m.1.into(),
            cells: (case.patch_px, case.patch_px),
        };
        for (picture, frame, rms) in &shown {
            cases.push(Case {
                picture,
                frame: frame.clone(),
                ground,
                poses: POSES.to_vec(),
                limits: rms.filter(|_| case.patch_px == LIMITED_CELLS).map(|rms| Limits { rms, time: TIME }),
                purpose: if *picture == SMOOTH { Purpose::Smooth } else { Purpose::Timed },
                reference: None,
            });
        }
        // What is too large for the board is not matched there.
        for (picture, land) in lands.iter().filter(|_| usize::from(case.patch_px) <= PATCH_MAX_PX) {
            cases.extend(matched::cases(picture, land, (SIDE, SIDE), ground, &POSES)?);
        }
    }
    Ok((cases, skipped))
}
