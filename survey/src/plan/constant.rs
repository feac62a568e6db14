//! The cheapest constant bases that guarantee the overlap, to hold the variable ones against.
//!
//! What a constant base costs is whole lines and photos. So for each number of lines, from the least on, the shortest
//! distance with which they still reach the area's end is tried: a longer one with as many lines overlaps less. The same
//! along the strips, where one base serves all of them.

use super::course::Course;
use super::lines::{END_M, Layout, Strip, too_many};
use crate::error::InputError;

/// More lines, and more photos in a strip, than any plan has.
const COUNT_MAX: usize = 500_000;

/// A nominal base over level ground overlaps as wished, but for rounding.
const ROUNDING: f64 = 1e-12;

/// Strips of one distance with exposures of one base.
#[derive(Debug, Clone, PartialEq)]
pub struct Constant {
    /// Base along the strips.
    pub base_m: f64,
    /// Distance of the strips.
    pub spacing_m: f64,
    /// The strips.
    pub strips: Vec<Strip>,
}

impl Layout<'_> {
    /// Strips as they would be at one flying height.
    pub(super) fn level(&self) -> Self {
        Layout { area: self.area.clone(), follow: None, ..*self }
    }

    /// The cheapest that has the wanted overlap everywhere on the ground.
    ///
    /// # Errors
    /// The terrain reaches the camera; more than half a million photos.
    pub fn constant(&self) -> Result<Constant, InputError> {
        let [nominal_base_m, nominal_spacing_m] = self.view.nominal_m(&self.overlaps);
        let [first_m, last_m] = self.across_m();
        let lines_of = |count: usize, spacing_m: f64| (0..count).map(move |line| first_m + line as f64 * spacing_m);
        let spacing_m = cheapest(last_m - first_m, nominal_spacing_m, |count, spacing_m| {
            let mut pairs = lines_of(count - 1, spacing_m);
            pairs.all(|across_m| self.side_overlap(across_m, spacing_m) >= self.overlaps.side - ROUNDING)
        })?;
        let count = steps(last_m - first_m, spacing_m) + 1;
        // Before and after the area lies one base of its own, which is shorter than the nominal one.
        let inside = |[from, to]: [f64; 2]| [from + nominal_base_m, to - nominal_base_m];
        let runs_of = |across_m: f64| self.runs(across_m).into_iter().map(inside);
        let runs: Vec<(usize, f64, [f64; 2])> = lines_of(count, spacing_m)
            .enumerate()
            .flat_map(|(line, across_m)| runs_of(across_m).map(move |run| (line, across_m, run)))
            .collect();
        // The longest run decides: where it holds with a base, the others have no more photos than they need of it.
        let longest_m = runs.iter().map(|(_, _, [from, to])| to - from).fold(0.0, f64::max);
        let base_m = cheapest(longest_m, nominal_base_m, |_, base_m| {
            runs.iter().all(|(_, across_m, run)| {
                exposures(*run, base_m)
                    .all(|along_m| self.forward_overlap(*across_m, along_m, base_m) >= self.overlaps.forward - ROUNDING)
            })
        })?;
        let strips = runs.into_iter().map(|(line, across_m, run)| {
            let mut along_m: Vec<f64> = exposures(run, base_m).collect();
            along_m.extend(along_m.last().map(|last| last + base_m));
            Strip { line, across_m, along_m, course: Course::default() }
        });
        let strips = strips.collect();
        Ok(Constant { base_m, spacing_m, strips })
    }
}

/// Steps of `step_m` that it takes to go `length_m`.
fn steps(length_m: f64, step_m: f64) -> usize {
    ((length_m - END_M) / step_m).ceil().max(0.0) as usize
}

/// Exposures of a run, a base before its start, all but the last, which lies a base or more beyond its end.
fn exposures([from_m, to_m]: [f64; 2], base_m: f64) -> impl Iterator<Item = f64> {
    (0..steps(to_m - from_m, base_m) + 2).map(move |photo| from_m + (photo as f64 - 1.0) * base_m)
}

/// The step of the fewest positions over a length for which `holds` says that it does, tried from the nominal one down.
fn cheapest(length_m: f64, nominal_m: f64, holds: impl Fn(usize, f64) -> bool) -> Result<f64, InputError> {
    if length_m <= 0.0 {
        return Ok(nominal_m);
    }
    let mut count = steps(length_m, nominal_m).max(1);
    while count < COUNT_MAX {
        let step_m = (length_m / count as f64).min(nominal_m);
        if holds(count + 1, step_m) {
            return Ok(step_m);
        }
        count += 1;
    }
    Err(too_many())
}
