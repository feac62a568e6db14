//! The shortest way from one line to another at a bounded turn: arcs and straights (Dubins, American Journal of Mathematics
//! 79, 1957; the six words after Shkel and Lumelsky, Robotics and Autonomous Systems 34, 2001).
//!
//! Course is clockwise from north, so in these formulas x is north, y east, and what the books call left turns right here.

use std::f64::consts::TAU;

/// Where and whereto, grid metres and radians clockwise from north.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pose {
    /// Grid.
    pub east_m: f64,
    /// Grid.
    pub north_m: f64,
    /// Clockwise from grid north.
    pub course_rad: f64,
}

/// A stretch of constant curvature.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Piece {
    /// Its beginning.
    pub from: Pose,
    /// Its length.
    pub length_m: f64,
    /// Radians a metre, clockwise; 0 is straight.
    pub curvature: f64,
}

impl Piece {
    /// The pose `along_m` behind the beginning.
    pub fn at(&self, along_m: f64) -> Pose {
        let Pose { east_m, north_m, course_rad } = self.from;
        let (sin, cos) = course_rad.sin_cos();
        if self.curvature == 0.0 {
            return Pose { east_m: east_m + along_m * sin, north_m: north_m + along_m * cos, course_rad };
        }
        let turned_rad = course_rad + self.curvature * along_m;
        let (sin_end, cos_end) = turned_rad.sin_cos();
        Pose {
            east_m: east_m + (cos - cos_end) / self.curvature,
            north_m: north_m + (sin_end - sin) / self.curvature,
            course_rad: turned_rad,
        }
    }

    /// The pose at its end.
    pub fn end(&self) -> Pose {
        self.at(self.length_m)
    }
}

/// Angles that rounding has turned once around are none.
const WHOLE_TURN: f64 = 1e-9;
/// How far a word's end may be off, in radii: a formula that does not apply misses by much more.
const MISS: f64 = 1e-6;

/// Within [0, 2π), a hair below being a hair above 0.
fn turn(angle_rad: f64) -> f64 {
    let angle = angle_rad.rem_euclid(TAU);
    if TAU - angle < WHOLE_TURN { 0.0 } else { angle }
}

/// The pieces of the shortest way from `from` to `to` with turns of `radius_m`.
pub fn shortest(from: Pose, to: Pose, radius_m: f64) -> [Piece; 3] {
    let (north, east) = (to.north_m - from.north_m, to.east_m - from.east_m);
    let distance = north.hypot(east) / radius_m;
    let bearing = east.atan2(north);
    let (a, b) = (from.course_rad - bearing, to.course_rad - bearing);
    let ways = words(a, b, distance).into_iter().map(|(signs, lengths)| {
        let mut at = from;
        let pieces = std::array::from_fn(|index| {
            let piece =
                Piece { from: at, length_m: radius_m * lengths[index], curvature: f64::from(signs[index]) / radius_m };
            at = piece.end();
            piece
        });
        let miss_m = (at.east_m - to.east_m).hypot(at.north_m - to.north_m);
        let off_rad = super::wrapped(at.course_rad - to.course_rad).abs();
        (pieces, lengths.iter().sum::<f64>(), miss_m <= MISS * radius_m * (1.0 + distance) && off_rad <= MISS)
    });
    let reached = ways.filter(|(_, length, arrives)| *arrives && length.is_finite());
    let shortest = reached.min_by(|(_, one, _), (_, other, _)| one.total_cmp(other));
    // Two turns and a straight between them the same way round exist for every pair of poses.
    shortest.map_or_else(|| [Piece { from, length_m: 0.0, curvature: 0.0 }; 3], |(pieces, _, _)| pieces)
}

/// Signs of the curvature and lengths in radii, of all six words; what does not exist is NaN.
fn words(a: f64, b: f64, d: f64) -> [([i8; 3], [f64; 3]); 6] {
    let ((sin_a, cos_a), (sin_b, cos_b)) = (a.sin_cos(), b.sin_cos());
    let cos_ab = (a - b).cos();
    let lsl = (cos_b - cos_a).atan2(d + sin_a - sin_b);
    let rsr = (cos_a - cos_b).atan2(d - sin_a + sin_b);
    let straight = |squared: f64| if squared > -WHOLE_TURN { squared.max(0.0).sqrt() } else { f64::NAN };
    let lsr_p = straight(d * d - 2.0 + 2.0 * cos_ab + 2.0 * d * (sin_a + sin_b));
    let lsr = (-cos_a - cos_b).atan2(d + sin_a + sin_b) - (-2.0f64).atan2(lsr_p);
    let rsl_p = straight(d * d - 2.0 + 2.0 * cos_ab - 2.0 * d * (sin_a + sin_b));
    let rsl = (cos_a + cos_b).atan2(d - sin_a - sin_b) - 2.0f64.atan2(rsl_p);
    let middle = |cosine: f64| TAU - (cosine / 8.0).acos();
    let rlr_p = middle(6.0 - d * d + 2.0 * cos_ab + 2.0 * d * (sin_a - sin_b));
    let rlr_t = a - (cos_a - cos_b).atan2(d - sin_a + sin_b) + 0.5 * rlr_p;
    let lrl_p = middle(6.0 - d * d + 2.0 * cos_ab + 2.0 * d * (sin_b - sin_a));
    let lrl_t = -a - (cos_a - cos_b).atan2(d + sin_a - sin_b) + 0.5 * lrl_p;
    let lsl_p = straight(2.0 + d * d - 2.0 * cos_ab + 2.0 * d * (sin_a - sin_b));
    let rsr_p = straight(2.0 + d * d - 2.0 * cos_ab + 2.0 * d * (sin_b - sin_a));
    [
        ([1, 0, 1], [turn(lsl - a), lsl_p, turn(b - lsl)]),
        ([-1, 0, -1], [turn(a - rsr), rsr_p, turn(rsr - b)]),
        ([1, 0, -1], [turn(lsr - a), lsr_p, turn(lsr - b)]),
        ([-1, 0, 1], [turn(a - rsl), rsl_p, turn(b - rsl)]),
        ([-1, 1, -1], [turn(rlr_t), rlr_p, turn(a - b - rlr_t + rlr_p)]),
        ([1, -1, 1], [turn(lrl_t), lrl_p, turn(b - a - lrl_t + lrl_p)]),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    fn pose(east_m: f64, north_m: f64, course_deg: f64) -> Pose {
        Pose { east_m, north_m, course_rad: course_deg.to_radians() }
    }

    fn length(pieces: &[Piece; 3]) -> f64 {
        pieces.iter().map(|piece| piece.length_m).sum()
    }

    #[test]
    fn lengths_are_those_of_plane_geometry() {
        // Straight on; half a circle to a line two radii beside; the same with a straight between.
        assert!((length(&shortest(pose(0.0, 0.0, 90.0), pose(500.0, 0.0, 90.0), 100.0)) - 500.0).abs() < 1e-6);
        let back = shortest(pose(0.0, 0.0, 90.0), pose(0.0, 200.0, 270.0), 100.0);
        assert!((length(&back) - 100.0 * PI).abs() < 1e-6, "{back:?}");
        let far = shortest(pose(0.0, 0.0, 90.0), pose(0.0, 500.0, 270.0), 100.0);
        assert!((length(&far) - (100.0 * PI + 300.0)).abs() < 1e-6, "{far:?}");
        // To a line d beside, nearer than two radii: out, around, and in again. The three circles' centres stand two radii
        // apart, the outer ones on lines 2 R + d apart: 2 (2 acos((R + d/2) / 2R)) + pi in turns.
        let near = shortest(pose(0.0, 0.0, 90.0), pose(0.0, 100.0, 270.0), 100.0);
        let expected = 100.0 * (4.0 * (150.0f64 / 200.0).acos() + PI);
        assert!((length(&near) - expected).abs() < 1e-6, "{} {expected}", length(&near));
    }

    #[test]
    fn every_way_arrives_smoothly() {
        let mut count = 0;
        for index in 0..6000u32 {
            // A lattice that meets no symmetry.
            let number = |step: f64, range: f64| (f64::from(index) * step).fract() * range;
            let from = pose(number(0.618, 700.0), number(0.737, 700.0), number(0.391, 360.0));
            let to = pose(number(0.271, 700.0), number(0.513, 700.0), number(0.877, 360.0));
            let pieces = shortest(from, to, 100.0);
            let end = pieces[2].end();
            assert!((end.east_m - to.east_m).hypot(end.north_m - to.north_m) < 1e-3, "{index}");
            assert!(super::super::wrapped(end.course_rad - to.course_rad).abs() < 1e-6, "{index}");
            assert!(pieces[0].end() == pieces[1].from && pieces[1].end() == pieces[2].from);
            let straight = (to.east_m - from.east_m).hypot(to.north_m - from.north_m);
            assert!(length(&pieces) >= straight - 1e-6);
            count += usize::from(pieces[1].curvature != 0.0);
        }
        // All kinds occur.
        assert!(count > 100 && count < 5900, "{count}");
    }
}
