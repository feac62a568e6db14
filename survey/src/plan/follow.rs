//! Flying heights that follow the ground.
//!
//! Wanted is a height H above the ground straight below a line. Three steps make waypoints of it. The ground's profile is taken exactly: at
//! each crossing of the line with a row or column of posts, and halfway between two of those. It is then raised until no part is steeper
//! than the climb allowed, never lowered: the least such profile above the ground is max over s' of g(s') - c |s - s'|. Of that, only the
//! points are kept without which a chord would be off by more than the tolerance (Douglas and Peucker, 1973; differences of height alone).
//! A chord of a profile that is nowhere steeper than c is not either.
//!
//! From line to line the same holds: at both ends the profile is no lower than max of g(p') - c (|ds| + |dt|) over all ground p' of the
//! block, ds along and dt across. That is nowhere steeper than c either, and a turn is longer than |ds| + |dt|.
//!
//! So the height above the ground straight below is nowhere less than H minus the tolerance, and more than H plus the tolerance only where
//! the climb allowed does not get down to the ground in time.

use super::course::{Course, Follow};
use super::lines::Layout;

impl Layout<'_> {
    /// The heights of a line's flight; level where the ground is not followed.
    #[must_use]
    pub fn course(&self, across_m: f64) -> Course {
        let Some(follow) = &self.follow else { return Course::default() };
        let [nominal_m, _] = self.view.nominal_m(&self.overlaps);
        let runs = self.runs(across_m);
        let (Some(first), Some(last)) = (runs.first(), runs.last()) else { return Course::default() };
        let (from_m, to_m) = (first[0] - follow.lead_m, last[1] + follow.lead_m);
        // The last exposure lies up to a base behind the run.
        let beyond_m = to_m + nominal_m;
        let mut profile = self.profile(across_m, [from_m, to_m]);
        profile.iter_mut().for_each(|point| point[1] -= self.view.base_height_m);
        fill(&mut profile);
        let (start_m, end_m) =
            (self.end_m(follow, across_m, [from_m; 2]), self.end_m(follow, across_m, [to_m, beyond_m]));
        let last = profile.len() - 1;
        profile[0][1] = profile[0][1].max(start_m);
        profile[last][1] = profile[last][1].max(end_m);
        profile.push([beyond_m, profile[last][1]]);
        follow.course(profile, &[0, last, last + 1])
    }

    /// The least height above the base plane at which a line may be entered or left on a part of it, so that no turn is too steep.
    fn end_m(&self, follow: &Follow, across_m: f64, [from_m, to_m]: [f64; 2]) -> f64 {
        let [nominal_m, nominal_across_m] = self.view.nominal_m(&self.overlaps);
        let [along_low, across_low, along_high, across_high] = self.area.bounds();
        let out_m = nominal_m + follow.lead_m;
        let block = [[along_low - out_m, along_high + out_m], [across_low, across_high + nominal_across_m]];
        let dem = self.terrain.dem();
        let highest_m = self.terrain.steepest_view(f64::NEG_INFINITY, &mut |first, last, highest, _| {
            let x = [first[0], last[0] + 1].map(|col| dem.west_m + col as f64 * dem.step_m[0]);
            let y = [first[1], last[1] + 1].map(|row| dem.south_m + row as f64 * dem.step_m[1]);
            let corners = [[0, 0], [0, 1], [1, 0], [1, 1]].map(|[i, j]| self.axes.of([x[i], y[j]]));
            let span = |axis: usize| {
                let all = corners.iter().map(|corner| corner[axis]);
                [all.clone().fold(f64::INFINITY, f64::min), all.fold(f64::NEG_INFINITY, f64::max)]
            };
            let (along, across) = (span(0), span(1));
            if apart_m(along, block[0]).max(apart_m(across, block[1])) > 0.0 {
                return f64::NEG_INFINITY;
            }
            highest - follow.climb * (apart_m(along, [from_m, to_m]) + apart_m(across, [across_m; 2]))
        });
        highest_m - self.view.base_height_m
    }

    /// The ground along a part of a line: positions, and heights above the height datum; NaN where it is not known.
    #[must_use]
    pub fn profile(&self, across_m: f64, [from_m, to_m]: [f64; 2]) -> Vec<[f64; 2]> {
        let dem = self.terrain.dem();
        let ([x0, y0], [u, v]) = (self.axes.point([0.0, across_m]), self.axes.along());
        let crossings = |start: f64, slope: f64, first: f64, step: f64, posts: usize| {
            let at = move |k: usize| (first + k as f64 * step - start) / slope;
            (0..if slope.abs() > 1e-12 { posts } else { 0 }).map(at)
        };
        let mut at: Vec<f64> = crossings(x0, u, dem.west_m, dem.step_m[0], dem.cols)
            .chain(crossings(y0, v, dem.south_m, dem.step_m[1], dem.rows))
            .filter(|along| (from_m..=to_m).contains(along))
            .chain([from_m, to_m])
            .collect();
        at.sort_by(f64::total_cmp);
        at.dedup_by(|a, b| *a - *b < 1e-6);
        let between: Vec<f64> = at.windows(2).map(|pair| 0.5 * (pair[0] + pair[1])).collect();
        at.extend(between);
        at.sort_by(f64::total_cmp);
        at.into_iter()
            .map(|along| {
                let [x, y] = self.axes.point([along, across_m]);
                [along, dem.height(x, y).unwrap_or(f64::NAN)]
            })
            .collect()
    }
}

/// How far two ranges are apart; 0 where they touch.
fn apart_m(one: [f64; 2], other: [f64; 2]) -> f64 {
    (one[0] - other[1]).max(other[0] - one[1]).max(0.0)
}

/// Unknown heights become those of the nearest known positions on the way, the higher of two.
fn fill(profile: &mut [[f64; 2]]) {
    let known: Vec<usize> = (0..profile.len()).filter(|k| profile[*k][1].is_finite()).collect();
    for k in 0..profile.len() {
        if !profile[k][1].is_finite() {
            let next = known.partition_point(|other| *other < k);
            let beside = [next.checked_sub(1).map(|before| known[before]), known.get(next).copied()];
            let heights = beside.into_iter().flatten().map(|other| profile[other][1]);
            profile[k][1] = heights.reduce(f64::max).unwrap_or(0.0);
        }
    }
}

#[cfg(test)]
mod tests;
