//! The simulator at its end of the link: what reaches the board when, and what comes back.

mod strange;
mod told;

use super::truth::Truth;
use super::{Flight, FrameRecord, Observer};
use crate::fault::FaultInjector;
use crate::fault::passage::Passage;
use crate::ground_station::GroundStation;
use crate::link::{Event, FrameEvent, Link, LinkError};
use crate::noise::White;
use crate::scenario::What;
use crate::setup::Setup;
use crate::vehicle::aloft::moment::Track;
use crate::vehicle::autopilot::Autopilot;
use crate::vehicle::motion::TrueState;
use crate::vehicle::sensors::{
    Exposure, LineEdge, Reading, Sample, Sensed, Shutter, ShutterLine, Streams, TimerModel, line_edges,
};
use crate::vehicle::servo::{follow_up_exact, wrapped};
use crate::vehicle::signing::Signatory;
use plumbline_firmware::wire::telemetry::PhotoReport;
use std::collections::VecDeque;
use strange::strange;
use told::Told;

/// From one heartbeat of the autopilot to the next, microseconds.
const HEARTBEAT_US: u64 = 1_000_000;
/// Longest time without a step: the firmware's own timers run by the steps.
const STEP_MAX_US: u64 = 50_000;

/// The simulator's side of the link.
pub(super) struct Cockpit<'s> {
    pub(super) setup: &'s Setup,
    pub(super) link: &'s mut dyn Link,
    pub(super) truth: Truth<'s>,
    streams: Streams,
    timer: TimerModel,
    pulse_jitter: White,
    /// Edges still to come.
    edges: VecDeque<LineEdge>,
    /// Exposures are made as the firmware tells; otherwise all edges are there from the beginning.
    is_told: bool,
    shutter: Shutter,
    line: ShutterLine,
    /// Planned exposures whose frames are still to come, and how many there were; none are made any more without.
    planned: VecDeque<(Exposure, PhotoReport)>,
    exposures: Option<u32>,
    autopilot: Autopilot,
    injector: FaultInjector,
    passage: Passage,
    station: GroundStation,
    told: Told,
    /// The autopilot's answers under way, in the order in which they arrive: when, and their bytes.
    answers: Vec<(u64, Vec<u8>)>,
    next_heartbeat_us: u64,
    now_us: u64,
    /// The board had power in the last step.
    is_on: bool,
    /// Fixes that the autopilot has had.
    fixes: usize,
    servo: (usize, f64),
    steps: u64,
    late: u32,
}

impl<'s> Cockpit<'s> {
    pub(super) fn new(setup: &'s Setup, link: &'s mut dyn Link) -> Self {
        let is_told = setup.plan.is_some() || setup.scenario.vehicle.auto_exposure.is_on;
        Cockpit {
            setup,
            link,
            truth: Truth::new(setup),
            streams: streams(setup),
            timer: TimerModel::new(&setup.scenario),
            pulse_jitter: White::new(setup.scenario.vehicle.timer.pps_jitter_us, setup.scenario.run.seed, "pps"),
            edges: if is_told { VecDeque::new() } else { line_edges(&setup.scenario).into() },
            is_told,
            shutter: Shutter::new(&setup.scenario),
            line: ShutterLine::new(&setup.scenario),
            planned: VecDeque::new(),
            exposures: setup.plan.as_ref().map(|_| 0),
            autopilot: autopilot(setup),
            injector: FaultInjector::new(setup.scenario.faults.link_faults, setup.scenario.run.seed, "to_firmware"),
            passage: Passage::new(setup.scenario.faults.timed.clone(), setup.scenario.run.seed),
            station: GroundStation::signing(setup.signing.map(Signatory::new)),
            told: Told::default(),
            answers: Vec::new(),
            next_heartbeat_us: 0,
            now_us: 0,
            is_on: true,
            fixes: 0,
            servo: (0, 0.0),
            steps: 0,
            late: 0,
        }
    }

    /// Lets everything happen until the first row of the next planned exposure arrives, which is returned, or until `end_us`.
    pub(super) fn exposed(
        &mut self,
        end_us: u64,
        observer: &dyn Observer,
    ) -> Result<Option<(Exposure, PhotoReport)>, LinkError> {
        self.until(end_us, observer)?;
        Ok(self.planned.pop_front().filter(|(exposure, _)| exposure.readout_start_us <= end_us))
    }

    /// The exposure of a frame whose shutter opens at an instant to come.
    pub(super) fn expose(&mut self, (frame, open_us): (u32, u64)) -> Exposure {
        let exposure = self.shutter.expose(frame, open_us);
        if self.is_told {
            self.line.add_edges(&self.setup.scenario, &exposure, &mut self.edges);
        }
        exposure
    }

    /// Opens the shutter no more, and hands over no frame that was under way.
    pub(super) fn stop_exposing(&mut self) {
        self.exposures = None;
        self.planned.clear();
    }

    /// The firmware has committed to an exposure: the shutter will open, where it still can, so that its middle is then.
    fn commit(&mut self, photo: PhotoReport) {
        let Some(count) = self.exposures else { return };
        let half_us = u64::from(self.setup.scenario.vehicle.exposure_us) / 2;
        let open_us = photo.mid_exposure_us.saturating_sub(half_us);
        if open_us <= self.now_us {
            self.late += 1;
            return;
        }
        let exposure = self.expose((count, open_us));
        self.exposures = Some(count + 1);
        self.planned.push_back((exposure, photo));
    }

    /// Lets everything happen that reaches the board before `end_us`, or before the frame of a planned exposure.
    pub(super) fn until(&mut self, end_us: u64, observer: &dyn Observer) -> Result<(), LinkError> {
        while !observer.is_interrupted() {
            // It may have been committed to just now.
            let frame_us = self.planned.front().map_or(u64::MAX, |(exposure, _)| exposure.readout_start_us);
            let end_us = end_us.min(frame_us);
            if self.next_heartbeat_us <= self.now_us {
                if self.autopilot.is_awake(self.now_us) {
                    let heartbeat = self.autopilot.heartbeat();
                    self.answer((self.now_us, heartbeat));
                }
                self.next_heartbeat_us += HEARTBEAT_US;
            }
            let answer_us = self.answers.first().map_or(u64::MAX, |(at, _)| *at);
            let edge_us = self.edges.front().map_or(u64::MAX, LineEdge::seen_us);
            let horizon = end_us.min(answer_us).min(edge_us).min(self.now_us + STEP_MAX_US);
            let slant = |state: &TrueState| self.setup.slant_m(state);
            if let Some(sample) = self.streams.next_before(horizon, &self.truth, &slant) {
                self.sample(&sample)?;
            } else if edge_us <= horizon {
                self.edge()?;
            } else if answer_us == horizon {
                let (at_us, bytes) = self.answers.remove(0);
                self.bytes(at_us, &bytes)?;
            } else if horizon < end_us {
                self.step(horizon, Event::Nothing)?;
            } else {
                return Ok(());
            }
        }
        Err(LinkError::Interrupted)
    }

    fn sample(&mut self, sample: &Sample) -> Result<(), LinkError> {
        if let Reading::Pps { .. } = sample.reading {
            let tick = self.timer.latch(sample.sampled_at_us as f64 + self.pulse_jitter.draw());
            return self.step(sample.arrived_at_us, Event::Pulse(tick));
        }
        if !self.autopilot.is_awake(sample.arrived_at_us) {
            return Ok(());
        }
        if let (Reading::Position { .. }, Some(received)) = (&sample.reading, self.truth.received(sample.sampled_at_us))
        {
            self.autopilot.receive(received);
        }
        if let Reading::Attitude { .. } = sample.reading {
            self.link.show(&|| self.truth.moving(sample.sampled_at_us));
        }
        let faults = &self.setup.scenario.faults.timed;
        let stranger = faults.is(What::LinkSecondSender, sample.sampled_at_us).then(|| self.autopilot.stranger());
        let messages = self.autopilot.messages(sample, &self.setup.crs)?;
        messages.iter().try_for_each(|message| self.bytes(sample.arrived_at_us, message))?;
        let Some(mut stranger) = stranger else { return Ok(()) };
        // It has no key to sign with.
        let messages = stranger.messages(&strange(sample), &self.setup.crs)?;
        messages.iter().try_for_each(|message| self.step(sample.arrived_at_us, Event::Bytes(message)))
    }

    /// Something of the autopilot's is under way.
    fn answer(&mut self, (at_us, bytes): (u64, Vec<u8>)) {
        let place = self.answers.partition_point(|(other, _)| *other <= at_us);
        self.answers.insert(place, (at_us, bytes));
    }

    fn edge(&mut self) -> Result<(), LinkError> {
        let Some(edge) = self.edges.pop_front() else { return Ok(()) };
        let tick = self.timer.latch(edge.at_us);
        self.step(edge.seen_us(), Event::Edge { tick, rising: edge.rising })
    }

    /// A message, through whatever goes wrong on the link.
    fn bytes(&mut self, at_us: u64, message: &[u8]) -> Result<(), LinkError> {
        // Signed as it leaves: what was made earlier may leave later.
        let signed = self.station.signatory.as_mut().map(|signatory| signatory.signed(message, at_us));
        let message = signed.as_deref().unwrap_or(message);
        let mut passed = Vec::with_capacity(message.len());
        self.injector.pass(message, &mut passed);
        let arrived = self.passage.pass(at_us, &passed);
        arrived.iter().try_for_each(|bytes| self.step(at_us, Event::Bytes(bytes)))
    }

    pub(super) fn frame(&mut self, exposure: &Exposure, pixels: &[u8]) -> Result<(), LinkError> {
        let camera = &self.setup.payload.camera;
        self.step(
            exposure.readout_start_us,
            Event::Frame(FrameEvent {
                sequence: exposure.frame,
                arrival: self.timer.ticks(exposure.readout_start_us),
                size: (camera.cols as u16, camera.rows as u16),
                pixels,
            }),
        )
    }

    fn step(&mut self, at_us: u64, event: Event<'_>) -> Result<(), LinkError> {
        self.now_us = at_us.max(self.now_us);
        if !self.has_power()? {
            return Ok(());
        }
        self.steps += 1;
        let sent = self.link.step(self.timer.ticks(self.now_us), event)?;
        self.station.take(&sent);
        self.told.read(&self.station.lines, self.now_us);
        let mut asked = std::mem::take(&mut self.station.timesync);
        let is_awake = self.autopilot.is_awake(self.now_us);
        asked.retain(|_| is_awake && self.setup.scenario.world.timer.timesync);
        for stamp in asked {
            let answer = self.autopilot.timesync_answer(stamp, self.now_us);
            self.answer(answer);
        }
        if is_awake {
            self.answer_commands();
        } else {
            (self.station.commands, self.station.parameters, self.station.origin) = Default::default();
        }
        std::mem::take(&mut self.station.exposures).into_iter().for_each(|command| self.shutter.command(command));
        self.hear(is_awake);
        for photo in std::mem::take(&mut self.station.due) {
            self.commit(photo);
        }
        let servo = std::mem::take(&mut self.station.servo);
        if !servo.is_empty() {
            let state = self.truth.state(self.now_us);
            let exact = follow_up_exact(state.heading_rad, state.pitch_rad, state.roll_rad);
            for command in servo {
                self.truth.command(self.now_us, command);
                let off = wrapped(command - exact);
                self.servo.0 += 1;
                self.servo.1 += off * off;
            }
        }
        Ok(())
    }

    /// Has the autopilot hear what the firmware says of its position.
    fn hear(&mut self, is_awake: bool) {
        self.truth.use_sources(self.autopilot.source_set());
        for message in std::mem::take(&mut self.station.vision) {
            if !(is_awake && self.truth.listens()) {
                continue;
            }
            let place_m = self.autopilot.place_of(&message, &self.setup.crs);
            let at_us = self.autopilot.arrival_us(self.now_us);
            self.truth.hear(at_us, message, place_m);
        }
    }

    /// Whether the board has power now; it boots with the first step after it had none.
    fn has_power(&mut self) -> Result<bool, LinkError> {
        let is_on = !self.setup.scenario.faults.timed.is(What::PowerOff, self.now_us);
        let was_on = std::mem::replace(&mut self.is_on, is_on);
        if is_on && !was_on {
            self.link.reboot(&self.setup.flash)?;
            self.shutter.restart(&self.setup.scenario);
        }
        Ok(is_on)
    }

    /// Has the autopilot do what it is asked for.
    fn answer_commands(&mut self) {
        for command in std::mem::take(&mut self.station.commands) {
            let answer = self.autopilot.commanded(&command, self.now_us);
            self.answer(answer);
        }
        for name in std::mem::take(&mut self.station.parameters) {
            self.autopilot.parameter(&name, self.now_us).into_iter().for_each(|answer| self.answer(answer));
        }
        if let Some(origin) = self.station.origin.take() {
            self.autopilot.set_origin(origin);
        }
        if self.station.fixes.len() > self.fixes {
            self.fixes = self.station.fixes.len();
            self.autopilot.take_fix();
        }
    }

    /// Whether the firmware has said what a frame came to.
    pub(super) fn is_reported(&self, record: &FrameRecord) -> bool {
        self.station.reports.contains_key(&record.exposure.frame)
    }

    /// What the firmware said of a frame.
    pub(super) fn report(&mut self, record: &mut FrameRecord) {
        record.take_reports(&mut self.station);
    }

    pub(super) fn finish(self, frames: Vec<FrameRecord>) -> Flight {
        let (count, squares) = self.servo;
        let (motion, track) = self.truth.finish(self.now_us);
        Flight {
            frames,
            health: self.station.health,
            signing: self.station.signatory.map(|signatory| (self.station.signing, Some(signatory.refused()))),
            messages: self.station.messages,
            servo: (count, (squares / count.max(1) as f64).sqrt()),
            faults: self.injector.counts(),
            steps: self.steps,
            photos: self.station.photos,
            plan: self.station.plan,
            late: self.late,
            lines: self.station.lines,
            source_set: self.autopilot.source_set(),
            motion,
            track: track.map(|track| Track { gnss: self.told.gnss, ..track }),
        }
    }
}

/// The vehicle's sensors. What a table says is told as it is: the laser adds nothing of its own.
fn streams(setup: &Setup) -> Streams {
    let mut scenario = setup.scenario.clone();
    if setup.pictures.is_some() {
        scenario.vehicle.range.sigma_m = 0.0;
    }
    Streams::new(&scenario, setup.payload.mount, setup.convergence_rad)
}

/// The scenario's autopilot. One that navigates has satellite navigation from the beginning until it is lost.
fn autopilot(setup: &Setup) -> Autopilot {
    let scenario = &setup.scenario;
    let mut faults = scenario.faults.autopilot_faults;
    if let Some(navigation) = &scenario.world.navigation {
        faults.gnss_s = Some([0.0, navigation.gnss_lost_s.unwrap_or(f64::INFINITY)]);
    }
    let home_up_m = setup.course.as_ref().map_or(0.0, |course| course.base_up_m);
    Autopilot::new(scenario.world.autopilot.loop_rate_hz, scenario.run.seed)
        .with(&faults)
        .at_home(home_up_m)
        .failing(scenario.faults.timed.clone(), scenario.run.seed)
}
