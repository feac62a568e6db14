//! Where the vehicle is: as it was made beforehand, with a servo that is told where to go, or where its fixes have led it.

use crate::link::Moving;
use crate::setup::Setup;
use crate::vehicle::aloft::moment::Track;
use crate::vehicle::aloft::{Aloft, STEP_US};
use crate::vehicle::autopilot::Received;
use crate::vehicle::inertial::vision::Vision;
use crate::vehicle::motion::{Motion, Recorded, TrueState};
use crate::vehicle::sensors::{Exposure, Sensed};
use crate::vehicle::servo::driven::DrivenServo;
use crate::vehicle::servo::wrapped;
use std::cell::RefCell;

/// From one kept state to the next of a vehicle with a commanded servo, microseconds.
const KEPT_US: u64 = 5_000;
/// Rates are differences over so long, microseconds. Chosen: two steps of what is integrated.
const RATES_US: u64 = 2 * STEP_US;
/// Around an exposure, microseconds: two steps of what is integrated.
const AROUND_US: u64 = 10_000;

/// Who moves vehicle and camera.
pub(super) enum Truth<'s> {
    /// A function of time.
    Given(&'s Motion),
    /// Likewise, and its navigation is told without an error of ours.
    Told(&'s Motion),
    /// As the first, but for the servo.
    Driven(&'s Motion, RefCell<DrivenServo>),
    /// The loop of autopilot, firmware and vehicle.
    Aloft(Box<RefCell<Aloft>>),
}

/// The motion around an exposure.
pub(super) enum Around<'s> {
    Given(&'s Motion),
    Cut(Motion),
}

impl Around<'_> {
    pub(super) fn state(&self, t_us: u64) -> TrueState {
        match self {
            Around::Given(motion) => motion.state(t_us),
            Around::Cut(motion) => motion.state(t_us),
        }
    }
}

impl<'s> Truth<'s> {
    pub(super) fn new(setup: &'s Setup) -> Self {
        let scenario = &setup.scenario;
        if setup.pictures.is_some() {
            return Truth::Told(&setup.motion);
        }
        let course = setup.course.as_ref();
        if let Some(aloft) = course.and_then(|course| Aloft::new(scenario, setup.payload.mount, course)) {
            return Truth::Aloft(Box::new(RefCell::new(aloft)));
        }
        let follow_up = &scenario.world.follow_up;
        if follow_up.servo_commanded {
            return Truth::Driven(&setup.motion, RefCell::new(DrivenServo::new(follow_up)));
        }
        Truth::Given(&setup.motion)
    }

    /// The firmware has sent a command for the servo.
    pub(super) fn command(&mut self, at_us: u64, angle_rad: f64) {
        match self {
            Truth::Given(_) | Truth::Told(_) => {}
            Truth::Driven(_, servo) => servo.get_mut().command(at_us, angle_rad),
            Truth::Aloft(aloft) => aloft.get_mut().command(at_us, angle_rad),
        }
    }

    /// Whether the autopilot navigates by what it hears.
    pub(super) fn listens(&self) -> bool {
        matches!(self, Truth::Aloft(_))
    }

    /// The autopilot gets a message; `place_m`: its position on the grid.
    pub(super) fn hear(&mut self, at_us: u64, message: Vision, place_m: Option<[f64; 2]>) {
        if let Truth::Aloft(aloft) = self {
            aloft.get_mut().hear(at_us, message, place_m);
        }
    }

    /// What the autopilot's receiver of satellite navigation has handed over by an instant, where one is simulated.
    pub(super) fn received(&self, t_us: u64) -> Option<Option<Received>> {
        match self {
            Truth::Given(_) | Truth::Told(_) | Truth::Driven(..) => None,
            Truth::Aloft(aloft) => Some(aloft.borrow_mut().received(t_us)),
        }
    }

    /// The autopilot's estimator is told to use another set of sources.
    pub(super) fn use_sources(&mut self, set: u8) {
        if let Truth::Aloft(aloft) = self {
            aloft.get_mut().use_sources(set);
        }
    }

    /// The motion around an exposure, for as many threads as make its picture.
    pub(super) fn around(&self, exposure: &Exposure, rolling_us: u64) -> Around<'s> {
        let margin_us = rolling_us.div_ceil(2) + AROUND_US;
        let (from_us, to_us) = (exposure.open_us.saturating_sub(margin_us), exposure.close_us + margin_us);
        match self {
            Truth::Given(motion) | Truth::Told(motion) => Around::Given(motion),
            Truth::Driven(motion, servo) => {
                Around::Cut(Motion::recorded(driven(motion, &mut servo.borrow_mut(), from_us, to_us)))
            }
            Truth::Aloft(aloft) => Around::Cut(Motion::recorded(aloft.borrow_mut().window(from_us, to_us))),
        }
    }

    /// How the vehicle moved a step before `t_us`: what it will have heard by then is heard, so that to look changes no flight.
    pub(super) fn moving(&self, t_us: u64) -> Moving {
        let at_us = t_us.saturating_sub(STEP_US).max(RATES_US);
        let [before, now] = [at_us - RATES_US, at_us].map(|t_us| match self {
            Truth::Given(motion) | Truth::Told(motion) | Truth::Driven(motion, _) => motion.state(t_us),
            Truth::Aloft(aloft) => aloft.borrow_mut().state(t_us),
        });
        let waypoint = match self {
            Truth::Given(motion) | Truth::Told(motion) | Truth::Driven(motion, _) => motion.waypoint(at_us),
            Truth::Aloft(aloft) => Some(aloft.borrow().waypoint()),
        };
        Moving { rates_rad_s: body_rates_rad_s(&before, &now, 1e-6 * RATES_US as f64), waypoint }
    }

    /// What was flown until `end_us`, where it was not known beforehand.
    pub(super) fn finish(self, end_us: u64) -> (Option<Vec<Recorded>>, Option<Track>) {
        match self {
            Truth::Given(_) | Truth::Told(_) => (None, None),
            Truth::Driven(motion, servo) => (Some(driven(motion, &mut servo.into_inner(), 0, end_us)), None),
            Truth::Aloft(aloft) => {
                let (motion, track) = aloft.into_inner().finish();
                (Some(motion), Some(track))
            }
        }
    }
}

impl Sensed for Truth<'_> {
    fn state(&self, t_us: u64) -> TrueState {
        match self {
            Truth::Given(motion) | Truth::Told(motion) => motion.state(t_us),
            Truth::Driven(motion, servo) => {
                TrueState { follow_up_rad: servo.borrow_mut().at(t_us), ..motion.state(t_us) }
            }
            Truth::Aloft(aloft) => aloft.borrow_mut().state(t_us),
        }
    }

    fn in_gap(&self, t_us: u64) -> bool {
        match self {
            Truth::Given(motion) | Truth::Driven(motion, _) => motion.in_gap(t_us),
            Truth::Told(_) | Truth::Aloft(_) => false,
        }
    }

    fn believed(&self, t_us: u64) -> Option<TrueState> {
        match self {
            Truth::Given(_) | Truth::Driven(..) => None,
            Truth::Told(motion) => Some(motion.state(t_us)),
            Truth::Aloft(aloft) => Some(aloft.borrow_mut().believed(t_us)),
        }
    }
}

/// States of a motion whose servo is a commanded one.
fn driven(motion: &Motion, servo: &mut DrivenServo, from_us: u64, to_us: u64) -> Vec<Recorded> {
    let first = from_us / KEPT_US;
    let last = to_us.div_ceil(KEPT_US);
    let mut state = |t_us: u64| TrueState { follow_up_rad: servo.at(t_us), ..motion.state(t_us) };
    (first..=last).map(|index| (index * KEPT_US) as f64).map(|t_us| (t_us, state(t_us as u64))).collect()
}

/// About forward, right and down, between two states that are `apart_s` apart.
fn body_rates_rad_s(before: &TrueState, now: &TrueState, apart_s: f64) -> [f64; 3] {
    let rate = |before_rad: f64, now_rad: f64| wrapped(now_rad - before_rad) / apart_s;
    let turn = rate(before.heading_rad, now.heading_rad);
    let [pitch, roll] = [rate(before.pitch_rad, now.pitch_rad), rate(before.roll_rad, now.roll_rad)];
    let ((sin_p, cos_p), (sin_r, cos_r)) = (now.pitch_rad.sin_cos(), now.roll_rad.sin_cos());
    [roll - turn * sin_p, pitch * cos_r + turn * cos_p * sin_r, turn * cos_p * cos_r - pitch * sin_r]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vehicle::inertial::strapdown::ned_from_body;

    /// The turn between both attitudes, by their matrices: its axis in the body times its angle, over 10 ms to some thousandths.
    #[test]
    fn rates_are_those_of_the_body() {
        let [before, now] = [0.0, 0.01].map(|t_s| TrueState {
            heading_rad: 3.139 + 0.3 * t_s,
            pitch_rad: 0.2 - 0.15 * t_s,
            roll_rad: -0.4 + 0.5 * t_s,
            ..TrueState::default()
        });
        let matrix = |state: &TrueState| ned_from_body([state.heading_rad, state.pitch_rad, state.roll_rad]);
        let turn = matrix(&before).transpose() * matrix(&now);
        let wanted = [turn[(2, 1)] - turn[(1, 2)], turn[(0, 2)] - turn[(2, 0)], turn[(1, 0)] - turn[(0, 1)]];
        for (rate, twice) in body_rates_rad_s(&before, &now, 0.01).into_iter().zip(wanted) {
            assert!((rate - 0.5 * twice / 0.01).abs() < 3e-3, "{rate} {twice}");
        }
    }
}
