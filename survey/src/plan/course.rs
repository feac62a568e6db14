//! How high a strip is flown, from waypoint to waypoint.

/// Waypoints along a line: position along, and height above the level flying height (the base plane's plus H), which is flown where there
/// are none. Between two of them the height changes evenly; before the first and behind the last it stays.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Course(Vec<[f64; 2]>);

impl Course {
    /// Through points whose positions ascend.
    #[must_use]
    pub fn through(points: Vec<[f64; 2]>) -> Self {
        Course(points)
    }

    /// Whether all of it is at the level flying height.
    #[must_use]
    pub fn is_level(&self) -> bool {
        self.0.is_empty()
    }

    /// Height above the level flying height.
    #[must_use]
    pub fn rise_m(&self, along_m: f64) -> f64 {
        height_at(&self.0, along_m)
    }

    /// Least and greatest height above the level flying height on a part of the way.
    #[must_use]
    pub fn range_m(&self, [from_m, to_m]: [f64; 2]) -> [f64; 2] {
        let ends = [self.rise_m(from_m), self.rise_m(to_m)];
        let within = self.between(from_m, to_m).iter().map(|[_, rise]| *rise);
        within.chain(ends).fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], rise| [low.min(rise), high.max(rise)])
    }

    /// The waypoints strictly between two positions, ascending.
    #[must_use]
    pub fn between(&self, from_m: f64, to_m: f64) -> &[[f64; 2]] {
        let first = self.0.partition_point(|[at, _]| *at <= from_m);
        let end = self.0.partition_point(|[at, _]| *at < to_m);
        &self.0[first..end.max(first)]
    }

    /// The steepest climb or descent between two positions, metres a metre.
    #[must_use]
    pub fn steepest(&self, from_m: f64, to_m: f64) -> f64 {
        let point = |at: f64| [at, self.rise_m(at)];
        let mut points = vec![point(from_m)];
        points.extend(self.between(from_m, to_m));
        points.push(point(to_m));
        let slopes = points.windows(2).filter(|pair| pair[1][0] > pair[0][0]);
        slopes.map(|pair| ((pair[1][1] - pair[0][1]) / (pair[1][0] - pair[0][0])).abs()).fold(0.0, f64::max)
    }
}

/// Height at a position over waypoints (position, ascending, and height): even between two, before the first and behind the last that of
/// these; 0 over none.
#[must_use]
pub fn height_at(waypoints: &[[f64; 2]], along_m: f64) -> f64 {
    let next = waypoints.partition_point(|[at, _]| *at <= along_m);
    match (next.checked_sub(1).map(|k| waypoints[k]), waypoints.get(next).copied()) {
        (Some([from, low]), Some([to, high])) => low + (high - low) * (along_m - from) / (to - from),
        (Some([_, height]), None) | (None, Some([_, height])) => height,
        (None, None) => 0.0,
    }
}

/// How the ground is followed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Follow {
    /// How far the height above the ground straight below may be off.
    pub tolerance_m: f64,
    /// Steepest climb and descent, metres a metre.
    pub climb: f64,
    /// How far before the first and behind the last exposure the way begins and ends.
    pub lead_m: f64,
}

impl Follow {
    /// Waypoints over a profile: positions, ascending, and heights above the base plane. Those of `ends` are kept.
    #[must_use]
    pub fn course(&self, mut profile: Vec<[f64; 2]>, ends: &[usize]) -> Course {
        for k in 1..profile.len() {
            let ([from, before], [to, here]) = (profile[k - 1], profile[k]);
            profile[k][1] = here.max(before - self.climb * (to - from));
        }
        for k in (1..profile.len()).rev() {
            let ([from, here], [to, after]) = (profile[k - 1], profile[k]);
            profile[k - 1][1] = here.max(after - self.climb * (to - from));
        }
        Course::through(thinned(&profile, ends, self.tolerance_m))
    }
}

/// Those of `ends`, and as many points between as a way through them needs to be nowhere off by more than the tolerance.
fn thinned(points: &[[f64; 2]], ends: &[usize], tolerance_m: f64) -> Vec<[f64; 2]> {
    let mut kept = vec![false; points.len()];
    let mut parts: Vec<[usize; 2]> = ends.windows(2).map(|pair| [pair[0], pair[1]]).collect();
    while let Some([from, to]) = parts.pop() {
        let ([a, low], [b, high]) = (points[from], points[to]);
        (kept[from], kept[to]) = (true, true);
        let off = |k: usize| (points[k][1] - (low + (high - low) * (points[k][0] - a) / (b - a))).abs();
        let worst = (from + 1..to).max_by(|i, k| off(*i).total_cmp(&off(*k)));
        if let Some(worst) = worst.filter(|worst| off(*worst) > tolerance_m) {
            parts.extend([[from, worst], [worst, to]]);
        }
    }
    points.iter().zip(kept).filter(|(_, is_kept)| *is_kept).map(|(point, _)| *point).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn heights_change_evenly_from_way_point_to_way_point() {
        let course = Course::through(vec![[0.0, 10.0], [100.0, 30.0], [150.0, 20.0]]);
        for (at, rise) in [(-5.0, 10.0), (0.0, 10.0), (50.0, 20.0), (100.0, 30.0), (125.0, 25.0), (900.0, 20.0)] {
            assert_eq!(course.rise_m(at), rise, "{at}");
        }
        assert_eq!(course.range_m([50.0, 125.0]), [20.0, 30.0]);
        assert_eq!(course.range_m([110.0, 112.0]), [27.6, 28.0]);
        assert_eq!(course.between(0.0, 150.0), [[100.0, 30.0]]);
        assert_eq!((course.steepest(0.0, 150.0), course.steepest(10.0, 50.0)), (0.2, 0.2));
        let level = Course::default();
        assert_eq!((level.rise_m(7.0), level.range_m([0.0, 9.0]), level.steepest(0.0, 9.0)), (0.0, [0.0; 2], 0.0));
    }
}
