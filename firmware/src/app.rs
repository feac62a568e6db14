//! The tasks, one a stream, and what they share.
//!
//! | task | waits for | does |
//! |---|---|---|
//! | [`receive::receive`] | bytes | messages to samples, clock, servo command |
//! | [`camera::camera`] | a frame, its rows, its pose | reduce, situate, rectify, register |
//! | [`transmit::transmit`] | the outbox | messages to bytes |
//! | [`beat::beat`] | the capture timer | heartbeat, time request, requests for streams, health, patience |
//! | [`edges::pulses`] | pulses per second | the clock |
//! | [`edges::edges`] | the shutter's edges | keeps them for their frames |
//!
//! Receive commits to the next exposure of a plan (`exposures`); receive and beat deal with the autopilot (`autopilot`), and
//! the pilot reads of it (`sentences`).
//!
//! A vehicle whose stores were refused runs [`grounded`] instead. All run on one executor in one thread: what they share
//! they use in one go, and await nothing meanwhile ([`Shared`]).

mod auto_exposure;
mod autopilot;
pub mod beat;
pub mod camera;
pub mod edges;
mod exposures;
pub mod grounded;
mod outbox;
pub mod receive;
mod sentences;
pub mod transmit;

use crate::journal::{Event, Gate, Journal};
use crate::shared::Shared;
use crate::stores::plan::Plan;
use crate::wire::command::{Acknowledgement, Ask};
use crate::wire::decoder::LinkCounters;
use crate::wire::incoming::Speakers;
use crate::wire::signing::{Refused, Signing};
use crate::wire::telemetry::{ExposureReport, FrameReport, InstantReport, PhotoReport};
use autopilot::Autopilot;
pub use autopilot::Companion;
use core::cell::Cell;
use core::future::poll_fn;
use core::sync::atomic::{AtomicU32, Ordering};
use embassy_sync::blocking_mutex::raw::NoopRawMutex;
use embassy_sync::signal::Signal;
use exposures::Flown;
use mavlink::dialects::common::MavSeverity;
use outbox::Outbox;
use plumbline_core::auto_exposure::{AutoExposure, Histogram};
use plumbline_core::fix::Fix;
use plumbline_core::pipeline::{Arrival, Pipeline, Situation};
use plumbline_core::stamp::{StampSettings, Stamper};
use plumbline_core::tile::Geographic;
use plumbline_core::units::{Micros, Radians, Ticks};

/// Something to be sent.
#[allow(clippy::large_enum_variant, reason = "no heap to put the large one on, and one at a time is taken")]
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Out {
    /// HEARTBEAT and health.
    Beat,
    /// A TIMESYNC request.
    TimesyncRequest,
    /// What the autopilot is asked for.
    Ask(Ask),
    /// PARAM_REQUEST_READ: the parameter's name.
    Parameter(&'static str),
    /// The result of a command to us.
    Acknowledgement(Acknowledgement),
    /// SET_GPS_GLOBAL_ORIGIN: where the autopilot's frame is to begin, and its height above sea level in millimetres.
    Origin(Geographic, i32),
    /// A message that is new when it is sent, from which the autopilot reckons the link's latency.
    Reference,
    /// The servo's command.
    Servo(Radians),
    /// The answer to a TIMESYNC request.
    TimesyncAnswer(i64),
    /// A planned photo.
    Photo(PhotoReport),
    /// A command to the camera.
    Exposure(ExposureReport),
    /// A line for the pilot.
    Text(MavSeverity, Line),
    /// A frame's result, with the number of the patch to be sent behind it.
    Frame(FrameOut),
}

/// A line of text, as much of it as STATUSTEXT holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Line(pub [u8; 50]);

impl Line {
    /// The line, cut after 50 bytes.
    pub fn new(text: &str) -> Self {
        Line::of([text])
    }

    /// The parts as one line, cut after 50 bytes.
    pub fn of<const N: usize>(parts: [&str; N]) -> Self {
        let mut line = [0; 50];
        let bytes = parts.iter().flat_map(|part| part.bytes());
        line.iter_mut().zip(bytes).for_each(|(to, from)| *to = from);
        Line(line)
    }
}

/// A finished frame on its way out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrameOut {
    /// The report.
    pub report: FrameReport,
    /// All that belongs to the instant of its exposure.
    pub instant: InstantReport,
    /// The state at mid-exposure, where it came that far.
    pub situation: Option<Situation>,
    /// The fix.
    pub fix: Option<Fix>,
    /// Number of the rectified patch, where there is one.
    pub patch: Option<u32>,
}

impl FrameOut {
    /// Nothing known yet of a frame.
    fn new(sequence: u32) -> Self {
        FrameOut {
            report: FrameReport::new(sequence),
            instant: InstantReport::new(sequence),
            situation: None,
            fix: None,
            patch: None,
        }
    }
}

/// What a heartbeat of the autopilot says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Armed {
    /// Whether it is armed.
    pub is_armed: bool,
    /// Whether the heartbeat was signed with our key.
    pub is_signed: bool,
}

/// Counters beside the link's.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counters {
    /// Samples whose stamp ran backwards.
    pub backwards: u32,
    /// Samples whose value cannot be meant.
    pub invalid: u32,
    /// Messages of a kind that we use, from somebody whom we do not listen to, and answers to what we did not ask.
    pub foreign: u32,
    /// Samples stamped later than they arrived.
    pub future: u32,
    /// Frames lost.
    pub frames_lost: u32,
    /// Patches whose transmission was cut short.
    pub patches_cut: u32,
    /// Fixes sent.
    pub fixes: u32,
}

/// What the tasks share.
#[allow(missing_debug_implementations, reason = "embassy-sync's primitives have none")]
pub struct App<'t> {
    /// The chain.
    pub pipeline: Shared<Pipeline<'t>>,
    stamper: Shared<Stamper>,
    link: Cell<LinkCounters>,
    counters: Cell<Counters>,
    /// Raised whenever a waiting frame should try again.
    fresh: Signal<NoopRawMutex, ()>,
    outbox: Outbox,
    /// Number of the patch in the pipeline's buffer.
    patch: Cell<u32>,
    /// What the newest heartbeat of the autopilot said, and who sent it for sure.
    armed: Cell<Option<Armed>>,
    /// Whether the autopilot has ever said that it is armed.
    was_armed: Cell<bool>,
    /// What messages are signed with, if they are.
    signing: Option<Shared<Signing>>,
    speakers: Speakers,
    autopilot: Shared<Autopilot>,
    /// Whether nothing is missing for fixes to be made and sent.
    is_ready: Cell<bool>,
    /// Where the reset counter of the fixes is kept over a start of this board.
    resets: Cell<Option<&'t AtomicU32>>,
    /// The newest command to the follow-up axis.
    servo: Cell<Option<Radians>>,
    flown: Option<Flown<'t>>,
    /// The control of the exposure, where there is one.
    auto_exposure: Option<Shared<AutoExposure>>,
    send_patches: bool,
    journal: &'t dyn Journal,
}

impl<'t> App<'t> {
    /// An application around a pipeline, with what its stamps depend on, the photos that are planned, the link that it is
    /// on, and what messages on it are signed with. All that decides goes into the `journal`.
    pub fn new(
        mut pipeline: Pipeline<'t>,
        stamps: &StampSettings,
        plan: Option<Plan<'t>>,
        send_patches: bool,
        companion: &Companion,
        signing: Option<Signing>,
        journal: &'t dyn Journal,
    ) -> Self {
        let auto_exposure = auto_exposure::of(stamps, plan.is_some());
        pipeline.histogram = auto_exposure.is_some().then(Histogram::new);
        App {
            pipeline: Shared::new(pipeline),
            stamper: Shared::new(Stamper::new(stamps)),
            link: Cell::new(LinkCounters::default()),
            counters: Cell::new(Counters::default()),
            fresh: Signal::new(),
            outbox: Outbox::new(),
            patch: Cell::new(0),
            armed: Cell::new(None),
            was_armed: Cell::new(false),
            signing: signing.map(Shared::new),
            speakers: companion.speakers,
            autopilot: Shared::new(Autopilot::new(companion)),
            is_ready: Cell::new(false),
            resets: Cell::new(None),
            servo: Cell::new(None),
            flown: plan.map(|plan| Flown::new(plan, &stamps.shutter)),
            auto_exposure: auto_exposure.map(Shared::new),
            send_patches,
            journal,
        }
    }

    /// Whether the autopilot is armed, if it ever said.
    pub fn armed(&self) -> Option<Armed> {
        self.armed.get()
    }

    /// Whether the autopilot has ever said that it is armed.
    pub fn was_armed(&self) -> bool {
        self.was_armed.get()
    }

    /// The newest time in signatures; nothing without a key.
    pub fn stamp(&self) -> Option<u64> {
        self.signing.as_ref().and_then(|signing| signing.with(|signing| signing.stamp()))
    }

    /// What was refused for its signature; nothing without a key.
    fn refused(&self) -> Option<Refused> {
        self.signing.as_ref().and_then(|signing| signing.with(|signing| signing.refused()))
    }

    /// The time in signatures goes on.
    fn advance_stamps(&self, now: Ticks) {
        self.signing.iter().for_each(|signing| {
            signing.with(|signing| signing.advance(now));
        });
    }

    /// Where the follow-up axis should be, for a board that turns it itself.
    pub fn servo(&self) -> Option<Radians> {
        self.servo.get()
    }

    /// The reset counter of the fixes goes on from what is in `kept`, whatever that is, and is kept there: an autopilot takes
    /// any change of it for the wish that it begin anew, which a start of this board is none of.
    pub fn keep_resets_in(&self, kept: &'t AtomicU32) {
        let resets = kept.load(Ordering::Relaxed) as u8;
        self.autopilot.with(|autopilot| autopilot.fixes.go_on_from(resets));
        self.resets.set(Some(kept));
    }

    /// Fixes since start.
    pub fn fixes(&self) -> u32 {
        self.counters.get().fixes
    }

    /// Whether the capture timer is tied to the autopilot's clock.
    pub fn is_tied(&self, now: Ticks) -> bool {
        self.instant(now).is_some()
    }

    /// Sends the pilot a line; waits until the outbox takes it.
    pub async fn say(&self, severity: MavSeverity, line: Line) {
        self.outbox.takes_text().await;
        self.outbox.put(Out::Text(severity, line));
    }

    /// Puts an event into the journal.
    fn event(&self, event: Event<'_>) {
        self.journal.event(event);
    }

    /// Waits until the journal lets this task pass.
    async fn gate(&self, gate: Gate) {
        poll_fn(|context| self.journal.gate(gate, context.waker())).await;
    }

    /// The autopilot's instant at a tick.
    fn instant(&self, tick: Ticks) -> Option<Micros> {
        self.arrival(tick).map(|arrival| arrival.at)
    }

    /// What arrived at a tick did so at this instant of the autopilot.
    fn arrival(&self, tick: Ticks) -> Option<Arrival> {
        let instant = self.stamper.with(|stamper| stamper.clock.instant(tick)).flatten();
        instant.map(|(at, sigma_us)| Arrival { at, sigma_us })
    }

    /// Counts.
    fn count(&self, with: impl FnOnce(&mut Counters)) {
        let mut counters = self.counters.get();
        with(&mut counters);
        self.counters.set(counters);
    }
}
