//! What the fixes of real frames are worth: against the truth where a table knows it, else against the flight's median offset.

use crate::run::{Flight, FrameRecord};
use crate::score::fixes::{probability, reason};
use crate::setup::Setup;
use crate::setup::frames::table::{Row, Table};
use serde::Serialize;
use std::collections::BTreeMap;

/// A fix is right so close, pixels of the reference: as `match_rate` of a flight's report has it.
pub const RIGHT_PX: f64 = 1.5;

/// A frame's fix.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fixed {
    /// Grid east and north, metres.
    pub place_m: [f64; 2],
    /// Variances of both, and their covariance between, square metres.
    pub covariance_m2: [f64; 3],
    /// From where the navigation had it, metres.
    pub offset_m: [f64; 2],
    /// From where it was, as far as that is known, metres.
    pub error_m: [f64; 2],
    /// Pitch and roll that the firmware rectified with, radians: the table's less what it has learnt of them in the flight.
    pub rectified_rad: Option<[f64; 2]>,
    /// Stated probability that it is wrong.
    pub risk: f64,
}

impl Fixed {
    /// One sigma, east and north, metres.
    #[must_use]
    pub fn sigma_m(&self) -> [f64; 2] {
        [self.covariance_m2[0].sqrt(), self.covariance_m2[2].sqrt()]
    }

    /// Distance from where it was, metres.
    #[must_use]
    pub fn off_m(&self) -> f64 {
        self.error_m[0].hypot(self.error_m[1])
    }

    /// Its error squared in its own sigmas, two degrees of freedom.
    fn nees(&self) -> f64 {
        let ([e, n], [ee, en, nn]) = (self.error_m, self.covariance_m2);
        (nn * e * e - 2.0 * en * e * n + ee * n * n) / (ee * nn - en * en)
    }
}

/// A frame, as it ended.
#[derive(Clone, Debug, PartialEq)]
pub struct Judged {
    /// Its fix, or why there is none.
    pub fix: Result<Fixed, &'static str>,
}

/// The fixes of a flight.
#[derive(Clone, Debug, PartialEq)]
pub struct Verdict {
    /// A frame each, in the table's order.
    pub frames: Vec<Judged>,
    /// Of the fixes from the navigation, east and north each, metres; `None` without a fix.
    pub median_offset_m: Option<[f64; 2]>,
    /// Side of a pixel, metres.
    pub resolution_m: f64,
}

/// The figures of a verdict.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Figures {
    /// Of the table.
    pub frames: usize,
    /// Those with a fix.
    pub accepted: usize,
    /// Fixes within [`RIGHT_PX`].
    pub right: usize,
    /// The others.
    pub wrong: usize,
    /// Of the fixes from the navigation, east and north each for itself, metres.
    pub median_offset_m: Option<[f64; 2]>,
    /// Median of the fixes' distances from the navigation, metres.
    pub median_distance_m: Option<f64>,
    /// Median of the fixes' errors, metres.
    pub median_error_m: Option<f64>,
    /// Mean of the fixes' errors squared in their own sigmas; 2 expected.
    pub nees_mean: Option<f64>,
    /// Frames without a fix, by reason.
    pub refused: BTreeMap<&'static str, usize>,
}

/// Judges a flight of `table`'s frames.
#[must_use]
pub fn judge(setup: &Setup, table: &Table, flight: &Flight) -> Verdict {
    let records = |row: usize| flight.frames.iter().find(move |record| record.exposure.frame as usize == row);
    let fixed = |(index, row): (usize, &Row)| fixed(setup, row, records(index));
    let mut frames: Vec<Judged> = table.rows.iter().enumerate().map(|row| Judged { fix: fixed(row) }).collect();
    let fixes = || frames.iter().filter_map(|frame| frame.fix.as_ref().ok());
    let median_offset_m = median([0, 1].map(|axis| fixes().map(|fix| fix.offset_m[axis]).collect()));
    let is_known = table.knows_truth();
    for (frame, row) in frames.iter_mut().zip(&table.rows) {
        let Ok(fix) = &mut frame.fix else { continue };
        let zero_m = match row.truth_m.filter(|_| is_known) {
            Some(truth_m) => std::array::from_fn(|axis| truth_m[axis] - row.place_m[axis]),
            None => median_offset_m.unwrap_or_default(),
        };
        fix.error_m = std::array::from_fn(|axis| fix.offset_m[axis] - zero_m[axis]);
    }
    Verdict { frames, median_offset_m, resolution_m: setup.scenario.vehicle.resolution_m }
}

fn fixed(setup: &Setup, row: &Row, record: Option<&FrameRecord>) -> Result<Fixed, &'static str> {
    let report = record.and_then(|record| record.report.as_ref());
    let Some((report, fix)) = report.and_then(|report| Some((report, report.fix?))) else {
        return Err(reason(report).unwrap_or("lost"));
    };
    let place_m = [setup.tile_centre[0] + f64::from(fix.east_m), setup.tile_centre[1] + f64::from(fix.north_m)];
    let offset_m = std::array::from_fn(|axis| place_m[axis] - row.place_m[axis]);
    Ok(Fixed {
        place_m,
        covariance_m2: [fix.variance_east_m2, fix.covariance_m2, fix.variance_north_m2].map(f64::from),
        offset_m,
        error_m: offset_m,
        rectified_rad: report.situation.map(|used| [used.pitch_rad, used.roll_rad].map(f64::from)),
        risk: probability(report.risk),
    })
}

/// Of each axis.
fn median(axes: [Vec<f64>; 2]) -> Option<[f64; 2]> {
    let [east, north] = axes.map(middle);
    Some([east?, north?])
}

fn middle(mut values: Vec<f64>) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    let count = values.len();
    (count > 0).then(|| 0.5 * (values[(count - 1) / 2] + values[count / 2]))
}

impl Verdict {
    /// The fixes, each with its frame's number.
    pub fn fixes(&self) -> impl Iterator<Item = (usize, &Fixed)> + Clone {
        self.frames.iter().enumerate().filter_map(|(index, frame)| Some((index, frame.fix.as_ref().ok()?)))
    }

    /// Whether a fix is right.
    #[must_use]
    pub fn is_right(&self, fix: &Fixed) -> bool {
        fix.off_m() <= RIGHT_PX * self.resolution_m
    }

    /// Median of the fixes' errors, metres.
    #[must_use]
    pub fn median_error_m(&self) -> Option<f64> {
        middle(self.fixes().map(|(_, fix)| fix.off_m()).collect())
    }

    /// Its figures.
    #[must_use]
    pub fn figures(&self) -> Figures {
        let accepted = self.fixes().count();
        let right = self.fixes().filter(|(_, fix)| self.is_right(fix)).count();
        let nees: f64 = self.fixes().map(|(_, fix)| fix.nees()).sum();
        let mut refused = BTreeMap::new();
        for why in self.frames.iter().filter_map(|frame| frame.fix.err()) {
            *refused.entry(why).or_insert(0) += 1;
        }
        Figures {
            frames: self.frames.len(),
            accepted,
            right,
            wrong: accepted - right,
            median_offset_m: self.median_offset_m,
            median_distance_m: middle(self.fixes().map(|(_, fix)| fix.offset_m[0].hypot(fix.offset_m[1])).collect()),
            median_error_m: self.median_error_m(),
            nees_mean: (accepted > 0).then(|| nees / accepted as f64),
            refused,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn fix(error_m: [f64; 2], covariance_m2: [f64; 3]) -> Fixed {
        Fixed { place_m: [0.0; 2], covariance_m2, offset_m: error_m, error_m, rectified_rad: None, risk: 1e-4 }
    }

    #[test]
    fn an_error_counts_in_the_sigmas_of_its_own_direction() {
        // Variances 4 and 1 along the diagonals: 2.5 each, with a covariance of 1.5.
        let along = fix([2.0f64.sqrt(), 2.0f64.sqrt()], [2.5, 1.5, 2.5]);
        let across = fix([0.5f64.sqrt(), -(0.5f64.sqrt())], [2.5, 1.5, 2.5]);
        assert!((along.nees() - 1.0).abs() < 1e-12, "{}", along.nees());
        assert!((across.nees() - 1.0).abs() < 1e-12, "{}", across.nees());
    }

    #[test]
    fn right_is_within_a_pixel_and_a_half() {
        let good = Judged { fix: Ok(fix([3.0, 0.0], [1.0, 0.0, 1.0])) };
        let bad = Judged { fix: Ok(fix([0.0, -3.1], [1.0, 0.0, 1.0])) };
        let none = Judged { fix: Err("low_score") };
        let verdict = Verdict { frames: vec![good, bad, none], median_offset_m: None, resolution_m: 2.0 };
        let figures = verdict.figures();
        assert_eq!((figures.frames, figures.accepted, figures.right, figures.wrong), (3, 2, 1, 1));
        assert_eq!(figures.refused.get("low_score"), Some(&1));
        assert!((figures.nees_mean.expect("fixes") - 0.5 * (9.0 + 3.1 * 3.1)).abs() < 1e-12);
    }

    #[test]
    fn offsets_that_turn_with_the_heading_have_a_median_length() {
        let around = |[east, north]: [f64; 2]| Judged { fix: Ok(fix([east, north], [1.0, 0.0, 1.0])) };
        let frames = [[5.0, 0.0], [-5.0, 0.0], [0.0, 5.0], [0.0, -5.0]].map(around).to_vec();
        let verdict = Verdict { frames, median_offset_m: Some([0.0; 2]), resolution_m: 2.0 };
        assert_eq!(verdict.figures().median_distance_m, Some(5.0));
        assert_eq!(verdict.figures().median_error_m, Some(5.0));
    }

    #[test]
    fn the_median_of_an_even_number_lies_between() {
        assert_eq!(median([vec![3.0, 1.0, 2.0, 10.0], vec![5.0]]), Some([2.5, 5.0]));
        assert_eq!(median([vec![], vec![]]), None);
    }
}
