//! A live flight: everything as it comes, in real time.

mod camera;
mod talk;

use super::LiveError;
use super::approach::Approach;
use super::connection::{Arrival, Connection, Side};
use super::frames::{Exposures, Job, Made, make};
use super::messages::{Listener, Said, Speaker};
use super::navigation::{Navigation, NavigationLog};
use super::report::{AttitudeStream, ClockTime, ExposureCounts, Live, TruthTime};
use super::truth::{Place, Truth};
use crate::fault::FaultCounts;
use crate::ground_station::GroundStation;
use crate::link::{Event, Link, annotation};
use crate::live::clock::Clock;
use crate::run::{Flight, FrameRecord, Keep, Observer};
use crate::scenario::{COOL_DOWN_US, Run, Scenario};
use crate::setup::Setup;
use crate::vehicle::motion::Recorded;
use crate::vehicle::sensors::{Exposure, TimerModel};
use crate::vehicle::servo::{follow_up_exact, wrapped};
use std::collections::VecDeque;
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::thread;
use std::time::{Duration, Instant};

/// Longest wait for something to come: a tenth of what an attitude may be late.
const LOOK: Duration = Duration::from_millis(2);
/// Longest time without a step, microseconds: the firmware's own timers run by the steps.
const STEP_MAX_US: f64 = 5000.0;
/// Exchanges before the firmware is started: a second and a half, so that the relation has a rate of its own.
const EXCHANGES_MIN: u64 = 30;
/// Frames whose timer's walk is made beforehand: ten hours at 4 Hz; later its rate stays.
const WALK_FRAMES: u32 = 144_000;

/// What is flown, and for how long.
#[derive(Clone, Copy, Debug)]
pub struct Wanted {
    /// Frames after which it ends.
    pub frames: Option<u32>,
    /// What is kept of the pictures.
    pub keep: Keep,
    /// Flights begun before this one.
    pub reconnects: u32,
}

/// A finished live flight.
#[derive(Debug)]
pub struct Flown {
    /// As every other flight.
    pub flight: Flight,
    /// The camera's truth, for [`Motion::recorded`](crate::vehicle::motion::Motion::recorded).
    pub motion: Vec<Recorded>,
    /// What is told of it beside.
    pub live: Live,
    /// The autopilot's own position against the truth.
    pub navigation: Option<Navigation>,
}

/// Flies until the frames are taken, the vehicle disarms, a connection closes or `observer` ends it. `judge` sees the finished
/// frames in a thread of its own: its work is none of real time. `None`: a connection closed before the vehicle was armed, as
/// when an autopilot boots anew.
///
/// # Errors
/// The firmware is lost, or a thread cannot be had.
pub fn fly(
    setup: &Setup,
    place: &Place,
    link: &mut dyn Link,
    approach: Approach,
    wanted: &Wanted,
    observer: &mut dyn Observer,
    judge: &mut (dyn Observer + Send),
) -> Result<Option<Flown>, LiveError> {
    link.annotate(&annotation::scene(setup.tile_centre, setup.scenario.vehicle.resolution_m));
    thread::scope(|scope| {
        let (jobs, to_make) = channel();
        let (finished, made) = channel();
        thread::Builder::new()
            .spawn_scoped(scope, move || make(setup, &to_make, &finished))
            .map_err(|error| LiveError::Lost(format!("no thread for the pictures: {error}")))?;
        let (closed, to_judge) = channel::<FrameRecord>();
        thread::Builder::new()
            .spawn_scoped(scope, move || to_judge.iter().for_each(|record| judge.finished(setup, &record)))
            .map_err(|error| LiveError::Lost(format!("no thread for the frames: {error}")))?;
        let mut flying = Flying::new(setup, place, link, approach, wanted, (jobs, made, closed));
        let ended = flying.fly(observer)?;
        flying.close(f64::INFINITY);
        Ok(flying.was_armed.then(|| flying.finish(ended)))
    })
}

/// A flight in the air.
struct Flying<'s> {
    setup: &'s Setup,
    place: &'s Place,
    link: &'s mut dyn Link,
    wanted: Wanted,
    autopilot: Connection,
    truth_end: Connection,
    arrivals: Receiver<Arrival>,
    /// What the truth's end says, and the autopilot's.
    listeners: [Listener; 2],
    speaker: Speaker,
    clock: Clock,
    epoch: Instant,
    rate_hz: u32,
    is_armed: bool,
    was_armed: bool,
    truth: Truth,
    samples: u64,
    log: NavigationLog,
    timer: TimerModel,
    station: GroundStation,
    exposures: Exposures,
    /// Exposed, and their truth has not come.
    waiting: VecDeque<Exposure>,
    /// Pictures that are being made, and those whose frames have not arrived yet.
    in_making: usize,
    ready: VecDeque<Made>,
    jobs: Sender<Job>,
    made: Receiver<Made>,
    to_judge: Sender<FrameRecord>,
    frames: Vec<FrameRecord>,
    closed: usize,
    counts: ExposureCounts,
    deliveries_ms: (f64, f64),
    /// The autopilot's time that the board has reached, and that of the first exposure.
    now_us: f64,
    begin_us: Option<f64>,
    steps: u64,
    /// Follow-up angles commanded, and when.
    commands: Vec<(f64, f64)>,
    /// Our TIMESYNC requests and the firmware's: their stamps, and when they were sent.
    asked: [VecDeque<(i64, f64)>; 2],
    exchanges: Vec<(f64, f64)>,
    /// Stamps of the attitudes that the firmware got, and when they arrived, microseconds.
    attitudes: [Vec<[f64; 2]>; 2],
    bytes: [u64; 2],
    next_sync_s: f64,
    next_beat_s: f64,
}

impl<'s> Flying<'s> {
    fn new(
        setup: &'s Setup,
        place: &'s Place,
        link: &'s mut dyn Link,
        approach: Approach,
        wanted: &Wanted,
        (jobs, made, to_judge): (Sender<Job>, Receiver<Made>, Sender<FrameRecord>),
    ) -> Self {
        let scenario = &setup.scenario;
        let run = Run { frames: scenario.run.frames.min(WALK_FRAMES), ..scenario.run.clone() };
        let is_armed = approach.is_armed;
        Flying {
            setup,
            place,
            link,
            wanted: *wanted,
            autopilot: approach.autopilot,
            truth_end: approach.truth,
            arrivals: approach.arrivals,
            listeners: [approach.listener, approach.heard],
            speaker: approach.speaker,
            clock: approach.clock,
            epoch: approach.epoch,
            rate_hz: approach.rate_hz,
            is_armed,
            was_armed: is_armed,
            truth: Truth::default(),
            samples: 0,
            log: NavigationLog::default(),
            timer: TimerModel::new(&Scenario { run, ..scenario.clone() }),
            station: GroundStation::default(),
            exposures: Exposures::new(scenario),
            waiting: VecDeque::new(),
            in_making: 0,
            ready: VecDeque::new(),
            jobs,
            made,
            to_judge,
            frames: Vec::new(),
            closed: 0,
            counts: ExposureCounts::default(),
            deliveries_ms: (0.0, 0.0),
            now_us: 0.0,
            begin_us: None,
            steps: 0,
            commands: Vec::new(),
            asked: [VecDeque::new(), VecDeque::new()],
            exchanges: Vec::new(),
            attitudes: [Vec::new(), Vec::new()],
            bytes: [0; 2],
            next_sync_s: 0.0,
            next_beat_s: 0.0,
        }
    }

    /// What ended it.
    fn fly(&mut self, observer: &mut dyn Observer) -> Result<&'static str, LiveError> {
        loop {
            let arrived = match self.arrivals.recv_timeout(LOOK) {
                Ok(arrival) => self.arrived(arrival),
                Err(RecvTimeoutError::Timeout) => Ok(()),
                Err(RecvTimeoutError::Disconnected) => return Ok("closed"),
            };
            let wall_s = self.wall_s(Instant::now());
            match arrived.and_then(|()| self.talk(wall_s)).and_then(|()| self.go_on(wall_s, observer)) {
                Err(LiveError::Closed(_)) => return Ok("closed"),
                other => other?,
            }
            if observer.is_interrupted() {
                return Ok("interrupted");
            }
            if self.was_armed && !self.is_armed {
                return Ok("disarmed");
            }
            if self.is_complete() {
                return Ok("frames");
            }
        }
    }

    /// Whether all frames that were wanted have been taken, and the firmware has had the time to report the last.
    fn is_complete(&self) -> bool {
        let last = self.frames.last().map_or(f64::INFINITY, |record| record.exposure.readout_start_us as f64);
        self.wanted.frames.is_some_and(|frames| self.frames.len() >= frames as usize)
            && self.now_us > last + COOL_DOWN_US as f64
    }

    fn wall_s(&self, at: Instant) -> f64 {
        at.saturating_duration_since(self.epoch).as_secs_f64()
    }

    /// What the board knows of an instant of ours; nothing before the clock is known.
    fn board_us(&self, wall_s: f64) -> Option<f64> {
        let at_us = self.clock.at(wall_s).filter(|_| self.clock.errors().exchanges >= EXCHANGES_MIN)?;
        Some(at_us.max(self.now_us))
    }

    fn arrived(&mut self, arrival: Arrival) -> Result<(), LiveError> {
        match arrival {
            Arrival::Closed(Side::Autopilot) => Err(LiveError::Closed(self.autopilot.name().to_owned())),
            Arrival::Closed(Side::Truth) => Err(LiveError::Closed(self.truth_end.name().to_owned())),
            Arrival::Bytes(Side::Truth, at, bytes) => {
                let wall_s = self.wall_s(at);
                let mut said = Vec::new();
                self.listeners[0].take(&bytes, &mut said);
                said.into_iter().try_for_each(|said| self.told(said, wall_s))
            }
            Arrival::Bytes(Side::Autopilot, at, bytes) => {
                let wall_s = self.wall_s(at);
                self.overheard(&bytes, wall_s);
                // What came before the board was on is lost, as on a board.
                let Some(at_us) = self.board_us(wall_s) else { return Ok(()) };
                self.edges(at_us)?;
                self.bytes[0] += bytes.len() as u64;
                self.step(at_us, Event::Bytes(&bytes))
            }
        }
    }

    /// Something on the truth's end.
    fn told(&mut self, said: Said, wall_s: f64) -> Result<(), LiveError> {
        match said {
            Said::Heartbeat { is_armed, .. } => {
                self.is_armed = is_armed;
                self.was_armed |= is_armed;
            }
            Said::Attitude(time_boot_ms, attitude) => {
                self.clock.stamped(wall_s, f64::from(time_boot_ms) * 1000.0);
                self.truth.attitude(time_boot_ms, attitude, wall_s);
            }
            Said::Truth(sim) => {
                self.samples += 1;
                let state = self.place.state(&sim)?;
                self.truth.state(sim.attitude, state, wall_s);
            }
            Said::Stamp(stamp_us) => self.truth.stamp(stamp_us as f64),
            Said::Position(position) => self.log.position(position),
            Said::Gnss(fix) => {
                if let Some(at_us) = self.clock.at(wall_s) {
                    self.log.gnss(fix, at_us);
                }
            }
            Said::Timesync { sent_ns, theirs_us } => {
                if let Some(sent_s) = taken(&mut self.asked[0], sent_ns) {
                    self.clock.exchanged(sent_s, wall_s, theirs_us);
                }
            }
            Said::Interval(_) | Said::GimbalAttitude(_) => {}
        }
        Ok(())
    }

    /// One step of the firmware at `at_us`; what it sends goes to the autopilot.
    fn step(&mut self, at_us: f64, event: Event<'_>) -> Result<(), LiveError> {
        self.now_us = at_us.max(self.now_us);
        self.steps += 1;
        let sent = self.link.step(self.timer.latch(self.now_us), event)?;
        if sent.is_empty() {
            return Ok(());
        }
        self.autopilot.send(&sent)?;
        self.bytes[1] += sent.len() as u64;
        self.station.take(&sent);
        self.station.vision.clear();
        self.heard_from_firmware();
        Ok(())
    }

    fn finish(mut self, ended: &str) -> Flown {
        let shift = self.truth.settle();
        let begin_us = self.begin_us.unwrap_or(f64::INFINITY);
        let navigation = self.log.navigation(&self.truth, &self.place.crs, begin_us);
        self.counts.dropped = self.exposures.dropped;
        let (sum_ms, most_ms) = self.deliveries_ms;
        self.counts.delivery_ms = [sum_ms / f64::from(self.counts.delivered.max(1)), most_ms];
        let live = Live {
            ended: ended.to_owned(),
            reconnects: self.wanted.reconnects,
            truth: TruthTime::new(&shift, self.rate_hz, self.samples, self.truth.unordered),
            clock: ClockTime::new(&self.clock.errors(), &self.exchanges),
            attitude: self.attitude_stream(begin_us),
            exposures: self.counts,
            bytes: self.bytes,
        };
        let motion = self.motion();
        let flight = Flight {
            servo: self.servo(),
            frames: self.frames,
            health: self.station.health,
            signing: self.setup.signing.map(|_| (self.station.signing, None)),
            messages: self.station.messages,
            faults: FaultCounts::default(),
            steps: self.steps,
            photos: self.station.photos,
            plan: self.station.plan,
            late: 0,
            lines: self.station.lines,
            source_set: 0,
            motion: None,
            track: None,
        };
        Flown { flight, motion, live, navigation }
    }

    /// The attitudes that the firmware got: those in microseconds, where there are more of them.
    fn attitude_stream(&self, begin_us: f64) -> AttitudeStream {
        let [coarse, fine] = self.attitudes.each_ref().map(|all| AttitudeStream::new(all, begin_us));
        if fine.messages > coarse.messages { fine } else { coarse }
    }

    /// Servo commands: how many, and their root mean square off the exact angle when they arrived.
    fn servo(&self) -> (usize, f64) {
        let off = |(at_us, angle): &(f64, f64)| {
            let state = self.truth.at(*at_us)?;
            Some(wrapped(angle - follow_up_exact(state.heading_rad, state.pitch_rad, state.roll_rad)))
        };
        let squares: Vec<f64> = self.commands.iter().filter_map(off).map(|off| off * off).collect();
        (squares.len(), (squares.iter().sum::<f64>() / squares.len().max(1) as f64).sqrt())
    }
}

/// When the request with this stamp was sent; older ones have no answer any more.
fn taken(asked: &mut VecDeque<(i64, f64)>, stamp: i64) -> Option<f64> {
    let index = asked.iter().position(|(sent, _)| *sent == stamp)?;
    asked.drain(..=index).next_back().map(|(_, sent_s)| sent_s)
}
