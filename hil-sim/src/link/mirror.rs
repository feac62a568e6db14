//! A link that others can listen to: what autopilot and firmware say to each other goes to a ground station as well, in real time.
//!
//! Whoever listens has no say: what a ground station sends is read and dropped. Nothing of the flight depends on it, its bytes are those
//! of the link alone.

use super::{Account, Event, Flash, Link, LinkError};
use mavlink::dialects::common::{ATTITUDE_DATA, AUTOPILOT_STATE_FOR_GIMBAL_DEVICE_DATA};
use mavlink::{MAVLinkV2MessageRaw, MavHeader, MavlinkVersion, MessageData};
use plumbline_survey::error::InputError;
use std::fmt;
use std::io::{ErrorKind, Read, Write};
use std::net::{SocketAddr, TcpListener, TcpStream, ToSocketAddrs, UdpSocket};
use std::str::FromStr;
use std::thread;
use std::time::{Duration, Instant};

/// How long an attempt to connect may take, and how long a ground station may take no bytes before it counts as gone. Chosen.
const ATTEMPT: Duration = Duration::from_secs(2);
/// Longest datagram: what every network passes in one piece.
const DATAGRAM_MAX: usize = 1_400;
/// Ticks of the capture timer a second.
const TICKS_PER_S: f64 = 1e6;
/// From one ATTITUDE to the next, ticks: a tenth of a second, as ground stations ask for.
const ATTITUDE_TICKS: u32 = 100_000;
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
    Datagrams(UdpSocket),
    /// Connected to where somebody listens.
    Connected(Vec<TcpStream>),
    /// Whoever connects.
    Listening(TcpListener, Vec<TcpStream>),
}

impl Way {
    fn open(station: &Station) -> std::io::Result<Self> {
        let addresses: Vec<SocketAddr> = station.address.to_socket_addrs()?.collect();
        if station.is_udp {
            let first = addresses.first().ok_or_else(|| std::io::Error::from(ErrorKind::AddrNotAvailable))?;
            let socket = UdpSocket::bind(if first.is_ipv4() { "0.0.0.0:0" } else { "[::]:0" })?;
            socket.connect(first)?;
            socket.set_nonblocking(true)?;
            return Ok(Way::Datagrams(socket));
        }
        if let Some(stream) = addresses.iter().find_map(|a| TcpStream::connect_timeout(a, ATTEMPT).ok()) {
            return Ok(Way::Connected(vec![ready(stream)?]));
        }
        let listener = TcpListener::bind(&addresses[..])?;
        listener.set_nonblocking(true)?;
        Ok(Way::Listening(listener, Vec::new()))
    }

    /// Whoever does not take it is left out, not waited for.
    fn send(&mut self, bytes: &[u8]) {
        let (Way::Connected(streams) | Way::Listening(_, streams)) = self else {
            if let Way::Datagrams(socket) = self {
                // Nobody there, or no room: a datagram may get lost.
                let _ = bytes.chunks(DATAGRAM_MAX).try_for_each(|piece| socket.send(piece).map(|_| ()));
                while socket.recv(&mut [0; DATAGRAM_MAX]).is_ok() {}
            }
            return;
        };
        streams.retain_mut(|stream| is_there(stream) && stream.write_all(bytes).is_ok());
        if let Way::Listening(listener, streams) = self {
            streams.extend(listener.accept().ok().and_then(|(stream, _)| ready(stream).ok()));
        }
    }
}

fn ready(stream: TcpStream) -> std::io::Result<TcpStream> {
    stream.set_nodelay(true)?;
    stream.set_write_timeout(Some(ATTEMPT))?;
    stream.set_read_timeout(Some(Duration::from_millis(1)))?;
    Ok(stream)
}

/// Takes what a ground station says; whether it still listens.
fn is_there(stream: &mut TcpStream) -> bool {
    // A read waits for its time-out: only what is there already is looked for.
    let mut one = [0];
    if stream.set_nonblocking(true).is_err() {
        return false;
    }
    let is_there = match stream.peek(&mut one) {
        Ok(0) => false,
        Ok(_) => stream.read(&mut [0; 4096]).is_ok(),
        Err(error) => error.kind() == ErrorKind::WouldBlock,
    };
    stream.set_nonblocking(false).is_ok() && is_there
}

/// A link, and a ground station beside it.
pub struct Mirror {
    link: Box<dyn Link>,
    way: Way,
    /// Simulated seconds in a second.
    speed: f64,
    /// The first step: its tick, and when it was.
    start: Option<(u32, Instant)>,
    /// Tick of the newest ATTITUDE.
    told: Option<u32>,
}

impl fmt::Debug for Mirror {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Mirror").field("way", &self.way).field("speed", &self.speed).finish_non_exhaustive()
    }
}

impl Mirror {
    /// Of a link, `speed` simulated seconds in a second.
    ///
    /// # Errors
    /// The address is none, or cannot be listened at.
    pub fn new(link: Box<dyn Link>, station: &Station, speed: f64) -> Result<Self, InputError> {
        let way = Way::open(station).map_err(|error| InputError::new(format!("--mavlink {station}: {error}")))?;
        Ok(Mirror { link, way, speed, start: None, told: None })
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
        if let Some(attitude) = attitude(bytes).filter(|_| is_due) {
            self.told = Some(timer);
            self.way.send(&attitude);
        }
    }
}

/// The ATTITUDE message of a message for a gimbal; `None` of another one.
fn attitude(bytes: &[u8]) -> Option<Vec<u8>> {
    let (head, behind) = bytes.split_at_checked(HEAD)?;
    let number = u32::from_le_bytes([head[7], head[8], head[9], 0]);
    if number != AUTOPILOT_STATE_FOR_GIMBAL_DEVICE_DATA::ID {
        return None;
    }
    let payload = behind.get(..usize::from(head[1]))?;
    let state = AUTOPILOT_STATE_FOR_GIMBAL_DEVICE_DATA::deser(MavlinkVersion::V2, payload).ok()?;
    let [w, x, y, z] = state.q;
    let attitude = ATTITUDE_DATA {
        time_boot_ms: (state.time_boot_us / 1000) as u32,
        roll: (2.0 * (w * x + y * z)).atan2(1.0 - 2.0 * (x * x + y * y)),
        pitch: (2.0 * (w * y - z * x)).clamp(-1.0, 1.0).asin(),
        yaw: (2.0 * (w * z + x * y)).atan2(1.0 - 2.0 * (y * y + z * z)),
        ..ATTITUDE_DATA::DEFAULT
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
            self.way.send(bytes);
            self.tell_attitude(timer, bytes);
        }
        let sent = self.link.step(timer, event)?;
        if !sent.is_empty() {
            self.way.send(&sent);
        }
        Ok(sent)
    }

    fn reboot(&mut self, flash: &Flash) -> Result<(), LinkError> {
        self.link.reboot(flash)
    }

    fn account(&self) -> Account {
        self.link.account()
    }

    fn annotate(&mut self, bytes: &[u8]) {
        self.link.annotate(bytes);
    }

    fn close_log(&mut self) -> Vec<u8> {
        self.link.close_log()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Answers each step with its event.
    struct Echo;

    impl Link for Echo {
        fn step(&mut self, _: u32, event: Event<'_>) -> Result<Vec<u8>, LinkError> {
            Ok(if let Event::Bytes(bytes) = event { bytes.to_vec() } else { vec![0xEE] })
        }
    }

    #[test]
    fn both_directions_are_heard_and_nothing_changes() {
        let heard = UdpSocket::bind("127.0.0.1:0").expect("a port");
        heard.set_read_timeout(Some(Duration::from_secs(5))).expect("set");
        let station: Station = format!("udp:{}", heard.local_addr().expect("bound")).parse().expect("a station");
        let mut mirror = Mirror::new(Box::new(Echo), &station, 1e3).expect("open");
        assert_eq!(mirror.step(0, Event::Bytes(b"abc")).expect("a step"), b"abc");
        assert_eq!(mirror.step(50_000, Event::Nothing).expect("a step"), [0xEE]);
        for wanted in [&b"abc"[..], b"abc", &[0xEE]] {
            let mut buffer = [0; 16];
            let count = heard.recv(&mut buffer).expect("heard");
            assert_eq!(&buffer[..count], wanted);
        }
    }

    #[test]
    fn a_gimbals_attitude_is_told_as_a_ground_station_shows_it() {
        let (heading, pitch, roll) = (2.0f32, -0.3f32, 0.2f32);
        let half = |angle: f32| (0.5 * angle).sin_cos();
        let ((sy, cy), (sp, cp), (sr, cr)) = (half(heading), half(pitch), half(roll));
        let q = [
            cr * cp * cy + sr * sp * sy,
            sr * cp * cy - cr * sp * sy,
            cr * sp * cy + sr * cp * sy,
            cr * cp * sy - sr * sp * cy,
        ];
        let state = AUTOPILOT_STATE_FOR_GIMBAL_DEVICE_DATA {
            time_boot_us: 7_000_000,
            q,
            ..AUTOPILOT_STATE_FOR_GIMBAL_DEVICE_DATA::DEFAULT
        };
        let mut raw = MAVLinkV2MessageRaw::new();
        raw.serialize_message_data(MavHeader { system_id: 1, component_id: 1, sequence: 9 }, &state);
        let told = attitude(raw.raw_bytes()).expect("an attitude");
        let payload = &told[HEAD..HEAD + usize::from(told[1])];
        let told = ATTITUDE_DATA::deser(MavlinkVersion::V2, payload).expect("a message");
        assert_eq!(told.time_boot_ms, 7000);
        for (told, wanted) in [(told.yaw, heading), (told.pitch, pitch), (told.roll, roll)] {
            assert!((told - wanted).abs() < 1e-5, "{told} {wanted}");
        }
        assert_eq!(attitude(b"short"), None);
    }

    #[test]
    fn a_ground_station_comes_and_goes() {
        let free = TcpListener::bind("127.0.0.1:0").expect("a port").local_addr().expect("bound");
        let station: Station = format!("tcp:{free}").parse().expect("a station");
        let mut mirror = Mirror::new(Box::new(Echo), &station, 1e3).expect("listens");
        mirror.step(0, Event::Nothing).expect("alone");
        let mut stream = TcpStream::connect(free).expect("connected");
        (1..5).for_each(|step| assert_eq!(mirror.step(step, Event::Bytes(b"x")).expect("a step"), b"x"));
        let mut heard = [0; 3];
        stream.read_exact(&mut heard).expect("heard");
        assert_eq!(&heard, b"xxx");
        drop(stream);
        (5..20).for_each(|step| assert_eq!(mirror.step(step, Event::Bytes(b"x")).expect("a step"), b"x"));
    }

    #[test]
    fn it_takes_as_long_as_it_says() {
        let station: Station = "udp:127.0.0.1:9".parse().expect("a station");
        let mut mirror = Mirror::new(Box::new(Echo), &station, 4.0).expect("open");
        let began = Instant::now();
        (0..=4).for_each(|step| drop(mirror.step(50_000 * step, Event::Nothing)));
        assert!(began.elapsed() >= Duration::from_millis(50), "{:?}", began.elapsed());
    }

    #[test]
    fn what_is_no_station_is_refused() {
        for text in ["udp:14550", "tcp::5760", "tcp:localhost:0", "serial:/dev/ttyS0", "udp:host:x"] {
            assert!(text.parse::<Station>().is_err(), "{text}");
        }
    }
}
