//! An attitude in a table (CSV), in the units that its columns say.

use super::fields::angles;
use super::{Attitude, Sample};
use crate::error::InputError;
use crate::io::shell::quoted;
use crate::io::table::Table;
use crate::logs::units::{Angles, Times};

/// Names of the column of time, and seconds in its unit. `timestamp` is that of a ULog's topic written as CSV.
const TIMES: [(&str, f64); 4] = [("t_s", 1.0), ("t_ms", 1e-3), ("t_us", 1e-6), ("timestamp", 1e-6)];
const DEGREES: [&str; 3] = ["roll_deg", "pitch_deg", "yaw_deg"];
const RADIANS: [&str; 3] = ["roll_rad", "pitch_rad", "yaw_rad"];
const QUATERNIONS: [[&str; 4]; 2] = [["qw", "qx", "qy", "qz"], ["q[0]", "q[1]", "q[2]", "q[3]"]];

/// Beyond every angle that is counted on, hundredths of degrees of a long flight among them.
const ANGLE_MAX_DEG: f64 = 1e7;

/// What the angles are given as.
enum Columns {
    Degrees([usize; 3]),
    Radians([usize; 3]),
    Quaternion([usize; 4]),
}

/// As [`Attitude::of_table`].
pub(super) fn read(text: &str, name: &str) -> Result<Attitude, InputError> {
    let table = Table::parse(text, name.to_owned())?;
    let (time, unit_s, columns) = columns_of(&table)?;
    let mut samples: Vec<Sample> = Vec::with_capacity(table.rows.len());
    for row in 0..table.rows.len() {
        let t_s = table.number(row, time)? * unit_s;
        let [roll_rad, pitch_rad, yaw_rad] = match columns {
            Columns::Degrees(columns) => {
                let angles_deg = table.numbers_of(row, columns)?;
                if let Some(k) = angles_deg.iter().position(|angle| angle.abs() > ANGLE_MAX_DEG) {
                    return Err(table.wrong(row, columns[k], "no angle in degrees"));
                }
                angles_deg.map(f64::to_radians)
            }
            Columns::Radians(columns) => table.numbers_of(row, columns)?,
            Columns::Quaternion(columns) => rotation(&table, row, columns)?,
        };
        if let Some(before) = samples.last().filter(|before| t_s <= before.t_s) {
            return Err(table.wrong(row, time, &format!("not later than {}", before.t_s / unit_s)));
        }
        samples.push(Sample { t_s, roll_rad, pitch_rad, yaw_rad });
    }
    check_time(&table, time, unit_s)?;
    let note = if let Columns::Degrees(columns) = columns { check_degrees(&table, columns)? } else { None };
    Ok(Attitude { name: name.to_owned(), samples, notes: note.into_iter().collect() })
}

/// The column of time, seconds in its unit, and the columns of the angles.
fn columns_of(table: &Table<'_>) -> Result<(usize, f64, Columns), InputError> {
    let is_there = |names: &[&str]| names.iter().any(|name| table.header.contains(name));
    let known = TIMES.iter().find(|(name, _)| is_there(&[name]));
    let (time, unit_s) = *known.unwrap_or(&TIMES[0]);
    let of_three = |[a, b, c]: [&'static str; 3]| table.columns([time, a, b, c]).map(|[t, a, b, c]| (t, [a, b, c]));
    if is_there(&DEGREES) {
        return of_three(DEGREES).map(|(time, columns)| (time, unit_s, Columns::Degrees(columns)));
    }
    if let Some([w, x, y, z]) = QUATERNIONS.into_iter().find(|names| is_there(names)) {
        let [time, columns @ ..] = table.columns([time, w, x, y, z])?;
        return Ok((time, unit_s, Columns::Quaternion(columns)));
    }
    if is_there(&RADIANS) {
        return of_three(RADIANS).map(|(time, columns)| (time, unit_s, Columns::Radians(columns)));
    }
    let no_time = if known.is_none() {
        format!(", nor a time ({})", TIMES.map(|(name, _)| name).join(", "))
    } else {
        String::new()
    };
    Err(InputError::new(format!(
        "{} has neither {} (or _rad) nor {}{no_time}, only {}",
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
fn check_time(table: &Table<'_>, time: usize, unit_s: f64) -> Result<(), InputError> {
    let Some(Times { unit, column, step, .. }) = Times::of(&table.numbers(time)?, unit_s) else { return Ok(()) };
    let (file, name) = (&table.name, table.header[time]);
    Err(InputError::new(format!(
        "{file}: {name} goes in steps of {step}, which look like {unit}: if so, name the column {column}: \
         sed '1s/\\b{name}\\b/{column}/' {} > renamed.csv",
        quoted(file)
    )))
}

/// Refuses degrees that are none; says so where they may be.
fn check_degrees(table: &Table<'_>, columns: [usize; 3]) -> Result<Option<String>, InputError> {
    let Some(found) = Angles::of_table(table, columns)? else { return Ok(None) };
    let says = found.says(&table.name, &columns);
    if found.is_certain { Err(InputError::new(says)) } else { Ok(Some(says)) }
}
