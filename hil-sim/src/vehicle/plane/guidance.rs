//! Guidance along waypoints by the estimated position: the L1 law as ArduPilot has it (S. Park, J. Deyst, J. P. How, A New Nonlinear
//! Guidance Logic for Trajectory Tracking, 2004), and height by the estimated height.

use super::Wanted;
use crate::vehicle::inertial::strapdown::GRAVITY_M_S2;

/// NAVL1_PERIOD and NAVL1_DAMPING.
const PERIOD_S: f64 = 17.0;
const DAMPING: f64 = 0.75;
/// Of what a height is off by, so much is climbed a second, and at most so fast, m/s. Chosen: TECS_CLMB_MAX is 5.
const HEIGHT_GAIN: f64 = 0.3;
const CLIMB_MAX_M_S: f64 = 3.0;
/// A course further off its leg than this is a turn, radians. Chosen: 15°.
const TURNING_RAD: f64 = 15.0 * std::f64::consts::PI / 180.0;

/// Flies legs around and around.
#[derive(Clone, Debug)]
pub struct Guidance {
    /// Grid east and north.
    waypoints: Vec<[f64; 2]>,
    /// The leg that is flown ends at this one.
    next: usize,
    up_m: f64,
    bank_max_rad: f64,
}

/// Where a place lies by a leg.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OnLeg {
    /// To the right.
    pub across_m: f64,
    /// Still to go.
    pub ahead_m: f64,
    /// The leg's course, clockwise from grid north.
    pub course_rad: f64,
}

impl Guidance {
    /// From the first waypoint to the second, at `up_m`. There are two at least.
    #[must_use]
    pub fn new(waypoints: Vec<[f64; 2]>, up_m: f64, bank_max_rad: f64) -> Self {
        Guidance { waypoints, next: 1, up_m, bank_max_rad }
    }

    /// The waypoint that the present leg ends at.
    #[must_use]
    pub fn next(&self) -> usize {
        self.next
    }

    /// Where `place_m`, east and north, lies by the present leg.
    #[must_use]
    pub fn on_leg(&self, place_m: [f64; 2]) -> OnLeg {
        on_leg(self.leg(0), place_m)
    }

    /// The present leg's ends, or those of a later one.
    fn leg(&self, later: usize) -> [[f64; 2]; 2] {
        let count = self.waypoints.len();
        let to = self.next + later;
        [self.waypoints[(to + count - 1) % count], self.waypoints[to % count]]
    }

    /// Whether a vehicle on `course_rad` is about to get on its leg still.
    #[must_use]
    pub fn is_turning(&self, course_rad: f64) -> bool {
        let [from, to] = self.leg(0);
        between(course_rad, course(from, to)).abs() > TURNING_RAD
    }

    /// What to fly, by the estimated place and velocity: east, north, up.
    pub fn wanted(&mut self, place_m: [f64; 3], velocity_m_s: [f64; 3]) -> Wanted {
        let [east, north, up] = place_m;
        let speed_m_s = velocity_m_s[0].hypot(velocity_m_s[1]).max(1.0);
        let mut leg = self.on_leg([east, north]);
        if leg.ahead_m < self.lead_m(speed_m_s) {
            self.next = (self.next + 1) % self.waypoints.len();
            leg = self.on_leg([east, north]);
        }
        let course_rad = velocity_m_s[0].atan2(velocity_m_s[1]);
        let reach_m = DAMPING * PERIOD_S * speed_m_s / std::f64::consts::PI;
        let back_rad =
            (leg.across_m / reach_m).clamp(-std::f64::consts::FRAC_1_SQRT_2, std::f64::consts::FRAC_1_SQRT_2).asin();
        let off_rad = (between(course_rad, leg.course_rad) + back_rad)
            .clamp(-std::f64::consts::FRAC_PI_2, std::f64::consts::FRAC_PI_2);
        let pull_m_s2 = -4.0 * DAMPING * DAMPING * speed_m_s * speed_m_s / reach_m * off_rad.sin();
        let bank_rad = (pull_m_s2 / GRAVITY_M_S2).atan().clamp(-self.bank_max_rad, self.bank_max_rad);
        let climb_m_s = (HEIGHT_GAIN * (self.up_m - up)).clamp(-CLIMB_MAX_M_S, CLIMB_MAX_M_S);
        Wanted { bank_rad, climb_m_s }
    }

    /// How far before a waypoint the turn to the next leg begins, so that it ends on that leg; at most half of the leg.
    fn lead_m(&self, speed_m_s: f64) -> f64 {
        let [[from, to], [_, after]] = [self.leg(0), self.leg(1)];
        let turn_rad = between(course(to, after), course(from, to)).abs();
        let radius_m = speed_m_s * speed_m_s / (GRAVITY_M_S2 * self.bank_max_rad.tan());
        let length_m = (to[0] - from[0]).hypot(to[1] - from[1]);
        // Beyond a right angle the tangent's point runs away.
        (radius_m * (0.5 * turn_rad).min(0.8).tan()).min(0.5 * length_m)
    }
}

fn on_leg([from, to]: [[f64; 2]; 2], place_m: [f64; 2]) -> OnLeg {
    let course_rad = course(from, to);
    let (sin, cos) = course_rad.sin_cos();
    let (east, north) = (place_m[0] - to[0], place_m[1] - to[1]);
    OnLeg { across_m: east * cos - north * sin, ahead_m: -(east * sin + north * cos), course_rad }
}

/// Clockwise from grid north.
fn course(from: [f64; 2], to: [f64; 2]) -> f64 {
    (to[0] - from[0]).atan2(to[1] - from[1])
}

fn between(a_rad: f64, b_rad: f64) -> f64 {
    crate::vehicle::servo::wrapped(a_rad - b_rad)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vehicle::plane::{Air, Plane};

    /// With a position that is right it stays on a square in wind: within 2 m on its legs, at its height.
    #[test]
    fn legs_are_held_in_wind() {
        let square = vec![[-300.0, -300.0], [-300.0, 300.0], [300.0, 300.0], [300.0, -300.0]];
        let mut guidance = Guidance::new(square, 120.0, 0.35);
        let air = Air { wind_m_s: [5.0, 2.0, 0.0], roll_rad_s: 0.0 };
        let mut plane = Plane::new([-290.0, -300.0, 110.0], 0.0, 22.0, air.wind_m_s);
        let (mut worst_m, mut legs) = (0.0_f64, 0);
        let mut since_turn_s = 0.0;
        for step in 0..30_000 {
            let velocity = plane.velocity_m_s();
            let next = guidance.next;
            let wanted = guidance.wanted(plane.place_m, velocity);
            legs += usize::from(guidance.next != next);
            plane.advance(0.005, &wanted, &air);
            let turning = guidance.is_turning(velocity[0].atan2(velocity[1]));
            since_turn_s = if turning { 0.0 } else { since_turn_s + 0.005 };
            if step > 4000 && since_turn_s > 8.0 {
                worst_m = worst_m.max(guidance.on_leg([plane.place_m[0], plane.place_m[1]]).across_m.abs());
            }
        }
        assert!(
            worst_m < 5.0 && legs >= 4 && (plane.place_m[2] - 120.0).abs() < 0.5,
            "{worst_m} m, {legs} legs, {plane:?}"
        );
    }
}
