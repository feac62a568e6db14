//! The 77 combinations of overlaps, and the paper's choice among them (paper 004, section 2).

use super::cells::{Cells, Known, Summary};
use super::file::{Combination, Limit};
use super::intersect::Sigmas;
use super::lines::{Layout, Overlaps, Strip, line_count, photo_count, too_many};
use super::sight::Photos;
use crate::error::InputError;
use rayon::prelude::*;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Called with the progress of a plan: steps done, and all of them.
pub type Progress<'p> = &'p (dyn Fn(usize, usize) + Sync);

/// What a plan has to keep.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limits {
    /// Ground speed.
    pub speed_m_s: f64,
    /// Least time between two exposures.
    pub min_interval_s: f64,
    /// Largest horizontal and height accuracy; `None` is no limit.
    pub accuracy_m: Option<[f64; 2]>,
}

/// Side overlaps of 30 to 80 % and forward overlaps of 60 to 90 % in steps of 5 %: 11 times 7, ascending.
pub fn all() -> impl Iterator<Item = Overlaps> {
    (6..=16).flat_map(|side| {
        (12..=18).map(move |forward| Overlaps { forward: f64::from(forward) / 20.0, side: f64::from(side) / 20.0 })
    })
}

/// How many there are.
pub const COUNT: usize = 77;

impl Layout<'_> {
    /// All combinations over this area in ascending order, side before forward, each laid, seen and its intersections'
    /// covariances formed; none is chosen yet. `progress` is called after each, from any thread.
    ///
    /// # Errors
    /// The terrain reaches the camera.
    pub fn combinations(
        &self,
        cells: &Cells,
        sigmas: &Sigmas,
        limits: &Limits,
        progress: Progress<'_>,
    ) -> Result<Vec<Combination>, InputError> {
        let wanted: Vec<Overlaps> = all().collect();
        let done = AtomicUsize::new(0);
        let looked_at = wanted.par_iter().map(|overlaps| {
            let layout = Layout { overlaps: *overlaps, area: self.area.clone(), ..*self };
            let strips = match layout.variable() {
                Ok(strips) => strips,
                Err(error) if error == too_many() => {
                    progress(done.fetch_add(1, Ordering::Relaxed) + 1, COUNT);
                    return Ok(beyond(overlaps));
                }
                Err(error) => return Err(error),
            };
            let known = cells.known(&Photos::new(&strips, self.terrain, self.axes, &self.view), sigmas);
            progress(done.fetch_add(1, Ordering::Relaxed) + 1, COUNT);
            Ok(combination(overlaps, &strips, &known, limits))
        });
        looked_at.collect()
    }
}

/// A combination of more photos than a plan may have.
fn beyond(overlaps: &Overlaps) -> Combination {
    Combination {
        forward: overlaps.forward,
        side: overlaps.side,
        lines: 0,
        photos: 0,
        interval_min_s: 0.0,
        gaps: 0,
        plan_m: None,
        height_m: None,
        ruled_out: Some(Limit::Photos),
        chosen: false,
    }
}

fn combination(overlaps: &Overlaps, strips: &[Strip], known: &[Known], limits: &Limits) -> Combination {
    let summary = Summary::new(known);
    let gaps = known.iter().filter(|cell| cell.is_gap()).count();
    let interval_min_s = base_min_m(strips) / limits.speed_m_s;
    let accuracy_m = summary.map(|summary| summary.rms_m);
    let too_coarse = limits.accuracy_m.is_some_and(|most| {
        // What is not determined at all is no better than any limit.
        accuracy_m.is_none_or(|rms| rms[0] > most[0] || rms[1] > most[1])
    });
    let ruled_out = match () {
        () if gaps > 0 => Some(Limit::Gap),
        () if interval_min_s < limits.min_interval_s => Some(Limit::Interval),
        () if too_coarse => Some(Limit::Accuracy),
        () => None,
    };
    Combination {
        forward: overlaps.forward,
        side: overlaps.side,
        lines: line_count(strips),
        photos: photo_count(strips),
        interval_min_s,
        gaps,
        plan_m: accuracy_m.map(|rms| rms[0]),
        height_m: accuracy_m.map(|rms| rms[1]),
        ruled_out,
        chosen: false,
    }
}

/// The shortest base of any strip; infinite where no strip has two photos.
#[must_use]
pub fn base_min_m(strips: &[Strip]) -> f64 {
    let bases = strips.iter().flat_map(|strip| strip.along_m.windows(2).map(|pair| pair[1] - pair[0]));
    bases.fold(f64::INFINITY, f64::min)
}

/// The sentence for limits that leave nothing.
#[must_use]
pub fn nothing_left(combinations: &[Combination]) -> String {
    let count = |limit: Limit| combinations.iter().filter(|c| c.ruled_out == Some(limit)).count();
    let photos = match count(Limit::Photos) {
        0 => String::new(),
        many => format!(", the number of photos {many}"),
    };
    format!(
        "none of the {} combinations of overlaps is left: gaps in the coverage rule out {}, the interval between exposures {}, the accuracy {}{photos}",
        combinations.len(),
        count(Limit::Gap),
        count(Limit::Interval),
        count(Limit::Accuracy)
    )
}
