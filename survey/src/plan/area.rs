//! The area to be photographed: one polygon, convex or not.

use crate::crs::System;
use crate::dem::Frame;
use crate::error::InputError;
use crate::io::geojson;
use std::path::Path;

/// A simple polygon without holes, working metres (x east, y north).
#[derive(Debug, Clone, PartialEq)]
pub struct Area {
    corners: Vec<[f64; 2]>,
}

impl Area {
    /// A polygon of at least three corners; the first need not be repeated at the end.
    ///
    /// # Errors
    /// One sentence: a coordinate is not finite, there are fewer than three corners, its sides cross or touch each other,
    /// it encloses nothing.
    pub fn new(corners: &[[f64; 2]]) -> Result<Self, InputError> {
        let refuse = |why: String| Err(InputError::new(format!("the area {why}")));
        if let Some([x, y]) = corners.iter().find(|[x, y]| !(x.is_finite() && y.is_finite())) {
            return refuse(format!("has a corner that is no place: {x}, {y}"));
        }
        let mut corners = corners.to_vec();
        corners.dedup();
        if corners.len() > 1 && corners.first() == corners.last() {
            corners.pop();
        }
        if corners.len() < 3 {
            return refuse(format!("has {} different corners, three are the least", corners.len()));
        }
        if let Some((a, b)) = crossing(&corners) {
            let side = |k: usize| {
                let ([x0, y0], [x1, y1]) = (corners[k], corners[(k + 1) % corners.len()]);
                format!("({x0}, {y0}) to ({x1}, {y1})")
            };
            return refuse(format!("crosses or touches itself: side {} and side {}", side(a), side(b)));
        }
        let area = Area { corners };
        if area.size_m2().abs() == 0.0 {
            return refuse("encloses nothing".to_owned());
        }
        Ok(area)
    }

    /// An area in the working metres of a frame, from corners in the elevation model's x and y.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn in_frame(corners: &[[f64; 2]], frame: &Frame) -> Result<Self, InputError> {
        Self::new(&corners.iter().map(|corner| frame.metres(*corner)).collect::<Vec<_>>())
    }

    /// Corners in their order, the first not repeated.
    #[must_use]
    pub fn corners(&self) -> &[[f64; 2]] {
        &self.corners
    }

    /// What it encloses, square metres.
    #[must_use]
    pub fn size_m2(&self) -> f64 {
        let [x0, y0] = self.corners[0];
        let doubled: f64 = self.sides().map(|(a, b)| (a[0] - x0) * (b[1] - y0) - (b[0] - x0) * (a[1] - y0)).sum();
        0.5 * doubled.abs()
    }

    /// x0, y0, x1, y1.
    #[must_use]
    pub fn bounds(&self) -> [f64; 4] {
        bounds(&self.corners)
    }

    /// Whether a point lies inside; on the border it may be either.
    #[must_use]
    pub fn contains(&self, [x, y]: [f64; 2]) -> bool {
        let crosses = |(a, b): &([f64; 2], [f64; 2])| {
            (a[1] > y) != (b[1] > y) && x < a[0] + (y - a[1]) / (b[1] - a[1]) * (b[0] - a[0])
        };
        self.sides().filter(crosses).count() % 2 == 1
    }

    /// The polygon in other coordinates.
    #[must_use]
    pub fn mapped(&self, map: impl Fn([f64; 2]) -> [f64; 2]) -> Self {
        Area { corners: self.corners.iter().map(|corner| map(*corner)).collect() }
    }

    /// Where the polygon lies in the band between two values of the second coordinate: ranges of the first, apart from
    /// each other and ascending. Borders belong to it.
    #[must_use]
    pub fn ranges(&self, [low, high]: [f64; 2]) -> Vec<[f64; 2]> {
        let mut ranges = Vec::new();
        for (a, b) in self.sides() {
            let (from, to) = (low.max(a[1].min(b[1])), high.min(a[1].max(b[1])));
            if from > to {
                continue;
            }
            let at = |t: f64| if a[1] == b[1] { None } else { Some(a[0] + (t - a[1]) / (b[1] - a[1]) * (b[0] - a[0])) };
            let ends = [at(from).unwrap_or(a[0]), at(to).unwrap_or(b[0])];
            ranges.push([ends[0].min(ends[1]), ends[0].max(ends[1])]);
        }
        // Inside the band its parts hang together by their sides and by the band's two borders.
        for border in [low, high] {
            let mut cuts: Vec<f64> = self
                .sides()
                .filter(|(a, b)| (a[1] > border) != (b[1] > border))
                .map(|(a, b)| a[0] + (border - a[1]) / (b[1] - a[1]) * (b[0] - a[0]))
                .collect();
            cuts.sort_by(f64::total_cmp);
            ranges.extend(cuts.chunks_exact(2).map(|pair| [pair[0], pair[1]]));
        }
        merged(ranges, 0.0)
    }

    fn sides(&self) -> impl Iterator<Item = ([f64; 2], [f64; 2])> {
        self.corners.iter().zip(self.corners.iter().cycle().skip(1)).map(|(a, b)| (*a, *b))
    }
}

/// The corners of the one polygon of a GeoJSON file, in x and y of an elevation model's reference system.
///
/// # Errors
/// As [`geojson::polygons`]; also several polygons, or holes.
pub fn read_corners(path: &Path, system: Option<System>) -> Result<Vec<[f64; 2]>, InputError> {
    let refuse = |why: String| Err(InputError::new(format!("{}: {why}", path.display())));
    match geojson::polygons(path, system)?.as_slice() {
        [one] if one.holes == 0 => Ok(one.outer.clone()),
        [one] => refuse(format!(
            "the polygon has {}, which are not planned around",
            crate::error::counted(one.holes, "hole")
        )),
        several => refuse(format!("it has {} polygons, one is planned at a time", several.len())),
    }
}

/// x0, y0, x1, y1 of some points.
#[must_use]
pub fn bounds(points: &[[f64; 2]]) -> [f64; 4] {
    points.iter().fold([f64::INFINITY, f64::INFINITY, f64::NEG_INFINITY, f64::NEG_INFINITY], |b, [x, y]| {
        [b[0].min(*x), b[1].min(*y), b[2].max(*x), b[3].max(*y)]
    })
}

/// Ranges that overlap, touch or lie closer than `gap` made one, ascending.
pub(super) fn merged(mut ranges: Vec<[f64; 2]>, gap: f64) -> Vec<[f64; 2]> {
    ranges.sort_by(|a, b| a[0].total_cmp(&b[0]));
    let mut apart: Vec<[f64; 2]> = Vec::with_capacity(ranges.len());
    for range in ranges {
        match apart.last_mut() {
            Some(last) if range[0] <= last[1] + gap => last[1] = last[1].max(range[1]),
            _ => apart.push(range),
        }
    }
    apart
}

/// Two sides that meet other than neighbours at their common corner.
fn crossing(corners: &[[f64; 2]]) -> Option<(usize, usize)> {
    let count = corners.len();
    let side = |k: usize| (corners[k], corners[(k + 1) % count]);
    // In the order of their lowest x only those that overlap in x are looked at together.
    let mut order: Vec<usize> = (0..count).collect();
    let low = |k: usize| side(k).0[0].min(side(k).1[0]);
    let high = |k: usize| side(k).0[0].max(side(k).1[0]);
    order.sort_by(|a, b| low(*a).total_cmp(&low(*b)));
    for (index, &a) in order.iter().enumerate() {
        for &b in order[index + 1..].iter().take_while(|&&b| low(b) <= high(a)) {
            let (first, second) = (a.min(b), a.max(b));
            let shared = if second == first + 1 {
                Some((side(first).0, side(first).1, side(second).1))
            } else if first == 0 && second == count - 1 {
                Some((side(second).0, side(second).1, side(first).1))
            } else {
                None
            };
            let meets = match shared {
                // Neighbours may only fold back on each other.
                Some((before, at, after)) => {
                    turn(before, at, after) == 0.0
                        && (before[0] - at[0]) * (after[0] - at[0]) + (before[1] - at[1]) * (after[1] - at[1]) > 0.0
                }
                None => meet(side(a), side(b)),
            };
            if meets {
                return Some((first, second));
            }
        }
    }
    None
}

/// Twice the area of a triangle, positive counter-clockwise.
fn turn(a: [f64; 2], b: [f64; 2], c: [f64; 2]) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

/// Whether two stretches have a point in common.
fn meet((a, b): ([f64; 2], [f64; 2]), (c, d): ([f64; 2], [f64; 2])) -> bool {
    let [abc, abd, cda, cdb] = [turn(a, b, c), turn(a, b, d), turn(c, d, a), turn(c, d, b)];
    if abc * abd < 0.0 && cda * cdb < 0.0 {
        return true;
    }
    let on = |p: [f64; 2], q: [f64; 2], r: [f64; 2]| {
        (0..2).all(|axis| r[axis] >= p[axis].min(q[axis]) && r[axis] <= p[axis].max(q[axis]))
    };
    abc == 0.0 && on(a, b, c) || abd == 0.0 && on(a, b, d) || cda == 0.0 && on(c, d, a) || cdb == 0.0 && on(c, d, b)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A U: two legs 100 wide, 200 apart, 300 high, on a base 100 high.
    fn u() -> Area {
        let corners = [
            [0.0, 0.0],
            [400.0, 0.0],
            [400.0, 400.0],
            [300.0, 400.0],
            [300.0, 100.0],
            [100.0, 100.0],
            [100.0, 400.0],
            [0.0, 400.0],
        ];
        Area::new(&corners).expect("simple")
    }

    #[test]
    fn a_concave_area_has_as_many_ranges_as_it_has_legs() {
        assert_eq!(u().ranges([150.0, 250.0]), [[0.0, 100.0], [300.0, 400.0]]);
        assert_eq!(u().ranges([50.0, 250.0]), [[0.0, 400.0]]);
        assert_eq!(u().ranges([-50.0, -1.0]), Vec::<[f64; 2]>::new());
        assert_eq!(u().ranges([400.0, 500.0]), [[0.0, 100.0], [300.0, 400.0]]);
        assert_eq!(u().size_m2(), 100_000.0);
        assert!(u().contains([50.0, 300.0]) && !u().contains([200.0, 300.0]));
    }

    #[test]
    fn a_band_inside_a_triangle_reaches_from_side_to_side() {
        let triangle = Area::new(&[[0.0, 0.0], [10.0, 0.0], [5.0, 10.0]]).expect("simple");
        assert_eq!(triangle.ranges([2.0, 4.0]), [[1.0, 9.0]]);
        assert_eq!(triangle.ranges([10.0, 12.0]), [[5.0, 5.0]]);
        assert_eq!(triangle.ranges([-5.0, 20.0]), [[0.0, 10.0]]);
    }

    #[test]
    fn what_crosses_touches_or_encloses_nothing_is_refused() {
        let refused = |corners: &[[f64; 2]]| Area::new(corners).expect_err("refused").to_string();
        let bow = refused(&[[0.0, 0.0], [10.0, 10.0], [10.0, 0.0], [0.0, 10.0]]);
        assert!(bow.contains("crosses") && bow.contains("(0, 0) to (10, 10)"), "{bow}");
        assert!(refused(&[[0.0, 0.0], [10.0, 0.0]]).contains("2 different corners"));
        assert!(refused(&[[0.0, 0.0], [f64::NAN, 0.0], [1.0, 1.0]]).contains("no place"));
        // There and back on one line.
        assert!(refused(&[[0.0, 0.0], [10.0, 0.0], [4.0, 0.0]]).contains("itself"));
        // A corner on another side.
        assert!(refused(&[[0.0, 0.0], [10.0, 0.0], [10.0, 10.0], [5.0, 0.0], [0.0, 10.0]]).contains("touches"));
        // Closed rings and doubled corners are fine.
        let closed = Area::new(&[[0.0, 0.0], [10.0, 0.0], [10.0, 0.0], [10.0, 10.0], [0.0, 0.0]]).expect("a triangle");
        assert_eq!(closed.corners().len(), 3);
    }
}
