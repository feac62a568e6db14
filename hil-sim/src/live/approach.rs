//! Before a live flight: both ends connected, the vehicle found to be a simulated one, its streams asked for.

use super::LiveError;
use super::clock::Clock;
use super::connection::{Arrival, Connection, Door, Side, Waiting, open};
use super::messages::{
    ATTITUDE_QUATERNION, GLOBAL_POSITION_INT, GPS_RAW_INT, Listener, OwnPosition, SIM_STATE, Said, SimState, Speaker,
    VEHICLE, VIBRATION, name,
};
use crate::setup::Start;
use plumbline_survey::error::InputError;
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::time::{Duration, Instant};

/// Rates at which truth and attitude are asked for, hertz, until one is accepted: an autopilot refuses what its loop does not
/// reach. Chosen: at 100 Hz the order of arrival alone leaves 10 ms open, and 10 Hz is the least that an attitude is
/// interpolated from.
const RATES_HZ: [u32; 7] = [100, 80, 50, 40, 25, 20, 10];
/// GPS_RAW_INT a second.
const GNSS_HZ: u32 = 5;
/// How long an answer to a request for a stream may take, and how often it is asked for.
const ACK_WAIT: Duration = Duration::from_millis(1500);
const ACK_TRIES: usize = 3;
/// Between two heartbeats of ours.
const BEAT: Duration = Duration::from_secs(1);
/// A vehicle slower than this stands on the ground, metres a second.
const STANDING_M_S: f64 = 1.0;
/// How far the clock goes beyond the newest stamp, in intervals of the stream: at 100 Hz 30 ms, of which 20 ms are usual, an
/// interval, a simulator's step and the way.
const HOLD_INTERVALS: f64 = 3.0;
/// Longest wait for something to come, while interrupts are looked for.
const LOOK: Duration = Duration::from_millis(20);

/// A vehicle whose streams flow.
#[derive(Debug)]
pub struct Approach {
    pub(super) autopilot: Connection,
    pub(super) truth: Connection,
    pub(super) arrivals: Receiver<Arrival>,
    pub(super) listener: Listener,
    pub(super) heard: Listener,
    pub(super) speaker: Speaker,
    pub(super) clock: Clock,
    /// What seconds of our clock count from.
    pub(super) epoch: Instant,
    /// Truth and attitudes a second.
    pub(super) rate_hz: u32,
    pub(super) is_armed: bool,
    start: Option<Start>,
    position: Option<OwnPosition>,
    systems: [Option<u8>; 2],
    beat: Option<Instant>,
    said: Vec<Said>,
}

/// How long one waits for each thing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    /// Seconds in all for connections, and for the vehicle's first word.
    pub wait: Duration,
}

impl Approach {
    /// Connects through `doors` (autopilot, truth), and has the vehicle's streams begin.
    ///
    /// # Errors
    /// One sentence: nobody there, not MAVLink 2, another system, no simulator, a stream that is denied, an interrupt.
    pub fn begin(doors: &mut [Door; 2], limits: Limits, waiting: &mut dyn Waiting) -> Result<Self, LiveError> {
        let [autopilot, truth] = open(doors, limits.wait, waiting)?;
        let (sender, arrivals) = channel();
        let [own, other] = doors;
        let mut approach = Approach {
            autopilot: Connection::begin(autopilot, own.name(), Side::Autopilot, sender.clone())?,
            truth: Connection::begin(truth, other.name(), Side::Truth, sender)?,
            arrivals,
            listener: Listener::default(),
            heard: Listener::default(),
            speaker: Speaker::default(),
            clock: Clock::new(0.0),
            epoch: Instant::now(),
            rate_hz: 0,
            is_armed: false,
            start: None,
            position: None,
            systems: [None; 2],
            beat: None,
            said: Vec::new(),
        };
        approach.vehicle(limits, waiting)?;
        approach.streams(waiting)?;
        approach.standing(limits, waiting)?;
        Ok(approach)
    }

    /// Where it begins.
    pub fn start(&self) -> Option<Start> {
        self.start
    }

    /// Waits for both heartbeats.
    fn vehicle(&mut self, limits: Limits, waiting: &mut dyn Waiting) -> Result<(), LiveError> {
        waiting.waits("waiting for the autopilot's heartbeat");
        self.wait(limits.wait, waiting, |this| this.systems.iter().all(Option::is_some))?;
        let ends = [(self.autopilot.name(), &self.heard), (self.truth.name(), &self.listener)];
        for ((end, heard), system) in ends.into_iter().zip(self.systems) {
            let seconds = limits.wait.as_secs_f64();
            let why = match system {
                Some(VEHICLE) => continue,
                Some(other) => {
                    format!("the autopilot there is system {other}, and the firmware is of system {VEHICLE}")
                }
                None if heard.messages() > 0 => format!("what came within {seconds} s is no autopilot's"),
                None if heard.skipped_bytes() > 0 => format!("what came within {seconds} s is not MAVLink 2"),
                None => format!("connected, but nothing came within {seconds} s"),
            };
            return Err(InputError::new(format!("{end}: {why}")).into());
        }
        Ok(())
    }

    /// Asks for the streams of the truth, at the highest rate that is accepted. Messages of one rate are sent by one loop.
    fn streams(&mut self, waiting: &mut dyn Waiting) -> Result<(), LiveError> {
        waiting.waits("asking for the truth");
        for rate_hz in RATES_HZ {
            if self.rate_hz == 0 && self.must(ATTITUDE_QUATERNION, rate_hz, waiting)? {
                self.rate_hz = rate_hz;
            }
        }
        if self.rate_hz == 0 {
            return Err(self.denied(ATTITUDE_QUATERNION));
        }
        for (id, rate_hz) in [(SIM_STATE, self.rate_hz), (GLOBAL_POSITION_INT, self.rate_hz), (GPS_RAW_INT, GNSS_HZ)] {
            if !self.must(id, rate_hz, waiting)? {
                return Err(self.denied(id));
            }
        }
        // Without it the truth's instants are less certain.
        self.asked(VIBRATION, self.rate_hz, waiting)?;
        self.clock = Clock::new(HOLD_INTERVALS * 1e6 / f64::from(self.rate_hz));
        Ok(())
    }

    fn denied(&self, id: u32) -> LiveError {
        let simulator = if id == SIM_STATE { "; only a simulated vehicle has it" } else { "" };
        InputError::new(format!("{}: the autopilot does not send {}{simulator}", self.truth.name(), name(id))).into()
    }

    /// Whether a stream was accepted; an autopilot has to answer.
    fn must(&mut self, id: u32, rate_hz: u32, waiting: &mut dyn Waiting) -> Result<bool, LiveError> {
        let silent = InputError::new(format!("{}: no answer to the request for {}", self.truth.name(), name(id)));
        self.asked(id, rate_hz, waiting)?.ok_or_else(|| silent.into())
    }

    /// Whether a stream was accepted; `None` where nobody answers.
    fn asked(&mut self, id: u32, rate_hz: u32, waiting: &mut dyn Waiting) -> Result<Option<bool>, LiveError> {
        for _ in 0..ACK_TRIES {
            let request = self.speaker.interval(id, 1_000_000 / rate_hz);
            self.truth.send(&request)?;
            let mut answer = None;
            self.wait(ACK_WAIT, waiting, |this| {
                let interval = this.said.iter().find_map(|said| match said {
                    Said::Interval(accepted) => Some(*accepted),
                    _ => None,
                });
                answer = interval;
                answer.is_some()
            })?;
            if answer.is_some() {
                return Ok(answer);
            }
        }
        Ok(None)
    }

    /// Waits for a true state, and finds out how high home is.
    fn standing(&mut self, limits: Limits, waiting: &mut dyn Waiting) -> Result<(), LiveError> {
        let mut newest: Option<SimState> = None;
        self.wait(limits.wait, waiting, |this| {
            for said in &this.said {
                if let Said::Truth(state) = said {
                    newest = Some(*state);
                }
            }
            newest.is_some() && this.position.is_some()
        })?;
        let end = self.truth.name();
        let Some((state, position)) = newest.zip(self.position) else {
            let id = if newest.is_none() { SIM_STATE } else { GLOBAL_POSITION_INT };
            let why =
                format!("{end}: {} was promised, and did not come within {} s", name(id), limits.wait.as_secs_f64());
            return Err(InputError::new(why).into());
        };
        let Some([lat, lon]) = state.place_e7 else {
            let why = "SIM_STATE comes without lat_int and lon_int, and its lat and lon step by 0.4 m";
            return Err(InputError::new(format!("{end}: {why}")).into());
        };
        let speed_m_s = state.velocity_ned_m_s.iter().map(|v| v * v).sum::<f64>().sqrt();
        let home_alt_m = if speed_m_s < STANDING_M_S { state.alt_m } else { position.alt_m - position.above_home_m };
        self.start = Some(Start { lat_deg: f64::from(lat) * 1e-7, lon_deg: f64::from(lon) * 1e-7, home_alt_m });
        Ok(())
    }

    /// Takes what comes until `done`, at most for `limit`.
    fn wait(
        &mut self,
        limit: Duration,
        waiting: &mut dyn Waiting,
        mut done: impl FnMut(&Self) -> bool,
    ) -> Result<(), LiveError> {
        let until = Instant::now() + limit;
        while Instant::now() < until {
            if waiting.is_interrupted() {
                return Err(LiveError::Interrupted);
            }
            if self.beat.is_none_or(|beat| beat.elapsed() >= BEAT) {
                self.beat = Some(Instant::now());
                let beat = self.speaker.heartbeat();
                self.truth.send(&beat)?;
            }
            self.said.clear();
            match self.arrivals.recv_timeout(LOOK) {
                Ok(arrival) => self.arrived(arrival)?,
                Err(RecvTimeoutError::Timeout) => continue,
                Err(RecvTimeoutError::Disconnected) => return Err(LiveError::Closed("both ends".to_owned())),
            }
            if done(self) {
                return Ok(());
            }
        }
        Ok(())
    }

    fn arrived(&mut self, arrival: Arrival) -> Result<(), LiveError> {
        match arrival {
            Arrival::Closed(side) => {
                let which = if side == Side::Truth { self.truth.name() } else { self.autopilot.name() };
                return Err(LiveError::Closed(which.to_owned()));
            }
            Arrival::Bytes(Side::Autopilot, _, bytes) => {
                let mut said = Vec::new();
                self.heard.take(&bytes, &mut said);
                let system = said.iter().find_map(|said| heartbeat(said).map(|(system, _)| system));
                self.systems[0] = self.systems[0].or(system);
            }
            Arrival::Bytes(Side::Truth, _, bytes) => {
                self.listener.take(&bytes, &mut self.said);
                for said in &self.said {
                    if let Some((system, is_armed)) = heartbeat(said) {
                        (self.systems[1], self.is_armed) = (self.systems[1].or(Some(system)), is_armed);
                    }
                    if let Said::Position(position) = said {
                        self.position = Some(*position);
                    }
                }
            }
        }
        Ok(())
    }
}

fn heartbeat(said: &Said) -> Option<(u8, bool)> {
    match said {
        Said::Heartbeat { system, is_armed } => Some((*system, *is_armed)),
        _ => None,
    }
}
