//! Heights that are no metres above the ground, headings of another side of the camera than its top, and tilts of the other sign: a patch is then another
//! part of the ground than the board takes it for, or turned, and next to nothing matches. What they may be instead is flown, and told where it fixes the
//! frames.

use super::judge::{Figures, Verdict};
use crate::setup::Setup;
use crate::setup::frames::table::{Row, Table};
use plumbline_survey::io::shell::quoted;
use plumbline_survey::logs::units::scaled;

/// Metres of a foot.
const FOOT_M: f64 = 0.3048;
/// Share of the frames that is fixed where a table is right, if by far not always: one that fixes less than half as many is in doubt.
/// Chosen.
const SHARE_MIN: f64 = 0.5;
/// Frames that are flown with other numbers at most. Chosen: what takes no longer than the flight itself and shows a share to a tenth.
const FRAMES_MAX: usize = 40;
/// Ground that makes less of the height than this changes no match: the search takes a scale that is off by a twentieth.
const GROUND_SHARE: f64 = 0.05;

/// What heights or headings may be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Meant {
    /// Feet above the ground.
    Feet,
    /// Metres above the sea, as the elevation model's.
    AboveSea,
    /// Headings that want so many degrees more: those of a camera that is mounted with another side forward.
    Turned(u16),
    /// Pitch positive nose down and roll positive left wing down.
    Negated,
}

const EVERY: [Meant; 6] =
    [Meant::Feet, Meant::AboveSea, Meant::Turned(180), Meant::Turned(90), Meant::Turned(270), Meant::Negated];

impl Meant {
    /// What may be meant by the table of a flight that has hardly a fix; nothing of one that has.
    #[must_use]
    pub fn of(figures: &Figures, has_model: bool) -> Vec<Meant> {
        let are_few = (figures.accepted as f64) < 0.5 * SHARE_MIN * figures.frames as f64;
        EVERY.into_iter().filter(|meant| are_few && (has_model || *meant != Meant::AboveSea)).collect()
    }

    /// Whether it is about the attitude, not about heights.
    #[must_use]
    pub fn is_attitude(self) -> bool {
        matches!(self, Meant::Turned(_) | Meant::Negated)
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
        let meant = |row: &Row| {
            let mut meant = row.clone();
            match self {
                Meant::Feet => meant.height_m *= FOOT_M,
                Meant::AboveSea => meant.height_m -= ground_m(row),
                Meant::Turned(degrees) => meant.attitude_rad[0] += f64::from(degrees).to_radians(),
                Meant::Negated => meant.attitude_rad[1..].iter_mut().for_each(|angle| *angle = -*angle),
            }
            meant
        };
        let rows: Vec<Row> = rows.iter().map(meant).collect();
        let is_above = rows.iter().all(|row| row.height_m > 0.0);
        is_above.then(|| Table { rows, lines: table.lines[taken].to_vec(), ..table.clone() })
    }

    /// What to type, where so at least half of the frames are fixed.
    #[must_use]
    pub fn says(self, table: &Table, verdict: &Verdict) -> Option<String> {
        let Figures { accepted, frames, .. } = verdict.figures();
        if (accepted as f64) < SHARE_MIN * frames as f64 {
            return None;
        }
        let name = &table.name;
        let (column, what, line) = match self {
            Meant::Feet => {
                let line = scaled(name, &[table.columns[2]], &FOOT_M.to_string(), "metres.csv");
                ("height_m", "in feet".to_owned(), format!(": {line}"))
            }
            Meant::AboveSea => (
                "height_m",
                "above the sea".to_owned(),
                ", and above the ground is needed: take the elevation model's height below each off".into(),
            ),
            Meant::Turned(degrees) => {
                let field = table.columns[3] + 1;
                let line = format!(
                    ", as of a camera that is mounted with another side forward: awk -F, -v OFS=, 'NR > 1 {{ ${field} = (${field} + {degrees}) % 360 }} 1' \
                     {} > turned.csv",
                    quoted(name)
                );
                ("heading_deg", format!("{degrees} degrees more"), line)
            }
            Meant::Negated => {
                let [pitch, roll] = [4, 5].map(|column| table.columns[column] + 1);
                let line = format!(
                    ": awk -F, -v OFS=, 'NR > 1 {{ ${pitch} = -${pitch}; ${roll} = -${roll} }} 1' {} > signs.csv",
                    quoted(name)
                );
                (
                    "pitch_deg and roll_deg",
                    "of the other sign (nose up and right wing down are positive)".to_owned(),
                    line,
                )
            }
        };
        Some(format!(
            "{name}, {column}: were it {what}, {accepted} of {frames} frames would be fixed; it seems to be{line}"
        ))
    }
}
