//! The two ends: connected to where somebody listens, or listened at until somebody connects.

use super::LiveError;
use plumbline_survey::error::InputError;
use std::fmt;
use std::io::{ErrorKind, Read, Write};
use std::net::{SocketAddr, TcpListener, TcpStream, ToSocketAddrs};
use std::str::FromStr;
use std::sync::mpsc::Sender;
use std::thread;
use std::time::{Duration, Instant};

/// How long one attempt to connect may take. Chosen: far above a round trip, and a name's addresses are tried in turn.
const ATTEMPT: Duration = Duration::from_secs(2);
/// Between two looks whether somebody has come. Chosen: short for a person, long for a processor.
const LOOK: Duration = Duration::from_millis(50);
/// How long the other side may take no bytes before it counts as gone. Chosen: a simulator that is paused in a debugger holds
/// them for longer, and then is no vehicle in flight.
const WRITE_MAX: Duration = Duration::from_secs(5);
/// Bytes read at once: some tens of messages.
const READ_BYTES: usize = 4096;

/// An end of a connection, `tcp:HOST:PORT`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct End {
    address: String,
}

impl FromStr for End {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let address = text.strip_prefix("tcp:").ok_or("not of the form tcp:HOST:PORT")?;
        let (host, port) = address.rsplit_once(':').ok_or("not of the form tcp:HOST:PORT")?;
        match port.parse::<u16>() {
            Ok(port) if port > 0 && !host.is_empty() => Ok(End { address: address.to_owned() }),
            _ => Err("not of the form tcp:HOST:PORT".to_owned()),
        }
    }
}

impl fmt::Display for End {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "tcp:{}", self.address)
    }
}

/// Who opens an end's connections.
#[derive(Debug)]
enum Way {
    /// Not known before the first.
    Unknown,
    /// We connect.
    Connect,
    /// The vehicle does.
    Accept(TcpListener),
}

/// An end with its option, ready to be opened, and after a loss once more, in the way that it was opened first.
#[derive(Debug)]
pub struct Door {
    /// `--autopilot`, `--truth` or `--mavlink`.
    pub option: &'static str,
    end: End,
    way: Way,
}

/// What is asked while one waits.
pub trait Waiting {
    /// What is waited for now.
    fn waits(&mut self, what: &str);

    /// Whether to wait no more.
    fn is_interrupted(&self) -> bool;
}

impl Door {
    /// The end of `option`.
    pub fn new(option: &'static str, end: End) -> Self {
        Door { option, end, way: Way::Unknown }
    }

    /// Its option with its end, for sentences.
    pub fn name(&self) -> String {
        format!("{} {}", self.option, self.end)
    }

    /// One attempt: connects, or has somebody connect. Who listens is found out once.
    fn attempt(&mut self, waiting: &mut dyn Waiting) -> Result<Option<TcpStream>, LiveError> {
        let addresses: Vec<SocketAddr> =
            self.end.address.to_socket_addrs().map_err(|error| self.refuse(&error.to_string()))?.collect();
        if let Way::Unknown | Way::Connect = self.way
            && let Some(stream) = addresses.iter().find_map(|a| TcpStream::connect_timeout(a, ATTEMPT).ok())
        {
            self.way = Way::Connect;
            return Ok(Some(stream));
        }
        if let Way::Unknown = self.way {
            let listener = TcpListener::bind(&addresses[..])
                .and_then(|listener| listener.set_nonblocking(true).map(|()| listener));
            let why = |error| self.refuse(&format!("nobody listens there, and it cannot be listened at: {error}"));
            self.way = Way::Accept(listener.map_err(why)?);
            waiting.waits(&format!("{}: nobody listens there, waiting for a connection to it", self.name()));
        }
        match &self.way {
            Way::Accept(listener) => Ok(listener.accept().ok().map(|(stream, _)| stream)),
            _ => Ok(None),
        }
    }

    fn refuse(&self, why: &str) -> InputError {
        InputError::new(format!("{}: {why}", self.name()))
    }

    /// Nobody was there.
    fn nobody(&self, limit: Duration) -> InputError {
        let who = match self.way {
            Way::Connect => "nobody listens there any more",
            _ => "nobody listens there, and nobody connected to it",
        };
        self.refuse(&format!("{who} within {} s", limit.as_secs_f64()))
    }
}

/// A connection of each door, within `limit`. All are listened at from the beginning: a simulator that cannot connect to
/// the second one may give up.
///
/// # Errors
/// One sentence: a name without an address, nobody there, an interrupt.
pub fn open<const DOORS: usize>(
    doors: &mut [Door; DOORS],
    limit: Duration,
    waiting: &mut dyn Waiting,
) -> Result<[TcpStream; DOORS], LiveError> {
    let until = Instant::now() + limit;
    let mut opened: Vec<Option<TcpStream>> = doors.iter().map(|_| None).collect();
    loop {
        for (door, opened) in doors.iter_mut().zip(&mut opened) {
            if opened.is_none() {
                *opened = door.attempt(waiting)?;
            }
        }
        if opened.iter().all(Option::is_some)
            && let Ok(all) = std::mem::take(&mut opened).into_iter().flatten().collect::<Vec<_>>().try_into()
        {
            return Ok(all);
        }
        if waiting.is_interrupted() {
            return Err(LiveError::Interrupted);
        }
        if Instant::now() >= until {
            let missing = doors.iter().zip(&opened).find(|(_, opened)| opened.is_none());
            let Some((door, _)) = missing else { continue };
            return Err(door.nobody(limit).into());
        }
        thread::sleep(LOOK);
    }
}

/// Which of the two.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// What the firmware talks to.
    Autopilot,
    /// What tells the truth.
    Truth,
}

/// Something that came, and when.
#[derive(Debug)]
pub enum Arrival {
    /// Bytes.
    Bytes(Side, Instant, Vec<u8>),
    /// No more will come.
    Closed(Side),
}

/// A connection: what is written, while a thread of its own reads and notes when.
#[derive(Debug)]
pub struct Connection {
    stream: TcpStream,
    name: String,
}

impl Connection {
    /// Begins to read; all that comes goes to `arrivals`.
    ///
    /// # Errors
    /// A system without sockets or threads to spare.
    pub fn begin(stream: TcpStream, name: String, side: Side, arrivals: Sender<Arrival>) -> Result<Self, LiveError> {
        let failed = |error: std::io::Error| LiveError::Lost(format!("{name}: {error}"));
        stream.set_nonblocking(false).map_err(failed)?;
        stream.set_nodelay(true).map_err(failed)?;
        stream.set_write_timeout(Some(WRITE_MAX)).map_err(failed)?;
        let reading = stream.try_clone().map_err(failed)?;
        thread::Builder::new().spawn(move || read(reading, side, &arrivals)).map_err(failed)?;
        Ok(Connection { stream, name })
    }

    /// Sends all of `bytes`.
    ///
    /// # Errors
    /// The other side has gone.
    pub fn send(&mut self, bytes: &[u8]) -> Result<(), LiveError> {
        self.stream.write_all(bytes).map_err(|error| LiveError::Closed(format!("{}: {error}", self.name)))
    }

    /// Its option with its end, for sentences.
    pub fn name(&self) -> &str {
        &self.name
    }
}

impl Drop for Connection {
    fn drop(&mut self) {
        // Its thread's read ends with it.
        let _ = self.stream.shutdown(std::net::Shutdown::Both);
    }
}

fn read(mut stream: TcpStream, side: Side, arrivals: &Sender<Arrival>) {
    let mut buffer = [0; READ_BYTES];
    loop {
        let arrival = match stream.read(&mut buffer) {
            Err(error) if error.kind() == ErrorKind::Interrupted => continue,
            Ok(0) | Err(_) => Arrival::Closed(side),
            Ok(count) => Arrival::Bytes(side, Instant::now(), buffer[..count].to_vec()),
        };
        let is_last = matches!(arrival, Arrival::Closed(_));
        if arrivals.send(arrival).is_err() || is_last {
            return;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    struct Patient(Vec<String>);

    impl Waiting for Patient {
        fn waits(&mut self, what: &str) {
            self.0.push(what.to_owned());
        }

        fn is_interrupted(&self) -> bool {
            false
        }
    }

    #[test]
    fn only_tcp_with_host_and_port_is_an_end() {
        assert_eq!("tcp:127.0.0.1:5760".parse::<End>().unwrap().to_string(), "tcp:127.0.0.1:5760");
        for text in ["udp:127.0.0.1:5760", "tcp:5760", "tcp::5760", "tcp:host:0", "tcp:host:70000", "tcp:host"] {
            assert!(text.parse::<End>().is_err(), "{text}");
        }
    }

    #[test]
    fn who_listens_is_connected_to_and_else_is_waited_for() {
        let there = TcpListener::bind("127.0.0.1:0").unwrap();
        let port = there.local_addr().unwrap().port();
        let free = TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap().port();
        let end = |port: u16| format!("tcp:127.0.0.1:{port}").parse::<End>().unwrap();
        let mut doors = [Door::new("--autopilot", end(free)), Door::new("--truth", end(port))];
        let mut patient = Patient(Vec::new());
        let error = open(&mut doors, Duration::from_millis(60), &mut patient).unwrap_err().to_string();
        assert!(error.contains(&format!("--autopilot tcp:127.0.0.1:{free}")) && error.contains("0.06 s"), "{error}");
        assert_eq!(patient.0.len(), 1);
        let calls = thread::spawn(move || TcpStream::connect(("127.0.0.1", free)).unwrap());
        assert!(open(&mut doors, Duration::from_secs(5), &mut patient).is_ok());
        calls.join().unwrap();
    }
}
