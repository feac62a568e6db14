//! The application's dealings with the autopilot: what arrived from it, what it is asked for, whether all is ready.

use super::{App, Line, Out};
use crate::autopilot::Presence;
use crate::autopilot::exchange::Exchange;
use crate::autopilot::fixes::{FixSettings, Fixes, Form};
use crate::autopilot::readiness::{Present, Told};
use crate::autopilot::requests::{Complaint, Intervals, Requests, Stream};
use crate::wire::boot_time::BootTime;
use crate::wire::fix_message::{Odometry, SentFix, VisionPosition};
use crate::wire::incoming::{Incoming, Speakers};
use mavlink::dialects::common::MavSeverity;
use plumbline_core::fix::Fix;
use plumbline_core::tilt::Attitude;
use plumbline_core::units::{Micros, Radians, Ticks};

/// Who is on the link, what is wanted from it, and how fixes are sent to it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Companion {
    /// Whose messages are taken.
    pub speakers: Speakers,
    /// How often samples are wanted.
    pub intervals: Intervals,
    /// How fixes are sent.
    pub fixes: FixSettings,
}

/// A sample or a frame older than this is none of late, ticks.
const LATE_TICKS: u32 = 2_000_000;

/// A fix in the form that the autopilot takes.
#[allow(clippy::large_enum_variant, reason = "no heap to put the large ones on, and one at a time is encoded")]
pub(super) enum FixMessage {
    Odometry(Odometry),
    VisionPosition(VisionPosition),
    /// With the sensor's id; its stamp is that of its transmission.
    GlobalPositionSensor(SentFix, u8),
}

/// State of the other side.
pub(super) struct Autopilot {
    presence: Presence,
    requests: Requests,
    pub(super) fixes: Fixes,
    exchange: Exchange,
    told: Told,
    /// When the newest attitude, position and frame came.
    newest: [Option<Ticks>; 3],
}

/// Places in [`Autopilot::newest`].
#[derive(Clone, Copy)]
pub(super) enum Kind {
    Attitude = 0,
    Position = 1,
    Frame = 2,
}

impl Autopilot {
    pub(super) fn new(companion: &Companion) -> Self {
        Autopilot {
            presence: Presence::default(),
            requests: Requests::new(&companion.intervals),
            fixes: Fixes::new(companion.fixes),
            exchange: Exchange::default(),
            told: Told::default(),
            newest: [None; 3],
        }
    }

    /// What a message shows beside the sample that it is.
    pub(super) fn heard(&mut self, message: &Incoming, now: Ticks) {
        let arrived = match message {
            Incoming::Attitude(BootTime::Micros(_), _) => Stream::Attitude,
            Incoming::Attitude(BootTime::Millis(_), _) => Stream::CoarseAttitude,
            Incoming::Position(_, sample) => {
                self.fixes.velocity_m_per_s = [sample.north_m_per_s, sample.east_m_per_s];
                Stream::Position
            }
            Incoming::Slant(..) => Stream::Range,
            Incoming::Down(..) => Stream::Local,
            Incoming::Gnss(_) => Stream::Gnss,
            Incoming::Heartbeat(heartbeat) => return self.presence.heard(*heartbeat, now),
            Incoming::Origin(origin) => return self.fixes.origin = Some(*origin),
            Incoming::Acknowledged(command, result) => return self.requests.acknowledged(*command, *result),
            _ => return,
        };
        self.requests.arrived(arrived);
    }

    /// A sample of this kind was taken.
    pub(super) fn taken(&mut self, kind: Kind, now: Ticks) {
        if let Some(newest) = self.newest.get_mut(kind as usize) {
            *newest = Some(now);
        }
    }

    /// Whether a TIMESYNC answer answers one of our requests.
    pub(super) fn answers(&mut self, sent_ns: i64) -> bool {
        self.exchange.answers(sent_ns)
    }

    /// The message of the fix of a frame exposed at `at`, in the form that the autopilot takes; nothing where none is due, or
    /// nothing is known of the frame that it would be in. `attitude`: of the vehicle, from true north.
    pub(super) fn fix_message(&mut self, fix: &Fix, at: Micros, attitude: Attitude) -> Option<FixMessage> {
        let form = self.fixes.form(self.presence.kind());
        if form == Form::GlobalPositionSensor {
            let id = self.fixes.sensor_id();
            return self.fixes.take(fix, at, attitude).map(|sent| FixMessage::GlobalPositionSensor(sent, id));
        }
        let (origin, down_m) = (self.fixes.origin?, self.fixes.down_at(at)?);
        let sent = self.fixes.take(fix, at, attitude)?;
        Some(match form {
            Form::VisionPosition => FixMessage::VisionPosition(VisionPosition::new(&sent, origin, down_m)),
            _ => FixMessage::Odometry(Odometry::new(&sent, origin, down_m)),
        })
    }

    fn present(&self, is_tied: bool, now: Ticks) -> Present {
        let [attitude, position, camera] =
            self.newest.map(|newest| newest.is_some_and(|at| now.0.wrapping_sub(at.0) <= LATE_TICKS));
        let is_local = self.fixes.form(self.presence.kind()).is_local();
        Present {
            autopilot: self.presence.is_there(),
            clock: is_tied,
            attitude,
            position,
            origin: self.fixes.origin.is_some() || !is_local,
            height: self.fixes.has_height() || !is_local,
            camera,
        }
    }
}

impl App<'_> {
    /// Ten times a second: what the autopilot is asked for, the time again while the clock is not tied, and the message that
    /// keeps its reckoning of our latency right.
    pub(super) fn ask_autopilot(&self, now: Ticks, is_second: bool) {
        let is_tied = self.is_tied(now);
        if !is_tied || is_second {
            self.outbox.put(Out::TimesyncRequest);
        }
        let asked = self.autopilot.with(|autopilot| {
            autopilot.presence.keep(now);
            let (is_there, kind) = (autopilot.presence.is_there(), autopilot.presence.kind());
            let is_origin_known = autopilot.fixes.origin.is_some();
            let ask = if is_there { autopilot.requests.next(now, is_origin_known) } else { None };
            let complaint = autopilot.requests.complaint().map(sentence);
            let needs_reference = is_there && is_tied && autopilot.fixes.form(kind).is_local();
            (ask, complaint, needs_reference)
        });
        let Some((ask, complaint, needs_reference)) = asked else { return };
        if let Some(ask) = ask {
            self.outbox.put(Out::Ask(ask));
        }
        if let Some(line) = complaint {
            self.outbox.put(Out::Text(MavSeverity::MAV_SEVERITY_WARNING, line));
        }
        if needs_reference {
            self.outbox.put(Out::Reference);
        }
        if is_second {
            self.tell_readiness(now);
        }
    }

    fn tell_readiness(&self, now: Ticks) {
        let is_tied = self.is_tied(now);
        let line = self.autopilot.with(|autopilot| {
            let missing = autopilot.present(is_tied, now).missing();
            self.is_ready.set(missing.is_none());
            autopilot.told.line(missing)
        });
        if let Some(Some(line)) = line {
            self.outbox.put(Out::Text(MavSeverity::MAV_SEVERITY_NOTICE, Line::new(line)));
        }
    }

    /// A time request goes out with this stamp.
    pub(super) fn asked_for_time(&self, stamp_ns: i64) {
        self.autopilot.with(|autopilot| autopilot.exchange.sent(stamp_ns));
    }
}

/// A complaint for the pilot.
fn sentence(complaint: Complaint) -> Line {
    match complaint {
        Complaint::Denied(stream, interval_us) => {
            let mut digits = [0; 10];
            let hz = 1_000_000 / interval_us.max(1);
            Line::of([stream.name(), " at ", decimal(hz, &mut digits), " Hz denied: raise SCHED_LOOP_RATE"])
        }
        Complaint::Slow(stream) => Line::of(["autopilot sends too little ", stream.name()]),
    }
}

/// A number in decimal digits.
fn decimal(number: u32, digits: &mut [u8; 10]) -> &str {
    let mut rest = number;
    let mut from = digits.len();
    for (place, digit) in digits.iter_mut().enumerate().rev() {
        *digit = b'0' + (rest % 10) as u8;
        rest /= 10;
        from = place;
        if rest == 0 {
            break;
        }
    }
    digits.get(from..).and_then(|used| core::str::from_utf8(used).ok()).unwrap_or("?")
}

/// An attitude whose heading is turned from grid to true north.
pub(super) fn from_true_north(attitude: Attitude, convergence: Radians) -> Attitude {
    Attitude { heading: Radians(attitude.heading.0 + convergence.0).wrapped(), ..attitude }
}
