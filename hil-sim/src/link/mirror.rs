//! A link that others can listen to: what autopilot and firmware say to each other goes to a ground station as well, in real time.
//!
//! Whoever listens has no say: what a ground station asks for (`answers`) is answered from here, what it orders is declined. Nothing of the
//! flight depends on it, its bytes are those of the link alone.

mod answers;

use super::{Account, Event, Flash, Link, LinkError, Moving};
use answers::{Answers, Listener};
use mavlink::dialects::common::{ATTITUDE_DATA, AUTOPILOT_STATE_FOR_GIMBAL_DEVICE_DATA};
use mavlink::{MAVLinkV2MessageRaw, MavHeader, MavlinkVersion, MessageData};
use plumbline_survey::error::InputError;
use std::fmt;
use std::io::{ErrorKind, Read, Write};
use std::net::{SocketAddr, TcpListener, TcpStream, ToSocketAddrs, UdpSocket};
use std::str::FromStr;
use std::thread;
use std::time::{Duration, Instant};

pub use answers::{Knowledge, Waypoint};

/// How long an attempt to connect may take, and how long a ground station may take no bytes before it counts as gone. Chosen.
const ATTEMPT: Duration = Duration::from_secs(2);
/// Longest datagram: what every network passes in one piece.
const DATAGRAM_MAX: usize = 1_400;
/// Ticks of the capture timer a second.
const TICKS_PER_S: f64 = 1e6;
/// From one ATTITUDE to the next, ticks: a tenth of a second, as ground stations ask for.
const ATTITUDE_TICKS: u32 = 100_000;
/// From one MISSION_CURRENT to the next at most, ticks: a second, as ArduPilot sends it.
const MISSION_TICKS: u32 = 1_000_000;
/// Bytes of a MAVLink 2 message before its payload.
const HEAD: usize = 10;

/// Where ground stations are: `udp:HOST:PORT`, or `tcp:HOST:PORT`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Station {
    is_udp: bool,
    address: String,
}

impl FromStr for Station {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        const FORM: &str = "not of the form udp:HOST:PORT or tcp:HOST:PORT";
        let udp = text.strip_prefix("udp:").map(|address| (true, address));
        let (is_udp, address) = udp.or(text.strip_prefix("tcp:").map(|address| (false, address))).ok_or(FORM)?;
        let (host, port) = address.rsplit_once(':').ok_or(FORM)?;
        match port.parse::<u16>() {
            Ok(port) if port > 0 && !host.is_empty() => Ok(Station { is_udp, address: address.to_owned() }),
            _ => Err(FORM.to_owned()),
        }
    }
}

impl fmt::Display for Station {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}", if self.is_udp { "udp" } else { "tcp" }, self.address)
    }
}

/// The way there.
#[derive(Debug)]
enum Way {
    Datagrams(UdpSocket, Box<Listener>),
    /// Connected to where somebody listens.
    Connected(Vec<(TcpStream, Listener)>),
    /// Whoever connects.
    Listening(TcpListener, Vec<(TcpStream, Listener)>),
}

impl Way {
    fn open(station: &Station) -> std::io::Result<Self> {
        let addresses: Vec<SocketAddr> = station.address.to_socket_addrs()?.collect();
        if station.is_udp {
            let first = addresses.first().ok_or_else(|| std::io::Error::from(ErrorKind::AddrNotAvailable))?;
            let socket = UdpSocket::bind(if first.is_ipv4() { "0.0.0.0:0" } else { "[::]:0" })?;
            socket.connect(first)?;
            socket.set_nonblocking(true)?;
            return Ok(Way::Datagrams(socket, Box::default()));
        }
        if let Some(stream) = addresses.iter().find_map(|a| TcpStream::connect_timeout(a, ATTEMPT).ok()) {
            return Ok(Way::Connected(vec![(ready(stream)?, Listener::default())]));
        }
        let listener = TcpListener::bind(&addresses[..])?;
        listener.set_nonblocking(true)?;
        Ok(Way::Listening(listener, Vec::new()))
    }

    /// Whoever does not take it is left out, not waited for. Whoever asks is answered.
    fn send(&mut self, bytes: &[u8], answers: &mut Answers) {
        let (Way::Connected(streams) | Way::Listening(_, streams)) = self else {
            if let Way::Datagrams(socket, listener) = self {
                // Nobody there, or no room: a datagram may get lost.
                let send =
                    |bytes: &[u8]| drop(bytes.chunks(DATAGRAM_MAX).try_for_each(|piece| socket.send(piece).map(drop)));
                send(bytes);
                let mut heard = [0; DATAGRAM_MAX];
                while let Ok(count) = socket.recv(&mut heard) {
                    send(&answers.to(listener, &heard[..count]));
                }
            }
            return;
        };
        streams.retain_mut(|(stream, listener)| {
            let Some(heard) = heard(stream) else { return false };
            let answer = answers.to(listener, &heard);
            stream.write_all(bytes).is_ok() && stream.write_all(&answer).is_ok()
        });
        if let Way::Listening(listener, streams) = self {
            let accepted = listener.accept().ok().and_then(|(stream, _)| ready(stream).ok());
            streams.extend(accepted.map(|stream| (stream, Listener::default())));
        }
    }
}

fn ready(stream: TcpStream) -> std::io::Result<TcpStream> {
    stream.set_nodelay(true)?;
    stream.set_write_timeout(Some(ATTEMPT))?;
    stream.set_read_timeout(Some(Duration::from_millis(1)))?;
    Ok(stream)
}

/// What a ground station has said; `None` where it listens no more.
fn heard(stream: &mut TcpStream) -> Option<Vec<u8>> {
    // A read waits for its time-out: only what is there already is looked for.
    stream.set_nonblocking(true).ok()?;
    let mut bytes = vec![0; 4096];
    let count = match stream.read(&mut bytes) {
        Ok(0) => None,
        Ok(count) => Some(count),
        Err(error) => (error.kind() == ErrorKind::WouldBlock).then_some(0),
    }?;
    stream.set_nonblocking(false).ok()?;
    bytes.truncate(count);
    Some(bytes)
}

/// The way to a ground station, open before there is a flight to tell of.
#[derive(Debug)]
pub struct Opened(Way);

impl Opened {
    /// Connects, or listens where nobody does.
    ///
    /// # Errors
    /// The address is none, or cannot be listened at.
    pub fn new(station: &Station) -> Result<Self, InputError> {
        let way = Way::open(station).map_err(|error| InputError::new(format!("--mavlink {station}: {error}")))?;
        Ok(Opened(way))
    }

    /// Where it listens; `None` where it goes to somebody itself.
    pub fn listens_at(&self) -> Option<SocketAddr> {
        let Way::Listening(listener, _) = &self.0 else { return None };
        listener.local_addr().ok()
    }
}

/// A link, and a ground station beside it.
pub struct Mirror {
    link: Box<dyn Link>,
    way: Way,
    answers: Answers,
    /// Simulated seconds in a second.
    speed: f64,
    /// The first step: its tick, and when it was.
    start: Option<(u32, Instant)>,
    /// Tick of the newest ATTITUDE.
    told: Option<u32>,
    /// How the vehicle moves.
    moving: Option<Moving>,
    /// Tick of the newest MISSION_CURRENT, and its waypoint.
    mission: Option<(u32, usize)>,
}

impl fmt::Debug for Mirror {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Mirror").field("way", &self.way).field("speed", &self.speed).finish_non_exhaustive()
    }
}

impl Mirror {
    /// Of a link, `speed` simulated seconds in a second; who asks is told what is known of the flight.
    pub fn new(link: Box<dyn Link>, Opened(way): Opened, speed: f64, knowledge: &Knowledge) -> Self {
        let answers = Answers::new(knowledge);
        Mirror { link, way, answers, speed, start: None, told: None, moving: None, mission: None }
    }

    /// Waits until it is time for a step.
    fn keep_pace(&mut self, timer: u32) {
        let (first, began) = *self.start.get_or_insert_with(|| (timer, Instant::now()));
        let due = Duration::from_secs_f64(f64::from(timer.wrapping_sub(first)) / TICKS_PER_S / self.speed);
        thread::sleep(due.saturating_sub(began.elapsed()));
    }

    /// The autopilot sends its attitude as the firmware asks for it, for a camera's gimbal; a ground station shows ATTITUDE.
    fn tell_attitude(&mut self, timer: u32, bytes: &[u8]) {
        let is_due = self.told.is_none_or(|told| timer.wrapping_sub(told) >= ATTITUDE_TICKS);
        let rates_rad_s = self.moving.map_or([0.0; 3], |moving| moving.rates_rad_s);
        if let Some(attitude) = attitude(bytes, rates_rad_s).filter(|_| is_due) {
            self.told = Some(timer);
            self.way.send(&attitude, &mut self.answers);
        }
    }

    /// The item of the mission that is flown to: when it changes, and once a second.
    fn tell_mission(&mut self, timer: u32) {
        let Some(waypoint) = self.moving.and_then(|moving| moving.waypoint) else { return };
        let is_new = |(told, other): (u32, usize)| other != waypoint || timer.wrapping_sub(told) >= MISSION_TICKS;
        if self.mission.is_none_or(is_new) {
            self.mission = Some((timer, waypoint));
            let current = self.answers.current(waypoint);
            self.way.send(&current, &mut self.answers);
        }
    }
}

/// The ATTITUDE message of a message for a gimbal, which has no rates; `None` of another one.
fn attitude(bytes: &[u8], rates_rad_s: [f64; 3]) -> Option<Vec<u8>> {
    let (head, behind) = bytes.split_at_checked(HEAD)?;
    let number = u32::from_le_bytes([head[7], head[8], head[9], 0]);
    if number != AUTOPILOT_STATE_FOR_GIMBAL_DEVICE_DATA::ID {
        return None;
    }
    let payload = behind.get(..usize::from(head[1]))?;
    let state = AUTOPILOT_STATE_FOR_GIMBAL_DEVICE_DATA::deser(MavlinkVersion::V2, payload).ok()?;
    let [w, x, y, z] = state.q;
    let [rollspeed, pitchspeed, yawspeed] = rates_rad_s.map(|rate| rate as f32);
    let attitude = ATTITUDE_DATA {
        time_boot_ms: (state.time_boot_us / 1000) as u32,
        roll: (2.0 * (w * x + y * z)).atan2(1.0 - 2.0 * (x * x + y * y)),
        pitch: (2.0 * (w * y - z * x)).clamp(-1.0, 1.0).asin(),
        yaw: (2.0 * (w * z + x * y)).atan2(1.0 - 2.0 * (y * y + z * z)),
        rollspeed,
        pitchspeed,
        yawspeed,
    };
    let mut raw = MAVLinkV2MessageRaw::new();
    let header = MavHeader { system_id: head[5].into(), component_id: head[6], sequence: head[4] };
    raw.serialize_message_data(header, &attitude);
    Some(raw.raw_bytes().to_vec())
}

impl Link for Mirror {
    fn step(&mut self, timer: u32, event: Event<'_>) -> Result<Vec<u8>, LinkError> {
        self.keep_pace(timer);
        if let Event::Bytes(bytes) = event {
            self.way.send(bytes, &mut self.answers);
            self.tell_attitude(timer, bytes);
            self.tell_mission(timer);
        }
        let sent = self.link.step(timer, event)?;
        if !sent.is_empty() {
            self.way.send(&sent, &mut self.answers);
        }
        Ok(sent)
    }

    fn reboot(&mut self, flash: &Flash) -> Result<(), LinkError> {
        self.link.reboot(flash)
    }

    fn account(&self) -> Account {
        self.link.account()
    }

    fn show(&mut self, moving: &dyn Fn() -> Moving) {
        self.moving = Some(moving());
    }

    fn annotate(&mut self, bytes: &[u8]) {
        self.link.annotate(bytes);
    }

    fn close_log(&mut self) -> Vec<u8> {
        self.link.close_log()
    }
}

#[cfg(test)]
mod tests;
