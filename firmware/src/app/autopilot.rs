//! The application's dealings with the autopilot: what arrived from it, what it is asked for, whether all is ready.

use super::{App, Line, Out, sentences};
use crate::autopilot::Presence;
use crate::autopilot::exchange::Exchange;
use crate::autopilot::fixes::{FixSettings, Fixes, Form};
use crate::autopilot::parameters::{Checked, Parameters};
use crate::autopilot::readiness::{Present, Told};
use crate::autopilot::requests::{Intervals, Requests, Stream};
use crate::autopilot::sources::{Sources, Switching};
use crate::autopilot::start::{Place, Start, StartSettings};
use crate::autopilot::wanted::Ours;
use crate::autopilot::watch::Watch;
use crate::wire::boot_time::BootTime;
use crate::wire::command::{Acknowledgement, Ask, SET_EKF_SOURCE_SET};
use crate::wire::fix_message::{Odometry, SentFix, VisionPosition};
use crate::wire::incoming::{Incoming, Speakers};
use crate::wire::order::Order;
use crate::wire::telemetry::FrameReport;
use core::sync::atomic::Ordering;
use mavlink::dialects::common::MavSeverity;
use plumbline_core::fix::Fix;
use plumbline_core::pipeline::{AddedSigmas, Instants, PositionSample};
use plumbline_core::tile::Geographic;
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
    /// Who chooses the sources of the autopilot's estimator.
    pub switching: Switching,
    /// Where the vehicle stands at first, where satellite navigation does not tell.
    pub start: Option<StartSettings>,
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
    parameters: Parameters,
    watch: Watch,
    sources: Sources,
    start: Start,
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
            parameters: Parameters::new(Ours {
                attitude_us: companion.intervals.attitude_us,
                sensor_id: companion.fixes.sensor_id,
            }),
            watch: Watch::default(),
            sources: Sources::new(companion.switching),
            start: Start::new(companion.start),
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
                self.start.reported(sample);
                Stream::Position
            }
            Incoming::Slant(..) => Stream::Range,
            Incoming::Down(..) => Stream::Local,
            Incoming::Gnss(gnss) => {
                self.sources.gnss(gnss.is_good);
                Stream::Gnss
            }
            Incoming::Heartbeat(heartbeat) => return self.presence.heard(*heartbeat, now),
            Incoming::Origin(origin) => {
                self.watch.origin(Some(*origin));
                return self.fixes.origin = Some(*origin);
            }
            Incoming::Acknowledged(SET_EKF_SOURCE_SET, result) => return self.sources.acknowledged(*result),
            Incoming::Acknowledged(command, result) => return self.requests.acknowledged(*command, *result),
            Incoming::Parameter(parameter) => return self.parameters.arrived(parameter, self.presence.kind()),
            _ => return,
        };
        self.requests.arrived(arrived);
    }

    /// It has booted anew: what it was told and what it said is no more.
    pub(super) fn has_rebooted(&mut self) {
        self.fixes.clear();
        self.watch.origin(None);
        self.parameters.forget();
        self.sources.forget();
        self.start.forget();
    }

    /// Whether the start stands in for positions of its own.
    pub(super) fn is_at_start(&self) -> bool {
        self.start.is_needed()
    }

    /// What a ground station orders; the result, where it is known at once.
    pub(super) fn ordered(&mut self, order: Order, by: (u8, u8)) -> Option<u8> {
        match order {
            Order::SourceSet(set) => {
                self.sources.ordered(set, by);
                None
            }
            Order::Position(place) => Some(self.start.ordered(place)),
        }
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

    /// The message of the fix of a frame exposed at an instant, so many metres above the ground, in the form that the autopilot
    /// takes; nothing where none is due, or nothing is known of the frame that it would be in. `attitude`: of the vehicle, from
    /// true north.
    pub(super) fn fix_message(
        &mut self,
        fix: &Fix,
        (at, height_m): (Micros, f32),
        attitude: Attitude,
    ) -> Option<FixMessage> {
        let form = self.fixes.form(self.presence.kind());
        if form == Form::GlobalPositionSensor {
            let id = self.fixes.sensor_id();
            return self.fixes.take(fix, at, attitude).map(|sent| FixMessage::GlobalPositionSensor(sent, id));
        }
        // An autopilot without a position has no height to tell, and takes the position without the height.
        let above_ground = Some(-height_m).filter(|_| self.start.is_needed());
        let (origin, down_m) = (self.fixes.origin?, self.fixes.down_at(at).or(above_ground)?);
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
            height: self.fixes.has_height() || !is_local || self.start.is_needed(),
            checked: self.parameters.checked() != Checked::NotYet,
            parameters: self.parameters.checked() != Checked::Wrong,
            camera,
        }
    }
}

/// What is to be sent after a beat.
#[derive(Default)]
struct Due {
    ask: Option<Ask>,
    set: Option<u8>,
    parameter: Option<&'static str>,
    answer: Option<Acknowledgement>,
    origin: Option<(Geographic, i32)>,
    place: Option<Place>,
    needs_reference: bool,
    is_changing: bool,
}

impl Autopilot {
    /// Ten times a second.
    fn due(&mut self, now: Ticks, is_tied: bool, is_armed: bool) -> Due {
        self.presence.keep(now);
        let (is_there, kind) = (self.presence.is_there(), self.presence.kind());
        let form = self.fixes.form(kind);
        self.parameters.of(kind, form);
        let place = self.start.next(is_armed).filter(|_| is_tied);
        let lacks_origin = is_there && is_tied && self.fixes.origin.is_none() && !self.sources.has_gnss();
        let origin = self.start.origin(lacks_origin);
        let answer = self.sources.answer();
        let is_changing = is_there && self.sources.is_changing();
        if !is_there {
            return Due { answer, place, is_changing, ..Due::default() };
        }
        // Fixes that the autopilot would not use, or would use wrongly, are not to be relied upon.
        let are_trusted = self.watch.is_trusted() && self.present(is_tied, now).missing().is_none();
        Due {
            ask: self.requests.next(now, self.fixes.origin.is_some()),
            set: self.sources.next(are_trusted, self.watch.is_lost()),
            parameter: self.parameters.next(is_armed),
            answer,
            origin,
            place,
            needs_reference: is_tied && form.is_local(),
            is_changing,
        }
    }

    /// The line that the pilot is to read after this beat of a second's ten. One line waits to be sent, so each kind has beats
    /// of its own.
    fn line(&mut self, beat: u32, is_armed: bool) -> Option<Line> {
        match beat {
            PARAMETERS_BEAT => self.parameters.line().map(sentences::parameter),
            FIXES_BEAT => self.watch.second(is_armed).map(sentences::fixes),
            SOURCES_BEAT => self.sources.news().map(sentences::source_set),
            // Readiness.
            0 => None,
            _ => self.requests.complaint().map(sentences::complaint),
        }
    }
}

/// Which of a second's ten beats is for which lines; the first is that of readiness, the others are for denied requests.
const PARAMETERS_BEAT: u32 = 3;
const FIXES_BEAT: u32 = 5;
const SOURCES_BEAT: u32 = 7;

impl App<'_> {
    /// Ten times a second, on a second's beat of this number: what the autopilot is asked for, the time again while the clock
    /// is not tied, and the message that keeps its reckoning of our latency right.
    pub(super) fn ask_autopilot(&self, now: Ticks, beat: u32) {
        let (is_tied, is_armed) = (self.is_tied(now), self.armed.get().is_some_and(|armed| armed.is_armed));
        if !is_tied || beat == 0 {
            self.outbox.put(Out::TimesyncRequest);
        }
        let disagreement_m = self.pipeline.with(|pipeline| pipeline.disagreement_m()).flatten();
        let both = |autopilot: &mut Autopilot| {
            autopilot.watch.disagreement(disagreement_m);
            let due = autopilot.due(now, is_tied, is_armed);
            (due, autopilot.line(beat, is_armed))
        };
        let Some((due, line)) = self.autopilot.with(both) else { return };
        let asks = [due.ask, due.set.map(Ask::SourceSet)].into_iter().flatten().map(Out::Ask);
        let parameter = due.parameter.map(Out::Parameter);
        let answer = due.answer.map(Out::Acknowledgement);
        let origin = due.origin.map(|(place, altitude_mm)| Out::Origin(place, altitude_mm));
        let reference = due.needs_reference.then_some(Out::Reference);
        let text = line.map(|line| Out::Text(MavSeverity::MAV_SEVERITY_WARNING, line));
        asks.chain(parameter)
            .chain(answer)
            .chain(origin)
            .chain(reference)
            .chain(text)
            .for_each(|out| self.outbox.put(out));
        self.pipeline.with(|pipeline| pipeline.autopilot_changes(due.is_changing));
        self.stand_at(due.place, now);
        if beat == 0 {
            self.tell_readiness(now);
        }
    }

    /// Where the vehicle is while the autopilot does not know it: as a position of its own would be, and with its sigmas.
    fn stand_at(&self, place: Option<Place>, now: Ticks) {
        let taken = self.pipeline.with(|pipeline| {
            pipeline.added_sigmas = place.map_or(AddedSigmas::default(), |place| AddedSigmas {
                position_m: place.sigma_m,
                velocity_m_per_s: place.velocity_m_per_s,
                heading_rad: place.heading_rad,
            });
            let (place, arrival) = place.zip(self.arrival(now))?;
            let at = Instants { sampled_at: arrival.at, stamp_sigma_us: 0.0, arrival: Some(arrival) };
            let sample = PositionSample::standing(place.place);
            pipeline.position(at, sample).ok().filter(|()| pipeline.is_on_the_map())
        });
        if let Some(Some(())) = taken {
            self.autopilot.with(|autopilot| autopilot.taken(Kind::Position, now));
        }
    }

    /// A ground station's order: what is answered at once.
    pub(super) fn ordered(&self, order: Order, by: (u8, u8)) {
        if let Some(Some(result)) = self.autopilot.with(|autopilot| autopilot.ordered(order, by)) {
            let answer = Acknowledgement { command: order.command(), result, target: by };
            self.outbox.put(Out::Acknowledgement(answer));
        }
    }

    /// What a frame came to.
    pub(super) fn watch(&self, report: &FrameReport) {
        let near_px = self.pipeline.with(|pipeline| pipeline.settings().search_px).unwrap_or(report.search_px.into());
        let changed = self.autopilot.with(|autopilot| {
            autopilot.watch.frame(report.refusal);
            let found = report.matched.filter(|_| report.refusal == 0)?;
            autopilot.fixes.found([found.d_col, found.d_row], near_px)
        });
        if let (Some(Some(resets)), Some(kept)) = (changed, self.resets.get()) {
            kept.store(resets.into(), Ordering::Relaxed);
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

/// An attitude whose heading is turned from grid to true north.
pub(super) fn from_true_north(attitude: Attitude, convergence: Radians) -> Attitude {
    Attitude { heading: Radians(attitude.heading.0 + convergence.0).wrapped(), ..attitude }
}
