//! What the offsets of a flight's fixes say of camera and map: a camera that sits otherwise than its file says moves fixes along with the
//! heading, a map that is shifted as a whole moves all of them alike. On one heading the two are one.

use super::judge::{Fixed, Verdict};
use crate::setup::frames::table::{Row, Table};
use plumbline_survey::calibrate::boresight::{Boresight, BoresightError, FIXES_MIN, Footprint, Sighting, estimate};
use plumbline_survey::camera_file::CameraFile;
use serde::Serialize;

/// An angle or an offset counts from so many of its sigmas on.
const SIGNIFICANT_SIGMAS: f64 = 3.0;
const NAMES: [&str; 3] = ["phi", "omega", "kappa"];

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
    /// What to make of it, in a sentence.
    pub says: String,
}

impl Platform {
    /// From the fixes of `verdict`, flown with the camera as its file has it.
    #[must_use]
    pub fn of(table: &Table, camera: &CameraFile, verdict: &Verdict) -> Self {
        let told_deg = camera.boresight.unwrap_or_default();
        let sightings: Vec<Sighting> = verdict
            .fixes()
            .map(|(index, fix)| {
                let row = &table.rows[index];
                Sighting {
                    fix_m: uncorrected_m(fix, row),
                    sigma_m: fix.sigma_m(),
                    position_m: row.truth_m.unwrap_or(row.place_m),
                    height_m: row.height_m,
                    attitude_rad: row.attitude_rad,
                    follow_up_rad: 0.0,
                }
            })
            .collect();
        let solve =
            |with_offset| estimate(&sightings, &Footprint::new(camera), told_deg.map(f64::to_radians), with_offset);
        match solve(true) {
            Ok(found) => Platform::separate(&found, told_deg),
            Err(BoresightError::TooFew(count)) => {
                Platform::nothing(format!("{count} fixes say nothing of camera and map: {FIXES_MIN} are needed"))
            }
            Err(BoresightError::Inseparable(_)) => Platform::either(solve(false).ok().as_ref(), told_deg, verdict),
            Err(error) => Platform::nothing(error.to_string()),
        }
    }

    /// φ, ω, κ, degrees, where a flight with them would be another.
    #[must_use]
    pub fn corrected_deg(&self, camera: &CameraFile) -> Option<[f64; 3]> {
        let told_deg = camera.boresight.unwrap_or_default();
        let found_deg = self.boresight_deg.filter(|_| self.separated)?;
        (0..3).any(|k| self.is_off(k, told_deg)).then_some(found_deg)
    }

    fn is_off(&self, k: usize, told_deg: [f64; 3]) -> bool {
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

    fn of_camera(found: &Boresight, told_deg: [f64; 3]) -> Self {
        let angle = |k: usize| if found.determined[k] { found.angles_rad[k].to_degrees() } else { told_deg[k] };
        let sd = |k: usize| Some(found.sd_rad[k].to_degrees()).filter(|sd| sd.is_finite());
        Platform {
            boresight_deg: Some(std::array::from_fn(angle)),
            boresight_sd_deg: Some(std::array::from_fn(sd)),
            boresight_determined: found.determined,
            map_offset_m: found.offset.map(|(offset_m, _)| offset_m),
            map_offset_sd_m: found.offset.map(|(_, sd_m)| sd_m),
            ..Platform::nothing(String::new())
        }
    }

    fn separate(found: &Boresight, told_deg: [f64; 3]) -> Self {
        let platform = Platform { separated: true, ..Platform::of_camera(found, told_deg) };
        let off: Vec<String> = (0..3)
            .filter(|k| platform.is_off(*k, told_deg))
            .map(|k| format!("{} by {:.2} degrees", NAMES[k], found.angles_rad[k].to_degrees() - told_deg[k]))
            .collect();
        let camera = match off.as_slice() {
            [] => "the camera sits as its file says".to_owned(),
            off => format!("the camera sits otherwise than its file says: {}", off.join(", ")),
        };
        let map = match found.offset {
            Some(([east, north], [sd_east, sd_north]))
                if east.abs() > SIGNIFICANT_SIGMAS * sd_east || north.abs() > SIGNIFICANT_SIGMAS * sd_north =>
            {
                format!("the map lies {east:.1} m east and {north:.1} m north of the positions")
            }
            _ => "the map is where the positions are".to_owned(),
        };
        Platform { says: format!("{camera}, and {map}"), ..platform }
    }

    /// The headings are too much alike.
    fn either(found: Option<&Boresight>, told_deg: [f64; 3], verdict: &Verdict) -> Self {
        let camera =
            found.map_or_else(|| Platform::nothing(String::new()), |found| Platform::of_camera(found, told_deg));
        let (map_offset_m, map_offset_sd_m) = mean(verdict).unzip();
        let [phi, omega, _] = camera.boresight_deg.unwrap_or(told_deg);
        let [east, north] = map_offset_m.unwrap_or_default();
        let says = format!(
            "the headings are too much alike to tell a tilted camera from a shifted map: either phi is {phi:.2} and omega \
             {omega:.2} degrees, or the map lies {east:.1} m east and {north:.1} m north of the positions, or a part of each; a \
             flight with a second heading tells"
        );
        Platform { map_offset_m, map_offset_sd_m, says, ..camera }
    }
}

/// Where a fix would be if the firmware had not taken out of the attitude what it has learnt of it: as a nose that is said to be up too far by an
/// angle moves the nadir that is found back by height times angle, a right wing too far down to the right.
fn uncorrected_m(fix: &Fixed, row: &Row) -> [f64; 2] {
    let ([pitch, roll], (sin, cos)) = (fix.less_tilt_rad, row.attitude_rad[0].sin_cos());
    let (ahead_m, right_m) = (-row.height_m * pitch, row.height_m * roll);
    [fix.place_m[0] + ahead_m * sin + right_m * cos, fix.place_m[1] + ahead_m * cos - right_m * sin]
}

/// Mean error of the fixes and its standard deviation, by their scatter.
fn mean(verdict: &Verdict) -> Option<([f64; 2], [f64; 2])> {
    let count = verdict.fixes().count();
    if count < 2 {
        return None;
    }
    let mean_m = [0, 1].map(|axis| verdict.fixes().map(|(_, fix)| fix.offset_m[axis]).sum::<f64>() / count as f64);
    let sd_m = [0, 1].map(|axis| {
        let squares: f64 = verdict.fixes().map(|(_, fix)| (fix.offset_m[axis] - mean_m[axis]).powi(2)).sum();
        (squares / ((count - 1) * count) as f64).sqrt()
    });
    Some((mean_m, sd_m))
}
