//! The paper's own rules for a base, and what they leave of the overlap on the ground.

use plumbline_survey::plan::lines::Layout;
use plumbline_survey::plan::overlap::lines;
use plumbline_survey::plan::terrain::Zone;

/// Bases by a rule.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fallen {
    /// All of them.
    pub bases: usize,
    /// Those whose pair overlaps less than wanted on the ground.
    pub below: usize,
    /// The least overlap.
    pub least: f64,
}

/// The base from the highest terrain in the overlap of the nominal base, as paper 004 has it: the shorter base sees more.
#[must_use]
pub fn one_pass(layout: &Layout<'_>) -> Fallen {
    fallen(layout, &|zone| layout.terrain.highest_in(&layout.axes, zone))
}

/// As above with the mean height of the zone, the other reading of "the height of the overlap".
#[must_use]
pub fn mean_height(layout: &Layout<'_>) -> Fallen {
    fallen(layout, &|zone| {
        let dem = layout.terrain.dem();
        let place = |k: usize| {
            let (col, row) = (k % dem.cols, k / dem.cols);
            [dem.west_m + col as f64 * dem.step_m[0], dem.south_m + row as f64 * dem.step_m[1]]
        };
        let inside = |at: [f64; 2], axis: usize, range: [f64; 2]| at[axis] >= range[0] && at[axis] <= range[1];
        let heights = (0..dem.heights.len()).filter(|&k| {
            let at = layout.axes.of(place(k));
            inside(at, 0, zone.along) && inside(at, 1, zone.across)
        });
        let (count, sum) = heights.fold((0, 0.0), |(count, sum), k| (count + 1, sum + dem.heights[k]));
        (count > 0).then(|| sum / f64::from(count))
    })
}

/// Exposures along the lines of the strict plan, each base from one look at its zone.
fn fallen(layout: &Layout<'_>, height_of: &dyn Fn(&Zone) -> Option<f64>) -> Fallen {
    let mut fallen = Fallen { bases: 0, below: 0, least: f64::INFINITY };
    let [nominal_m, _] = layout.view.nominal_m(&layout.overlaps);
    let Ok(strict) = layout.variable() else { return fallen };
    for across_m in lines(&strict) {
        for [from_m, to_m] in layout.runs(across_m) {
            let mut along_m = from_m;
            while along_m < to_m {
                let height_m = height_of(&layout.view.forward_zone(along_m, nominal_m, across_m));
                let above_m = (height_m.unwrap_or(0.0) - layout.view.base_height_m).max(0.0);
                let base_m = nominal_m * (1.0 - above_m / layout.view.height_m);
                let overlap = layout.forward_overlap(across_m, along_m, base_m);
                fallen.bases += 1;
                fallen.below += usize::from(overlap < layout.overlaps.forward - 1e-9);
                fallen.least = fallen.least.min(overlap);
                along_m += base_m;
            }
        }
    }
    fallen
}
