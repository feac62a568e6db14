//! A track along a plan's strips: straight over their points at constant speed, and around from one to the next.

use super::turn::{Piece, Pose, shortest};
use super::wave::Wave;
use crate::noise::stream;

/// Seconds flown straight before a strip's first point, so that position and velocity have settled, and behind its last.
const RUN_IN_S: f64 = 5.0;
const RUN_OUT_S: f64 = 2.0;
/// Seconds before the run-in: the board needs pulses, a clock and positions before it can expose anything.
const BEFORE_S: f64 = 5.0;
/// Slowest and fastest parts of the deviations from the line, hertz: what an autopilot leaves.
const DEVIATION_HZ: [f64; 2] = [0.01, 0.05];

/// A strip as it is flown.
#[derive(Debug, Clone, PartialEq)]
pub struct Line {
    /// Grid east and north of its first and last point in flight.
    pub ends_m: [[f64; 2]; 2],
    /// Direction of flight, clockwise from grid north.
    pub course_rad: f64,
    /// Above the height datum.
    pub up_m: f64,
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
    /// Each with its beginning, metres of the track, and the height at both ends.
    pieces: Vec<(f64, Piece, [f64; 2])>,
    length_m: f64,
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
            if let Some((left, up_m)) = before {
                let pieces = shortest(left, from, manner.radius_m);
                let whole: f64 = pieces.iter().map(|piece| piece.length_m).sum();
                let mut done = 0.0;
                for piece in pieces {
                    let up_at = |along_m: f64| up_m + (line.up_m - up_m) * along_m / whole.max(f64::MIN_POSITIVE);
                    track.push(piece, [up_at(done), up_at(done + piece.length_m)]);
                    done += piece.length_m;
                }
            }
            let [first, last] = line.ends_m;
            let along_m = (last[0] - first[0]).hypot(last[1] - first[1]);
            let length_m = along_m + (lead_s + RUN_OUT_S) * speed;
            let straight = Piece { from, length_m, curvature: 0.0 };
            track.push(straight, [line.up_m; 2]);
            before = Some((straight.end(), line.up_m));
        }
        track
    }

    fn push(&mut self, piece: Piece, up_m: [f64; 2]) {
        if piece.length_m > 0.0 {
            self.pieces.push((self.length_m, piece, up_m));
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

    /// Where it is; straight on behind its end.
    pub fn at(&self, t_s: f64) -> OnTrack {
        let along_m = self.speed_m_s * t_s;
        let index = self.pieces.partition_point(|(begin_m, ..)| *begin_m <= along_m).saturating_sub(1);
        let mut on = OnTrack { place_m: [0.0; 3], velocity_m_s: [0.0; 3], course_rad: 0.0 };
        if let Some((begin_m, piece, [up_m, up_end_m])) = self.pieces.get(index) {
            let pose = piece.at(along_m - begin_m);
            let share = (along_m - begin_m) / piece.length_m;
            // A cubic whose rate is 0 at both ends, so that pieces meet smoothly.
            let climb = up_end_m - up_m;
            let (sin, cos) = pose.course_rad.sin_cos();
            on.place_m = [pose.east_m, pose.north_m, up_m + climb * smooth(share)];
            on.velocity_m_s =
                [self.speed_m_s * sin, self.speed_m_s * cos, climb * rate(share) * self.speed_m_s / piece.length_m];
            on.course_rad = pose.course_rad;
        }
        for (axis, (sigma_m, wave)) in self.deviations.iter().enumerate() {
            on.place_m[axis] += sigma_m * wave.normal(t_s);
            on.velocity_m_s[axis] += sigma_m * wave.normal_rate(t_s);
        }
        on
    }
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
            up_m,
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
                    assert!((up - line.up_m).abs() < 1e-9);
                    passed += 1;
                }
            }
        }
        // 900 m at 30 m/s, three times, looked at a hundred times a second.
        assert!((8990..=9010).contains(&passed), "{passed}");
        let start = track.at(0.0);
        assert!((start.place_m[0] + 300.0).abs() < 1e-9, "{start:?}");
    }

    #[test]
    fn the_same_seed_deviates_the_same() {
        assert_eq!(track([1.0, 1.0]).at(50.0), track([1.0, 1.0]).at(50.0));
        let off = track([1.0, 0.5]).at(50.0);
        let exact = track([0.0, 0.0]).at(50.0);
        assert!(off.place_m.iter().zip(exact.place_m).all(|(a, b)| (a - b).abs() > 1e-3 && (a - b).abs() < 5.0));
    }
}
