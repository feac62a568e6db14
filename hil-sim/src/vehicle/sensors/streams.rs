//! The streams, merged in the order in which they arrive at the board.

use super::attitude_faults::FaultyAttitude;
use super::faulty::Faulty;
use super::reading::{Reading, Sample};
use super::sensed::Sensed;
use crate::noise::{GaussMarkov, White, stream, uniform};
use crate::scenario::{FollowUpMode, Mounting, Scenario, Seconds, is_during};
use crate::vehicle::motion::TrueState;
use crate::vehicle::mount::antenna;
use crate::vehicle::servo::wrapped;
use rand_chacha::ChaCha12Rng;

/// The kinds, in the order in which samples that arrive at the same microsecond are delivered.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    Pps,
    Attitude,
    FollowUp,
    Range,
    Position,
}

/// A stream's timetable.
#[derive(Debug, Clone)]
struct Timetable {
    kind: Kind,
    rate_hz: u64,
    latency_us: u64,
    /// How much older than its stamp a value is.
    delay_us: u64,
    /// The clock's step that the message can stamp, 1 or 1000; what is beyond is cut off.
    stamp_us: u64,
    /// Index of the next sample.
    next: u64,
}

impl Timetable {
    fn sampled_at_us(&self) -> u64 {
        // Spread over what a coarse stamp cuts off, by the golden ratio, as a loop that knows nothing of whole milliseconds
        // does.
        self.next * 1_000_000 / self.rate_hz + self.next * 618 % self.stamp_us
    }

    /// When the value held that is stamped with [`Self::sampled_at_us`].
    fn held_at_us(&self) -> u64 {
        self.sampled_at_us().saturating_sub(self.delay_us)
    }

    fn arrived_at_us(&self) -> u64 {
        self.sampled_at_us() + self.latency_us
    }
}

/// The sensors of one flight. It remembers where each stream stands: ask for ever later times.
#[derive(Debug)]
pub struct Streams {
    timetables: Vec<Timetable>,
    /// Pulses from the first second to the one before the second are not there.
    pulses_lost_s: Option<[f64; 2]>,
    convergence_rad: f64,
    mount: Mounting,
    /// Heading, pitch, roll.
    attitude_white: [White; 3],
    attitude_drift: [GaussMarkov; 3],
    faulty_attitude: FaultyAttitude,
    faulty: Faulty,
    follow_up_white: White,
    range_white: White,
    dropout: (f64, ChaCha12Rng),
    zero_s: Option<Seconds>,
    /// East, north, up.
    position_drift: [GaussMarkov; 3],
    position_white: [White; 3],
    /// North, east, down.
    velocity_white: [White; 3],
}

impl Streams {
    /// Sensors at rest before their first sample. `convergence_rad`: grid convergence, true heading minus grid
    /// heading, taken as one value for the whole area.
    #[must_use]
    pub fn new(scenario: &Scenario, mount: Mounting, convergence_rad: f64) -> Self {
        let seed = scenario.run.seed;
        let attitude = &scenario.vehicle.attitude;
        let heading_white_deg = attitude.heading_white_deg.unwrap_or(attitude.white_deg);
        let heading_drift_deg = attitude.heading_drift_deg.unwrap_or(attitude.drift_deg);
        let white = |deg: f64, name: &str| White::new(deg.to_radians(), seed, name);
        let drift =
            |deg: f64, name: &str| GaussMarkov::new(deg.to_radians(), scenario.world.attitude.drift_s, seed, name);
        let position = &scenario.vehicle.position;
        let (sigma_m, constant_s) = (scenario.vehicle.position_sigma_m(), scenario.world.position.time_constant_s);
        let wandering = |name: &str| GaussMarkov::new(sigma_m, constant_s, seed, name);
        let shaking = |name: &str| White::new(position.velocity_sigma_m_s, seed, name);
        Streams {
            timetables: timetables(scenario),
            pulses_lost_s: scenario.faults.timer.pps_lost_s,
            convergence_rad,
            mount,
            attitude_white: [
                white(heading_white_deg, "attitude.heading.white"),
                white(attitude.white_deg, "attitude.pitch.white"),
                white(attitude.white_deg, "attitude.roll.white"),
            ],
            attitude_drift: [
                drift(heading_drift_deg, "attitude.heading.drift"),
                drift(attitude.drift_deg, "attitude.pitch.drift"),
                drift(attitude.drift_deg, "attitude.roll.drift"),
            ],
            faulty_attitude: FaultyAttitude::new(scenario.faults.attitude_faults),
            faulty: Faulty::new(scenario.faults.timed.clone(), convergence_rad),
            follow_up_white: white(scenario.vehicle.follow_up.noise_deg, "follow_up"),
            range_white: White::new(scenario.vehicle.range.sigma_m, seed, "range"),
            dropout: (scenario.faults.range.dropout_percent / 100.0, stream(seed, "range.dropout")),
            zero_s: scenario.faults.range.zero_s,
            position_drift: ["position.east", "position.north", "position.up"].map(wandering),
            position_white: ["position.east.white", "position.north.white", "position.up.white"]
                .map(|name| White::new(position.white_m, seed, name)),
            velocity_white: ["velocity.north", "velocity.east", "velocity.down"].map(shaking),
        }
    }

    /// The next sample that arrives before `until_us`, `None` when there is none yet.
    ///
    /// `slant`: the range from the true state to where the laser really hits the ground, metres; `None` without an
    /// echo. Inside a gap of a replayed log the attitude sensor is silent.
    pub fn next_before(
        &mut self,
        until_us: u64,
        motion: &dyn Sensed,
        slant: &dyn Fn(&TrueState) -> Option<f64>,
    ) -> Option<Sample> {
        loop {
            // `min_by_key` keeps the first of equals: the order of the kinds.
            let late_us = |timetable: &Timetable| match timetable.kind {
                Kind::Pps => self.faulty.pulse_late_us(timetable.sampled_at_us()),
                _ => 0,
            };
            let arrived_at_us = |timetable: &Timetable| timetable.arrived_at_us() + late_us(timetable);
            let timetable = self.timetables.iter_mut().min_by_key(|timetable| arrived_at_us(timetable))?;
            let (kind, sampled_at_us) = (timetable.kind, timetable.sampled_at_us() + late_us(timetable));
            let (arrived_at_us, held_at_us) = (arrived_at_us(timetable), timetable.held_at_us());
            if arrived_at_us >= until_us {
                return None;
            }
            timetable.next += 1;
            let reading = match kind {
                Kind::Pps => {
                    let second = sampled_at_us / 1_000_000;
                    let lost = is_during(self.pulses_lost_s, second as f64);
                    (!lost).then_some(Reading::Pps { second })
                }
                Kind::Attitude => {
                    let older_us = self.faulty.attitude_delay_us(sampled_at_us);
                    let reading = self.attitude(held_at_us, older_us, motion);
                    (!motion.in_gap(sampled_at_us)).then_some(reading)
                }
                Kind::FollowUp => Some(self.follow_up(held_at_us, motion)),
                Kind::Range => Some(self.range(held_at_us, slant(&motion.state(held_at_us)))),
                Kind::Position => Some(self.position(held_at_us, motion)),
            };
            let sample = reading.map(|reading| Sample { sampled_at_us, arrived_at_us, reading });
            let sample = sample.and_then(|sample| self.faulty.pass(sample));
            let sample = match kind {
                Kind::Attitude => sample.and_then(|sample| self.faulty_attitude.pass(sample)),
                _ => sample,
            };
            if sample.is_some() {
                return sample;
            }
        }
    }

    /// What was true at `t_us` less `older_us`, with the noise of `t_us`: a delay changes no random number. An autopilot that
    /// navigates tells what it believes.
    fn attitude(&mut self, t_us: u64, older_us: u64, motion: &dyn Sensed) -> Reading {
        if let Some(own) = motion.believed(t_us.saturating_sub(older_us)) {
            return Reading::Attitude {
                heading_true_rad: wrapped(own.heading_rad + self.convergence_rad),
                pitch_rad: own.pitch_rad,
                roll_rad: own.roll_rad,
                velocity_ned_m_s: self.velocity_ned(&own),
            };
        }
        let state = motion.state(t_us.saturating_sub(older_us));
        let white = self.attitude_white.each_mut().map(White::draw);
        let drift = self.attitude_drift.each_mut().map(|drift| drift.at(t_us));
        Reading::Attitude {
            heading_true_rad: wrapped(state.heading_rad + self.convergence_rad + white[0] + drift[0]),
            pitch_rad: state.pitch_rad + white[1] + drift[1],
            roll_rad: state.roll_rad + white[2] + drift[2],
            velocity_ned_m_s: self.velocity_ned(&state),
        }
    }

    fn follow_up(&mut self, t_us: u64, motion: &dyn Sensed) -> Reading {
        let follow_up_rad = wrapped(motion.state(t_us).follow_up_rad + self.follow_up_white.draw());
        Reading::FollowUp { follow_up_rad }
    }

    fn range(&mut self, at_us: u64, true_slant_m: Option<f64>) -> Reading {
        // Both are drawn in any case, so that one lost echo does not change the noise of the next.
        let noise_m = self.range_white.draw();
        let lost = uniform(&mut self.dropout.1) < self.dropout.0;
        if is_during(self.zero_s, 1e-6 * at_us as f64) {
            return Reading::Range { slant_m: Some(0.0) };
        }
        Reading::Range { slant_m: true_slant_m.filter(|_| !lost).map(|slant_m| slant_m + noise_m) }
    }

    fn position(&mut self, t_us: u64, motion: &dyn Sensed) -> Reading {
        if let Some(own) = motion.believed(t_us) {
            let velocity_ned_m_s = self.velocity_ned(&own);
            return Reading::Position { east_m: own.east_m, north_m: own.north_m, up_m: own.up_m, velocity_ned_m_s };
        }
        let state = motion.state(t_us);
        let [east, north, up] = self.position_drift.each_mut().map(|drift| drift.at(t_us));
        let white = self.position_white.each_mut().map(White::draw);
        let noise = self.velocity_white.each_mut().map(White::draw);
        let velocity = self.velocity_ned(&state);
        let antenna = antenna(&state, &self.mount);
        Reading::Position {
            east_m: antenna[0] + east + white[0],
            north_m: antenna[1] + north + white[1],
            up_m: antenna[2] + up + white[2],
            velocity_ned_m_s: std::array::from_fn(|axis| velocity[axis] + noise[axis]),
        }
    }

    /// From the grid's axes to true north, east and down. A course of 0 on the grid is the convergence off true north.
    fn velocity_ned(&self, state: &TrueState) -> [f64; 3] {
        let [east, north, up] = state.velocity_enu_m_s;
        let (sin, cos) = self.convergence_rad.sin_cos();
        [north * cos - east * sin, north * sin + east * cos, -up]
    }
}

/// The streams that the scenario switches on, in the order of [`Kind`]. All sample first at time 0, except the pulse:
/// second 0 is before power-on.
fn timetables(scenario: &Scenario) -> Vec<Timetable> {
    let stream = |kind, rate_hz: u32, [latency_us, delay_us]: [u32; 2], stamp_us| Timetable {
        kind,
        rate_hz: rate_hz.into(),
        latency_us: latency_us.into(),
        delay_us: delay_us.into(),
        stamp_us,
        next: 0,
    };
    let (vehicle, world) = (&scenario.vehicle, &scenario.world);
    let (attitude, range, position) = (&vehicle.attitude, &vehicle.range, &vehicle.position);
    let mut timetables = Vec::new();
    if world.timer.pps {
        timetables.push(Timetable { next: 1, ..stream(Kind::Pps, 1, [0, 0], 1) });
    }
    timetables.push(stream(Kind::Attitude, attitude.rate_hz, [world.attitude.latency_us, attitude.delay_us], 1));
    if vehicle.follow_up.mode == FollowUpMode::Measured {
        let follow_up = &world.follow_up;
        let late_us = [follow_up.latency_us, vehicle.follow_up.delay_us];
        timetables.push(stream(Kind::FollowUp, follow_up.rate_hz, late_us, 1000));
    }
    timetables.push(stream(Kind::Range, range.rate_hz, [world.range.latency_us, range.delay_us], 1000));
    timetables.push(stream(Kind::Position, position.rate_hz, [world.position.latency_us, position.delay_us], 1000));
    timetables
}
