//! A fixed-wing aeroplane as a point mass in coordinated turns: bank and climb follow what is asked for with a lag, the air carries
//! it, its speed through the air is held.

pub mod guidance;
pub mod wind;

use crate::vehicle::inertial::strapdown::GRAVITY_M_S2;

/// Time constants of bank, of the rate of roll and of the climb, and the fastest roll: of a small aeroplane. Chosen, as ArduPilot's
/// defaults have them (RLL2SRV_TCONST 0.45 s, RLL2SRV_RMAX 75 °/s, TECS_TIME_CONST of some seconds).
const BANK_S: f64 = 0.45;
const ROLL_S: f64 = 0.1;
const ROLL_MAX_RAD_S: f64 = 75.0 * std::f64::consts::PI / 180.0;
const CLIMB_S: f64 = 1.5;
/// How long it takes to be carried by wind that has changed: mass over the drag's slope. Chosen: 1 to 2 s of a light aeroplane.
const CARRIED_S: f64 = 1.5;
/// Angle of attack in level flight, radians; it grows with the load. Chosen: 2°.
const ATTACK_RAD: f64 = 2.0 * std::f64::consts::PI / 180.0;

/// What is asked of it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Wanted {
    /// Right wing down.
    pub bank_rad: f64,
    /// Upwards.
    pub climb_m_s: f64,
}

/// What the air does.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Air {
    /// Where it moves to: east, north, up.
    pub wind_m_s: [f64; 3],
    /// How it turns the wings, radians a second.
    pub roll_rad_s: f64,
}

/// Where it is and how it moves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plane {
    /// Grid east, north, up.
    pub place_m: [f64; 3],
    /// Through the air.
    pub airspeed_m_s: f64,
    /// Clockwise from grid north; it flies where it points to.
    pub heading_rad: f64,
    /// Right wing down.
    pub roll_rad: f64,
    roll_rad_s: f64,
    climb_m_s: f64,
    /// By which it is carried.
    carried_m_s: [f64; 3],
}

impl Plane {
    /// In level flight, carried by the wind.
    #[must_use]
    pub fn new(place_m: [f64; 3], heading_rad: f64, airspeed_m_s: f64, wind_m_s: [f64; 3]) -> Self {
        Plane {
            place_m,
            airspeed_m_s,
            heading_rad,
            roll_rad: 0.0,
            roll_rad_s: 0.0,
            climb_m_s: 0.0,
            carried_m_s: wind_m_s,
        }
    }

    /// Over the ground: east, north, up.
    #[must_use]
    pub fn velocity_m_s(&self) -> [f64; 3] {
        let (sin, cos) = self.heading_rad.sin_cos();
        let level_m_s = (self.airspeed_m_s * self.airspeed_m_s - self.climb_m_s * self.climb_m_s).max(0.0).sqrt();
        let air = [level_m_s * sin, level_m_s * cos, self.climb_m_s];
        std::array::from_fn(|axis| air[axis] + self.carried_m_s[axis])
    }

    /// Nose up: the way through the air and the angle of attack that carries the load of the turn.
    #[must_use]
    pub fn pitch_rad(&self) -> f64 {
        (self.climb_m_s / self.airspeed_m_s).clamp(-1.0, 1.0).asin() + ATTACK_RAD / self.roll_rad.cos().max(0.1)
    }

    /// Goes on by a step.
    pub fn advance(&mut self, dt_s: f64, wanted: &Wanted, air: &Air) {
        let before = self.velocity_m_s();
        let asked_rad_s = ((wanted.bank_rad - self.roll_rad) / BANK_S).clamp(-ROLL_MAX_RAD_S, ROLL_MAX_RAD_S);
        self.roll_rad_s += (asked_rad_s + air.roll_rad_s - self.roll_rad_s) * share(dt_s, ROLL_S);
        self.roll_rad += self.roll_rad_s * dt_s;
        self.climb_m_s += (wanted.climb_m_s - self.climb_m_s) * share(dt_s, CLIMB_S);
        for (carried, wind) in self.carried_m_s.iter_mut().zip(air.wind_m_s) {
            *carried += (wind - *carried) * share(dt_s, CARRIED_S);
        }
        // A turn in which nothing slips: the wings' pull to the side is the turn's.
        self.heading_rad += GRAVITY_M_S2 * self.roll_rad.tan() / self.airspeed_m_s * dt_s;
        let after = self.velocity_m_s();
        for (axis, place) in self.place_m.iter_mut().enumerate() {
            *place += 0.5 * (before[axis] + after[axis]) * dt_s;
        }
    }
}

/// What a first-order lag of `constant_s` makes up for within a step.
fn share(dt_s: f64, constant_s: f64) -> f64 {
    1.0 - (-dt_s / constant_s).exp()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Radius V²/(g tan φ), around once in 2π V/(g tan φ): back where it began, and the wind has carried it.
    #[test]
    fn a_steady_bank_is_a_circle_in_the_air() {
        let bank_rad = 0.35_f64;
        let wind_m_s = [3.0, -1.0, 0.0];
        let mut plane = Plane { roll_rad: bank_rad, ..Plane::new([0.0; 3], 0.0, 22.0, wind_m_s) };
        let (wanted, air) = (Wanted { bank_rad, climb_m_s: 0.0 }, Air { wind_m_s, roll_rad_s: 0.0 });
        let around_s = std::f64::consts::TAU * 22.0 / (GRAVITY_M_S2 * bank_rad.tan());
        let steps = (around_s / 0.005).round();
        (0..steps as u32).for_each(|_| plane.advance(0.005, &wanted, &air));
        let off = [plane.place_m[0] - 3.0 * 0.005 * steps, plane.place_m[1] + 0.005 * steps];
        assert!(off[0].hypot(off[1]) < 0.2 && plane.place_m[2].abs() < 1e-9, "{off:?}");
    }

    #[test]
    fn bank_lags_and_its_rate_is_limited() {
        let mut plane = Plane::new([0.0; 3], 0.0, 22.0, [0.0; 3]);
        let wanted = Wanted { bank_rad: 1.0, climb_m_s: 0.0 };
        (0..60).for_each(|_| plane.advance(0.005, &wanted, &Air::default()));
        assert!(plane.roll_rad > 0.1 && plane.roll_rad < 0.3 * ROLL_MAX_RAD_S, "{}", plane.roll_rad);
    }
}
