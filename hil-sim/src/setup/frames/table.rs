//! `frames.csv`: the frames of a flight, where the navigation had each and how the camera was turned.

use crate::vehicle::servo::wrapped;
use plumbline_survey::error::{InputError, counted};
use plumbline_survey::io::table::{Table as Csv, text_of};
use plumbline_survey::logs::units::{Angles, Unit, check_gimbal, fits_radians};
use std::f64::consts::PI;
use std::path::{Path, PathBuf};

/// Columns that every table has, and behind them those of one that knows the truth.
const COLUMNS: [&str; 9] =
    ["file", "east_m", "north_m", "height_m", "heading_deg", "pitch_deg", "roll_deg", "true_east_m", "true_north_m"];
/// A flight of two frames is none.
const ROWS_MIN: usize = 3;
/// Greatest height above the ground, metres: beyond it are satellites, and millimetres.
const HEIGHT_MAX_M: f64 = 50_000.0;
/// A heading that is nearer to the course in most frames is meant by it: what wind and a heading that is read roughly leave. Chosen: 30 degrees.
const COURSE_RAD: f64 = PI / 6.0;

/// A frame of the flight.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// Its picture.
    pub file: PathBuf,
    /// Where the navigation had it, grid east and north, metres.
    pub place_m: [f64; 2],
    /// Height above the ground below, metres.
    pub height_m: f64,
    /// Heading clockwise from grid north, pitch nose up, roll right side down; radians.
    pub attitude_rad: [f64; 3],
    /// Where it really was, grid east and north, metres.
    pub truth_m: Option<[f64; 2]>,
}

/// A flight's frames in their order.
#[derive(Clone, Debug, PartialEq)]
pub struct Table {
    /// What messages call it.
    pub name: String,
    /// At least three.
    pub rows: Vec<Row>,
    /// Lines of the file that they stand on.
    pub lines: Vec<usize>,
    /// What its angles may be if they are no degrees.
    pub doubt: Option<String>,
    /// Where in the file east, north, height, heading, pitch and roll stand, counted from 0.
    pub columns: [usize; 6],
}

impl Table {
    /// Reads a table. Pictures are looked for from its folder on.
    ///
    /// # Errors
    /// One sentence with the line and the column: a column that is missing, no number, a height or an angle that cannot be meant.
    pub fn read(path: &Path) -> Result<Self, InputError> {
        let (text, name) = text_of(path)?;
        Self::parse(&text, name, path.parent().unwrap_or(Path::new("")))
    }

    fn parse(text: &str, name: String, folder: &Path) -> Result<Self, InputError> {
        let csv = Csv::parse(text, name.clone())?;
        let [always @ .., _, _] = COLUMNS;
        let knows_truth = COLUMNS[7..].iter().any(|column| csv.header.contains(column));
        let (file, columns, truth): (usize, [usize; 6], _) = if knows_truth {
            let [file, columns @ .., east, north] = csv.columns(COLUMNS)?;
            (file, columns, Some([east, north]))
        } else {
            let [file, columns @ ..] = csv.columns(always)?;
            (file, columns, None)
        };
        if csv.rows.len() < ROWS_MIN {
            let count = counted(csv.rows.len(), "frame");
            return Err(InputError::new(format!("{name} has {count}, at least {ROWS_MIN} are needed for a flight")));
        }
        let angles = [columns[3], columns[4], columns[5]];
        let doubt = Angles::of_table(&csv, angles)?;
        let says = doubt.as_ref().map(|found| found.says(&name, &angles));
        if let (Some(Angles { unit: Unit::Hundredths, .. }), Some(says)) = (&doubt, &says) {
            return Err(InputError::new(says));
        }
        let row = |index: usize| {
            let [east_m, north_m, height_m, heading_deg, pitch_deg, roll_deg] = csv.numbers_of(index, columns)?;
            let wrong = |column: usize, what: &str| Err(csv.wrong(index, columns[column], what));
            if height_m <= 0.0 {
                return wrong(2, "no height above the ground: it must be above 0");
            }
            if height_m > HEIGHT_MAX_M {
                return wrong(2, "no height above the ground in metres: no frame is taken from farther than 50 km");
            }
            if heading_deg.abs() > 360.0 {
                return wrong(3, "no heading in degrees from −360 to 360");
            }
            if pitch_deg.abs() >= 90.0 {
                let hint = "not between −90 and 90: 0 is a camera that looks straight down, so a gimbal's pitch of −90 is 0 here";
                return wrong(4, hint);
            }
            if roll_deg.abs() > 180.0 {
                return wrong(5, "no roll in degrees from −180 to 180");
            }
            Ok(Row {
                file: folder.join(csv.rows[index].1[file]),
                place_m: [east_m, north_m],
                height_m,
                attitude_rad: [heading_deg, pitch_deg, roll_deg].map(f64::to_radians),
                truth_m: truth.map(|columns| csv.numbers_of(index, columns)).transpose()?,
            })
        };
        let rows = (0..csv.rows.len()).map(row).collect::<Result<Vec<Row>, InputError>>()?;
        let lines = csv.rows.iter().map(|(line, _)| *line).collect();
        check_gimbal(&name, "frame", rows.iter().map(|row| row.attitude_rad[1]))?;
        let table = Table { name, rows, lines, doubt: says, columns };
        table.radians(columns[3])?;
        Ok(table)
    }

    /// Headings within a turn of radians that are the course as radians, and not as degrees. `column`: theirs.
    fn radians(&self, column: usize) -> Result<(), InputError> {
        let headings = || self.rows.iter().map(|row| row.attitude_rad[0].to_degrees());
        if !headings().all(|heading| fits_radians("heading_deg", heading)) {
            return Ok(());
        }
        let course_rad = |pair: &[Row]| {
            let [a, b] = [pair[0].place_m, pair[1].place_m];
            (b[0] - a[0]).atan2(b[1] - a[1])
        };
        let agrees = |unit_rad: f64| {
            let pairs = self.rows.windows(2).filter(|pair| pair[0].place_m != pair[1].place_m);
            let off_rad =
                |pair: &[Row]| wrapped(pair[0].attitude_rad[0].to_degrees() * unit_rad - course_rad(pair)).abs();
            let (near, far): (Vec<f64>, Vec<f64>) = pairs.map(off_rad).partition(|off_rad| *off_rad < COURSE_RAD);
            near.len() > far.len()
        };
        if agrees(1.0_f64.to_radians()) || !agrees(1.0) {
            return Ok(());
        }
        let name = &self.name;
        Err(InputError::new(format!(
            "{name}, heading_deg: as radians it is the course from frame to frame, and as degrees it is not: if it is radians, \
             {}, and likewise pitch_deg and roll_deg where they are",
            Unit::Radians.in_degrees(name, &[column])
        )))
    }

    /// From each frame to the next, metres.
    pub fn steps_m(&self) -> impl Iterator<Item = f64> + '_ {
        self.rows.windows(2).map(|pair| {
            let [a, b] = [pair[0].place_m, pair[1].place_m];
            (b[0] - a[0]).hypot(b[1] - a[1])
        })
    }

    /// Whether the truth is known.
    #[must_use]
    pub fn knows_truth(&self) -> bool {
        self.rows.iter().all(|row| row.truth_m.is_some())
    }

    /// Where a row is, for messages.
    #[must_use]
    pub fn line(&self, index: usize) -> String {
        format!("{}, line {}", self.name, self.lines.get(index).copied().unwrap_or_default())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::{FRAC_PI_2, TAU};

    const HEAD: &str = "file,east_m,north_m,height_m,heading_deg,pitch_deg,roll_deg";

    fn parse(text: &str) -> Result<Table, String> {
        Table::parse(text, "f.csv".to_owned(), Path::new("there")).map_err(|error| error.to_string())
    }

    #[test]
    fn a_table_with_the_truth_and_one_without() {
        let rows = "a.png,10,20,100,90,1,-2\nb.png,13,24,100,90,0,0\nc.png,13,24,101,-90,0,0\n";
        let table = parse(&format!("{HEAD}\n{rows}")).expect("sound");
        assert_eq!(table.rows[0].file, Path::new("there/a.png"));
        assert_eq!(table.steps_m().collect::<Vec<_>>(), [5.0, 0.0]);
        assert!(!table.knows_truth());
        let rows = "a.png,10,20,100,90,1,-2,11,21\nb.png,13,24,100,90,0,0,1,2\nc.png,13,24,101,-90,0,0,1,2\n";
        let table = parse(&format!("{HEAD},true_east_m,true_north_m\n{rows}")).expect("sound");
        assert_eq!(table.rows[0].truth_m, Some([11.0, 21.0]));
        assert!(table.knows_truth());
    }

    #[test]
    fn headings_in_radians_are_known_by_the_course() {
        // A circle, clockwise; leant by some degrees.
        let circle = |unit: f64| {
            let row = |index: usize| {
                let turn = TAU * index as f64 / 40.0;
                let heading = wrapped(turn + FRAC_PI_2 + PI / 40.0) * unit;
                format!("f.png,{},{},100,{heading},2,-3\n", 50.0 * turn.sin(), 50.0 * turn.cos())
            };
            parse(&format!("{HEAD}\n{}", (0..40).map(row).collect::<String>()))
        };
        assert!(circle(180.0 / PI).is_ok());
        let error = circle(1.0).expect_err("radians");
        assert!(
            error.contains("f.csv, heading_deg: as radians") && error.contains("$5 *= 57.29577951308232"),
            "{error}"
        );
        // A camera that looks to the north on its way around is not meant otherwise.
        let row = |index: usize| {
            let turn = TAU * index as f64 / 40.0;
            format!("f.png,{},{},100,{},2,-3\n", 50.0 * turn.sin(), 50.0 * turn.cos(), 0.1 * (index % 3) as f64)
        };
        assert!(parse(&format!("{HEAD}\n{}", (0..40).map(row).collect::<String>())).is_ok());
    }

    #[test]
    fn what_cannot_be_meant_is_told_with_its_line() {
        let row = |row: &str| format!("{HEAD}\na.png,1,2,100,0,0,0\nb.png,1,2,100,0,0,0\n{row}\n");
        for (text, wanted) in [
            (row("c.png,1,2,0,0,0,0"), "f.csv, line 4: height_m"),
            (row("c.png,1,2,100,400,0,0"), "heading_deg"),
            (row("c.png,1,2,100,0,-90,0"), "gimbal"),
            (row("c.png,1,2,100,0,0,x"), "roll_deg"),
            (format!("{HEAD}\na.png,1,2,100,0,0,0\n"), "1 frame,"),
            (row("c.png,1,2,101740,0,0,0"), "no height above the ground in metres"),
            (format!("{HEAD},true_east_m\na.png,1,2,100,0,0,0,0\n"), "true_north_m"),
            (format!("{HEAD},true_east_m\n").replace("roll_deg,", ""), "no columns roll_deg, true_north_m, only file"),
            (row("c.png,1,2,100,9000,0,3000"), "hundredths of a degree: if so, awk -F, -v OFS=, 'NR > 1 { $5 *= 0.01;"),
            (format!("{HEAD}\na,1,2,9,0,-89,0\nb,1,2,9,0,-89,0\nc,1,2,9,0,-88,0\n"), "add 90"),
        ] {
            let error = parse(&text).expect_err(wanted);
            assert!(error.contains(wanted), "{error}");
        }
    }
}
