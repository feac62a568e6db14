//! A flight that is kept by its fixes: the aeroplane goes where its autopilot steers it, the autopilot steers by where it believes to
//! be, and it believes what its sensors and the firmware's fixes tell it.
//!
//! Everything is stepped, at 200 Hz, as far as somebody asks: a picture, a sample, the end. What reaches the autopilot counts from the
//! first step that ends after it; nothing here knows of a clock on the wall, so that all links fly alike.

mod instruments;
pub mod moment;
mod receiver;
#[cfg(test)]
mod tests;

use super::autopilot::Received;
use super::inertial::estimator::{Estimator, Measurement, Settings};
use super::inertial::filter::Begin;
use super::inertial::imu::Imu;
use super::inertial::strapdown::{Inertial, ned_from_body};
use super::inertial::vision::{Driver, Vision};
use super::motion::{Recorded, TrueState, recorded};
use super::mount::camera_of_antenna;
use super::plane::Plane;
use super::plane::guidance::Guidance;
use super::plane::wind::Wind;
use super::servo::driven::DrivenServo;
use super::servo::wrapped;
use crate::noise::White;
use crate::scenario::{FollowUpMode, Mounting, Navigation, Scenario, WrongParameters};
use instruments::{Instruments, is_due};
use moment::{Moment, ToldOfGnss, Track};
use nalgebra::Vector3;
use receiver::Receiver;
use std::collections::VecDeque;

/// A step of aeroplane and inertial sensors.
pub const STEP_US: u64 = 5_000;
const STEP_S: f64 = 1e-6 * STEP_US as f64;
/// What is told of the flight, ten times a second.
const MOMENT_US: u64 = 100_000;
/// What an autopilot knows of itself that has stood level, turned by its compass and had satellite navigation for a while, one sigma.
/// Chosen: half a degree of tilt, two of heading, 0.2 m/s.
const BEGIN_TILT_RAD: f64 = 0.5 * std::f64::consts::PI / 180.0;
const BEGIN_HEADING_RAD: f64 = 2.0 * std::f64::consts::PI / 180.0;
const BEGIN_VELOCITY_M_S: f64 = 0.2;
/// The source of positions that is a companion (EK3_SRC2_POSXY), the driver that takes MAVLink (VISO_TYPE), and the defaults of what else
/// the estimator has as parameters: VISO_POS_M_NSE, EK3_GLITCH_RAD.
const EXTERNAL: f32 = 6.0;
const BY_MAVLINK: f32 = 1.0;
const NOISE_M: f32 = 0.2;
const GLITCH_M: f32 = 25.0;

/// Where is flown.
#[derive(Clone, Debug, PartialEq)]
pub struct Course {
    /// Grid east and north, at least two.
    pub waypoints: Vec<[f64; 2]>,
    /// Height to fly at, above the height datum.
    pub up_m: f64,
    /// That of the ground's base: home.
    pub base_up_m: f64,
}

/// The flight.
#[derive(Clone, Debug)]
pub struct Aloft {
    navigation: Navigation,
    mount: Mounting,
    course: Course,
    plane: Plane,
    wind: Wind,
    guidance: Guidance,
    imu: Imu,
    instruments: Instruments,
    receiver: Receiver,
    estimator: Estimator,
    /// Its twin, which has had no fix since satellite navigation was lost.
    free: Option<Estimator>,
    driver: Driver,
    uses_fixes: bool,
    source_set: u8,
    servo: Option<DrivenServo>,
    /// Messages under way: when they arrive, and where on the grid their positions are.
    inbox: VecDeque<(u64, Vision, Option<[f64; 2]>)>,
    /// The camera's truth and what the autopilot believes of itself, at each step.
    truth: Vec<Recorded>,
    believed: Vec<Recorded>,
    /// Where the vehicle truly was: north and east, at each step since the filter's own time.
    passed: VecDeque<(u64, [f64; 2])>,
    at_us: u64,
    moments: Vec<Moment>,
}

impl Aloft {
    /// At time 0, at the first waypoint on the way to the second; `None` where the scenario has no such flight.
    #[must_use]
    pub fn new(scenario: &Scenario, mount: Mounting, course: &Course) -> Option<Self> {
        let navigation = scenario.world.navigation.clone()?;
        let seed = scenario.run.seed;
        let wind = Wind::new(&navigation, seed);
        let guidance = Guidance::new(course.waypoints.clone(), course.up_m, navigation.bank_max_deg.to_radians());
        let plane = begin(course, &guidance, scenario.vehicle.flight.speed_m_s, wind.mean_m_s());
        let parameters = &scenario.faults.autopilot_faults.parameters;
        let figures = navigation.grade.figures();
        let instruments = Instruments::new(&navigation, course.base_up_m, seed);
        let settings = Settings {
            figures,
            begin: Begin {
                tilt_rad: BEGIN_TILT_RAD,
                heading_rad: BEGIN_HEADING_RAD,
                velocity_m_s: BEGIN_VELOCITY_M_S,
                place_m: navigation.gnss_sigma_m,
            },
            gnss: [navigation.gnss_sigma_m, navigation.gnss_velocity_sigma_m_s],
            heading_rad: instruments.heading_sigma_rad(),
            glitch_m: f64::from(known(parameters.ek3_glitch_rad, GLITCH_M)),
        };
        let estimator = Estimator::new(misled(&inertial(&plane), &settings.begin, seed), &settings, 0);
        let follows = scenario.vehicle.follow_up.mode != FollowUpMode::Fixed;
        let mut aloft = Aloft {
            mount,
            course: course.clone(),
            plane,
            wind,
            guidance,
            imu: Imu::new(&figures, seed),
            instruments,
            receiver: Receiver::new(scenario.faults.timed.clone(), navigation.gnss_sigma_m),
            estimator,
            free: None,
            driver: driver(parameters),
            uses_fixes: known(parameters.ek3_src2_posxy, EXTERNAL) == EXTERNAL
                && known(parameters.viso_type, BY_MAVLINK) == BY_MAVLINK,
            source_set: 1,
            servo: follows.then(|| DrivenServo::new(&scenario.world.follow_up)),
            inbox: VecDeque::new(),
            truth: Vec::new(),
            believed: Vec::new(),
            passed: VecDeque::new(),
            at_us: 0,
            moments: Vec::new(),
            navigation,
        };
        aloft.record();
        Some(aloft)
    }

    /// The camera's truth at `t_us`.
    pub fn state(&mut self, t_us: u64) -> TrueState {
        self.advance_to(t_us);
        recorded(&self.truth, t_us as f64).unwrap_or_default()
    }

    /// What the autopilot believes at `t_us` of the vehicle: the place of its antenna.
    pub fn believed(&mut self, t_us: u64) -> TrueState {
        self.advance_to(t_us);
        recorded(&self.believed, t_us as f64).unwrap_or_default()
    }

    /// The waypoint that is flown to now.
    pub fn waypoint(&self) -> usize {
        self.guidance.next()
    }

    /// What the receiver of satellite navigation has handed over by `t_us`.
    pub fn received(&mut self, t_us: u64) -> Option<Received> {
        self.advance_to(t_us);
        self.receiver.received(t_us)
    }

    /// The camera's truth from `from_us` to `to_us`.
    pub fn window(&mut self, from_us: u64, to_us: u64) -> Vec<Recorded> {
        self.advance_to(to_us);
        let from = (from_us / STEP_US) as usize;
        let to = (to_us.div_ceil(STEP_US) as usize + 1).min(self.truth.len());
        self.truth.get(from.min(to)..to).unwrap_or_default().to_vec()
    }

    /// Something of the firmware's reaches the autopilot at `at_us`; `place_m`: its position on the grid, east and north.
    pub fn hear(&mut self, at_us: u64, message: Vision, place_m: Option<[f64; 2]>) {
        let place = self.inbox.partition_point(|(other, ..)| *other <= at_us);
        self.inbox.insert(place, (at_us, message, place_m));
    }

    /// The estimator's set of sources from now on.
    pub fn use_sources(&mut self, set: u8) {
        self.source_set = set;
    }

    /// The servo is told at `at_us` to go to an angle.
    pub fn command(&mut self, at_us: u64, angle_rad: f64) {
        if let Some(servo) = &mut self.servo {
            servo.command(at_us, angle_rad);
        }
    }

    /// What was flown: the camera's truth, and the autopilot's navigation.
    #[must_use]
    pub fn finish(self) -> (Vec<Recorded>, Track) {
        let track = Track {
            gnss_lost_s: self.navigation.gnss_lost_s,
            waypoints: self.course.waypoints,
            gnss: ToldOfGnss::default(),
            fixes: self.estimator.counts,
            moments: self.moments,
        };
        (self.truth, track)
    }

    fn advance_to(&mut self, t_us: u64) {
        while self.at_us < t_us {
            self.step();
        }
    }

    fn step(&mut self) {
        let before = inertial(&self.plane);
        self.at_us += STEP_US;
        let own = state_of(self.estimator.present());
        let wanted = self.guidance.wanted([own.east_m, own.north_m, own.up_m], own.velocity_enu_m_s);
        self.plane.advance(STEP_S, &wanted, &self.wind.at(self.at_us));
        let now = inertial(&self.plane);
        let measured = self.imu.measure(&before.increment(&now, STEP_S), self.at_us);
        self.read();
        self.sense(&now);
        self.estimator.advance(self.at_us, &measured);
        if let Some(free) = &mut self.free {
            free.advance(self.at_us, &measured);
        }
        self.record();
    }

    /// What has arrived of the firmware's.
    fn read(&mut self) {
        while let Some((_, message, place_m)) = self.inbox.pop_front_if(|(at_us, ..)| *at_us <= self.at_us) {
            let was_healthy = self.driver.is_healthy(self.at_us);
            let Some(fix) = self.driver.take(&message, self.at_us) else { continue };
            let is_wanted = self.source_set == 2 && self.uses_fixes && was_healthy;
            if let Some([east, north]) = place_m.filter(|_| is_wanted) {
                let fix = super::inertial::vision::VisionFix { place_m: [north, east], ..fix };
                self.estimator.take(fix.at_us, Measurement::Vision(fix));
            }
        }
    }

    /// What the other sensors say of the truth.
    fn sense(&mut self, now: &Inertial) {
        let lost_us = self.navigation.gnss_lost_s.map_or(u64::MAX, |lost_s| (1e6 * lost_s).round() as u64);
        if self.at_us >= lost_us && self.free.is_none() {
            self.free = Some(self.estimator.clone());
        }
        if self.at_us < lost_us && is_due(instruments::GNSS_US, self.at_us) {
            let measured = self.instruments.gnss(now);
            if let Some(gnss) = self.receiver.pass(self.at_us, measured).filter(|_| self.source_set == 1) {
                self.estimator.take(self.at_us, gnss);
            }
        }
        if is_due(instruments::SLOW_US, self.at_us) {
            for measurement in self.instruments.slow(now, self.at_us) {
                self.estimator.take(self.at_us, measurement);
                if let Some(free) = &mut self.free {
                    free.take(self.at_us, measurement);
                }
            }
        }
    }

    fn record(&mut self) {
        let vehicle = state_of(&inertial(&self.plane));
        let follow_up_rad = self.servo.as_mut().map_or(0.0, |servo| servo.at(self.at_us));
        let camera = self.camera(&TrueState { follow_up_rad, ..vehicle });
        self.truth.push((self.at_us as f64, camera));
        let own = state_of(self.estimator.present());
        self.believed.push((self.at_us as f64, own));
        self.passed.push_back((self.at_us, [vehicle.north_m, vehicle.east_m]));
        let (filter_us, _) = self.estimator.filter();
        while self.passed.pop_front_if(|(at_us, _)| *at_us < filter_us).is_some() {}
        if is_due(MOMENT_US, self.at_us) {
            self.remember(&vehicle, &own);
        }
    }

    /// The camera on its arm; where the arm turns, its velocity is that of the place that was recorded last to this one.
    fn camera(&self, vehicle: &TrueState) -> TrueState {
        let arm = |state: &TrueState| camera_of_antenna(state, &self.mount);
        let [east_m, north_m, up_m] = arm(vehicle);
        let mut velocity_enu_m_s = vehicle.velocity_enu_m_s;
        let has_arm = [self.mount.lever_arm_m, self.mount.head_arm_m].iter().flatten().any(|m| *m != 0.0);
        if let Some((_, last)) = self.truth.last().filter(|_| has_arm) {
            let moved = [east_m - last.east_m, north_m - last.north_m, up_m - last.up_m];
            velocity_enu_m_s = moved.map(|m| m / STEP_S);
        }
        TrueState { east_m, north_m, up_m, velocity_enu_m_s, ..*vehicle }
    }

    fn remember(&mut self, vehicle: &TrueState, own: &TrueState) {
        let place = |state: &TrueState| [state.east_m, state.north_m, state.up_m];
        let then = self.passed.front().map(|(_, place_m)| *place_m);
        let course_rad = vehicle.velocity_enu_m_s[0].atan2(vehicle.velocity_enu_m_s[1]);
        let off = |axis: usize| own.velocity_enu_m_s[axis] - vehicle.velocity_enu_m_s[axis];
        self.moments.push(Moment {
            at_s: 1e-6 * self.at_us as f64,
            truth_m: place(vehicle),
            believed_m: place(own),
            free_m: self.free.as_ref().map(|free| place(&state_of(free.present()))),
            velocity_error_m_s: off(0).hypot(off(1)),
            heading_error_rad: wrapped(own.heading_rad - vehicle.heading_rad),
            nees: then.and_then(|then| self.estimator.nees(then)),
            across_m: self.guidance.on_leg([vehicle.east_m, vehicle.north_m]).across_m,
            is_turning: self.guidance.is_turning(course_rad),
        });
    }
}

/// A parameter as it is set, or as documented; one that is never answered has its documented value all the same.
fn known(parameter: Option<f32>, documented: f32) -> f32 {
    parameter.filter(|value| value.is_finite()).unwrap_or(documented)
}

fn driver(parameters: &WrongParameters) -> Driver {
    let [delay_ms, noise_m] = [known(parameters.viso_delay_ms, 0.0), known(parameters.viso_pos_m_nse, NOISE_M)];
    Driver::new(delay_ms.into(), noise_m.into())
}

/// At the first waypoint, its nose so far into the wind that it flies to the second.
fn begin(course: &Course, guidance: &Guidance, airspeed_m_s: f64, wind_m_s: [f64; 3]) -> Plane {
    let from = course.waypoints.first().copied().unwrap_or_default();
    let course_rad = guidance.on_leg(from).course_rad;
    let (sin, cos) = course_rad.sin_cos();
    let to_the_right_m_s = wind_m_s[0] * cos - wind_m_s[1] * sin;
    let heading_rad = course_rad - (to_the_right_m_s / airspeed_m_s).clamp(-0.9, 0.9).asin();
    Plane::new([from[0], from[1], course.up_m], heading_rad, airspeed_m_s, wind_m_s)
}

/// The vehicle's own place, velocity and attitude: those of its antenna.
fn inertial(plane: &Plane) -> Inertial {
    let ned = |[east, north, up]: [f64; 3]| Vector3::new(north, east, -up);
    Inertial {
        ned_from_body: ned_from_body([plane.heading_rad, plane.pitch_rad(), plane.roll_rad]),
        velocity_m_s: ned(plane.velocity_m_s()),
        place_m: ned(plane.place_m),
    }
}

fn state_of(nav: &Inertial) -> TrueState {
    let [heading_rad, pitch_rad, roll_rad] = nav.angles_rad();
    let (place, velocity) = (nav.place_m, nav.velocity_m_s);
    TrueState {
        east_m: place.y,
        north_m: place.x,
        up_m: -place.z,
        heading_rad,
        pitch_rad,
        roll_rad,
        follow_up_rad: 0.0,
        velocity_enu_m_s: [velocity.y, velocity.x, -velocity.z],
    }
}

/// What an autopilot believes that is off as much as it knows.
fn misled(truth: &Inertial, begin: &Begin, seed: u64) -> Inertial {
    let off = |sigmas: [f64; 3], name: &str| {
        let mut noise = White::new(1.0, seed, name);
        Vector3::from(sigmas.map(|sigma| sigma * noise.draw()))
    };
    let turn = off([begin.tilt_rad, begin.tilt_rad, begin.heading_rad], "navigation.begin.attitude");
    Inertial {
        ned_from_body: super::inertial::strapdown::turned(turn) * truth.ned_from_body,
        velocity_m_s: truth.velocity_m_s + off([begin.velocity_m_s; 3], "navigation.begin.velocity"),
        place_m: truth.place_m + off([begin.place_m; 3], "navigation.begin.place"),
    }
}
