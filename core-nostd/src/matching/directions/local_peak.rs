//! The local peak of a patch's scores near a shift, without a search.

use super::evidence::{self, PARTS};
use super::images::Images;
use super::parts::parts;
use crate::matching::local_maximum::vertex;
use crate::matching::search::images::ScoredShift;
use heapless::Vec;
use nalgebra::Matrix2;

/// A local maximum, pixels from the centre of the search.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LocalPeak {
    /// Columns to the right.
    pub d_col: i16,
    /// Rows downwards.
    pub d_row: i16,
    /// Sub-pixel position by parabolas through the score and its neighbours, columns and rows from the centre of the search.
    pub top: (f32, f32),
    /// Four times its score less its four neighbours.
    pub curvature: f32,
}

/// Shifts to the left, right, above and below.
const SIDES: [(i16, i16); 4] = [(-1, 0), (1, 0), (0, -1), (0, 1)];

/// Climbs from a shift, pixels from the centre of a search of ±`radius`, to its local maximum, at most `within_px` away along either axis;
/// `None` where there is none so near, or not within the search.
pub(super) fn near(images: &Images<'_>, from: (i16, i16), within_px: u16, radius: u16) -> Option<LocalPeak> {
    let mut at = from;
    let reach = radius.saturating_sub(1);
    let is_allowed = |at: (i16, i16)| {
        at.0.unsigned_abs().max(at.1.unsigned_abs()) <= reach
            && at.0.abs_diff(from.0).max(at.1.abs_diff(from.1)) <= within_px
    };
    let mut known = [None; 5];
    for _ in 0..=2 * within_px {
        if !is_allowed(at) {
            return None;
        }
        let around = SIDES.map(|(col, row)| (at.0 + col, at.1 + row));
        let [left, right, above, below] = around;
        let scores = scored(images, [at, left, right, above, below], &known, radius);
        let [own, beside @ ..] = scores;
        let [of_left, of_right, of_above, of_below] = beside;
        known = [(at, own), (left, of_left), (right, of_right), (above, of_above), (below, of_below)].map(Some);
        match beside.into_iter().zip(around).reduce(|best, next| if next.0 > best.0 { next } else { best }) {
            Some((score, next)) if score > own => at = next,
            _ => return Some(local_peak(at, own, beside)),
        }
    }
    None
}

/// A shift, pixels from the centre, as an index into a search of ±`radius`.
fn counted((col, row): (i16, i16), radius: u16) -> ScoredShift {
    let at = |at: i16| (at + radius as i16).max(0) as u16;
    ScoredShift::new(at(col), at(row))
}

/// A shift and its score.
type Known = ((i16, i16), f32);

/// Scores of five shifts, some of them known.
fn scored(images: &Images<'_>, at: [(i16, i16); 5], known: &[Option<Known>; 5], radius: u16) -> [f32; 5] {
    let known = |at: &(i16, i16)| known.iter().flatten().find(|known| known.0 == *at).map(|known| known.1);
    let mut shifts: Vec<ScoredShift, 5> = Vec::new();
    for at in at.iter().filter(|at| known(at).is_none()) {
        // There is room.
        let _ = shifts.push(counted(*at, radius));
    }
    images.score(&mut shifts);
    let mut scores = shifts.iter().map(|shift| shift.score);
    at.map(|at| known(&at).or_else(|| scores.next()).unwrap_or_default())
}

fn local_peak((d_col, d_row): (i16, i16), own: f32, [left, right, above, below]: [f32; 4]) -> LocalPeak {
    LocalPeak {
        d_col,
        d_row,
        top: (d_col as f32 + vertex(left, own, right), d_row as f32 + vertex(above, own, below)),
        curvature: 4.0 * own - left - right - above - below,
    }
}

/// Jackknife covariance of its sub-pixel position over the parts of the patch, square pixels.
pub(super) fn covariance(images: &Images<'_>, peak: &LocalPeak, radius: u16) -> Matrix2<f32> {
    let at = |(col, row)| {
        let shift = counted((peak.d_col + col, peak.d_row + row), radius);
        (shift.col, shift.row)
    };
    let [left, right, above, below] = SIDES.map(at);
    let own = at((0, 0));
    let [own, left, right, above, below, _]: [[f32; PARTS]; 6] = parts(images, &[own, left, right, above, below, own]);
    evidence::vertex(&own, &[left, right, above, below]).1
}
