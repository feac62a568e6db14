//! Evidence for each place where the nadir may be.

use super::CAP;
use super::top::Top;
use crate::matching::directions::half::{MIDDLE, SHIFTS, Scores};
use crate::math::squared;

/// Evidence for which the odds change by a factor of e, about: the slope of the risk's log-odds where a surface is half decided.
const NAT: f32 = 20.0;
/// Evidence against a place beyond which it does not matter how much there is.
const LOWEST: f32 = -400.0;
/// Least [widening](Places::widen), one sigma, shifts: a place beside costs more than it can have. Chosen.
pub(super) const DRIFT_MIN: f32 = 0.1;

/// Evidence of every shift, and of all that lies beyond.
#[derive(Clone, Copy, Debug)]
pub(super) struct Places {
    pub evidence: Scores,
    /// That of a place which no frame has looked at.
    unseen: f32,
}

impl Places {
    /// Nothing known.
    pub const fn new() -> Self {
        Places { evidence: [[0.0; SHIFTS]; SHIFTS], unseen: 0.0 }
    }

    /// What the navigation says: so many steps (columns, rows) off the middle, one sigma of each axis, steps; 0 where it does not say. It has no
    /// more weight than a piece of ground.
    pub fn expected((col, row): (f32, f32), sigma: f32) -> Self {
        let cost = if sigma > 0.0 { 0.5 * NAT / squared(sigma) } else { 0.0 };
        let of = |at: usize, off: f32| squared(at as f32 - MIDDLE as f32 - off);
        let against = |at_row, at_col| (-cost * (of(at_col, col) + of(at_row, row))).max(-CAP);
        let evidence = core::array::from_fn(|row| core::array::from_fn(|col| against(row, col)));
        Places { evidence, unseen: if cost > 0.0 { -CAP } else { 0.0 } }
    }

    /// Moves all of it by so many shifts to the right and downwards.
    pub fn shift(&mut self, cols: i16, rows: i16) {
        shift(&mut self.evidence, self.unseen, (cols, rows));
    }

    /// Only such a share of all evidence is left.
    pub fn fade(&mut self, share: f32) {
        self.evidence.as_flattened_mut().iter_mut().chain([&mut self.unseen]).for_each(|own| *own *= share);
    }

    /// Each place takes over from the one that is worth most less what the way from there costs; `sigma`: of the way, each axis, steps.
    pub fn widen(&mut self, sigma: f32) {
        let cost = 0.5 * NAT / squared(sigma);
        let best = |line: &[f32; SHIFTS], at: usize| {
            let from = line.iter().enumerate().map(|(from, own)| own - cost * squared(from as f32 - at as f32));
            from.fold(f32::MIN, f32::max)
        };
        for line in self.evidence.iter_mut() {
            let before = *line;
            *line = core::array::from_fn(|at| best(&before, at));
        }
        for col in 0..SHIFTS {
            let before: [f32; SHIFTS] = core::array::from_fn(|row| self.evidence[row][col]);
            for (row, line) in self.evidence.iter_mut().enumerate() {
                line[col] = best(&before, row);
            }
        }
    }

    /// Adds scores of which 1 is so much evidence and `top` the highest.
    pub fn add(&mut self, scores: &Scores, weight: f32, top: f32) {
        let least = weight * top - CAP;
        let of = |score: f32| (weight * score).max(least);
        for (own, score) in self.evidence.as_flattened_mut().iter_mut().zip(scores.as_flattened()) {
            *own += of(*score);
        }
        self.unseen += of(0.0);
    }

    /// Evidence against every place further than `within` steps from one, (column, row).
    pub fn hold(&mut self, evidence: f32, (col, row): (f32, f32), within: f32) {
        for (line, at) in self.evidence.iter_mut().zip(0..) {
            for (own, beside) in line.iter_mut().zip(0..) {
                if (at as f32 - row).abs().max((beside as f32 - col).abs()) > within {
                    *own -= evidence;
                }
            }
        }
        self.unseen -= evidence;
    }

    /// The highest is 0, and what lies far below no lower than it must; where the highest is.
    pub fn settle(&mut self) -> Top {
        let top = Top::of(&self.evidence);
        for own in self.evidence.as_flattened_mut().iter_mut().chain([&mut self.unseen]) {
            *own = (*own - top.score).max(LOWEST);
        }
        Top { score: 0.0, ..top }
    }

    /// The highest, and the evidence of what is away from it.
    pub fn highest(&self) -> (Top, f32) {
        let top = Top::of(&self.evidence);
        (top, top.second(&self.evidence).max(self.unseen))
    }
}

/// Places that are put by, in half the memory: to a 64th, of what settled places have.
#[derive(Clone, Copy, Debug)]
pub(super) struct Kept {
    evidence: [[i16; SHIFTS]; SHIFTS],
    unseen: i16,
}

/// Steps of what is kept: −[`LOWEST`] less than twice fits.
const KEPT: f32 = 64.0;

impl Kept {
    /// Nothing known.
    pub const fn new() -> Self {
        Kept { evidence: [[0; SHIFTS]; SHIFTS], unseen: 0 }
    }

    /// Of places.
    pub fn of(places: &Places) -> Self {
        let of = |evidence: f32| (KEPT * evidence) as i16;
        Kept { evidence: places.evidence.map(|line| line.map(of)), unseen: of(places.unseen) }
    }

    /// As they were.
    pub fn places(&self) -> Places {
        let of = |kept: i16| f32::from(kept) / KEPT;
        Places { evidence: self.evidence.map(|line| line.map(of)), unseen: of(self.unseen) }
    }

    /// As [`Places::shift`].
    pub fn shift(&mut self, cols: i16, rows: i16) {
        shift(&mut self.evidence, self.unseen, (cols, rows));
    }
}

fn shift<T: Copy>(evidence: &mut [[T; SHIFTS]; SHIFTS], unseen: T, (cols, rows): (i16, i16)) {
    let from = |at: usize, by: i16| usize::try_from(at as i16 - by).ok();
    let before = *evidence;
    for (row, line) in evidence.iter_mut().enumerate() {
        for (col, own) in line.iter_mut().enumerate() {
            let place = from(row, rows).and_then(|row| before.get(row)?.get(from(col, cols)?));
            *own = place.copied().unwrap_or(unseen);
        }
    }
}
