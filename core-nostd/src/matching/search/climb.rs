//! From the candidates to the peaks of the two best of them.

use super::Peak;
use super::images::{Images, ScoredShift};
use crate::matching::local_maximum::{MAIN_LOBE_PX, vertex};

/// Share of the highest score from which the second shift climbs: values a pixel apart correlate by a half, so that one
/// with a quarter at the candidate has no peak that comes near.
const RIVAL_SHARE: f32 = 0.25;
/// Most steps to the peak: a local maximum of the ranking is off by one or two.
const STEPS: usize = 5;

/// Neighbours of a shift: left, right, above, below and a corner, twice since shifts are scored in pairs.
type Neighbours = [ScoredShift; 6];

/// Climbs from the two best of `shifts`. The second stays off the first's main lobe: otherwise a row of trees whose
/// other local maximum the ranking put a pixel off would seem to lead.
pub(super) fn climb(images: &Images<'_>, shifts: &[ScoredShift], radius: u16, scores: &[i16]) -> Option<Peak> {
    let mut top = shifts.iter().copied().reduce(better)?;
    let mut second = shifts.iter().copied().filter(|shift| is_apart(&top, shift)).reduce(better);
    let mut near = [Neighbours::default(); 2];
    let is_rival = |second: ScoredShift| second.score >= RIVAL_SHARE * top.score;
    let mut moved = (true, second.is_some_and(is_rival));
    for _ in 0..STEPS {
        let asked = match moved {
            (true, true) => near.as_mut_slice(),
            (true, false) => &mut near[..1],
            (false, true) => &mut near[1..],
            (false, false) => break,
        };
        if moved.0 {
            asked[0] = around(top, 2 * radius, scores);
        }
        if let (true, Some(second), Some(last)) = (moved.1, second, asked.last_mut()) {
            *last = around(second, 2 * radius, scores);
        }
        images.score(asked.as_flattened_mut());
        let higher = near[0].iter().copied().fold(top, better);
        let beside = second.map(|second| near[1].iter().copied().filter(|p| is_apart(&higher, p)).fold(second, better));
        let beside = beside.filter(|shift| is_apart(&higher, shift));
        moved = (higher.apart(&top) > 0, beside.zip(second).is_some_and(|(now, before)| now.apart(&before) > 0));
        (top, second) = (higher, beside);
        if let Some(overtaken) = second.as_mut().filter(|second| second.score > top.score) {
            core::mem::swap(&mut top, overtaken);
            near.swap(0, 1);
            moved = (moved.1, moved.0);
        }
    }
    // Only the neighbours of the peak itself determine its sub-pixel position.
    Some(peak(&top, second, (!moved.0).then_some(&near[0]), radius))
}

/// Whether a shift lies off the peak's main lobe and has a positive score.
fn is_apart(top: &ScoredShift, shift: &ScoredShift) -> bool {
    shift.apart(top) >= MAIN_LOBE_PX as u16 && shift.score > 0.0
}

/// The neighbours of a shift, with the corner that the ranking has highest. At the border the nearest shift replaces
/// one beyond.
fn around(shift: ScoredShift, last: u16, scores: &[i16]) -> Neighbours {
    let step = |at: u16, step: u16| (at + step).saturating_sub(1).min(last);
    let beside = |(cols, rows)| (step(shift.col, cols), step(shift.row, rows));
    let rank = |&(col, row): &(u16, u16)| scores.get(row as usize * (last as usize + 1) + col as usize);
    let corner = [(0, 0), (2, 0), (0, 2), (2, 2)].map(beside).into_iter().max_by_key(rank).unwrap_or_default();
    let [left, right, above, below] = [(0, 1), (2, 1), (1, 0), (1, 2)].map(beside);
    [left, right, above, below, corner, corner].map(|(col, row)| ScoredShift::new(col, row))
}

fn peak(top: &ScoredShift, second: Option<ScoredShift>, around: Option<&Neighbours>, radius: u16) -> Peak {
    let centred = |shift: &ScoredShift| (shift.col as i16 - radius as i16, shift.row as i16 - radius as i16);
    let (d_col, d_row) = centred(top);
    let on_border = [top.col, top.row].iter().any(|&at| at == 0 || at == 2 * radius);
    let vertex = |[before, behind]: [&ScoredShift; 2]| vertex(before.score, top.score, behind.score);
    Peak {
        d_col,
        d_row,
        score: top.score,
        second: second.map_or(0.0, |second| second.score),
        second_at: second.as_ref().map_or((d_col, d_row), centred),
        vertex: match around {
            Some([left, right, above, below, ..]) if !on_border => (vertex([left, right]), vertex([above, below])),
            _ => (0.0, 0.0),
        },
        on_border,
    }
}

fn better(a: ScoredShift, b: ScoredShift) -> ScoredShift {
    if b.score > a.score { b } else { a }
}
