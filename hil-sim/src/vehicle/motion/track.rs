//! The horizontal track.

use crate::noise::uniform;
use rand_chacha::ChaCha12Rng;
use std::f64::consts::TAU;

/// Angular speed of the second circle over that of the first: the golden ratio's inverse, backwards, so that the curve
/// never closes.
const SECOND: f64 = -0.618_033_988_749_894_9;
/// Speed on the second circle over that on the first. Below 1 the sum never stands still and always turns the same
/// way: a Lissajous curve, with its cusps, would spin the heading around within a frame.
const SPEEDS: f64 = 0.4;
/// Radius of the second circle over that of the first.
const RADII: f64 = SPEEDS / -SECOND;
/// Angular speed of the first circle, radians a second: 300 frames at 4 Hz turn once around, so all headings occur.
const TURN_RAD_S: f64 = 0.1;
/// Angular speed of the first circle on a small area. The course turns up to 2.1 times as fast: 20°/s.
const TURN_MAX_RAD_S: f64 = 0.17;

/// The sum of two circular motions around the area's centre.
#[derive(Debug)]
pub struct Track {
    /// Radius of the first circle, metres.
    radius_m: f64,
    /// Angular speed of the first circle, radians a second; negative turns left. Never zero.
    turn_rad_s: f64,
    /// Angles of both at time 0, clockwise from north.
    phase_rad: [f64; 2],
}

impl Track {
    /// Within ±`half_extent_m` of the centre at a root-mean-square speed of `speed_m_s`, or slower where that would
    /// turn the course faster than 20°/s. At speed 0 the vehicle turns on the spot.
    pub fn new(mut rng: ChaCha12Rng, half_extent_m: f64, speed_m_s: f64) -> Self {
        let first_m_s = speed_m_s / (1.0 + SPEEDS * SPEEDS).sqrt();
        let largest_m = half_extent_m / (1.0 + RADII);
        let turn_rad_s = (first_m_s / largest_m).clamp(TURN_RAD_S, TURN_MAX_RAD_S);
        let phase_rad = [TAU * uniform(&mut rng), TAU * uniform(&mut rng)];
        let sense = if uniform(&mut rng) < 0.5 { -1.0 } else { 1.0 };
        Track { radius_m: (first_m_s / turn_rad_s).min(largest_m), turn_rad_s: sense * turn_rad_s, phase_rad }
    }

    /// East and north of the centre, and their derivatives.
    pub fn at(&self, t_s: f64) -> ([f64; 2], [f64; 2]) {
        let [(sin_a, cos_a), (sin_b, cos_b)] = self.circles(t_s);
        let [east, north] = self.direction(t_s);
        let speed_m_s = self.radius_m * self.turn_rad_s.abs();
        let position = [self.radius_m * (sin_a + RADII * sin_b), self.radius_m * (cos_a + RADII * cos_b)];
        (position, [speed_m_s * east, speed_m_s * north])
    }

    /// Direction of flight, clockwise from north, within (−π, π].
    pub fn course_rad(&self, t_s: f64) -> f64 {
        let [east, north] = self.direction(t_s);
        east.atan2(north)
    }

    /// Root-mean-square speed.
    pub fn speed_m_s(&self) -> f64 {
        self.radius_m * self.turn_rad_s.abs() * (1.0 + SPEEDS * SPEEDS).sqrt()
    }

    /// Sine and cosine of the angles of both circles.
    fn circles(&self, t_s: f64) -> [(f64, f64); 2] {
        let [first_rad, second_rad] = self.phase_rad;
        [first_rad + self.turn_rad_s * t_s, second_rad + SECOND * self.turn_rad_s * t_s].map(f64::sin_cos)
    }

    /// East and north of the velocity, in units of the speed on the first circle.
    fn direction(&self, t_s: f64) -> [f64; 2] {
        let [(sin_a, cos_a), (sin_b, cos_b)] = self.circles(t_s);
        [cos_a - SPEEDS * cos_b, SPEEDS * sin_b - sin_a].map(|part| part * self.turn_rad_s.signum())
    }
}
