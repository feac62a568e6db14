//! The files of a flight: `fixes.csv` as `plumbline fly` writes it, and the poses of an independent navigation.
//!
//! Fixes: rows whose `accepted` is 1, with `mid_exposure_us`, `east_m`, `north_m`, `sigma_east_m`, `sigma_north_m`. Poses:
//! `mid_exposure_us`, `east_m`, `north_m` (of the point that fixes refer to, on their grid), `height_m` (of the camera above
//! the ground), `heading_deg` (from grid north), `pitch_deg`, `roll_deg` and, where a servo turned the camera,
//! `follow_up_deg`. Other columns are not read. A fix and a pose belong together where `mid_exposure_us` is the same.

use super::Sighting;
use crate::error::InputError;
use crate::io::table::{Table, text_of};
use crate::logs::units::{Angles, Unit, check_gimbal};
use std::collections::HashMap;
use std::path::Path;

/// Columns of the poses.
const COLUMNS: [&str; 7] = ["mid_exposure_us", "east_m", "north_m", "height_m", "heading_deg", "pitch_deg", "roll_deg"];

/// The fixes that have a pose, in the fixes' order.
#[derive(Clone, Debug, PartialEq)]
pub struct Joined {
    /// What is known of each.
    pub sightings: Vec<Sighting>,
    /// Line of each in the fixes' file.
    pub lines: Vec<usize>,
    /// Accepted fixes without a pose.
    pub fixes_alone: usize,
    /// Poses without an accepted fix.
    pub poses_alone: usize,
    /// Whether the poses tell the follow-up angle.
    pub tells_follow_up: bool,
}

/// Reads and joins both files, as [`join`].
///
/// # Errors
/// A file cannot be read; otherwise as [`join`].
pub fn read(fixes: &Path, poses: &Path, follow_up: &dyn Fn([f64; 3]) -> f64) -> Result<Joined, InputError> {
    let ((fixes, fixes_name), (poses, poses_name)) = (text_of(fixes)?, text_of(poses)?);
    join((&fixes, &fixes_name), (&poses, &poses_name), follow_up)
}

/// Joins the two files' texts, each with what errors call it. `follow_up` is the follow-up angle of a heading, pitch and roll,
/// radians, where the poses do not tell it.
///
/// # Errors
/// A column is missing or there twice, a row is too short or too long, a field is no finite number or out of its range, an
/// instant stands there twice, no instant stands in both.
pub fn join(
    (fixes, fixes_name): (&str, &str),
    (poses, poses_name): (&str, &str),
    follow_up: &dyn Fn([f64; 3]) -> f64,
) -> Result<Joined, InputError> {
    let fixes = Table::parse(fixes, fixes_name.to_owned())?;
    let [accepted, instant, east, north, sigma_east, sigma_north] =
        fixes.columns(["accepted", "mid_exposure_us", "east_m", "north_m", "sigma_east_m", "sigma_north_m"])?;
    let mut poses = Poses::parse(Table::parse(poses, poses_name.to_owned())?, follow_up)?;
    let mut seen: HashMap<u64, usize> = HashMap::new();
    let tells_follow_up = poses.tells_follow_up;
    let mut joined =
        Joined { sightings: Vec::new(), lines: Vec::new(), fixes_alone: 0, poses_alone: 0, tells_follow_up };
    let mut both = Vec::new();
    for (row, (line, fields)) in fixes.rows.iter().enumerate() {
        match fields[accepted] {
            "1" => {}
            "0" => continue,
            _ => return Err(fixes.wrong(row, accepted, "neither 0 nor 1")),
        }
        let at_us = microseconds(&fixes, row, instant, &mut seen)?;
        let fix_m = [fixes.number(row, east)?, fixes.number(row, north)?];
        let sigma_m = [above_0(&fixes, row, sigma_east)?, above_0(&fixes, row, sigma_north)?];
        match poses.by_instant.remove(&at_us) {
            Some(pose) => {
                both.push((at_us, *line, Sighting { fix_m, sigma_m, ..pose }));
            }
            None => joined.fixes_alone += 1,
        }
    }
    // Neighbours in time see the same ground, whatever the order of the rows.
    both.sort_by_key(|(at_us, ..)| *at_us);
    (joined.lines, joined.sightings) = both.into_iter().map(|(_, line, sighting)| (line, sighting)).unzip();
    joined.poses_alone = poses.by_instant.len();
    if seen.is_empty() {
        return Err(InputError::new(format!("{fixes_name} holds no accepted fix")));
    }
    if joined.sightings.is_empty() {
        return Err(InputError::new(format!(
            "no mid_exposure_us stands in both: {fixes_name} has {} accepted fixes, {poses_name} {} poses",
            joined.fixes_alone, joined.poses_alone
        )));
    }
    Ok(joined)
}

/// Poses by their instants, as sightings without a fix.
struct Poses {
    by_instant: HashMap<u64, Sighting>,
    tells_follow_up: bool,
}

impl Poses {
    fn parse(table: Table<'_>, follow_up: &dyn Fn([f64; 3]) -> f64) -> Result<Self, InputError> {
        let [instant, east, north, height, angles @ ..] = table.columns(COLUMNS)?;
        let turn = match table.header.contains(&"follow_up_deg") {
            true => Some(table.column("follow_up_deg")?),
            false => None,
        };
        let (mut by_instant, mut seen) = (HashMap::new(), HashMap::new());
        check_degrees(&table, angles)?;
        for row in 0..table.rows.len() {
            let at_us = microseconds(&table, row, instant, &mut seen)?;
            let angle = |column: usize| Ok((table.number(row, column)? % 360.0).to_radians());
            let attitude_rad = [angle(angles[0])?, angle(angles[1])?, angle(angles[2])?];
            for (column, angle) in angles.into_iter().zip(attitude_rad).skip(1) {
                if angle.cos() <= 0.0 {
                    let hint = if column == angles[1] {
                        "not between −90 and 90: 0 is a camera that looks straight down, so to a gimbal's pitch add 90"
                    } else {
                        "not between −90 and 90 degrees"
                    };
                    return Err(table.wrong(row, column, hint));
                }
            }
            let pose = Sighting {
                fix_m: [0.0; 2],
                sigma_m: [0.0; 2],
                position_m: [table.number(row, east)?, table.number(row, north)?],
                height_m: above_0(&table, row, height)?,
                attitude_rad,
                rectified_rad: None,
                follow_up_rad: turn.map_or_else(|| Ok(follow_up(attitude_rad)), angle)?,
            };
            by_instant.insert(at_us, pose);
        }
        if by_instant.is_empty() {
            return Err(InputError::new(format!("{} holds no pose", table.name)));
        }
        check_gimbal(&table.name, "pose", by_instant.values().map(|pose: &Sighting| pose.attitude_rad[1]))?;
        Ok(Poses { by_instant, tells_follow_up: turn.is_some() })
    }
}

/// Refuses angles that look like no degrees.
fn check_degrees(table: &Table<'_>, angles: [usize; 3]) -> Result<(), InputError> {
    // A level flight to the north whose headings are degrees can write them with a turn more.
    let way_out = match Angles::of_table(table, angles)? {
        Some(found) if found.unit == Unit::Radians => (found, "; if they are degrees, add 360 to heading_deg"),
        Some(found) if found.is_certain => (found, ""),
        _ => return Ok(()),
    };
    Err(InputError::new(way_out.0.says(&table.name, &angles) + way_out.1))
}

fn above_0(table: &Table<'_>, row: usize, column: usize) -> Result<f64, InputError> {
    let value = table.number(row, column)?;
    if value > 0.0 { Ok(value) } else { Err(table.wrong(row, column, "not above 0")) }
}

/// An instant that has not been there before.
fn microseconds(
    table: &Table<'_>,
    row: usize,
    column: usize,
    seen: &mut HashMap<u64, usize>,
) -> Result<u64, InputError> {
    let (line, fields) = &table.rows[row];
    let whole = fields[column].parse::<u64>();
    let at_us = whole.map_err(|_| table.wrong(row, column, "not a whole number of microseconds"))?;
    match seen.insert(at_us, *line) {
        Some(before) => {
            let what = format!("that of line {before} already");
            Err(table.wrong(row, column, &what))
        }
        None => Ok(at_us),
    }
}
