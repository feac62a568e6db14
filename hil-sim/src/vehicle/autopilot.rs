//! The autopilot that the firmware believes to talk to: samples as MAVLink messages, its clock, and what it does when asked.
//!
//! It is as unkind as a real one, measured on ArduPlane 4.8: unasked it sends each message once a second and no attitude
//! quaternion at all; it streams what SET_MESSAGE_INTERVAL asks for and its loop allows, and acknowledges or denies; its TIMESYNC
//! answers name nobody and take from 1.6 to 13 ms; its microseconds are counted in 32 bits, its milliseconds are cut off. Its
//! parameters are answered by name where it has them. Where it knows no place it sends (0, 0), and neither origin nor height.

mod clock;
mod gnss;
mod heard;
mod messages;
pub(crate) mod parameters;
#[cfg(test)]
mod tests;

use crate::noise::stream;
use crate::scenario::{AutopilotFaults, FaultList, is_during};
use crate::vehicle::sensors::{Reading, Sample};
use clock::Clock;
pub use gnss::Received;
use heard::way_us;
use mavlink::dialects::common::{
    ATTITUDE_QUATERNION_DATA, AUTOPILOT_STATE_FOR_GIMBAL_DEVICE_DATA, DISTANCE_SENSOR_DATA, GLOBAL_POSITION_INT_DATA,
    GPS_GLOBAL_ORIGIN_DATA, GPS_RAW_INT_DATA, HEARTBEAT_DATA, LOCAL_POSITION_NED_DATA, MavAutopilot, MavModeFlag,
    MavState, MavType, TIMESYNC_DATA,
};
use mavlink::{MAVLinkV2MessageRaw, MavHeader, MessageData};
use messages::{attitude, coarse_attitude, encoder, local, position, quaternion, range};
use parameters::Parameters;
use plumbline_firmware::wire::command::{
    ACCEPTED, Acknowledgement, Command, DENIED, REQUEST_MESSAGE, SET_EKF_SOURCE_SET, SET_MESSAGE_INTERVAL, UNSUPPORTED,
};
use plumbline_survey::crs::Crs;
use plumbline_survey::error::InputError;
use rand_chacha::ChaCha12Rng;
use std::collections::BTreeMap;

/// The autopilot's system and component id.
const SYSTEM: u8 = 1;
const COMPONENT: u8 = 1;
/// The encoder's component id, MAV_COMP_ID_GIMBAL2.
const ENCODER: u8 = 171;
/// The component id of one that is no autopilot, MAV_COMP_ID_USER1.
const STRANGER: u8 = 25;
/// From one message to the next of what is sent unasked, microseconds.
const UNASKED_US: u64 = 1_000_000;
/// Messages that are sent unasked.
const UNASKED: [u32; 4] =
    [GLOBAL_POSITION_INT_DATA::ID, DISTANCE_SENSOR_DATA::ID, LOCAL_POSITION_NED_DATA::ID, GPS_RAW_INT_DATA::ID];
/// A stream is sent in the loop that is nearest to when it is due: half of a loop of 300 Hz, microseconds.
const LOOP_SLACK_US: u64 = 1_700;

/// Turns samples into messages, and answers.
#[derive(Debug, Clone)]
pub struct Autopilot {
    sequence: u8,
    /// What all its messages bear in place of their own component ids.
    component: Option<u8>,
    clock: Clock,
    /// Interval of each stream that is sent, and when it is next due.
    streams: BTreeMap<u32, (u64, u64)>,
    /// Its loop, beyond whose rate it sends nothing, hertz.
    loop_rate_hz: u32,
    /// Latitude, longitude in 1e-7 degrees and height of where its local frame begins: where it first knew its place.
    origin: Option<(i32, i32, f64)>,
    /// Whether it has a position.
    is_placed: bool,
    /// The heading that it knows, from true north, once it has had an attitude.
    heading_true_rad: Option<f64>,
    /// Its estimator's set of sources.
    source_set: u8,
    parameters: Parameters,
    faults: AutopilotFaults,
    waits: ChaCha12Rng,
    /// Likewise of what needs no answer.
    ways: ChaCha12Rng,
    /// Height of where it was armed.
    home_up_m: f64,
    /// What its receiver of satellite navigation has last, where one is simulated.
    receiver: Option<Option<Received>>,
}

impl Autopilot {
    /// Before its first message.
    pub fn new(loop_rate_hz: u32, seed: u64) -> Self {
        let faults = AutopilotFaults::default();
        Autopilot {
            sequence: 0,
            component: None,
            clock: Clock::new(FaultList::default(), seed),
            streams: unasked(),
            loop_rate_hz,
            origin: None,
            is_placed: true,
            heading_true_rad: None,
            source_set: 1,
            parameters: Parameters::new(loop_rate_hz, &faults.parameters),
            faults,
            waits: stream(seed, "autopilot"),
            ways: stream(seed, "autopilot.heard"),
            home_up_m: 0.0,
            receiver: None,
        }
    }

    /// What its receiver of satellite navigation has now.
    pub fn receive(&mut self, received: Option<Received>) {
        self.receiver = Some(received);
    }

    /// With what the scenario has wrong with it.
    pub fn with(self, faults: &AutopilotFaults) -> Self {
        let parameters = Parameters::new(self.loop_rate_hz, &faults.parameters);
        Autopilot { is_placed: !faults.knows_no_place, parameters, faults: *faults, ..self }
    }

    /// Armed at a height, from which relative altitudes count.
    pub fn at_home(self, home_up_m: f64) -> Self {
        Autopilot { home_up_m, ..self }
    }

    /// With the faults of its clock.
    pub fn failing(self, faults: FaultList, seed: u64) -> Self {
        Autopilot { clock: Clock::new(faults, seed), ..self }
    }

    /// Whether it has power at `at_us`. Where it has booted since it was asked last, all that it was told is forgotten.
    pub fn is_awake(&mut self, at_us: u64) -> bool {
        if self.clock.has_booted(at_us) {
            (self.sequence, self.streams, self.origin, self.source_set) = (0, unasked(), None, 1);
        }
        !self.clock.is_off(at_us)
    }

    /// Another component of its system that sends what it sends, with values of its own.
    pub fn stranger(&self) -> Self {
        Autopilot { component: Some(STRANGER), ..self.clone() }
    }

    /// The set of sources that its estimator uses.
    pub fn source_set(&self) -> u8 {
        self.source_set
    }

    /// It is given an origin: latitude, longitude in 1e-7 degrees, and height.
    pub fn set_origin(&mut self, origin: (i32, i32, f64)) {
        self.origin.get_or_insert(origin);
    }

    /// It gets a fix, which gives it a position where it has an origin.
    pub fn take_fix(&mut self) {
        self.is_placed |= self.origin.is_some();
    }

    /// The answer to a request for a parameter that was sent at `at_us`: when it arrives, and its bytes.
    pub fn parameter(&mut self, name: &str, at_us: u64) -> Option<(u64, Vec<u8>)> {
        let answer = self.parameters.answer(name)?;
        Some((at_us + self.way_us() + self.way_us(), self.encode(COMPONENT, &answer)))
    }

    /// The messages of a sample; none for readings that travel by wire, and for streams that nobody asked for.
    ///
    /// # Errors
    /// A position that the reference system cannot convert.
    pub fn messages(&mut self, sample: &Sample, crs: &Crs) -> Result<Vec<Vec<u8>>, InputError> {
        let has_gnss = is_during(self.faults.gnss_s, 1e-6 * sample.sampled_at_us as f64);
        let Some(sample) = self.clock.stamped(sample) else { return Ok(Vec::new()) };
        let sample = &sample;
        let messages = match sample.reading {
            Reading::Pps { .. } => Vec::new(),
            Reading::Attitude { heading_true_rad, pitch_rad, roll_rad, velocity_ned_m_s } => {
                self.heading_true_rad = Some(heading_true_rad);
                let q = quaternion(heading_true_rad, pitch_rad, roll_rad);
                vec![
                    self.due(sample, &attitude(sample, q, velocity_ned_m_s)),
                    self.due(sample, &coarse_attitude(sample, q)),
                ]
            }
            // A device of its own, which sends as it likes.
            Reading::FollowUp { follow_up_rad } => vec![self.encode(ENCODER, &encoder(sample, follow_up_rad))],
            Reading::Range { slant_m } => vec![self.due(sample, &range(sample, slant_m))],
            Reading::Position { east_m, north_m, up_m, velocity_ned_m_s } => {
                let degrees = crs.to_wgs84(east_m, north_m)?;
                let gnss = gnss::gnss(sample, has_gnss, self.receiver, crs)?;
                let gnss = self.due(sample, &gnss);
                if self.is_placed {
                    let heights_m = [up_m, up_m - self.home_up_m];
                    let message = position(sample, degrees, heights_m, velocity_ned_m_s, self.heading_true_rad);
                    let (_, _, origin_up_m) = *self.origin.get_or_insert((message.lat, message.lon, up_m));
                    vec![self.due(sample, &message), self.due(sample, &local(sample, origin_up_m - up_m)), gnss]
                } else {
                    let message = position(sample, (0.0, 0.0), [up_m; 2], [0.0; 3], self.heading_true_rad);
                    vec![self.due(sample, &message), gnss]
                }
            }
        };
        Ok(messages.into_iter().filter(|message| !message.is_empty()).collect())
    }

    /// Its heartbeat.
    pub fn heartbeat(&mut self) -> Vec<u8> {
        self.encode(
            COMPONENT,
            &HEARTBEAT_DATA {
                custom_mode: 0,
                mavtype: MavType::MAV_TYPE_FIXED_WING,
                autopilot: MavAutopilot::MAV_AUTOPILOT_ARDUPILOTMEGA,
                base_mode: MavModeFlag::MAV_MODE_FLAG_SAFETY_ARMED,
                system_status: MavState::MAV_STATE_ACTIVE,
                mavlink_version: 3,
            },
        )
    }

    /// The answer to a TIMESYNC request that carried `theirs_ns` and was sent at `at_us`: when it arrives, and its bytes. It
    /// names nobody.
    pub fn timesync_answer(&mut self, theirs_ns: i64, at_us: u64) -> (u64, Vec<u8>) {
        let at_autopilot_us = at_us + self.way_us();
        let answer = TIMESYNC_DATA { tc1: self.clock.told_us(at_autopilot_us) * 1000, ts1: theirs_ns };
        let back_us = self.way_us() + self.clock.late_us(at_autopilot_us);
        (at_autopilot_us + back_us, self.encode(COMPONENT, &answer))
    }

    /// What comes of a command that was sent at `at_us`: when it arrives, and its bytes.
    pub fn commanded(&mut self, command: &Command, at_us: u64) -> (u64, Vec<u8>) {
        let at_autopilot_us = at_us + self.way_us();
        let [first, second] = command.parameters.map(f64::from);
        let (mut sent, result) = match command.command {
            SET_MESSAGE_INTERVAL => (Vec::new(), self.set_interval(first as u32, second, at_autopilot_us)),
            REQUEST_MESSAGE if first as u32 == GPS_GLOBAL_ORIGIN_DATA::ID => match self.origin {
                Some((latitude, longitude, up_m)) => {
                    let altitude = (up_m * 1000.0).round() as i32;
                    let origin = GPS_GLOBAL_ORIGIN_DATA { latitude, longitude, altitude };
                    (self.encode(COMPONENT, &origin), ACCEPTED)
                }
                None => (Vec::new(), DENIED),
            },
            SET_EKF_SOURCE_SET if SOURCE_SETS.contains(&first) && !self.faults.denies_source_set => {
                self.source_set = first as u8;
                (Vec::new(), ACCEPTED)
            }
            SET_EKF_SOURCE_SET => (Vec::new(), DENIED),
            _ => (Vec::new(), UNSUPPORTED),
        };
        let mut bytes = self.encode(COMPONENT, &Acknowledgement { command: command.command, result, target: (0, 0) });
        bytes.append(&mut sent);
        (at_autopilot_us + self.way_us(), bytes)
    }

    fn set_interval(&mut self, message: u32, interval_us: f64, now_us: u64) -> u8 {
        let is_known = UNASKED.contains(&message)
            || [ATTITUDE_QUATERNION_DATA::ID, AUTOPILOT_STATE_FOR_GIMBAL_DEVICE_DATA::ID].contains(&message);
        // As fast as its loop is too fast.
        let is_too_fast = interval_us <= 1e6 / f64::from(self.loop_rate_hz);
        if !is_known || is_too_fast {
            return DENIED_AS[usize::from(is_known)];
        }
        self.streams.insert(message, (interval_us as u64, self.clock.reads(now_us)));
        ACCEPTED
    }

    /// How long a message takes to the autopilot or back.
    fn way_us(&mut self) -> u64 {
        way_us(&mut self.waits)
    }

    /// The message, where its stream is due.
    fn due<D: MessageData>(&mut self, sample: &Sample, data: &D) -> Vec<u8> {
        let Some((interval_us, due_us)) = self.streams.get_mut(&D::ID) else { return Vec::new() };
        let now_us = sample.arrived_at_us;
        if now_us + LOOP_SLACK_US < *due_us {
            return Vec::new();
        }
        *due_us = (*due_us + *interval_us).max(now_us);
        self.encode(COMPONENT, data)
    }

    fn encode<D: MessageData>(&mut self, component: u8, data: &D) -> Vec<u8> {
        let mut raw = MAVLinkV2MessageRaw::new();
        let header = MavHeader {
            system_id: SYSTEM.into(),
            component_id: self.component.unwrap_or(component),
            sequence: self.sequence,
        };
        self.sequence = self.sequence.wrapping_add(1);
        raw.serialize_message_data(header, data);
        raw.raw_bytes().to_vec()
    }
}

/// MAV_RESULT of a message that it does not know, and of a rate that it does not reach (FAILED).
const DENIED_AS: [u8; 2] = [DENIED, 4];

/// Sets of sources of its estimator.
const SOURCE_SETS: [f64; 3] = [1.0, 2.0, 3.0];

/// What it sends unasked, and how often.
fn unasked() -> BTreeMap<u32, (u64, u64)> {
    UNASKED.iter().map(|message| (*message, (UNASKED_US, 0))).collect()
}
