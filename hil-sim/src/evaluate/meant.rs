//! Heights that are no metres above the ground: a patch is then another part of the ground than the board takes it for, and next to nothing
//! matches. What they may be instead is flown, and told where it fixes the frames.

use super::judge::{Figures, Verdict};
use crate::setup::Setup;
use crate::setup::frames::table::{Row, Table};
use plumbline_survey::logs::units::scaled;

/// Metres of a foot.
const FOOT_M: f64 = 0.3048;
/// Share of the frames that is fixed where heights are right, if by far not always: heights that fix less than half as many are in doubt.
/// Chosen.
const SHARE_MIN: f64 = 0.5;
/// Frames that are flown with other heights at most. Chosen: what takes no longer than the flight itself and shows a share to a tenth.
const FRAMES_MAX: usize = 40;
/// Ground that makes less of the height than this changes no match: the search takes a scale that is off by a twentieth.
const GROUND_SHARE: f64 = 0.05;

/// What heights may be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Meant {
    /// Feet above the ground.
    Feet,
    /// Metres above the sea, as the elevation model's.
    AboveSea,
}

impl Meant {
    /// What may be meant by the heights of a flight that has hardly a fix; nothing of one that has.
    #[must_use]
    pub fn of(figures: &Figures, has_model: bool) -> &'static [Meant] {
        match (figures.accepted as f64) < 0.5 * SHARE_MIN * figures.frames as f64 {
            true if has_model => &[Meant::Feet, Meant::AboveSea],
            true => &[Meant::Feet],
            false => &[],
        }
    }

    /// Frames from the flight's middle as they would be; `None` where that cannot be.
    #[must_use]
    pub fn table(self, table: &Table, setup: &Setup) -> Option<Table> {
        let count = table.rows.len();
        let taken = (count - count.min(FRAMES_MAX)) / 2..(count + count.min(FRAMES_MAX)) / 2;
        let ground_m = |row: &Row| setup.ground.height(row.place_m[0], row.place_m[1]);
        let rows = &table.rows[taken.clone()];
        if self == Meant::AboveSea && rows.iter().all(|row| ground_m(row).abs() < GROUND_SHARE * row.height_m) {
            return None;
        }
        let height_m = |row: &Row| match self {
            Meant::Feet => FOOT_M * row.height_m,
            Meant::AboveSea => row.height_m - ground_m(row),
        };
        let rows: Vec<Row> = rows.iter().map(|row| Row { height_m: height_m(row), ..row.clone() }).collect();
        let is_above = rows.iter().all(|row| row.height_m > 0.0);
        is_above.then(|| Table { rows, lines: table.lines[taken].to_vec(), ..table.clone() })
    }

    /// What to type, where with these heights at least half of the frames are fixed.
    #[must_use]
    pub fn says(self, table: &Table, verdict: &Verdict) -> Option<String> {
        let Figures { accepted, frames, .. } = verdict.figures();
        if (accepted as f64) < SHARE_MIN * frames as f64 {
            return None;
        }
        let name = &table.name;
        let (what, line) = match self {
            Meant::Feet => {
                ("in feet", format!(": {}", scaled(name, &[table.height_column], &FOOT_M.to_string(), "metres.csv")))
            }
            Meant::AboveSea => (
                "above the sea",
                ", and above the ground is needed: take the elevation model's height below each off".into(),
            ),
        };
        Some(format!(
            "{name}, height_m: were it {what}, {accepted} of {frames} frames would be fixed; it seems to be{line}"
        ))
    }
}
