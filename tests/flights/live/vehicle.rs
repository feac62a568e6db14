//! A vehicle that flies circles and tells of it over two sockets, as a simulated autopilot does.

use mavlink::dialects::common::{
    ATTITUDE_QUATERNION_DATA, DISTANCE_SENSOR_DATA, GLOBAL_POSITION_INT_DATA, GPS_RAW_INT_DATA, GpsFixType,
    HEARTBEAT_DATA, MavAutopilot, MavDistanceSensor, MavMessage, MavModeFlag, MavSensorOrientation, MavState, MavType,
    SIM_STATE_DATA, TIMESYNC_DATA, VIBRATION_DATA,
};
use mavlink::error::ParserError;
use mavlink::{MAVLinkV2MessageRaw, MavHeader, MavlinkVersion, MessageData};
use plumbline_firmware::wire::command::{ACCEPTED, Acknowledgement, Command, DENIED, SET_MESSAGE_INTERVAL};
use plumbline_firmware::wire::decoder::Decoder;
use plumbline_survey::crs::Crs;
use std::collections::BTreeMap;
use std::io::{ErrorKind, Read, Write};
use std::net::{TcpListener, TcpStream};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::thread;
use std::time::{Duration, Instant};

/// Where it circles: grid of UTM zone 33, and how high home is.
pub const EPSG: u32 = 32633;
pub const CENTRE: [f64; 2] = [560_000.0, 5_330_000.0];
pub const HOME_M: f64 = 250.0;
const HEIGHT_M: f64 = 120.0;
const RADIUS_M: f64 = 300.0;
const SPEED_M_S: f64 = 25.0;
/// Its loop: steps of its clock, microseconds.
const STEP_US: u64 = 5000;
/// How old its estimated attitude is.
pub const DELAY_US: u64 = 16_000;
/// How far off it believes to be, metres east.
pub const OFF_M: f64 = 3.0;

/// How it behaves.
#[derive(Clone, Copy, Debug)]
pub struct Manner {
    /// Its clock against ours.
    pub speed: f64,
    /// Its system id.
    pub system: u8,
    /// A message that it denies.
    pub denies: u32,
    /// When its clock stands still for how long of our time: seconds of its own clock, and ours.
    pub pause: (f64, f64),
    /// When satellite navigation is lost, seconds of its clock.
    pub lost_s: f64,
}

impl Default for Manner {
    fn default() -> Self {
        Manner { speed: 1.0, system: 1, denies: u32::MAX, pause: (f64::INFINITY, 0.0), lost_s: f64::INFINITY }
    }
}

/// SIM_STATE with its extension fields.
#[derive(Clone, Debug, PartialEq)]
struct SimState(SIM_STATE_DATA, [i32; 2]);

impl MessageData for SimState {
    type Message = MavMessage;
    const ID: u32 = SIM_STATE_DATA::ID;
    const NAME: &'static str = SIM_STATE_DATA::NAME;
    const EXTRA_CRC: u8 = SIM_STATE_DATA::EXTRA_CRC;
    const ENCODED_LEN: usize = SIM_STATE_DATA::ENCODED_LEN + 8;

    fn ser(&self, version: MavlinkVersion, payload: &mut [u8]) -> usize {
        let base = SIM_STATE_DATA::ENCODED_LEN;
        self.0.ser(version, payload);
        payload[base..base + 4].copy_from_slice(&self.1[0].to_le_bytes());
        payload[base + 4..base + 8].copy_from_slice(&self.1[1].to_le_bytes());
        base + 8
    }

    fn deser(_: MavlinkVersion, _: &[u8]) -> Result<Self, ParserError> {
        unreachable!("nobody sends it one")
    }
}

/// What the firmware sent.
#[derive(Debug, Default)]
pub struct Heard {
    /// Messages by sender and id.
    pub messages: BTreeMap<(u8, u8, u32), u32>,
    /// Bytes that belonged to none.
    pub skipped: u32,
    /// All of them.
    pub bytes: u64,
}

/// A vehicle on its own thread until it is dropped.
#[derive(Debug)]
pub struct Vehicle {
    /// Ports of the autopilot's end and of the truth's.
    pub ports: [u16; 2],
    pub heard: Arc<Mutex<Heard>>,
    stop: Arc<AtomicBool>,
}

impl Vehicle {
    /// Listens at two ports and begins to fly when both are connected to.
    pub fn new(manner: Manner) -> Self {
        let listeners = [(); 2].map(|()| TcpListener::bind("127.0.0.1:0").expect("a port"));
        let ports = listeners.each_ref().map(|listener| listener.local_addr().expect("an address").port());
        let (heard, stop) = (Arc::new(Mutex::new(Heard::default())), Arc::new(AtomicBool::new(false)));
        let (to, until) = (Arc::clone(&heard), Arc::clone(&stop));
        thread::spawn(move || {
            let ends = listeners.map(|listener| End::new(listener.accept().expect("a connection").0));
            Flying { manner, ends, clock_us: 5_000_000, heard: to }.fly(&until);
        });
        Vehicle { ports, heard, stop }
    }
}

impl Drop for Vehicle {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
    }
}

/// A connection with the intervals of the streams that were asked for on it.
struct End {
    stream: TcpStream,
    decoder: Decoder,
    streams: BTreeMap<u32, u64>,
    sequence: u8,
}

impl End {
    fn new(stream: TcpStream) -> Self {
        stream.set_nonblocking(true).expect("a socket");
        stream.set_nodelay(true).expect("a socket");
        End { stream, decoder: Decoder::new(), streams: BTreeMap::new(), sequence: 0 }
    }

    fn send<D: MessageData>(&mut self, system: u8, data: &D) -> bool {
        let mut raw = MAVLinkV2MessageRaw::new();
        let header = MavHeader { system_id: system.into(), component_id: 1, sequence: self.sequence };
        self.sequence = self.sequence.wrapping_add(1);
        raw.serialize_message_data(header, data);
        let mut rest = raw.raw_bytes();
        while !rest.is_empty() {
            match self.stream.write(rest) {
                Ok(count) => rest = &rest[count..],
                Err(error) if error.kind() == ErrorKind::WouldBlock => thread::yield_now(),
                Err(_) => return false,
            }
        }
        true
    }

    /// Whether a stream is due: those of one interval are together.
    fn is_due(&self, id: u32, now_us: u64) -> bool {
        self.streams.get(&id).is_some_and(|interval_us| now_us.is_multiple_of((*interval_us).max(STEP_US)))
    }
}

/// An answer, to be sent on its connection; whether that lives.
type Answer = Box<dyn Fn(&mut End) -> bool>;

struct Flying {
    manner: Manner,
    ends: [End; 2],
    clock_us: u64,
    heard: Arc<Mutex<Heard>>,
}

impl Flying {
    fn fly(&mut self, stop: &AtomicBool) {
        let crs = Crs::from_epsg(EPSG).expect("a known system");
        let mut due = Instant::now();
        while !stop.load(Ordering::Relaxed) {
            self.clock_us += STEP_US;
            due += Duration::from_secs_f64(1e-6 * STEP_US as f64 / self.manner.speed);
            let (at_s, long_s) = self.manner.pause;
            if 1e-6 * self.clock_us as f64 >= at_s {
                due += Duration::from_secs_f64(long_s);
                self.manner.pause.0 = f64::INFINITY;
            }
            thread::sleep(due.saturating_duration_since(Instant::now()));
            if !(0..2).all(|end| self.answer(end) && self.stream(end, &crs)) {
                return;
            }
        }
    }

    /// Answers what came in; whether the connection lives.
    fn answer(&mut self, end: usize) -> bool {
        let (system, clock_us, denies) = (self.manner.system, self.clock_us, self.manner.denies);
        let mut answers: Vec<Answer> = Vec::new();
        loop {
            let room = self.ends[end].decoder.free().len();
            let mut buffer = vec![0; room];
            let count = match self.ends[end].stream.read(&mut buffer) {
                Ok(0) => return false,
                Ok(count) => count,
                Err(error) if error.kind() == ErrorKind::WouldBlock => break,
                Err(_) => return false,
            };
            let End { decoder, streams, .. } = &mut self.ends[end];
            decoder.free()[..count].copy_from_slice(&buffer[..count]);
            decoder.filled(count);
            while let Some(packet) = decoder.next() {
                if end == 0 {
                    let mut heard = self.heard.lock().expect("nobody panics with it");
                    *heard.messages.entry((packet.system, packet.component, packet.id)).or_default() += 1;
                }
                if packet.id == TIMESYNC_DATA::ID {
                    let asked = TIMESYNC_DATA::deser(MavlinkVersion::V2, packet.payload).expect("a payload");
                    let answer = TIMESYNC_DATA { tc1: clock_us as i64 * 1000, ts1: asked.ts1 };
                    answers.push(Box::new(move |end| end.send(system, &answer)));
                } else if packet.id == Command::ID {
                    let command = Command::deser(MavlinkVersion::V2, packet.payload).expect("a payload");
                    let [id, interval_us] = command.parameters;
                    let accepted = command.command == SET_MESSAGE_INTERVAL && id as u32 != denies;
                    if accepted {
                        streams.insert(id as u32, interval_us as u64);
                    }
                    let result = if accepted { ACCEPTED } else { DENIED };
                    let answer = Acknowledgement { command: command.command, result, target: (0, 0) };
                    answers.push(Box::new(move |end| end.send(system, &answer)));
                }
            }
            if end == 0 {
                let mut heard = self.heard.lock().expect("nobody panics with it");
                heard.bytes += count as u64;
                heard.skipped = self.ends[end].decoder.counters().skipped_bytes;
            }
        }
        answers.iter().all(|answer| answer(&mut self.ends[end]))
    }

    /// Sends what is due; whether the connection lives.
    fn stream(&mut self, end: usize, crs: &Crs) -> bool {
        let (now_us, manner) = (self.clock_us, self.manner);
        let (system, end) = (manner.system, &mut self.ends[end]);
        let time_boot_ms = (now_us / 1000) as u32;
        let mut lives = true;
        if now_us.is_multiple_of(1_000_000) {
            lives &= end.send(system, &heartbeat());
        }
        if end.is_due(ATTITUDE_QUATERNION_DATA::ID, now_us) {
            let [q1, q2, q3, q4] = attitude(now_us - DELAY_US, crs);
            let [rollspeed, pitchspeed, yawspeed] = [0.0; 3];
            let data = ATTITUDE_QUATERNION_DATA { time_boot_ms, q1, q2, q3, q4, rollspeed, pitchspeed, yawspeed };
            lives &= end.send(system, &data);
        }
        if end.is_due(GLOBAL_POSITION_INT_DATA::ID, now_us) {
            lives &= end.send(system, &own_position(now_us, crs));
        }
        if end.is_due(GPS_RAW_INT_DATA::ID, now_us) {
            lives &= end.send(system, &gnss(1e-6 * now_us as f64 >= manner.lost_s));
        }
        if end.is_due(SIM_STATE_DATA::ID, now_us) {
            lives &= end.send(system, &sim_state(now_us, crs));
        }
        if end.is_due(VIBRATION_DATA::ID, now_us) {
            let data = VIBRATION_DATA { time_usec: now_us, ..VIBRATION_DATA::DEFAULT };
            lives &= end.send(system, &data);
        }
        if end.is_due(DISTANCE_SENSOR_DATA::ID, now_us) {
            lives &= end.send(system, &range(now_us));
        }
        lives
    }
}

/// Place on the grid, and velocity east and north.
fn place(at_us: u64) -> ([f64; 2], [f64; 2]) {
    let along = SPEED_M_S / RADIUS_M * 1e-6 * at_us as f64;
    let (sin, cos) = along.sin_cos();
    ([CENTRE[0] + RADIUS_M * sin, CENTRE[1] + RADIUS_M * cos], [SPEED_M_S * cos, -SPEED_M_S * sin])
}

/// Pitch and roll.
fn tilt(at_us: u64) -> [f64; 2] {
    let at_s = 1e-6 * at_us as f64;
    [0.04 * (1.1 * at_s).sin(), 0.1 + 0.12 * (1.7 * at_s).sin()]
}

fn attitude(at_us: u64, crs: &Crs) -> [f32; 4] {
    let ([east, north], [ve, vn]) = place(at_us);
    let heading = ve.atan2(vn) + crs.convergence_rad(east, north).expect("on the grid");
    let [pitch, roll] = tilt(at_us);
    let [(sy, cy), (sp, cp), (sr, cr)] = [heading, pitch, roll].map(|angle| (0.5 * angle).sin_cos());
    [cr * cp * cy + sr * sp * sy, sr * cp * cy - cr * sp * sy, cr * sp * cy + sr * cp * sy, cr * cp * sy - sr * sp * cy]
        .map(|x: f64| x as f32)
}

fn e7(place: [f64; 2], crs: &Crs) -> [i32; 2] {
    let (lat, lon) = crs.to_wgs84(place[0], place[1]).expect("on the grid");
    [lat, lon].map(|degrees| (degrees * 1e7).round() as i32)
}

fn sim_state(at_us: u64, crs: &Crs) -> SimState {
    let ([east, north], [ve, vn]) = place(at_us);
    let convergence = crs.convergence_rad(east, north).expect("on the grid");
    let (sin, cos) = convergence.sin_cos();
    let [q1, q2, q3, q4] = attitude(at_us, crs);
    let (true_east, true_north) = (ve * cos + vn * sin, vn * cos - ve * sin);
    let (vn, ve, alt) = (true_north as f32, true_east as f32, (HOME_M + HEIGHT_M) as f32);
    SimState(SIM_STATE_DATA { q1, q2, q3, q4, alt, vn, ve, ..SIM_STATE_DATA::DEFAULT }, e7([east, north], crs))
}

fn own_position(at_us: u64, crs: &Crs) -> GLOBAL_POSITION_INT_DATA {
    let ([east, north], [ve, vn]) = place(at_us);
    let [lat, lon] = e7([east + OFF_M, north], crs);
    GLOBAL_POSITION_INT_DATA {
        time_boot_ms: (at_us / 1000) as u32,
        lat,
        lon,
        alt: ((HOME_M + HEIGHT_M) * 1000.0) as i32,
        relative_alt: (HEIGHT_M * 1000.0) as i32,
        vx: (vn * 100.0) as i16,
        vy: (ve * 100.0) as i16,
        vz: 0,
        hdg: u16::MAX,
    }
}

fn range(at_us: u64) -> DISTANCE_SENSOR_DATA {
    let [pitch, roll] = tilt(at_us);
    DISTANCE_SENSOR_DATA {
        time_boot_ms: (at_us / 1000) as u32,
        min_distance: 20,
        max_distance: 30_000,
        current_distance: (100.0 * HEIGHT_M / (pitch.cos() * roll.cos())).round() as u16,
        mavtype: MavDistanceSensor::MAV_DISTANCE_SENSOR_LASER,
        id: 0,
        orientation: MavSensorOrientation::MAV_SENSOR_ROTATION_PITCH_270,
        covariance: u8::MAX,
    }
}

fn gnss(is_lost: bool) -> GPS_RAW_INT_DATA {
    let fix_type = if is_lost { GpsFixType::GPS_FIX_TYPE_NO_FIX } else { GpsFixType::GPS_FIX_TYPE_3D_FIX };
    GPS_RAW_INT_DATA { fix_type, ..GPS_RAW_INT_DATA::DEFAULT }
}

fn heartbeat() -> HEARTBEAT_DATA {
    HEARTBEAT_DATA {
        custom_mode: 10,
        mavtype: MavType::MAV_TYPE_FIXED_WING,
        autopilot: MavAutopilot::MAV_AUTOPILOT_ARDUPILOTMEGA,
        base_mode: MavModeFlag::MAV_MODE_FLAG_SAFETY_ARMED,
        system_status: MavState::MAV_STATE_ACTIVE,
        mavlink_version: 3,
    }
}
