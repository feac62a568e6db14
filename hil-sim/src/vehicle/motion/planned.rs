//! A track along a plan's strips: straight over their points at constant speed, and around from one to the next.

use super::turn::{Piece, Pose, shortest};
use super::wave::Wave;
use crate::noise::stream;
use plumbline_survey::plan::course::height_at;

/// Seconds flown straight before a strip's first point, so that position and velocity have settled, and behind its last.
const RUN_IN_S: f64 = 5.0;
const RUN_OUT_S: f64 = 2.0;
/// Seconds before the run-in: the board needs pulses, a clock and positions before it can expose anything.
const BEFORE_S: f64 = 5.0;
/// Seconds before and behind a waypoint over which a climb changes into the next.
const ROUNDED_S: f64 = 1.5;
/// Slowest and fastest parts of the deviations from the line, hertz: what an autopilot leaves.
const DEVIATION_HZ: [f64; 2] = [0.01, 0.05];

/// A strip as it is flown.
#[derive(Debug, Clone, PartialEq)]
pub struct Line {
    /// Grid east and north of its first and last point in flight.
    pub ends_m: [[f64; 2]; 2],
    /// Direction of flight, clockwise from grid north.
    pub course_rad: f64,
    /// Waypoints of its height: distance from the first point, ascending, and height above the height datum. Between them it changes
    /// evenly, before the first and behind the last it stays. One alone is a level line.
    pub heights: Vec<[f64; 2]>,
}

impl Line {
    /// Its waypoints in the order of flight: east, north and up; of a level line its ends.
    pub fn way(&self) -> Vec<[f64; 3]> {
        let ([first, _], (sin, cos)) = (self.ends_m, self.course_rad.sin_cos());
        let at = |along_m: f64| [first[0] + along_m * sin, first[1] + along_m * cos, self.up_m(along_m)];
        self.way_along_m().into_iter().map(at).collect()
    }

    /// Their distances from the first point.
    fn way_along_m(&self) -> Vec<f64> {
        let [first, last] = self.ends_m;
        match self.heights.len() {
            0 | 1 => vec![0.0, (last[0] - first[0]).hypot(last[1] - first[1])],
            _ => self.heights.iter().map(|[along_m, _]| *along_m).collect(),
        }
    }

    /// Height at a distance from the first point.
    fn up_m(&self, at_m: f64) -> f64 {
        height_at(&self.heights, at_m)
    }
}

/// How strips are flown.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Manner {
    /// Ground speed.
    pub speed_m_s: f64,
    /// Radius of the turns.
    pub radius_m: f64,
    /// Deviations from the track, one sigma: east and north each, and up.
    pub deviation_m: [f64; 2],
}

/// The track, a function of time.
#[derive(Debug)]
pub struct PlannedTrack {
    speed_m_s: f64,
    /// Each with its beginning, metres of the track, and how it climbs.
    pieces: Vec<(f64, Piece, Climb)>,
    length_m: f64,
    /// Metres of the track at which it passes each line's waypoints.
    passed_m: Vec<f64>,
    /// East, north, up.
    deviations: [(f64, Wave); 3],
}

/// Where the track is at an instant.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OnTrack {
    /// East, north, up.
    pub place_m: [f64; 3],
    /// Its derivative.
    pub velocity_m_s: [f64; 3],
    /// Clockwise from grid north.
    pub course_rad: f64,
}

impl PlannedTrack {
    /// The strips in their order; the seed decides the deviations.
    pub fn new(lines: &[Line], manner: &Manner, seed: u64) -> Self {
        let speed = manner.speed_m_s;
        let mut track = PlannedTrack {
            speed_m_s: speed,
            pieces: Vec::new(),
            length_m: 0.0,
            passed_m: Vec::new(),
            deviations: [("east", 0), ("north", 0), ("up", 1)].map(|(name, which)| {
                let rng = stream(seed, &format!("motion.deviation.{name}"));
                (manner.deviation_m[which], Wave::new(rng, DEVIATION_HZ[0], DEVIATION_HZ[1]))
            }),
        };
        let mut before: Option<(Pose, f64)> = None;
        for line in lines {
            let pose = |[east_m, north_m]: [f64; 2]| Pose { east_m, north_m, course_rad: line.course_rad };
            let lead_s = if before.is_none() { RUN_IN_S + BEFORE_S } else { RUN_IN_S };
            let back = Piece { from: pose(line.ends_m[0]), length_m: -lead_s * speed, curvature: 0.0 };
            let from = back.end();
            let entered_m = line.up_m(-lead_s * speed);
            if let Some((left, up_m)) = before {
                let pieces = shortest(left, from, manner.radius_m);
                let whole: f64 = pieces.iter().map(|piece| piece.length_m).sum();
                let mut done = 0.0;
                for piece in pieces {
                    let up_at = |along_m: f64| up_m + (entered_m - up_m) * along_m / whole.max(f64::MIN_POSITIVE);
                    track.push(piece, Climb::between(up_at(done), up_at(done + piece.length_m)));
                    done += piece.length_m;
                }
            }
            let [first, last] = line.ends_m;
            let along_m = (last[0] - first[0]).hypot(last[1] - first[1]);
            let length_m = along_m + (lead_s + RUN_OUT_S) * speed;
            let straight = Piece { from, length_m, curvature: 0.0 };
            let first_m = track.length_m + lead_s * speed;
            track.passed_m.extend(line.way_along_m().iter().map(|waypoint_m| first_m + waypoint_m));
            track.straight(line, &straight, lead_s * speed);
            before = Some((straight.end(), line.up_m(length_m - lead_s * speed)));
        }
        track
    }

    /// A line's straight, which begins `lead_m` before its first point, in parts of one climb each.
    fn straight(&mut self, line: &Line, straight: &Piece, lead_m: f64) {
        let knots = knots(line, [-lead_m, straight.length_m - lead_m], ROUNDED_S * self.speed_m_s);
        for pair in knots.windows(2) {
            let (from, length_m) = (straight.at(pair[0].at_m + lead_m), pair[1].at_m - pair[0].at_m);
            let climb = Climb { up_m: [pair[0].up_m, pair[1].up_m], slope: [pair[0].slope, pair[1].slope] };
            self.push(Piece { from, length_m, curvature: 0.0 }, climb);
        }
    }

    fn push(&mut self, piece: Piece, climb: Climb) {
        if piece.length_m > 0.0 {
            self.pieces.push((self.length_m, piece, climb));
            self.length_m += piece.length_m;
        }
    }

    /// Seconds from the beginning to the end.
    pub fn duration_s(&self) -> f64 {
        self.length_m / self.speed_m_s
    }

    /// Metres a second.
    pub fn speed_m_s(&self) -> f64 {
        self.speed_m_s
    }

    /// The waypoint that is flown to, counted over all lines; behind the last one that one.
    pub fn waypoint(&self, t_s: f64) -> Option<usize> {
        let passed = self.passed_m.partition_point(|at_m| *at_m <= self.speed_m_s * t_s);
        Some(passed.min(self.passed_m.len().checked_sub(1)?))
    }

    /// Where it is; straight on behind its end.
    pub fn at(&self, t_s: f64) -> OnTrack {
        let along_m = self.speed_m_s * t_s;
        let index = self.pieces.partition_point(|(begin_m, ..)| *begin_m <= along_m).saturating_sub(1);
        let mut on = OnTrack { place_m: [0.0; 3], velocity_m_s: [0.0; 3], course_rad: 0.0 };
        if let Some((begin_m, piece, climb)) = self.pieces.get(index) {
            let pose = piece.at(along_m - begin_m);
            let share = (along_m - begin_m) / piece.length_m;
            let (sin, cos) = pose.course_rad.sin_cos();
            on.place_m = [pose.east_m, pose.north_m, climb.up_m(share, piece.length_m)];
            on.velocity_m_s =
                [self.speed_m_s * sin, self.speed_m_s * cos, climb.slope(share, piece.length_m) * self.speed_m_s];
            on.course_rad = pose.course_rad;
        }
        for (axis, (sigma_m, wave)) in self.deviations.iter().enumerate() {
            on.place_m[axis] += sigma_m * wave.normal(t_s);
            on.velocity_m_s[axis] += sigma_m * wave.normal_rate(t_s);
        }
        on
    }
}

/// How the height changes over a piece: its values and slopes at both ends, a cubic between them, so that pieces meet smoothly.
#[derive(Debug, Clone, Copy)]
struct Climb {
    up_m: [f64; 2],
    slope: [f64; 2],
}

impl Climb {
    /// Level at both ends.
    fn between(from_m: f64, to_m: f64) -> Self {
        Climb { up_m: [from_m, to_m], slope: [0.0; 2] }
    }

    fn up_m(&self, share: f64, length_m: f64) -> f64 {
        let x = share.clamp(0.0, 1.0);
        let slopes = self.slope[0] * x * (1.0 - x) * (1.0 - x) - self.slope[1] * x * x * (1.0 - x);
        self.up_m[0] + (self.up_m[1] - self.up_m[0]) * smooth(share) + length_m * slopes
    }

    fn slope(&self, share: f64, length_m: f64) -> f64 {
        let x = share.clamp(0.0, 1.0);
        let slopes = self.slope[0] * (1.0 - x) * (1.0 - 3.0 * x) - self.slope[1] * x * (2.0 - 3.0 * x);
        (self.up_m[1] - self.up_m[0]) * rate(share) / length_m + slopes
    }
}

/// A place on a line, its height and how that changes.
struct Knot {
    at_m: f64,
    up_m: f64,
    slope: f64,
}

/// A line's heights from one place to another: even between waypoints, rounded off over `rounded_m` to both sides of each, level at both
/// ends.
fn knots(line: &Line, [from_m, to_m]: [f64; 2], rounded_m: f64) -> Vec<Knot> {
    let mut at = vec![from_m];
    at.extend(line.heights.iter().map(|point| point[0]).filter(|at| *at > from_m && *at < to_m));
    at.push(to_m);
    let points: Vec<[f64; 2]> = at.into_iter().map(|at| [at, line.up_m(at)]).collect();
    let slopes: Vec<f64> =
        points.windows(2).map(|pair| (pair[1][1] - pair[0][1]) / (pair[1][0] - pair[0][0])).collect();
    let knot =
        |[at_m, up_m]: [f64; 2], off_m: f64, slope: f64| Knot { at_m: at_m + off_m, up_m: up_m + off_m * slope, slope };
    let mut knots = vec![knot(points[0], 0.0, 0.0)];
    for (k, pair) in points.windows(2).enumerate().filter(|_| slopes.iter().any(|slope| *slope != 0.0)) {
        let off_m = rounded_m.min(0.4 * (pair[1][0] - pair[0][0]));
        knots.extend([knot(pair[0], off_m, slopes[k]), knot(pair[1], -off_m, slopes[k])]);
    }
    knots.push(knot(points[points.len() - 1], 0.0, 0.0));
    knots
}

/// 0 to 1 with a rate of 0 at both ends.
fn smooth(share: f64) -> f64 {
    let x = share.clamp(0.0, 1.0);
    x * x * (3.0 - 2.0 * x)
}

/// Its derivative.
fn rate(share: f64) -> f64 {
    let x = share.clamp(0.0, 1.0);
    6.0 * x * (1.0 - x)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lines() -> Vec<Line> {
        let line = |north: f64, ends: [f64; 2], course_deg: f64, up_m: f64| Line {
            ends_m: ends.map(|east| [east, north]),
            course_rad: f64::to_radians(course_deg),
            heights: vec![[0.0, up_m]],
        };
        vec![
            line(0.0, [0.0, 900.0], 90.0, 300.0),
            line(120.0, [900.0, 0.0], 270.0, 300.0),
            line(500.0, [0.0, 900.0], 90.0, 330.0),
        ]
    }

    fn track(deviation_m: [f64; 2]) -> PlannedTrack {
        PlannedTrack::new(&lines(), &Manner { speed_m_s: 30.0, radius_m: 150.0, deviation_m }, 7)
    }

    /// Position is continuous and its derivative is the velocity: central differences over 2 ms, whose error is an
    /// acceleration's change over a millisecond, at the joints half of v²/R times a millisecond, 3 mm/s.
    #[test]
    fn velocity_is_the_derivative_everywhere() {
        for deviation_m in [[0.0, 0.0], [3.0, 2.0]] {
            let track = track(deviation_m);
            let steps = (track.duration_s() / 0.01) as usize;
            for step in 1..steps {
                let t_s = 0.01 * step as f64;
                let (before, here, after) = (track.at(t_s - 1e-3), track.at(t_s), track.at(t_s + 1e-3));
                for axis in 0..3 {
                    let rate = (after.place_m[axis] - before.place_m[axis]) / 2e-3;
                    assert!((rate - here.velocity_m_s[axis]).abs() < 0.01, "{t_s} {axis} {rate} {here:?}");
                }
            }
        }
    }

    #[test]
    fn strips_are_flown_straight_at_their_height_and_speed() {
        let track = track([0.0, 0.0]);
        let mut passed = 0;
        for step in 0..(track.duration_s() * 100.0) as usize {
            let on = track.at(0.01 * step as f64);
            let [east, north, up] = on.place_m;
            let speed = on.velocity_m_s[0].hypot(on.velocity_m_s[1]);
            assert!((speed - 30.0).abs() < 1e-9, "{speed}");
            for line in lines() {
                let is_over = (0.0..=900.0).contains(&east) && (north - line.ends_m[0][1]).abs() < 1e-6;
                if is_over && super::super::wrapped(on.course_rad - line.course_rad).abs() < 1e-9 {
                    assert!((up - line.up_m(0.0)).abs() < 1e-9);
                    passed += 1;
                }
            }
        }
        // 900 m at 30 m/s, three times, looked at a hundred times a second.
        assert!((8990..=9010).contains(&passed), "{passed}");
        let start = track.at(0.0);
        assert!((start.place_m[0] + 300.0).abs() < 1e-9, "{start:?}");
    }

    /// Between waypoints a climb is even; beside them it is off by no more than a parabola over 1.5 s to both sides is from its corner.
    #[test]
    fn heights_of_way_points_are_flown_evenly_and_smoothly() {
        let mut lines = lines();
        lines[0].heights = vec![[-100.0, 300.0], [300.0, 340.0], [700.0, 310.0]];
        let track = PlannedTrack::new(&lines, &Manner { speed_m_s: 30.0, radius_m: 150.0, deviation_m: [0.0; 2] }, 7);
        let mut seen = 0;
        for step in 1..(track.duration_s() * 100.0) as usize {
            let t_s = 0.01 * step as f64;
            let (before, on, after) = (track.at(t_s - 1e-3), track.at(t_s), track.at(t_s + 1e-3));
            assert!(((after.place_m[2] - before.place_m[2]) / 2e-3 - on.velocity_m_s[2]).abs() < 0.01, "{t_s}");
            let [east, north, up] = on.place_m;
            if (0.0..=900.0).contains(&east) && north.abs() < 1e-6 {
                let wanted = lines[0].up_m(east);
                let is_beside = [300.0, 700.0].iter().any(|at| (east - at).abs() < 45.0);
                let off = (up - wanted).abs();
                assert!(off < if is_beside { 45.0 * 0.175 / 4.0 + 1e-6 } else { 1e-9 }, "{east}: {off}");
                seen += 1;
            }
        }
        assert!(seen > 2_900, "{seen}");
    }

    /// A waypoint is flown to until the track is over it, and then the next one, on the other side of a turn too.
    #[test]
    fn each_waypoint_is_flown_to_until_it_is_reached() {
        let mut lines = lines();
        lines[0].heights = vec![[0.0, 300.0], [450.0, 340.0], [900.0, 310.0]];
        let track = PlannedTrack::new(&lines, &Manner { speed_m_s: 30.0, radius_m: 150.0, deviation_m: [0.0; 2] }, 7);
        let way: Vec<[f64; 3]> = lines.iter().flat_map(Line::way).collect();
        assert_eq!((way.len(), track.waypoint(0.0), track.waypoint(1e4)), (7, Some(0), Some(6)));
        let mut reached = Vec::new();
        for step in 1..(track.duration_s() * 100.0) as usize {
            let (before, now) = (track.waypoint(0.01 * (step - 1) as f64), track.waypoint(0.01 * step as f64));
            if before != now {
                let ([east, north, _], [at_east, at_north, _]) =
                    (track.at(0.01 * step as f64).place_m, way[reached.len()]);
                assert!((east - at_east).hypot(north - at_north) < 0.31, "{before:?} {east} {north}");
                reached.push(before);
            }
        }
        assert_eq!(reached, (0..6).map(Some).collect::<Vec<_>>());
    }

    #[test]
    fn the_same_seed_deviates_the_same() {
        assert_eq!(track([1.0, 1.0]).at(50.0), track([1.0, 1.0]).at(50.0));
        let off = track([1.0, 0.5]).at(50.0);
        let exact = track([0.0, 0.0]).at(50.0);
        assert!(off.place_m.iter().zip(exact.place_m).all(|(a, b)| (a - b).abs() > 1e-3 && (a - b).abs() < 5.0));
    }
}
