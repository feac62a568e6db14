//! A flight: events in the order in which they reach the board, each a step of the link, and what came of every frame.

use crate::autopilot::Autopilot;
use crate::fault::{FaultCounts, FaultInjector};
use crate::flight::{TrueState, follow_up_exact};
use crate::link::{Event, FrameEvent, Link, LinkError};
use crate::render::Rendered;
use crate::replay::annotation;
use crate::scenario::COOL_DOWN_US;
use crate::score::raw::{RawMatch, match_raw};
use crate::sensors::noise::White;
use crate::sensors::{
    Exposure, LineEdge, Reading, Sample, Shutter, ShutterLine, Streams, TimerModel, exposures, line_edges, lost_frames,
};
use crate::stage::Stage;
use crate::station::{ReceivedPatch, Station};
use plumbline_firmware::wire::telemetry::{FrameReport, Health, InstantReport, PhotoReport, PlanReport};
use std::collections::{BTreeMap, VecDeque};

/// One way over the link to the autopilot, microseconds: what a TIMESYNC exchange takes each way.
const LINK_DELAY_US: u64 = 1500;
/// Longest time without a step: the firmware's own timers run by the steps.
const STEP_MAX_US: u64 = 50_000;

/// What happened to one frame.
#[derive(Clone, Debug)]
pub struct FrameRecord {
    /// When it was exposed.
    pub exposure: Exposure,
    /// The truth at mid-exposure.
    pub truth: TrueState,
    /// What the firmware said; `None` when it said nothing.
    pub report: Option<FrameReport>,
    /// What it said of the instant of its exposure.
    pub instant: Option<InstantReport>,
    /// What matching without rectification would have given.
    pub raw: Option<RawMatch>,
    /// The picture, kept for the first frames and a few others.
    pub frame: Option<Vec<u8>>,
    /// The patch that the firmware sent.
    pub patch: Option<ReceivedPatch>,
    /// The planned photo that it is, as the firmware called it when it committed to the exposure.
    pub photo: Option<PhotoReport>,
}

/// A finished flight.
#[derive(Clone, Debug)]
pub struct Flight {
    /// A record a frame, in order.
    pub frames: Vec<FrameRecord>,
    /// The firmware's last word on its own state.
    pub health: Health,
    /// Messages received from the firmware, by id.
    pub messages: BTreeMap<u32, u64>,
    /// Servo commands: how many, and their root mean square off the exact angle at the time they arrived, radians.
    pub servo: (usize, f64),
    /// What was done to the link.
    pub faults: FaultCounts,
    /// Steps of the link.
    pub steps: u64,
    /// Numbers of the planned photos by frame, as the firmware told them with the stamped frames.
    pub photos: BTreeMap<u32, u32>,
    /// How far it says that the plan has been flown.
    pub plan: Option<PlanReport>,
}

/// What is to be kept of the pictures.
#[derive(Clone, Copy, Debug)]
pub struct Keep {
    /// Frames from the first whose pictures are kept.
    pub first: u32,
    /// And every so many after that; 0 for none.
    pub every: u32,
}

impl Keep {
    fn keeps(&self, frame: u32) -> bool {
        frame < self.first || (self.every > 0 && frame.is_multiple_of(self.every))
    }
}

/// Flies `stage` over `link`. `progress` is called with each frame's number as it is handed over.
///
/// # Errors
/// [`LinkError`] when the firmware is lost, or a position cannot be converted.
pub fn fly(stage: &Stage, link: &mut dyn Link, keep: Keep, progress: &mut dyn FnMut(u32)) -> Result<Flight, LinkError> {
    link.annotate(&annotation::scene(stage.tile_centre, stage.scenario.resolution_m));
    let mut cockpit = Cockpit::new(stage, link);
    let mut roll = Roll { frames: Vec::with_capacity(stage.scenario.frames as usize), closed: 0, keep };
    let mut lost = lost_frames(&stage.scenario);
    let mut end_us = stage.scenario.duration_us();
    if stage.plan.is_some() {
        // Exposures come as the firmware commits to them.
        while roll.frames.len() < stage.scenario.frames as usize {
            let Some((exposure, photo)) = cockpit.exposed(end_us)? else { break };
            roll.take(&mut cockpit, &exposure, Some(photo), lost.next() == Some(true), progress)?;
            if roll.frames.len() == stage.scenario.frames as usize {
                end_us = end_us.min(exposure.readout_start_us + COOL_DOWN_US);
                cockpit.stop_exposing();
            }
        }
    } else {
        for (exposure, is_lost) in exposures(&stage.scenario).zip(lost) {
            cockpit.until(exposure.readout_start_us)?;
            roll.take(&mut cockpit, &exposure, None, is_lost, progress)?;
        }
    }
    cockpit.until(end_us)?;
    let Roll { mut frames, closed, .. } = roll;
    for last in frames.get_mut(closed..).unwrap_or_default() {
        cockpit.close(last, keep);
    }
    Ok(cockpit.finish(frames))
}

/// The frames of a flight as they are taken.
struct Roll {
    frames: Vec<FrameRecord>,
    /// Those before this one have their reports.
    closed: usize,
    keep: Keep,
}

impl Roll {
    /// Takes the frame of an exposure whose first row arrives now.
    fn take(
        &mut self,
        cockpit: &mut Cockpit<'_>,
        exposure: &Exposure,
        photo: Option<PhotoReport>,
        is_lost: bool,
        progress: &mut dyn FnMut(u32),
    ) -> Result<(), LinkError> {
        let stage = cockpit.stage;
        let truth = stage.motion.state(exposure.mid_us());
        cockpit.link.annotate(&annotation::frame(exposure.frame, [truth.east_m, truth.north_m]));
        let exposure = *exposure;
        let (report, instant, raw) = (None, None, None);
        let mut record = FrameRecord { exposure, truth, report, instant, raw, frame: None, patch: None, photo };
        if is_lost {
            progress(exposure.frame);
            self.frames.push(record);
            return Ok(());
        }
        let rendered = picture(stage, &exposure);
        progress(exposure.frame);
        cockpit.frame(&exposure, &rendered.pixels)?;
        record.frame = Some(rendered.pixels);
        // The frames before have their poses by now, and their reports.
        for before in self.frames.get_mut(self.closed..).unwrap_or_default() {
            cockpit.close(before, self.keep);
        }
        self.closed = self.frames.len();
        self.frames.push(record);
        Ok(())
    }
}

/// The picture of an exposure: each row the mean of so many instants of its own exposure as the scenario says, by the
/// midpoint rule. Frame and truth belong to mid-exposure of the middle row.
fn picture(stage: &Stage, exposure: &Exposure) -> Rendered {
    let scenario = &stage.scenario;
    let station = |offset_us: f64| {
        let at_us = exposure.mid_us().saturating_add_signed(offset_us.round() as i64);
        stage.station(&stage.motion.state(at_us))
    };
    let offsets_us = |row: usize| scenario.sample_offsets_us(row);
    let (noise_dn, seed, index) = (scenario.noise_dn, scenario.seed, exposure.frame.into());
    if scenario.rolling_shutter_ms == 0.0 {
        // All rows share their instants.
        let stations: Vec<_> = offsets_us(0).map(station).collect();
        return stage.renderer.render_rows(&stage.ground, &|_| stations.clone(), noise_dn, seed, index);
    }
    let stations = |row: usize| offsets_us(row).map(station).collect();
    stage.renderer.render_rows(&stage.ground, &stations, noise_dn, seed, index)
}

/// The simulator's side of the link.
struct Cockpit<'s> {
    stage: &'s Stage,
    link: &'s mut dyn Link,
    streams: Streams,
    timer: TimerModel,
    pulse_jitter: White,
    /// Edges still to come.
    edges: VecDeque<LineEdge>,
    shutter: Shutter,
    line: ShutterLine,
    /// Planned exposures whose frames are still to come, and how many there were; none are made any more without.
    planned: VecDeque<(Exposure, PhotoReport)>,
    exposures: Option<u32>,
    autopilot: Autopilot,
    injector: FaultInjector,
    station: Station,
    /// TIMESYNC answers under way: when they arrive, their bytes.
    answers: Vec<(u64, Vec<u8>)>,
    now_us: u64,
    servo: (usize, f64),
    steps: u64,
}

impl<'s> Cockpit<'s> {
    fn new(stage: &'s Stage, link: &'s mut dyn Link) -> Self {
        Cockpit {
            stage,
            link,
            streams: Streams::new(&stage.scenario, stage.convergence_rad),
            timer: TimerModel::new(&stage.scenario),
            pulse_jitter: White::new(stage.scenario.timer.pps_jitter_us, stage.scenario.seed, "pps"),
            edges: if stage.plan.is_some() { VecDeque::new() } else { line_edges(&stage.scenario).into() },
            shutter: Shutter::new(&stage.scenario),
            line: ShutterLine::new(&stage.scenario),
            planned: VecDeque::new(),
            exposures: stage.plan.as_ref().map(|_| 0),
            autopilot: Autopilot::default(),
            injector: FaultInjector::new(&stage.scenario, "to_firmware"),
            station: Station::default(),
            answers: Vec::new(),
            now_us: 0,
            servo: (0, 0.0),
            steps: 0,
        }
    }

    /// Lets everything happen until the first row of the next planned exposure arrives, which is returned, or until `end_us`.
    fn exposed(&mut self, end_us: u64) -> Result<Option<(Exposure, PhotoReport)>, LinkError> {
        self.until(end_us)?;
        Ok(self.planned.pop_front().filter(|(exposure, _)| exposure.readout_start_us <= end_us))
    }

    /// Opens the shutter no more, and hands over no frame that was under way.
    fn stop_exposing(&mut self) {
        self.exposures = None;
        self.planned.clear();
    }

    /// The firmware has committed to an exposure: the shutter will open, where it still can, so that its middle is then.
    fn commit(&mut self, photo: PhotoReport) {
        let Some(count) = self.exposures else { return };
        let half_us = u64::from(self.stage.scenario.exposure_us) / 2;
        let open_us = photo.mid_exposure_us.saturating_sub(half_us);
        if open_us <= self.now_us {
            return;
        }
        let exposure = self.shutter.expose(count, open_us);
        self.exposures = Some(count + 1);
        let mut edges: Vec<_> = self.edges.drain(..).collect();
        edges.extend(self.line.edges(&self.stage.scenario, &exposure));
        edges.sort_by(|a, b| a.at_us.total_cmp(&b.at_us));
        self.edges = edges.into();
        self.planned.push_back((exposure, photo));
    }

    /// Lets everything happen that reaches the board before `end_us`, or before the frame of a planned exposure.
    fn until(&mut self, end_us: u64) -> Result<(), LinkError> {
        loop {
            // It may have been committed to just now.
            let frame_us = self.planned.front().map_or(u64::MAX, |(exposure, _)| exposure.readout_start_us);
            let end_us = end_us.min(frame_us);
            let answer_us = self.answers.first().map_or(u64::MAX, |(at, _)| *at);
            let edge_us = self.edges.front().map_or(u64::MAX, LineEdge::seen_us);
            let horizon = end_us.min(answer_us).min(edge_us).min(self.now_us + STEP_MAX_US);
            let slant = |state: &TrueState| self.stage.slant_m(state);
            if let Some(sample) = self.streams.next_before(horizon, &self.stage.motion, &slant) {
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
    }

    fn sample(&mut self, sample: &Sample) -> Result<(), LinkError> {
        if let Reading::Pps { .. } = sample.reading {
            let tick = self.timer.latch(sample.sampled_at_us as f64 + self.pulse_jitter.draw());
            return self.step(sample.arrived_at_us, Event::Pulse(tick));
        }
        match self.autopilot.message(sample, &self.stage.crs)? {
            Some(message) => self.bytes(sample.arrived_at_us, &message),
            None => Ok(()),
        }
    }

    fn edge(&mut self) -> Result<(), LinkError> {
        let Some(edge) = self.edges.pop_front() else { return Ok(()) };
        let tick = self.timer.latch(edge.at_us);
        self.step(edge.seen_us(), Event::Edge { tick, rising: edge.rising })
    }

    /// A message, through whatever goes wrong on the link.
    fn bytes(&mut self, at_us: u64, message: &[u8]) -> Result<(), LinkError> {
        let mut passed = Vec::with_capacity(message.len());
        self.injector.pass(message, &mut passed);
        self.step(at_us, Event::Bytes(&passed))
    }

    fn frame(&mut self, exposure: &Exposure, pixels: &[u8]) -> Result<(), LinkError> {
        let camera = &self.stage.scenario.camera;
        self.step(
            exposure.readout_start_us,
            Event::Frame(FrameEvent {
                sequence: exposure.frame,
                arrival: self.timer.ticks(exposure.readout_start_us),
                size: (camera.cols, camera.rows),
                pixels,
            }),
        )
    }

    fn step(&mut self, at_us: u64, event: Event<'_>) -> Result<(), LinkError> {
        self.now_us = at_us.max(self.now_us);
        self.steps += 1;
        let sent = self.link.step(self.timer.ticks(self.now_us), event)?;
        self.station.take(&sent);
        let mut asked = std::mem::take(&mut self.station.timesync);
        asked.retain(|_| self.stage.scenario.timer.timesync);
        for (stamp, system, component) in asked {
            let at_autopilot = self.now_us + LINK_DELAY_US;
            let answer = self.autopilot.timesync_answer(stamp, at_autopilot, (system, component));
            self.answers.push((at_autopilot + LINK_DELAY_US, answer));
        }
        for photo in std::mem::take(&mut self.station.due) {
            self.commit(photo);
        }
        let servo = std::mem::take(&mut self.station.servo);
        if !servo.is_empty() {
            let state = self.stage.motion.state(self.now_us);
            let exact = follow_up_exact(state.heading_rad, state.pitch_rad, state.roll_rad);
            for command in servo {
                let off = crate::flight::wrapped(command - exact);
                self.servo.0 += 1;
                self.servo.1 += off * off;
            }
        }
        Ok(())
    }

    /// Takes what the firmware said of a frame, compares the raw frame, and drops pictures that nobody wants.
    fn close(&mut self, record: &mut FrameRecord, keep: Keep) {
        let frame = record.exposure.frame;
        record.report = self.station.reports.get(&frame).copied();
        record.instant = self.station.instants.get(&frame).copied();
        record.patch = self.station.patches.remove(&frame);
        if let Some(pixels) = &record.frame {
            record.raw = match_raw(self.stage, &record.truth, pixels, record.report.as_ref());
        }
        if !keep.keeps(frame) {
            record.frame = None;
            record.patch = None;
        }
    }

    fn finish(self, frames: Vec<FrameRecord>) -> Flight {
        let (count, squares) = self.servo;
        Flight {
            frames,
            health: self.station.health,
            messages: self.station.messages,
            servo: (count, (squares / count.max(1) as f64).sqrt()),
            faults: self.injector.counts(),
            steps: self.steps,
            photos: self.station.photos,
            plan: self.station.plan,
        }
    }
}
