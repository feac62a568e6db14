//! An attitude in a table (CSV), in the units that its columns say.

use super::fields::angles;
use super::{Attitude, Sample};
use crate::error::InputError;
use crate::io::table::Table;
use std::f64::consts::{FRAC_PI_2, TAU};

/// Names of the column of time, and seconds in its unit. `timestamp` is that of a ULog's topic written as CSV.
const TIMES: [(&str, f64); 4] = [("t_s", 1.0), ("t_ms", 1e-3), ("t_us", 1e-6), ("timestamp", 1e-6)];
const DEGREES: [&str; 3] = ["roll_deg", "pitch_deg", "yaw_deg"];
const RADIANS: [&str; 3] = ["roll_rad", "pitch_rad", "yaw_rad"];
const QUATERNIONS: [[&str; 4]; 2] = [["qw", "qx", "qy", "qz"], ["q[0]", "q[1]", "q[2]", "q[3]"]];

/// No autopilot logs its attitude as seldom, seconds between two rows; in milliseconds one does from 500 Hz down.
const STEP_MAX_S: f64 = 2.0;
/// Up to this step it rather is milliseconds: one a second is 1000 of them, 500 Hz are 2000 microseconds.
const STEP_MAX_MS: f64 = 1500.0;
/// A heading that jumps by more than this goes around a whole turn in radians, and in degrees by less than 7.
const TURN_RAD: f64 = 5.5;

/// What the angles are given as.
enum Columns {
    Degrees([usize; 3]),
    Radians([usize; 3]),
    Quaternion([usize; 4]),
}

/// As [`Attitude::of_table`].
pub(super) fn read(text: &str, name: &str) -> Result<Attitude, InputError> {
    let table = Table::parse(text, name.to_owned())?;
    let (time, unit_s) = time_of(&table)?;
    let columns = columns_of(&table)?;
    let mut samples: Vec<Sample> = Vec::with_capacity(table.rows.len());
    for row in 0..table.rows.len() {
        let t_s = table.number(row, time)? * unit_s;
        let [roll_rad, pitch_rad, yaw_rad] = match columns {
            Columns::Degrees(columns) => table.numbers_of(row, columns)?.map(f64::to_radians),
            Columns::Radians(columns) => table.numbers_of(row, columns)?,
            Columns::Quaternion(columns) => rotation(&table, row, columns)?,
        };
        if let Some(before) = samples.last().filter(|before| t_s <= before.t_s) {
            return Err(table.wrong(row, time, &format!("not later than {}", before.t_s / unit_s)));
        }
        samples.push(Sample { t_s, roll_rad, pitch_rad, yaw_rad });
    }
    check_time(&table, time, &samples)?;
    let note = if let Columns::Degrees(_) = columns { check_degrees(&table, &samples)? } else { None };
    Ok(Attitude { name: name.to_owned(), samples, notes: note.into_iter().collect() })
}

/// The column of time, and seconds in its unit.
fn time_of(table: &Table<'_>) -> Result<(usize, f64), InputError> {
    let is_there = |(name, _): &&(&str, f64)| table.header.contains(name);
    let (name, unit_s) = TIMES.iter().find(is_there).unwrap_or(&TIMES[0]);
    Ok((table.column(name)?, *unit_s))
}

fn columns_of(table: &Table<'_>) -> Result<Columns, InputError> {
    let is_there = |names: &[&str]| names.iter().any(|name| table.header.contains(name));
    if is_there(&DEGREES) {
        return table.columns(DEGREES).map(Columns::Degrees);
    }
    if let Some(names) = QUATERNIONS.into_iter().find(|names| is_there(names)) {
        return table.columns(names).map(Columns::Quaternion);
    }
    if is_there(&RADIANS) {
        return table.columns(RADIANS).map(Columns::Radians);
    }
    Err(InputError::new(format!(
        "{} has neither {} (or _rad) nor {}, only {}",
        table.name,
        DEGREES.join(", "),
        QUATERNIONS[0].join(", "),
        table.header.join(", ")
    )))
}

fn rotation(table: &Table<'_>, row: usize, columns: [usize; 4]) -> Result<[f64; 3], InputError> {
    let rotation = angles(table.numbers_of(row, columns)?);
    if rotation[0].is_finite() {
        Ok(rotation)
    } else {
        Err(table.wrong(row, columns[0], "not part of a unit quaternion"))
    }
}

/// Refuses seconds that are none.
fn check_time(table: &Table<'_>, time: usize, samples: &[Sample]) -> Result<(), InputError> {
    let mut steps: Vec<f64> = samples.windows(2).map(|pair| pair[1].t_s - pair[0].t_s).collect();
    steps.sort_by(f64::total_cmp);
    let Some(&step_s) = steps.get(steps.len() / 2).filter(|step| **step > STEP_MAX_S) else { return Ok(()) };
    let name = table.header[time];
    let (unit, column) = match name {
        "t_s" if step_s <= STEP_MAX_MS => ("milliseconds", "t_ms"),
        "t_s" => ("microseconds", "t_us"),
        "t_ms" => ("microseconds", "t_us"),
        _ => return Ok(()),
    };
    let step =
        (step_s * 1e3).round() * 1e-3 / TIMES.iter().find(|(known, _)| *known == name).map_or(1.0, |known| known.1);
    Err(InputError::new(format!(
        "{}: {name} goes in steps of {step}, which look like {unit}: if so, name the column {column}: \
         sed '1s/\\b{name}\\b/{column}/' {} > renamed.csv",
        table.name, table.name
    )))
}

/// Refuses degrees that are radians; says so where they may be.
fn check_degrees(table: &Table<'_>, samples: &[Sample]) -> Result<Option<String>, InputError> {
    let most =
        |angle: fn(&Sample) -> f64| samples.iter().map(angle).map(f64::to_degrees).map(f64::abs).fold(0.0, f64::max);
    let [roll, pitch, yaw] = [most(|s| s.roll_rad), most(|s| s.pitch_rad), most(|s| s.yaw_rad)];
    let is_small = roll <= TAU / 2.0 + 0.01 && pitch <= FRAC_PI_2 + 0.01 && yaw <= TAU + 0.01;
    if !is_small || roll.max(pitch) == 0.0 {
        return Ok(None);
    }
    let turns = samples.windows(2).any(|pair| (pair[1].yaw_rad - pair[0].yaw_rad).abs().to_degrees() > TURN_RAD);
    let sentence = format!(
        "{}: no angle is larger than {:.2}, which looks like radians: if so, name the columns {}: \
         sed '1s/_deg/_rad/g' {} > renamed.csv",
        table.name,
        roll.max(pitch).max(yaw),
        RADIANS.join(", "),
        table.name
    );
    if turns { Err(InputError::new(sentence)) } else { Ok(Some(sentence)) }
}
