//! Heights that are no metres above the ground, headings of another side of the camera than its top or counted the other way, tilts of the other sign or
//! swapped: a patch is then another part of the ground than the board takes it for, or turned, and matches nowhere or beside its place. What they may be
//! instead is flown, and told where it is clearly better. Nothing is mended by it.

mod reading;

use super::judge::{Figures, Verdict};
use crate::setup::Setup;
use crate::setup::frames::table::{Row, Table};
use plumbline_survey::io::shell::{beside, quoted};
use plumbline_survey::logs::units::scaled;
use reading::{EVERY, Reading};

/// Metres of a foot.
const FOOT_M: f64 = 0.3048;
/// Share of the frames whose fix is right where a table is, if by far not always: one that has less than half as many is in doubt.
/// Chosen.
const SHARE_MIN: f64 = 0.5;
/// Share of the fixes that may be wrong before a table is in doubt: a sound flight has next to none. Chosen.
const WRONG_MAX: f64 = 0.1;
/// What is meant leaves at most so many of the frames without a right fix, as a part of those that are so as it is written. Chosen: chance changes some
/// frames of forty.
const LEFT_MAX: f64 = 0.5;
/// Frames that are flown with other numbers at most. Chosen: what takes no longer than the flight itself and shows a share to a tenth.
const FRAMES_MAX: usize = 40;
/// Ground that makes less of the height than this changes no match: the search takes a scale that is off by a twentieth.
const GROUND_SHARE: f64 = 0.05;

/// What heights or the attitude may be.
#[derive(Clone, Copy, Debug)]
pub enum Meant {
    /// Feet above the ground.
    Feet,
    /// Metres above the sea, as the elevation model's.
    AboveSea,
    /// An attitude by other conventions.
    Attitude(&'static Reading),
}

impl Meant {
    /// What may be meant by the table of a flight that has hardly a right fix or many wrong ones; nothing of another.
    #[must_use]
    pub fn of(figures: &Figures, has_model: bool) -> Vec<Meant> {
        let are_few = (figures.right as f64) < 0.5 * SHARE_MIN * figures.frames as f64;
        let are_wrong = figures.wrong as f64 > WRONG_MAX * figures.accepted as f64;
        if !are_few && !are_wrong {
            return Vec::new();
        }
        let heights = [Some(Meant::Feet), has_model.then_some(Meant::AboveSea)];
        heights.into_iter().flatten().chain(EVERY.iter().map(Meant::Attitude)).collect()
    }

    /// Whether it is about the attitude, not about heights.
    #[must_use]
    pub fn is_attitude(self) -> bool {
        matches!(self, Meant::Attitude(_))
    }

    /// Frames from the flight's middle as they would be; `None` where that cannot be.
    #[must_use]
    pub fn table(self, table: &Table, setup: &Setup) -> Option<Table> {
        let count = table.rows.len();
        let taken = (count - count.min(FRAMES_MAX)) / 2..(count + count.min(FRAMES_MAX)) / 2;
        let ground_m = |row: &Row| setup.ground.height(row.place_m[0], row.place_m[1]);
        let rows = &table.rows[taken.clone()];
        let is_level = || rows.iter().all(|row| ground_m(row).abs() < GROUND_SHARE * row.height_m);
        if matches!(self, Meant::AboveSea) && is_level() {
            return None;
        }
        let meant = |row: &Row| {
            let mut meant = row.clone();
            match self {
                Meant::Feet => meant.height_m *= FOOT_M,
                Meant::AboveSea => meant.height_m -= ground_m(row),
                Meant::Attitude(reading) => meant.attitude_rad = (reading.read)(row.attitude_rad),
            }
            meant
        };
        let rows: Vec<Row> = rows.iter().map(meant).collect();
        let is_above = rows.iter().all(|row| row.height_m > 0.0);
        is_above.then(|| Table { rows, lines: table.lines[taken].to_vec(), ..table.clone() })
    }

    /// The columns, and what they would be.
    #[must_use]
    pub fn what(self) -> &'static str {
        match self {
            Meant::Feet => "height_m: were it in feet",
            Meant::AboveSea => "height_m: were it above the sea",
            Meant::Attitude(reading) => reading.what,
        }
    }

    /// What to type; `verdict` is that of the frames as they would be, `others` what does as well.
    #[must_use]
    pub fn says(self, table: &Table, verdict: &Verdict, others: &[Meant]) -> String {
        let Figures { right, frames, .. } = verdict.figures();
        let name = &table.name;
        let field = |column: usize| format!("${}", table.columns[column] + 1);
        let line = match self {
            Meant::Feet => format!(": {}", scaled(name, &[table.columns[2]], &FOOT_M.to_string(), "metres.csv")),
            Meant::AboveSea => {
                ", and above the ground is needed: take the elevation model's height below each off".to_owned()
            }
            Meant::Attitude(Reading { awk, made, .. }) => {
                let line = awk.replace("$H", &field(3)).replace("$P", &field(4)).replace("$R", &field(5));
                format!(": awk -F, -v OFS=, 'NR > 1 {{ {line} }} 1' {} > {}", quoted(name), beside(name, made))
            }
        };
        let others: String = others.iter().map(|other| format!("; as many with {}", other.what())).collect();
        format!("{name}, {}, {right} of {frames} frames would have a right fix; so it seems{line}{others}", self.what())
    }
}

/// What is clearly better, of flights by what may be meant: those with most right fixes, the one with the least errors first.
#[must_use]
pub fn best<T>(before: &Figures, mut flown: Vec<(T, Verdict)>) -> Vec<(T, Verdict)> {
    let share = |figures: &Figures| figures.right as f64 / figures.frames.max(1) as f64;
    let is_clear = |figures: &Figures| {
        let right = share(figures);
        right >= SHARE_MIN && 1.0 - right <= LEFT_MAX * (1.0 - share(before))
    };
    let right = |verdict: &Verdict| verdict.figures().right;
    flown.retain(|(_, verdict)| is_clear(&verdict.figures()));
    let most = flown.iter().map(|(_, verdict)| right(verdict)).max();
    flown.retain(|(_, verdict)| Some(right(verdict)) == most);
    let error_m = |verdict: &Verdict| verdict.figures().median_error_m.unwrap_or(f64::INFINITY);
    flown.sort_by(|(_, a), (_, b)| error_m(a).total_cmp(&error_m(b)));
    flown
}
