//! What the numbers of a table look like, whatever its columns say: angles like radians or hundredths of a degree, times like milliseconds or
//! microseconds, a pitch like a gimbal's.
//!
//! Nothing is converted here: the sentences say what to type. Who reads a table decides whether it is refused or flown with a note.

use crate::error::InputError;
use crate::io::shell::{beside, quoted};
use crate::io::table::Table;

/// A pitch farther from level than this, degrees, is a gimbal's: no camera whose axis is so near the horizon takes a picture that is fixed.
pub const GIMBAL_DEG: f64 = 75.0;
/// What the last digit of two decimals may add to an angle in radians.
const ROUNDED_RAD: f64 = 0.01;
/// A heading that jumps by more than this goes around a whole turn in radians, and in degrees by less than 7.
const TURN_RAD: f64 = 5.5;
/// A pitch or roll beyond a whole turn is none in degrees, however it is counted.
const TILT_MOST_DEG: f64 = 360.0;
/// A heading that is counted on over north passes this after ten turns.
const HEADING_MOST_DEG: f64 = 3600.0;
/// Hundredths of a degree in a degree.
const HUNDREDTHS: f64 = 100.0;

/// No autopilot logs its attitude as seldom, seconds between two rows; in milliseconds one does from 500 Hz down.
const STEP_MAX_S: f64 = 2.0;
/// Up to this step of seconds it rather is milliseconds: one a second is 1000 of them, 500 Hz are 2000 microseconds.
const STEP_MAX_MS: f64 = 1500.0;

/// What angles are that are called degrees and do not look like them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unit {
    /// They may be degrees of a level flight to the north.
    Radians,
    /// As MAVLink and ArduPilot have some angles: 3000 is 30 degrees.
    Hundredths,
}

/// Angles that are called degrees and look like another unit.
#[derive(Clone, Debug, PartialEq)]
pub struct Angles {
    /// Which one.
    pub unit: Unit,
    /// Whether degrees cannot be meant.
    pub is_certain: bool,
    most: f64,
}

/// An angle that goes around, by the name of its column.
fn is_heading(name: &str) -> bool {
    let name = name.to_lowercase();
    ["yaw", "heading", "course"].iter().any(|what| name.contains(what))
}

/// As far as an angle is counted either way, degrees, by the name of its column.
fn bound_deg(name: &str) -> f64 {
    match name.to_lowercase() {
        name if name.contains("pitch") => 90.0,
        name if name.contains("roll") => 180.0,
        _ => 360.0,
    }
}

/// Whether a value could be this angle in radians.
#[must_use]
pub fn fits_radians(name: &str, value: f64) -> bool {
    value.abs() <= bound_deg(name).to_radians() + ROUNDED_RAD
}

impl Angles {
    /// Judges the columns of one attitude, each with its name; values that are not there are passed over. `None`: they look like degrees.
    #[must_use]
    pub fn of(columns: &[(&str, &[f64])]) -> Option<Self> {
        let most = |values: &[f64]| values.iter().fold(0.0, |most: f64, value| most.max(value.abs()));
        let all = |is: &dyn Fn(&str, f64) -> bool| columns.iter().all(|(name, values)| is(name, most(values)));
        // A tenth at least: a few may be outliers, or what a log has where there is nothing.
        let often = |heading: bool, limit: f64| {
            let count = |values: &[f64]| values.iter().filter(|value| value.abs() > limit).count();
            columns.iter().any(|(name, values)| is_heading(name) == heading && 10 * count(values) > values.len())
        };
        let largest = columns.iter().map(|(_, values)| most(values)).fold(0.0, f64::max);
        let found = |unit, is_certain| Some(Angles { unit, is_certain, most: largest });
        let tilts = columns.iter().any(|(name, values)| !is_heading(name) && most(values) > 0.0);
        if tilts && all(&fits_radians) {
            let turns = |values: &[f64]| values.windows(2).any(|pair| (pair[1] - pair[0]).abs() > TURN_RAD);
            return found(Unit::Radians, columns.iter().any(|(name, values)| is_heading(name) && turns(values)));
        }
        let is_certain = often(false, TILT_MOST_DEG);
        if (is_certain || often(true, HEADING_MOST_DEG)) && all(&|name, most| most <= HUNDREDTHS * bound_deg(name)) {
            return found(Unit::Hundredths, is_certain);
        }
        None
    }

    /// As [`Self::of`], of columns of a table.
    ///
    /// # Errors
    /// A field is no finite number.
    pub fn of_table<const N: usize>(table: &Table<'_>, columns: [usize; N]) -> Result<Option<Self>, InputError> {
        let values = columns.iter().map(|column| table.numbers(*column)).collect::<Result<Vec<_>, _>>()?;
        let named: Vec<_> = columns.iter().zip(&values).map(|(at, values)| (table.header[*at], &values[..])).collect();
        Ok(Self::of(&named))
    }

    /// What they look like, and what to type if they are: `columns`, counted from 0, of the file of that name.
    #[must_use]
    pub fn says(&self, name: &str, columns: &[usize]) -> String {
        let what = match self.unit {
            Unit::Radians => format!("no angle is larger than {:.2}, which looks like radians", self.most),
            Unit::Hundredths => format!("angles go up to {}, which looks like hundredths of a degree", self.most),
        };
        format!("{name}: {what}: if so, {}", self.unit.in_degrees(name, columns))
    }
}

impl Unit {
    /// The line that makes degrees of a table's columns, counted from 0.
    #[must_use]
    pub fn in_degrees(self, name: &str, columns: &[usize]) -> String {
        let factor = match self {
            Unit::Radians => "57.29577951308232",
            Unit::Hundredths => "0.01",
        };
        scaled(name, columns, factor, "degrees.csv")
    }
}

/// The line that makes of a table another one beside it, some columns of which, counted from 0, are multiplied.
#[must_use]
pub fn scaled(name: &str, columns: &[usize], factor: &str, made: &str) -> String {
    let each: Vec<String> = columns.iter().map(|column| format!("${} *= {factor}", column + 1)).collect();
    format!("awk -F, -v OFS=, 'NR > 1 {{ {} }} 1' {} > {}", each.join("; "), quoted(name), beside(name, made))
}

/// Times that do not look like their unit.
#[derive(Clone, Debug, PartialEq)]
pub struct Times {
    /// What they look like.
    pub unit: &'static str,
    /// A column of such times in a table of attitudes.
    pub column: &'static str,
    factor: &'static str,
    /// The median step, in the unit of the numbers.
    pub step: f64,
}

impl Times {
    /// Judges instants that are called seconds, or `unit_s` of a second. `None`: they look like that.
    #[must_use]
    pub fn of(instants: &[f64], unit_s: f64) -> Option<Self> {
        let mut steps: Vec<f64> = instants.windows(2).map(|pair| pair[1] - pair[0]).collect();
        steps.sort_by(f64::total_cmp);
        let step = steps.get(steps.len() / 2).copied().filter(|step| step * unit_s > STEP_MAX_S)?;
        let [milli, micro] = [("milliseconds", "t_ms", "0.001"), ("microseconds", "t_us", "0.000001")];
        let (unit, column, factor) = match unit_s {
            1.0 if step <= STEP_MAX_MS => milli,
            // Microseconds themselves look like nothing else.
            1e-6 => return None,
            _ => micro,
        };
        Some(Times { unit, column, factor, step: (step * 1e3).round() * 1e-3 })
    }

    /// The line that makes seconds of a table's column, counted from 0.
    #[must_use]
    pub fn in_seconds(&self, name: &str, column: usize) -> String {
        scaled(name, &[column], self.factor, "seconds.csv")
    }
}

/// Refuses a gimbal's pitch, whose -90 (or 90) looks straight down: a camera that looks at the horizon in every `what` has no fix.
///
/// # Errors
/// Every pitch, radians, is so.
pub fn check_gimbal(name: &str, what: &str, pitches_rad: impl Iterator<Item = f64> + Clone) -> Result<(), InputError> {
    let all = |is: fn(f64) -> bool| pitches_rad.clone().map(f64::to_degrees).all(is);
    let meant = if all(|pitch| pitch < -GIMBAL_DEG) {
        "so to a gimbal's pitch add 90"
    } else if all(|pitch| pitch > GIMBAL_DEG) {
        "so take a gimbal's pitch, which is 90 there, from 90"
    } else {
        return Ok(());
    };
    Err(InputError::new(format!(
        "{name}, pitch_deg: every {what} looks at the horizon; 0 is a camera that looks straight down, {meant}"
    )))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn judged(columns: [&[f64]; 3]) -> Option<(Unit, bool)> {
        let [roll, pitch, yaw] = columns;
        Angles::of(&[("roll_deg", roll), ("pitch_deg", pitch), ("yaw_deg", yaw)])
            .map(|found| (found.unit, found.is_certain))
    }

    #[test]
    fn angles_are_known_by_how_large_they_are() {
        for (columns, wanted) in [
            ([&[0.1, -0.2][..], &[0.0, 0.0], &[3.1, -3.1]], Some((Unit::Radians, true))),
            ([&[0.1, -0.2], &[0.0, 0.0], &[3.1, 3.0]], Some((Unit::Radians, false))),
            // Level to the last bit, beyond a right angle in radians, a turn on: degrees.
            ([&[0.0, 0.0], &[0.0, 0.0], &[3.1, 3.0]], None),
            ([&[0.1, 0.2], &[1.7, 0.0], &[3.1, 3.0]], None),
            ([&[0.1, 0.2], &[0.0, 0.0], &[361.0, 363.0]], None),
            ([&[3000.0, 20.0], &[-150.0, 0.0], &[27000.0, 35999.0]], Some((Unit::Hundredths, true))),
            ([&[30.0, 20.0], &[-150.0, 0.0], &[27000.0, 35999.0]], Some((Unit::Hundredths, false))),
            // Two turns on; a pitch counted to 360; values that are no hundredths either; a value that is missing.
            ([&[30.0, 20.0], &[-15.0, 0.0], &[700.0, 900.0]], None),
            ([&[359.0, 1.0], &[359.0, 0.0], &[0.0, 90.0]], None),
            ([&[65535.0, 1.0], &[0.0, 0.0], &[0.0, 90.0]], None),
            ([&[f64::NAN, 10.0], &[0.0, 0.0], &[0.0, 90.0]], None),
        ] {
            assert_eq!(judged(columns), wanted, "{columns:?}");
        }
        let found = Angles::of(&[("roll_deg", &[3000.0])]).expect("hundredths");
        let line = "awk -F, -v OFS=, 'NR > 1 { $2 *= 0.01; $4 *= 0.01 } 1' a.csv > degrees.csv";
        assert_eq!(
            found.says("a.csv", &[1, 3]),
            format!("a.csv: angles go up to 3000, which looks like hundredths of a degree: if so, {line}")
        );
        // What is made lies beside the table, whose names of files are from its folder on.
        assert!(found.says("flight/a.csv", &[1]).ends_with("flight/a.csv > flight/degrees.csv"));
    }

    #[test]
    fn times_are_known_by_their_steps() {
        let unit = |step: f64, unit_s: f64| Times::of(&[0.0, step, 2.0 * step], unit_s).map(|found| found.unit);
        assert_eq!([unit(0.02, 1.0), unit(2.0, 1.0), unit(20.0, 1e-3), unit(2e7, 1e-6)], [None; 4]);
        assert_eq!([unit(20.0, 1.0), unit(1500.0, 1.0)], [Some("milliseconds"); 2]);
        assert_eq!([unit(2000.0, 1.0), unit(20_000.0, 1e-3)], [Some("microseconds"); 2]);
    }

    #[test]
    fn a_gimbals_pitch_is_known_where_all_are_so() {
        let check = |pitches_deg: &[f64]| {
            let pitches_rad = pitches_deg.iter().map(|deg| deg.to_radians());
            check_gimbal("f.csv", "frame", pitches_rad).map_err(|error| error.to_string())
        };
        assert!(
            check(&[-89.0, -76.0]).expect_err("down").contains("f.csv, pitch_deg: every frame looks at the horizon")
        );
        assert!(check(&[89.0, 76.0]).expect_err("down").contains("from 90"));
        assert!(check(&[-89.0, -74.0]).is_ok() && check(&[-89.0, 89.0]).is_ok());
    }
}
