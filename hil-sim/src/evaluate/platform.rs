//! What the offsets of a flight's fixes say of camera and map: a camera that sits otherwise than its file says moves fixes along with the
//! heading, a map that is shifted as a whole moves all of them alike. On one heading the two are one.

use super::judge::{Fixed, Verdict};
use crate::setup::frames::table::{Row, Table};
use plumbline_survey::calibrate::boresight::{
    Boresight, BoresightError, FIXES_MIN, Footprint, SD_MAX_RAD, Sighting, estimate_to,
};
use plumbline_survey::camera_file::CameraFile;
use serde::Serialize;

/// An angle or an offset counts from so many of its sigmas on.
pub(super) const SIGNIFICANT_SIGMAS: f64 = 3.0;
/// An angle that is known no better is not shown: one degree, what the board expects of a camera that was mounted by eye
/// (`navigation/filter/misalignment.rs` of the core).
const SHOWN_SD_RAD: f64 = 0.0175;
/// What a camera may sit off the one that was flown and count as that one, degrees: half of what a boresight may be uncertain by to be written.
const SETTLED_DEG: f64 = 0.5 * SD_MAX_RAD / std::f64::consts::PI * 180.0;

/// What places are compared with.
pub(super) fn positions(knows_truth: bool) -> &'static str {
    if knows_truth { "the true positions" } else { "the navigation's positions" }
}

/// An offset; what rounds to nothing has no sign.
pub(super) fn apart(offset_m: [f64; 2]) -> String {
    let [east, north] = offset_m.map(|m| (10.0 * m).round() / 10.0 + 0.0);
    format!("{east:.1} m east and {north:.1} m north")
}

/// What a flight says of camera and map.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Platform {
    /// Whether the camera's tilt and the map's offset can be told apart; where not, either of both is given as if there were no other.
    pub separated: bool,
    /// φ, ω, κ of the camera, as in its file, degrees; those that the flight does not show are the file's.
    pub boresight_deg: Option<[f64; 3]>,
    /// Their standard deviations, degrees; `null` where nothing shows the angle.
    pub boresight_sd_deg: Option<[Option<f64>; 3]>,
    /// Which of them the flight shows.
    pub boresight_determined: [bool; 3],
    /// Of the map against the navigation, or the truth where it is known, east and north, metres.
    pub map_offset_m: Option<[f64; 2]>,
    /// Its standard deviations, metres.
    pub map_offset_sd_m: Option<[f64; 2]>,
    /// What to make of it, in a sentence; of those that are told apart by `words`.
    pub says: String,
}

impl Platform {
    /// From the fixes of `verdict`, flown with a camera that sits by `flown_deg`.
    #[must_use]
    pub fn of(table: &Table, camera: &CameraFile, verdict: &Verdict, flown_deg: [f64; 3]) -> Self {
        let sightings: Vec<Sighting> = verdict.fixes().map(|(index, fix)| sighting(fix, &table.rows[index])).collect();
        let told_deg = camera.boresight.unwrap_or_default();
        let flown_rad = flown_deg.map(f64::to_radians);
        let solve =
            |with_offset| estimate_to(SHOWN_SD_RAD, &sightings, &Footprint::new(camera), flown_rad, with_offset);
        match solve(true) {
            Ok(found) => Platform { separated: true, ..Platform::of_camera(&found, told_deg) },
            Err(BoresightError::TooFew(count)) => {
                Platform::nothing(format!("{count} fixes say nothing of camera and map: {FIXES_MIN} are needed"))
            }
            Err(BoresightError::Inseparable(_)) => {
                Platform::either(solve(false).ok().as_ref(), flown_deg, table, verdict)
            }
            Err(error) => Platform::nothing(error.to_string()),
        }
    }

    /// φ, ω, κ, degrees, with which a flight would be another than with `flown_deg`.
    #[must_use]
    pub fn to_fly_deg(&self, camera: &CameraFile, flown_deg: [f64; 3]) -> Option<[f64; 3]> {
        let told_deg = camera.boresight.unwrap_or_default();
        let found_deg = self.boresight_deg.filter(|_| self.separated)?;
        let wanted_deg: [f64; 3] =
            std::array::from_fn(|k| if self.is_off(k, told_deg) { found_deg[k] } else { told_deg[k] });
        let settled_deg = if flown_deg == told_deg { 0.0 } else { SETTLED_DEG };
        (0..3).any(|k| (wanted_deg[k] - flown_deg[k]).abs() > settled_deg).then_some(wanted_deg)
    }

    /// Whether an angle is another than the file's.
    pub(super) fn is_off(&self, k: usize, told_deg: [f64; 3]) -> bool {
        let (Some(found_deg), Some(sd_deg)) = (self.boresight_deg, self.boresight_sd_deg) else { return false };
        let sd_deg = sd_deg[k].unwrap_or(f64::INFINITY);
        self.boresight_determined[k] && (found_deg[k] - told_deg[k]).abs() > SIGNIFICANT_SIGMAS * sd_deg
    }

    fn nothing(says: String) -> Self {
        Platform {
            separated: false,
            boresight_deg: None,
            boresight_sd_deg: None,
            boresight_determined: [false; 3],
            map_offset_m: None,
            map_offset_sd_m: None,
            says,
        }
    }

    /// A large correction counts, with what its model leaves open in its standard deviation: the next flight is with it.
    fn of_camera(found: &Boresight, told_deg: [f64; 3]) -> Self {
        let angle = |k: usize| found.shown_rad[k].map_or(told_deg[k], f64::to_degrees);
        let sd = |k: usize| Some(found.sd_rad[k].to_degrees()).filter(|sd| sd.is_finite());
        Platform {
            boresight_deg: Some(std::array::from_fn(angle)),
            boresight_sd_deg: Some(std::array::from_fn(sd)),
            boresight_determined: found.shown_rad.map(|angle| angle.is_some()),
            map_offset_m: found.offset.map(|(offset_m, _)| offset_m),
            map_offset_sd_m: found.offset.map(|(_, sd_m)| sd_m),
            ..Platform::nothing(String::new())
        }
    }

    /// The headings are too much alike. Both alternatives are of the same offsets.
    fn either(found: Option<&Boresight>, flown_deg: [f64; 3], table: &Table, verdict: &Verdict) -> Self {
        let camera =
            found.map_or_else(|| Platform::nothing(String::new()), |found| Platform::of_camera(found, flown_deg));
        let (map_offset_m, map_offset_sd_m) = mean(table, verdict).unzip();
        let tilt_deg = tilt_deg(table, verdict);
        let angle = |k: usize| match camera.boresight_deg {
            Some(found_deg) if camera.boresight_determined[k] => found_deg[k],
            _ => flown_deg[k] + tilt_deg[k],
        };
        let (positions, offset) = (positions(table.knows_truth()), apart(map_offset_m.unwrap_or_default()));
        let says = format!(
            "the headings are too much alike to tell a tilted camera from a shifted map: either phi is {:.2} and omega {:.2} degrees, \
             or the map lies {offset} of {positions}, or a part of each; a flight with a second heading tells",
            angle(0),
            angle(1)
        );
        Platform { map_offset_m, map_offset_sd_m, says, ..camera }
    }
}

fn sighting(fix: &Fixed, row: &Row) -> Sighting {
    Sighting {
        fix_m: fix.place_m,
        sigma_m: fix.sigma_m(),
        position_m: row.truth_m.unwrap_or(row.place_m),
        height_m: row.height_m,
        attitude_rad: row.attitude_rad,
        rectified_rad: fix.rectified_rad,
        follow_up_rad: 0.0,
    }
}

/// How far a fix would be off if the firmware had not taken out of the attitude what it has learnt of it: as a nose that is said to be up too
/// far by an angle moves the nadir that is found back by height times angle, a right wing too far down to the right.
fn unlearnt_m(fix: &Fixed, row: &Row) -> [f64; 2] {
    let ([_, pitch_rad, roll_rad], (sin, cos)) = (row.attitude_rad, row.attitude_rad[0].sin_cos());
    let [pitch, roll] = fix.rectified_rad.map_or([0.0; 2], |[pitch, roll]| [pitch_rad - pitch, roll_rad - roll]);
    let (ahead_m, right_m) = (-row.height_m * pitch, row.height_m * roll);
    let position_m = row.truth_m.unwrap_or(row.place_m);
    [
        fix.place_m[0] - position_m[0] + ahead_m * sin + right_m * cos,
        fix.place_m[1] - position_m[1] + ahead_m * cos - right_m * sin,
    ]
}

/// Phi and omega, degrees, that move fixes so far along the camera's axes in the mean.
fn tilt_deg(table: &Table, verdict: &Verdict) -> [f64; 2] {
    let count = verdict.fixes().count().max(1) as f64;
    let along = |(index, fix): (usize, &Fixed)| {
        let (row, [east, north]) = (&table.rows[index], unlearnt_m(fix, &table.rows[index]));
        let (sin, cos) = row.attitude_rad[0].sin_cos();
        [(east * cos - north * sin) / row.height_m, (east * sin + north * cos) / row.height_m]
    };
    [0, 1].map(|axis| (verdict.fixes().map(|fix| along(fix)[axis]).sum::<f64>() / count).atan().to_degrees())
}

/// Mean offset of the fixes and its standard deviation, by their scatter.
fn mean(table: &Table, verdict: &Verdict) -> Option<([f64; 2], [f64; 2])> {
    let offsets_m: Vec<[f64; 2]> = verdict.fixes().map(|(index, fix)| unlearnt_m(fix, &table.rows[index])).collect();
    let count = offsets_m.len();
    if count < 2 {
        return None;
    }
    let mean_m = [0, 1].map(|axis| offsets_m.iter().map(|offset_m| offset_m[axis]).sum::<f64>() / count as f64);
    let sd_m = [0, 1].map(|axis| {
        let squares: f64 = offsets_m.iter().map(|offset_m| (offset_m[axis] - mean_m[axis]).powi(2)).sum();
        (squares / ((count - 1) * count) as f64).sqrt()
    });
    Some((mean_m, sd_m))
}
