//! The true motion of the vehicle and of the camera's servo, as functions of time.
//!
//! Nothing is stored and stepped but the servo: a state depends on the scenario and the instant alone, in whatever
//! order it is asked for. Frames: grid east and north (absolute, in the CRS of the ground), up above its height datum;
//! heading clockwise from GRID north, pitch nose up, roll right wing down, follow-up angle counter-clockwise from above
//! about the body's up axis. Time: integer microseconds of the autopilot's clock.
//!
//! Synthetic motion: pitch and roll uniform within the largest tilt, below 20°/s for 99 % of the time at ±10° and 0.05 to
//! 0.25 Hz; height uniform within its range at no more than 2.5 m/s; a track that always turns one way, through all
//! headings.

mod climb;
mod log;
mod planned;
mod recorded;
#[cfg(test)]
mod tests;
mod track;
mod turn;
mod wave;

pub use log::AttitudeLog;
pub use planned::{Line, Manner, PlannedTrack};
pub use recorded::{Recorded, recorded};

use super::servo::{Servo, follow_up_exact, wrapped};
use crate::noise::stream;
use crate::scenario::{FollowUpMode, Scenario};
use climb::Climb;
use plumbline_survey::error::InputError;
use track::Track;
use wave::Wave;

/// Slowest and fastest parts of the heading's wander around the course, hertz.
const WANDER_HZ: [f64; 2] = [0.01, 0.04];

/// Where a flight may go.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Area {
    /// Grid.
    pub centre_east_m: f64,
    /// Grid.
    pub centre_north_m: f64,
    /// The vehicle stays this close to the centre, in east and in north. The ground must be larger by
    /// [`footprint_margin_m`](crate::scenario::footprint::footprint_margin_m).
    pub half_extent_m: f64,
    /// The ground's height from which the scenario's heights count, above the height datum.
    pub base_up_m: f64,
}

/// The truth at one instant.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct TrueState {
    /// Grid.
    pub east_m: f64,
    /// Grid.
    pub north_m: f64,
    /// Above the height datum.
    pub up_m: f64,
    /// Clockwise from grid north, within (−π, π].
    pub heading_rad: f64,
    /// Nose up.
    pub pitch_rad: f64,
    /// Right wing down.
    pub roll_rad: f64,
    /// Of the camera against the body, counter-clockwise from above, within (−π, π].
    pub follow_up_rad: f64,
    /// East, north, up on the grid; the exact derivative of the position.
    pub velocity_enu_m_s: [f64; 3],
}

/// True motion over a flight.
#[derive(Debug)]
pub struct Motion {
    source: Source,
}

/// Who moves the vehicle.
#[derive(Debug)]
enum Source {
    /// We do.
    Made(Box<Made>),
    /// Somebody else did.
    Recorded(Vec<Recorded>),
}

/// Motion that is a function of time.
#[derive(Debug)]
struct Made {
    course: Course,
    attitude: Attitude,
    /// `None`: the camera is fixed to the body.
    servo: Option<Servo>,
}

/// Where the vehicle goes.
#[derive(Debug)]
enum Course {
    /// Around over an area, up and down.
    Free { area: Area, track: Track, climb: Climb },
    /// Along a plan's strips.
    Planned(PlannedTrack),
}

#[derive(Debug)]
enum Attitude {
    Synthetic { pitch: Wave, roll: Wave, tilt_max_rad: f64, wander: Wave, wander_rad: f64 },
    Log { log: AttitudeLog, start_s: f64, time_scale: f64 },
}

impl Motion {
    /// Synthetic motion, decided by the scenario's seed.
    ///
    /// # Errors
    /// [`InputError`] when the area leaves no room to fly.
    pub fn synthetic(scenario: &Scenario, area: &Area) -> Result<Self, InputError> {
        Self::with_attitude(scenario, area, Attitude::synthetic(scenario))
    }

    /// Along a plan's strips, with synthetic attitude around the course.
    #[must_use]
    pub fn planned(scenario: &Scenario, track: PlannedTrack) -> Self {
        Self::on_course(scenario, Course::Planned(track), Attitude::synthetic(scenario))
    }

    /// The attitude of `log`, with synthetic horizontal motion and height. The log's yaw is taken as the heading on the
    /// grid; it has nothing to do with the course. Start and time scale are the scenario's `replay`, or the log's
    /// first row and 1.
    ///
    /// # Errors
    /// [`InputError`] when the area leaves no room to fly or the log does not cover the flight.
    pub fn replay(scenario: &Scenario, area: &Area, log: AttitudeLog) -> Result<Self, InputError> {
        let (start_s, time_scale) = log.span(scenario)?;
        Self::with_attitude(scenario, area, Attitude::Log { log, start_s, time_scale })
    }

    fn with_attitude(scenario: &Scenario, area: &Area, attitude: Attitude) -> Result<Self, InputError> {
        let half_extent_m = area.half_extent_m;
        if !(half_extent_m.is_finite() && half_extent_m > 0.0) {
            return Err(InputError::new(format!(
                "the ground is too small to fly over: {half_extent_m} m are left around its centre after the footprint"
            )));
        }
        let seed = scenario.run.seed;
        let course = Course::Free {
            area: *area,
            track: Track::new(stream(seed, "motion.track"), half_extent_m, scenario.vehicle.flight.speed_m_s),
            climb: Climb::new(stream(seed, "motion.climb"), scenario.run.flight.height_m),
        };
        Ok(Self::on_course(scenario, course, attitude))
    }

    fn on_course(scenario: &Scenario, course: Course, attitude: Attitude) -> Self {
        let follows = scenario.vehicle.follow_up.mode != FollowUpMode::Fixed;
        let servo = follows.then(|| Servo::new(scenario.world.follow_up.servo_lag_s));
        Motion { source: Source::Made(Box::new(Made { course, attitude, servo })) }
    }

    /// Motion that was recorded: samples in the order of time, at least one.
    #[must_use]
    pub fn recorded(samples: Vec<Recorded>) -> Self {
        Motion { source: Source::Recorded(samples) }
    }

    /// The truth at `t_us`; of recorded motion, beyond its samples and in its gaps, the nearest sample.
    pub fn state(&self, t_us: u64) -> TrueState {
        match &self.source {
            Source::Made(made) => made.state(t_us),
            Source::Recorded(samples) => {
                recorded(samples, t_us as f64).unwrap_or_else(|| recorded::nearest(samples, t_us as f64))
            }
        }
    }

    /// Whether the log that is replayed has nothing at `t_us`. The true attitude goes on there, interpolated; the
    /// attitude sensor is silent, so the firmware has to refuse the frame.
    pub fn in_gap(&self, t_us: u64) -> bool {
        let Source::Made(made) = &self.source else { return false };
        match &made.attitude {
            Attitude::Synthetic { .. } => false,
            Attitude::Log { log, start_s, time_scale } => log.in_gap(start_s + t_us as f64 * 1e-6 * time_scale),
        }
    }

    /// The waypoint of a plan that is flown to at `t_us`, from 0 on.
    pub fn waypoint(&self, t_us: u64) -> Option<usize> {
        let Source::Made(made) = &self.source else { return None };
        match &made.course {
            Course::Free { .. } => None,
            Course::Planned(track) => track.waypoint(t_us as f64 * 1e-6),
        }
    }

    /// Root-mean-square horizontal speed that is really flown, metres a second.
    pub fn speed_m_s(&self) -> f64 {
        match &self.source {
            Source::Made(made) => match &made.course {
                Course::Free { track, .. } => track.speed_m_s(),
                Course::Planned(track) => track.speed_m_s(),
            },
            Source::Recorded(samples) => {
                let squares = samples.iter().map(|(_, state)| {
                    let [east, north, _] = state.velocity_enu_m_s;
                    east * east + north * north
                });
                (squares.sum::<f64>() / samples.len().max(1) as f64).sqrt()
            }
        }
    }
}

impl Made {
    fn state(&self, t_us: u64) -> TrueState {
        let t_s = t_us as f64 * 1e-6;
        let ([east_m, north_m, up_m], velocity_enu_m_s) = match &self.course {
            Course::Free { area, track, climb } => {
                let ([east, north], [v_east, v_north]) = track.at(t_s);
                let (height_m, v_up) = climb.at(t_s);
                let place = [area.centre_east_m + east, area.centre_north_m + north, area.base_up_m + height_m];
                (place, [v_east, v_north, v_up])
            }
            Course::Planned(track) => {
                let on = track.at(t_s);
                (on.place_m, on.velocity_m_s)
            }
        };
        let [heading_rad, pitch_rad, roll_rad] = self.attitude_at(t_s);
        let exact = |t_s: f64| {
            let [heading_rad, pitch_rad, roll_rad] = self.attitude_at(t_s);
            follow_up_exact(heading_rad, pitch_rad, roll_rad)
        };
        TrueState {
            east_m,
            north_m,
            up_m,
            heading_rad,
            pitch_rad,
            roll_rad,
            follow_up_rad: self.servo.as_ref().map_or(0.0, |servo| servo.at(t_us, exact)),
            velocity_enu_m_s,
        }
    }

    /// Direction of flight, clockwise from grid north, as it is wanted.
    fn course_rad(&self, t_s: f64) -> f64 {
        match &self.course {
            Course::Free { track, .. } => track.course_rad(t_s),
            Course::Planned(track) => track.at(t_s).course_rad,
        }
    }

    /// Heading within (−π, π], pitch, roll.
    fn attitude_at(&self, t_s: f64) -> [f64; 3] {
        match &self.attitude {
            Attitude::Synthetic { pitch, roll, tilt_max_rad, wander, wander_rad } => [
                wrapped(self.course_rad(t_s) + wander_rad * wander.normal(t_s)),
                tilt_max_rad * pitch.uniform(t_s),
                tilt_max_rad * roll.uniform(t_s),
            ],
            Attitude::Log { log, start_s, time_scale } => log.at(start_s + t_s * time_scale),
        }
    }
}

impl Attitude {
    /// As the scenario has it, decided by its seed.
    fn synthetic(scenario: &Scenario) -> Self {
        let wave =
            |name: &str, [low_hz, high_hz]: [f64; 2]| Wave::new(stream(scenario.run.seed, name), low_hz, high_hz);
        Attitude::Synthetic {
            pitch: wave("motion.pitch", scenario.vehicle.flight.tilt_hz),
            roll: wave("motion.roll", scenario.vehicle.flight.tilt_hz),
            tilt_max_rad: scenario.vehicle.flight.tilt_max_deg.to_radians(),
            wander: wave("motion.wander", WANDER_HZ),
            wander_rad: scenario.run.flight.heading_wander_deg.to_radians(),
        }
    }
}
