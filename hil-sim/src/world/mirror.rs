//! A ground continued beyond its borders by its mirror images: as large as one wants, without a raster more.
//!
//! Across a border heights and grey values go on without a step. What lies at the same place of two fields looks alike, turned
//! over; shifts that a search goes through are far shorter than a field, so that nothing is found twice in it.

use super::grid::Bounds;

/// Reflections of a ray at most: rays that go farther see the horizon.
const REFLECTIONS_MAX: usize = 64;

/// Which field lies where.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Mirror {
    field: Bounds,
    whole: Bounds,
}

impl Mirror {
    /// The field in the middle of a square of `side_m` around `centre`.
    pub(super) fn new(field: Bounds, [east_m, north_m]: [f64; 2], side_m: f64) -> Self {
        let half_m = 0.5 * side_m;
        let whole = Bounds {
            west_m: east_m - half_m,
            east_m: east_m + half_m,
            south_m: north_m - half_m,
            north_m: north_m + half_m,
        };
        Mirror { field, whole }
    }

    /// The whole square.
    pub(super) fn bounds(&self) -> Bounds {
        self.whole
    }

    /// Where a point of the square lies in the field; `None` outside.
    pub(super) fn folded(&self, east_m: f64, north_m: f64) -> Option<[f64; 2]> {
        self.whole.contains(east_m, north_m).then(|| self.turned([east_m, north_m]).map(|(at, _)| at))
    }

    /// The field's coordinates, and the direction along each axis in which they grow.
    fn turned(&self, at: [f64; 2]) -> [(f64, f64); 2] {
        let (centre, middle) = (self.whole.centre(), self.field.centre());
        let sides = [self.field.east_m - self.field.west_m, self.field.north_m - self.field.south_m];
        std::array::from_fn(|axis| {
            let side = sides[axis];
            let from_border = at[axis] - centre[axis] + 0.5 * side;
            let (fields, rest) = (from_border.div_euclid(side), from_border.rem_euclid(side));
            let low = middle[axis] - 0.5 * side;
            if fields.rem_euclid(2.0) == 0.0 { (low + rest, 1.0) } else { (low + side - rest, -1.0) }
        })
    }

    /// How far along `direction` something is met, where `meet` says it within the field: at each border the ray turns back as a
    /// ball does, since the ground beyond is this one turned over.
    pub(super) fn along(
        &self,
        origin: [f64; 3],
        direction: [f64; 3],
        meet: impl Fn([f64; 3], [f64; 3]) -> Option<f64>,
    ) -> Option<f64> {
        let [(east, east_sign), (north, north_sign)] = self.turned([origin[0], origin[1]]);
        let mut at = [east, north, origin[2]];
        let mut to = [direction[0] * east_sign, direction[1] * north_sign, direction[2]];
        let low = [self.field.west_m, self.field.south_m];
        let high = [self.field.east_m, self.field.north_m];
        let mut gone = 0.0;
        for _ in 0..REFLECTIONS_MAX {
            if let Some(met) = meet(at, to) {
                return Some(gone + met);
            }
            let leaves = |axis: usize| match to[axis] {
                rate if rate > 0.0 => ((high[axis] - at[axis]) / rate, high[axis]),
                rate if rate < 0.0 => ((low[axis] - at[axis]) / rate, low[axis]),
                _ => (f64::INFINITY, at[axis]),
            };
            let axis = usize::from(leaves(1).0 < leaves(0).0);
            let (step, border) = leaves(axis);
            if !step.is_finite() {
                return None;
            }
            let step = step.max(0.0);
            at = std::array::from_fn(|i| at[i] + step * to[i]);
            (at[axis], to[axis]) = (border, -to[axis]);
            gone += step;
            if at[2] < 0.0 && to[2] <= 0.0
                || !self.whole.contains(origin[0] + gone * direction[0], origin[1] + gone * direction[1])
            {
                return None;
            }
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use crate::world::{procedural, procedural_around};

    #[test]
    fn in_the_middle_it_is_the_field_and_beside_it_its_mirror_image() {
        let field = procedural(1);
        let [east, north] = field.bounds().centre();
        let around = procedural_around(1, 32755, [700_000.0, 6_000_000.0], 8000.0);
        let side = field.bounds().east_m - field.bounds().west_m;
        for (dx, dy) in [(0.0, 0.0), (312.3, -77.7), (-850.0, 899.0)] {
            let value = field.albedo(east + dx, north + dy);
            let at = |x: f64, y: f64| around.albedo(700_000.0 + x, 6_000_000.0 + y);
            let same = |other: Option<f64>| (value.unwrap() - other.unwrap()).abs() < 1e-6;
            assert!(value.is_some() && same(at(dx, dy)));
            assert!(same(at(side - dx, dy)) && same(at(dx, -side - dy)) && same(at(side - dx, side - dy)));
            assert!(same(at(2.0 * side + dx, dy)));
            let height = around.height(700_000.0 + side - dx, 6_000_000.0 + dy);
            assert!((height - field.height(east + dx, north + dy)).abs() < 1e-6);
        }
        assert_eq!(around.albedo(704_001.0, 6_000_000.0), None);
        assert_eq!((around.epsg(), around.bounds().centre()), (32755, [700_000.0, 6_000_000.0]));
    }

    #[test]
    fn rays_meet_what_is_there_on_both_sides_of_a_border() {
        let around = procedural_around(1, 32755, [0.0, 0.0], 8000.0);
        let side = procedural(1).bounds().east_m - procedural(1).bounds().west_m;
        let mut across = 0;
        for index in 0..400 {
            let origin = [0.5 * side - 60.0 + 0.3 * f64::from(index), -900.0 + 4.5 * f64::from(index), 120.0];
            let direction = [0.7 - 0.0035 * f64::from(index), 0.3, -1.0];
            let [east, north, up] = around.intersect(origin, direction).unwrap();
            // The ray stands on the ground there, and above it before.
            assert!((around.height(east, north) - up).abs() < 1e-6, "{index}");
            for part in [0.2, 0.5, 0.9, 0.99] {
                let at = |axis: usize, end: f64| origin[axis] + part * (end - origin[axis]);
                assert!(around.height(at(0, east), at(1, north)) <= at(2, up) + 1e-6, "{index}");
            }
            across += usize::from((east - 0.5 * side) * (origin[0] - 0.5 * side) < 0.0);
        }
        assert!(across > 50, "{across}");
        // To the horizon and beyond the border of all.
        assert_eq!(around.intersect([0.0, 0.0, 100.0], [1.0, 0.0, 0.01]), None);
        assert_eq!(around.intersect([3900.0, 0.0, 100.0], [10.0, 0.0, -1.0]), None);
    }
}
