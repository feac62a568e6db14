//! The cheapest constant bases that guarantee the overlap, to hold the variable ones against.
//!
//! What a constant base costs is whole lines and photos. So for each number of lines, from the least on, the shortest
//! distance with which they still reach the area's end is tried: a longer one with as many lines overlaps less. The same
//! along the strips, where one base serves all of them.
//!
//! Most of those need not be looked at. A step of at most half a footprint leaves no ground between the zones of neighbouring pairs, so that
//! each piece of ground in the block is in the zone of one of them, and its highest is a limit for this step and all shorter ones. Where the
//! ground reaches the flying height, none is short enough.

use super::course::Course;
use super::lines::{END_M, Layout, Strip, too_many};
use super::terrain::Zone;
use crate::error::InputError;

/// More lines, and more photos in a strip, than any plan has.
const COUNT_MAX: usize = 500_000;

/// A nominal base over level ground overlaps as wished, but for rounding.
const ROUNDING: f64 = 1e-12;

/// What a limit of steps may be off by, as a share: they are tried from a little longer ones on.
const LIMIT_ROUNDING: f64 = 1e-9;

/// Most places across at which the highest ground is looked for.
const PLACES_MAX: f64 = 1000.0;

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
        let holds = |count: usize, spacing_m: f64| {
            let mut pairs = lines_of(count - 1, spacing_m);
            pairs.all(|across_m| self.side_overlap(across_m, spacing_m) >= self.overlaps.side - ROUNDING)
        };
        let spacing_m = cheapest(last_m - first_m, nominal_spacing_m, holds, |step_m| self.spacing_most_m(step_m))?;
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
        let holds = |_, base_m: f64| {
            runs.iter().all(|(_, across_m, run)| {
                exposures(*run, base_m)
                    .all(|along_m| self.forward_overlap(*across_m, along_m, base_m) >= self.overlaps.forward - ROUNDING)
            })
        };
        let base_m = cheapest(longest_m, nominal_base_m, holds, |step_m| self.base_most_m(&runs, step_m))?;
        let strips = runs.into_iter().map(|(line, across_m, run)| {
            let mut along_m: Vec<f64> = exposures(run, base_m).collect();
            along_m.extend(along_m.last().map(|last| last + base_m));
            Strip { line, across_m, along_m, course: Course::default() }
        });
        let strips = strips.collect();
        Ok(Constant { base_m, spacing_m, strips })
    }

    /// No distance of lines up to `step_m` that keeps the side overlap is longer than this.
    ///
    /// The zones of pairs of lines reach from half a footprint, less a step, before the first line as far behind the last. Along, those of the
    /// pairs around a place reach as far as the runs that all of these pairs see, half a footprint longer at both ends.
    fn spacing_most_m(&self, step_m: f64) -> f64 {
        let [half_along_m, half_m] = self.view.footprint_m.map(|side| 0.5 * side);
        if step_m > half_m {
            return f64::INFINITY;
        }
        let [first_m, last_m] = self.across_m();
        let [_, nominal_m] = self.view.nominal_m(&self.overlaps);
        let (from_m, to_m) = (first_m - half_m + step_m, last_m + half_m - step_m);
        let cell_m = self.terrain.dem().step_m.into_iter().fold(f64::INFINITY, f64::min);
        let places = ((to_m - from_m) / cell_m).ceil().clamp(1.0, PLACES_MAX);
        let highest_at = |place: f64| {
            let across_m = from_m + (to_m - from_m) * place / places;
            let seen = if across_m > last_m {
                [last_m - half_m, last_m]
            } else {
                [across_m.max(first_m), across_m.max(first_m) + nominal_m]
            };
            let runs = self.beyond(self.area.ranges(seen));
            let along = [runs.first()?[0] - half_along_m, runs.last()?[1] + half_along_m];
            self.terrain.highest_in(&self.axes, &Zone { along, across: [across_m; 2] })
        };
        let highest_m = (0..=places as usize).filter_map(|place| highest_at(place as f64)).reduce(f64::max);
        self.most_m(1, self.overlaps.side, highest_m)
    }

    /// No base up to `step_m` that keeps the forward overlap on all runs is longer than this: the zones of a run's pairs reach half a footprint
    /// beyond it.
    fn base_most_m(&self, runs: &[(usize, f64, [f64; 2])], step_m: f64) -> f64 {
        let [half_m, half_across_m] = self.view.footprint_m.map(|side| 0.5 * side);
        if step_m > half_m {
            return f64::INFINITY;
        }
        let highest_in = |(_, across_m, [from_m, to_m]): &(usize, f64, [f64; 2])| {
            let (along, across) =
                ([from_m - half_m, to_m + half_m], [across_m - half_across_m, across_m + half_across_m]);
            self.terrain.highest_in(&self.axes, &Zone { along, across })
        };
        let highest_m = runs.iter().filter_map(highest_in).reduce(f64::max);
        self.most_m(0, self.overlaps.forward, highest_m)
    }

    /// The longest step along an axis that keeps an overlap over ground of a height, and a little more; 0 where none does.
    fn most_m(&self, axis: usize, overlap: f64, highest_m: Option<f64>) -> f64 {
        let share = 1.0 - highest_m.map_or(0.0, |highest| highest - self.view.base_height_m) / self.view.height_m;
        (self.view.footprint_m[axis] * share * (1.0 - overlap + ROUNDING) * (1.0 + LIMIT_ROUNDING)).max(0.0)
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

/// The step of the fewest positions over a length for which `holds` says that it does, tried from the nominal one down. `most_m` is asked now
/// and then how long one can be at most, of those no longer than the one that it is asked with.
fn cheapest(
    length_m: f64,
    nominal_m: f64,
    holds: impl Fn(usize, f64) -> bool,
    most_m: impl Fn(f64) -> f64,
) -> Result<f64, InputError> {
    if length_m <= 0.0 {
        return Ok(nominal_m);
    }
    let mut count = steps(length_m, nominal_m).max(1);
    let mut asked_m = f64::INFINITY;
    while count < COUNT_MAX {
        let step_m = (length_m / count as f64).min(nominal_m);
        if holds(count + 1, step_m) {
            return Ok(step_m);
        }
        count += 1;
        // Shorter steps have larger zones: the limit falls.
        if step_m < 0.5 * asked_m {
            let limit_m = most_m(step_m);
            asked_m = if limit_m.is_finite() { step_m } else { asked_m };
            count = count.max(if limit_m > 0.0 { steps(length_m, limit_m) } else { COUNT_MAX });
        }
    }
    Err(too_many())
}

#[cfg(test)]
mod tests {
    use super::super::area::Area;
    use super::super::axes::Axes;
    use super::super::lines::{Overlaps, View};
    use super::super::terrain::Terrain;
    use super::*;
    use crate::dem::Dem;

    /// A block of 800 x 700 m, askew, footprints of 400 x 500 m from 300 m above a base plane at 100 m.
    fn layout<'t>(terrain: &'t Terrain<'t>, overlaps: Overlaps) -> Layout<'t> {
        let axes = Axes::new(37.0);
        let corners = [[0.0, 0.0], [800.0, 0.0], [700.0, 700.0], [300.0, 400.0]].map(|corner| axes.of(corner));
        let area = Area::new(&corners).expect("an area");
        let view = View { height_m: 300.0, base_height_m: 100.0, footprint_m: [400.0, 500.0] };
        Layout { terrain, axes, area, view, overlaps, follow: None }
    }

    /// Bases and distances as they are found without any limit.
    fn one_by_one(layout: &Layout<'_>) -> f64 {
        let [first_m, last_m] = layout.across_m();
        let holds = |count: usize, spacing_m: f64| {
            (0..count - 1).all(|line| {
                let across_m = first_m + line as f64 * spacing_m;
                layout.side_overlap(across_m, spacing_m) >= layout.overlaps.side - ROUNDING
            })
        };
        cheapest(last_m - first_m, layout.view.nominal_m(&layout.overlaps)[1], holds, |_| f64::INFINITY).expect("one")
    }

    #[test]
    fn limits_leave_out_nothing_that_holds() {
        let mut askew = 0;
        for (k, top_m) in [20.0, 150.0, 240.0, 290.0].into_iter().enumerate() {
            // A peak inside the block, on its edge and beyond it.
            for [x0, y0] in [[500.0, 300.0], [0.0, 0.0], [-120.0, 200.0], [900.0, 500.0]] {
                let peak = |x: f64, y: f64| 100.0 + top_m * (-((x - x0).powi(2) + (y - y0).powi(2)) / 1e4).exp();
                let dem = Dem::from_fn((120, 120), [-700.0, -700.0], [20.0; 2], peak);
                let terrain = Terrain::new(&dem);
                for overlaps in [Overlaps { forward: 0.6, side: 0.3 }, Overlaps { forward: 0.8, side: 0.7 }] {
                    let layout = layout(&terrain, overlaps);
                    let found = layout.constant().expect("a constant base");
                    assert_eq!(found.spacing_m, one_by_one(&layout), "{top_m} m at {x0}, {y0}");
                    let limit_m = layout.spacing_most_m(found.spacing_m);
                    assert!(limit_m >= found.spacing_m, "{limit_m} {}", found.spacing_m);
                    askew += usize::from(limit_m.is_finite() && k > 1);
                }
            }
        }
        assert!(askew > 4, "{askew} limits");
    }

    #[test]
    fn ground_above_the_flying_height_is_seen_at_once() {
        let dem = Dem::from_fn((120, 120), [-700.0, -700.0], [20.0; 2], |x, _| if x == 500.0 { 450.0 } else { 100.0 });
        let terrain = Terrain::new(&dem);
        let tried = std::cell::Cell::new(0);
        let layout = layout(&terrain, Overlaps { forward: 0.6, side: 0.3 });
        let holds = |_, _| {
            tried.set(tried.get() + 1);
            false
        };
        assert!(cheapest(800.0, 350.0, holds, |step_m| layout.spacing_most_m(step_m)).is_err());
        assert!(tried.get() < 10 && layout.constant().is_err(), "{} tried", tried.get());
    }
}
