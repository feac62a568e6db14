//! Hill climbing from the candidates of the coarse ranking to the peak, and from the rivals to the second peak.

use super::Peak;
use super::evidence::{Evidence, PARTS, vertex};
use super::images::Images;
use super::parts::parts;
use crate::matching::local_maximum::{LocalMaximum, highest};
use crate::matching::search::images::ScoredShift;

/// Shifts nearer than this to a local maximum lie on its main lobe, pixels: gradients are taken over 3 x 3 pixels and smoothed over as
/// many, and noise adds local maxima on the lobe.
pub(super) const MAIN_LOBE_PX: u16 = 4;
/// Steps of a climb at most: a local maximum of the ranking is off by one or two.
const STEPS: usize = 5;
/// Local maxima off the main lobe that the whole patch scores. Chosen: with six, repetitive ground under noise as strong as itself misses
/// its second peak once in 300.
const RIVALS: usize = 12;
/// Rivals that the peak is compared with part by part: with the peak and its four neighbours an even number.
const RIVALS_BY_PART: usize = 5;
/// A rival that overtakes the peak while it climbs becomes the peak, so many times at most.
const PEAK_CHANGES: usize = 2;

/// Climbs from the best of `shifts`, and then from the best of the coarse `scores` off that peak's main lobe: where the main lobe is long,
/// a shift further along it is the rival. Overwrites the scores on the main lobe.
pub(super) fn climb(images: &Images<'_>, shifts: &[ScoredShift], radius: u16, scores: &mut [i16]) -> Option<Peak> {
    let mut top = climbed(images, shifts.iter().copied().reduce(higher_of)?, radius, scores, |_| true);
    let mut rivals = [ScoredShift::default(); RIVALS];
    let mut count = 0;
    let mut former = None;
    for _ in 0..PEAK_CHANGES {
        count = rivals_into(images, &top, radius, scores, &mut rivals);
        if let (Some(former), Some(last)) = (former, rivals.last_mut()) {
            (*last, count) = (former, RIVALS);
        }
        let rivals = rivals.get_mut(..count).unwrap_or(&mut []);
        let Some((second, others)) = rivals.split_first_mut() else { break };
        for other in others {
            if other.score > second.score {
                core::mem::swap(other, second);
            }
        }
        *second = climbed(images, *second, radius, scores, |shift| is_apart(&top, shift));
        if second.score <= top.score {
            break;
        }
        former = Some(core::mem::replace(&mut top, *second));
    }
    let rivals = rivals.get(..count).unwrap_or(&[]);
    Some(with_evidence(images, &top, rivals, radius))
}

/// The local maximum that a climb from a shift ends at, over shifts that are `allowed`.
fn climbed(
    images: &Images<'_>,
    mut top: ScoredShift,
    radius: u16,
    scores: &[i16],
    allowed: impl Fn(&ScoredShift) -> bool,
) -> ScoredShift {
    for _ in 0..STEPS {
        let mut asked = around(top, 2 * radius, scores);
        images.score(&mut asked);
        let higher = asked.into_iter().filter(|shift| allowed(shift)).fold(top, higher_of);
        if higher.apart(&top) == 0 {
            break;
        }
        top = higher;
    }
    top
}

/// Scores the highest local maxima of the coarse scores off the main lobe by the whole patch; returns how many.
fn rivals_into(
    images: &Images<'_>,
    top: &ScoredShift,
    radius: u16,
    scores: &mut [i16],
    rivals: &mut [ScoredShift; RIVALS],
) -> usize {
    let side = 2 * radius as usize + 1;
    let lobe = MAIN_LOBE_PX - 1;
    let (left, right) = (top.col.saturating_sub(lobe) as usize, (top.col + lobe) as usize + 1);
    for row in top.row.saturating_sub(lobe) as usize..=((top.row + lobe) as usize).min(side - 1) {
        if let Some(line) = scores.get_mut(row * side + left..row * side + right.min(side)) {
            line.fill(i16::MIN);
        }
    }
    let mut buffer = [LocalMaximum::default(); RIVALS];
    let maxima = highest(scores, (side, side), |&score| score, &mut buffer);
    let is_apart = |shift: &ScoredShift| shift.apart(top) >= MAIN_LOBE_PX;
    let found = maxima.iter().map(|maximum| ScoredShift::new(maximum.col, maximum.row)).filter(is_apart);
    *rivals = [ScoredShift::default(); RIVALS];
    let mut count = 0;
    for (rival, shift) in rivals.iter_mut().zip(found) {
        *rival = shift;
        count += 1;
    }
    images.score(rivals);
    count
}

/// Neighbours of a shift: left, right, above, below, and a corner twice, since shifts are scored in pairs.
type Neighbours = [ScoredShift; 6];

/// The four neighbours of a shift and, of its four corners, the one of the highest coarse score. Clamped to the search.
fn around(shift: ScoredShift, last: u16, scores: &[i16]) -> Neighbours {
    let beside = |by| step(&shift, by, last);
    let rank = |&(col, row): &(u16, u16)| scores.get(row as usize * (last as usize + 1) + col as usize);
    let corner = [(0, 0), (2, 0), (0, 2), (2, 2)].map(beside).into_iter().max_by_key(rank).unwrap_or_default();
    let [left, right, above, below] = SIDES.map(beside);
    [left, right, above, below, corner, corner].map(|(col, row)| ScoredShift::new(col, row))
}

/// Steps to the left, right, up and down, each plus one.
const SIDES: [(u16, u16); 4] = [(0, 1), (2, 1), (1, 0), (1, 2)];

fn step(shift: &ScoredShift, (cols, rows): (u16, u16), last: u16) -> (u16, u16) {
    let step = |at: u16, by: u16| (at + by).saturating_sub(1).min(last);
    (step(shift.col, cols), step(shift.row, rows))
}

/// Whether a shift lies off the peak's main lobe.
fn is_apart(top: &ScoredShift, shift: &ScoredShift) -> bool {
    shift.apart(top) >= MAIN_LOBE_PX
}

/// The peak with its statistics against its rivals, highest first.
fn with_evidence(images: &Images<'_>, top: &ScoredShift, rivals: &[ScoredShift], radius: u16) -> Peak {
    let last = 2 * radius;
    let mut asked = [(top.col, top.row); 1 + SIDES.len() + RIVALS_BY_PART];
    let [_, left, right, above, below, others @ ..] = &mut asked;
    let beside = [left, right, above, below].into_iter().zip(SIDES.map(|by| step(top, by, last)));
    let others = others.iter_mut().zip(rivals.iter().map(|rival| (rival.col, rival.row)));
    beside.chain(others).for_each(|(asked, shift)| *asked = shift);
    let [own, left, right, above, below, others @ ..] = parts(images, &asked);
    let mut evidence = Evidence::new(&own, others.get(..rivals.len().min(RIVALS_BY_PART)).unwrap_or(&[]));
    let beside = [left, right, above, below];
    let sum = |shares: &[f32; PARTS]| shares.iter().sum::<f32>();
    evidence.curvature = 4.0 * evidence.score - beside.iter().map(sum).sum::<f32>();
    let on_border = [top.col, top.row].iter().any(|&at| at == 0 || at == last);
    let (vertex, covariance) = if on_border { Default::default() } else { vertex(&own, &beside) };
    let centred = |shift: &ScoredShift| (shift.col as i16 - radius as i16, shift.row as i16 - radius as i16);
    let (d_col, d_row) = centred(top);
    let second = rivals.first();
    Peak {
        d_col,
        d_row,
        score: top.score,
        second: second.map_or(0.0, |second| second.score.max(0.0)),
        second_at: second.map_or((d_col, d_row), centred),
        vertex,
        covariance,
        on_border,
        evidence,
    }
}

fn higher_of(a: ScoredShift, b: ScoredShift) -> ScoredShift {
    if b.score > a.score { b } else { a }
}
