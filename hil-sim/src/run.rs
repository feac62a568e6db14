//! A flight: events in the order in which they reach the board, each a step of the link, and the result of every frame.

mod cockpit;
#[cfg(test)]
mod tests;
mod truth;

use crate::camera::faulty::FaultyCamera;
use crate::camera::render::Rendered;
use crate::fault::FaultCounts;
use crate::ground_station::{GroundStation, ReceivedPatch};
use crate::link::{Link, LinkError, annotation};
use crate::scenario::{COOL_DOWN_US, is_during};
use crate::setup::Setup;
use crate::vehicle::aloft::moment::Track;
use crate::vehicle::motion::{Recorded, TrueState};
use crate::vehicle::sensors::{Exposure, Sensed, lost_frames, openings};
use cockpit::Cockpit;
use plumbline_firmware::wire::telemetry::{FrameReport, Health, InstantReport, PhotoReport, PlanReport, SigningReport};
use std::collections::BTreeMap;
use std::fmt;

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
    /// The picture, kept for the first frames and a few others.
    pub frame: Option<Vec<u8>>,
    /// The patch that the firmware sent.
    pub patch: Option<ReceivedPatch>,
    /// The planned photo that it is, as the firmware called it when it committed to the exposure.
    pub photo: Option<PhotoReport>,
}

impl FrameRecord {
    /// Takes what the firmware said of the frame; its patch is kept nowhere else.
    pub(crate) fn take_reports(&mut self, station: &mut GroundStation) {
        let frame = self.exposure.frame;
        self.report = station.reports.get(&frame).copied();
        self.instant = station.instants.get(&frame).copied();
        self.patch = station.patches.remove(&frame);
    }
}

/// A finished flight.
#[derive(Clone, Debug)]
pub struct Flight {
    /// A record a frame, in order.
    pub frames: Vec<FrameRecord>,
    /// The firmware's last word on its own state.
    pub health: Health,
    /// Where messages were signed, what the firmware refused, and how many the autopilot where that is known.
    pub signing: Option<(SigningReport, Option<u64>)>,
    /// Messages received from the firmware, by id.
    pub messages: BTreeMap<u32, u64>,
    /// Servo commands: how many, and their root mean square off the exact angle at the time they arrived, radians.
    pub servo: (usize, f64),
    /// What was done to the link.
    pub faults: FaultCounts,
    /// Steps of the link.
    pub steps: u64,
    /// Numbers of the planned photos by frame, as the firmware reported them with the stamped frames.
    pub photos: BTreeMap<u32, u32>,
    /// How far it says that the plan has been flown.
    pub plan: Option<PlanReport>,
    /// Planned exposures that the firmware committed to when their shutter would have had to be open already.
    pub late: u32,
    /// What the firmware told the pilot, line by line.
    pub lines: Vec<String>,
    /// The set of sources that the simulated autopilot's estimator used in the end; 0 of a real one.
    pub source_set: u8,
    /// The camera's truth, where it was not known before the flight.
    pub motion: Option<Vec<Recorded>>,
    /// The simulated autopilot's navigation, where it has one.
    pub track: Option<Track>,
}

/// A flight that ended early: what there is of it, and why.
#[derive(Debug)]
pub struct Aborted {
    /// Its frames are those up to the last one that was reported.
    pub flight: Flight,
    /// What ended it.
    pub why: LinkError,
}

impl fmt::Display for Aborted {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.why.fmt(f)
    }
}

impl std::error::Error for Aborted {}

impl From<Box<Aborted>> for LinkError {
    fn from(aborted: Box<Aborted>) -> Self {
        aborted.why
    }
}

/// Observes a flight; `()` ignores every event.
pub trait Observer {
    /// Frame `frame` was exposed.
    fn exposed(&mut self, _frame: u32) {}

    /// All that the firmware says of a frame is in, and its picture is still there.
    fn finished(&mut self, _setup: &Setup, _record: &FrameRecord) {}

    /// Whether the flight is to end now.
    fn is_interrupted(&self) -> bool {
        false
    }
}

impl Observer for () {}

/// What is to be kept of the pictures.
#[derive(Clone, Copy, Debug, Default)]
pub struct Keep {
    /// Frames from the first whose pictures are kept.
    pub first: u32,
    /// And every so many after that; 0 for none.
    pub every: u32,
    /// And of frames without a fix, so many from the first.
    pub refused: u32,
}

impl Keep {
    /// Drops the pictures of a frame that is closed and that nobody wants.
    pub(crate) fn tidy(&mut self, record: &mut FrameRecord) {
        let frame = record.exposure.frame;
        if frame < self.first || self.every > 0 && frame.is_multiple_of(self.every) {
            return;
        }
        if self.refused > 0 && record.frame.is_some() && record.report.is_none_or(|report| report.fix.is_none()) {
            self.refused -= 1;
            return;
        }
        (record.frame, record.patch) = (None, None);
    }
}

/// Flies `setup` over `link` while `observer` watches.
///
/// # Errors
/// [`Aborted`] with the frames so far when the firmware is lost, a position cannot be converted or the observer ends it.
pub fn fly(
    setup: &Setup,
    link: &mut dyn Link,
    keep: Keep,
    observer: &mut dyn Observer,
) -> Result<Flight, Box<Aborted>> {
    link.annotate(&annotation::scene(setup.tile_centre, setup.scenario.vehicle.resolution_m));
    let frames = Vec::with_capacity(setup.scenario.run.frames as usize);
    let (scenario, camera) = (&setup.scenario, &setup.payload.camera);
    let size = (camera.cols as usize, camera.rows as usize);
    let camera = FaultyCamera::new(scenario.faults.timed.clone(), scenario.run.seed, size);
    let mut roll = Frames { cockpit: Cockpit::new(setup, link), camera, observer, frames, closed: 0, keep };
    let end = if setup.plan.is_some() { roll.along_plan() } else { roll.at_intervals() };
    while roll.closed < roll.frames.len() {
        roll.close();
    }
    let Frames { cockpit, mut frames, .. } = roll;
    let Err(why) = end else { return Ok(cockpit.finish(frames)) };
    let reported = frames.iter().rposition(|record| record.report.is_some()).map_or(0, |last| last + 1);
    frames.truncate(reported);
    Err(Box::new(Aborted { flight: cockpit.finish(frames), why }))
}

/// The frames of a flight as they are taken.
struct Frames<'s> {
    cockpit: Cockpit<'s>,
    camera: FaultyCamera,
    observer: &'s mut dyn Observer,
    frames: Vec<FrameRecord>,
    /// Those before this one have their reports.
    closed: usize,
    keep: Keep,
}

impl Frames<'_> {
    /// A frame at each interval.
    fn at_intervals(&mut self) -> Result<(), LinkError> {
        let scenario = &self.cockpit.setup.scenario;
        let (mut openings, mut lost) = (openings(scenario), lost_frames(scenario));
        let mut next = openings.next().map(|opening| self.cockpit.expose(opening));
        while let Some(exposure) = next {
            self.cockpit.until(exposure.readout_start_us, self.observer)?;
            // Its edges may come before the frame has been worked on.
            next = openings.next().map(|opening| self.cockpit.expose(opening));
            self.take(&exposure, None, lost.next() == Some(true))?;
        }
        self.cockpit.until(scenario.run.duration_us(), self.observer)
    }

    /// Exposures come as the firmware commits to them.
    fn along_plan(&mut self) -> Result<(), LinkError> {
        let scenario = &self.cockpit.setup.scenario;
        let (mut end_us, mut lost) = (scenario.run.duration_us(), lost_frames(scenario));
        while self.frames.len() < scenario.run.frames as usize {
            let Some((exposure, photo)) = self.cockpit.exposed(end_us, self.observer)? else { break };
            self.take(&exposure, Some(photo), lost.next() == Some(true))?;
            if self.frames.len() == scenario.run.frames as usize {
                end_us = end_us.min(exposure.readout_start_us + COOL_DOWN_US);
                self.cockpit.stop_exposing();
            }
        }
        self.cockpit.until(end_us, self.observer)
    }

    /// Takes the frame of an exposure whose first row arrives now.
    fn take(&mut self, exposure: &Exposure, photo: Option<PhotoReport>, is_lost: bool) -> Result<(), LinkError> {
        let (setup, exposure) = (self.cockpit.setup, *exposure);
        let truth = self.cockpit.truth.state(exposure.mid_us());
        self.cockpit.link.annotate(&annotation::frame(exposure.frame, [truth.east_m, truth.north_m]));
        let (report, instant) = (None, None);
        let mut record = FrameRecord { exposure, truth, report, instant, frame: None, patch: None, photo };
        self.observer.exposed(exposure.frame);
        if !is_lost {
            let pixels = match &setup.pictures {
                Some(pictures) => pictures.read(exposure.frame as usize)?.pixels,
                None => self.rendered(&exposure),
            };
            let pixels = self.camera.pass(exposure.frame, exposure.mid_us(), pixels);
            self.cockpit.frame(&exposure, &pixels)?;
            record.frame = Some(pixels);
            self.close_before();
        }
        self.frames.push(record);
        Ok(())
    }

    fn rendered(&self, exposure: &Exposure) -> Vec<u8> {
        let setup = self.cockpit.setup;
        let motion = self.cockpit.truth.around(exposure, setup.scenario.vehicle.rolling_shutter_us());
        picture(setup, exposure, &|at_us| motion.state(at_us)).pixels
    }

    /// Ends the frames before one that has just been handed over. Mostly they have their reports by now; the last of them may still
    /// wait for its pose, and has until the next one.
    fn close_before(&mut self) {
        while let Some(record) = self.frames.get(self.closed)
            && (self.closed + 1 < self.frames.len() || self.cockpit.is_reported(record))
        {
            self.close();
        }
    }

    /// Ends the first frame that is not closed yet: it gets what the firmware said of it, the observer sees it, and pictures that
    /// nobody wants are dropped.
    fn close(&mut self) {
        let Some(record) = self.frames.get_mut(self.closed) else { return };
        self.cockpit.report(record);
        self.observer.finished(self.cockpit.setup, record);
        self.keep.tidy(record);
        self.closed += 1;
    }
}

/// The picture of an exposure of a vehicle that is in `state` at each instant: each row the mean of so many instants of its own
/// exposure as the scenario says, by the midpoint rule. Frame and truth belong to mid-exposure of the middle row.
pub(crate) fn picture(setup: &Setup, exposure: &Exposure, state: &(dyn Fn(u64) -> TrueState + Sync)) -> Rendered {
    let scenario = &setup.scenario;
    let (noise_dn, seed, index) = (scenario.world.noise_dn, scenario.run.seed, exposure.frame.into());
    let levels = (scenario.gain(exposure.set_us, exposure.mid_us()), noise_dn);
    let at_s = 1e-6 * (u64::from(exposure.frame) * scenario.run.frame_interval_us()) as f64;
    if is_during(scenario.faults.shutter.covered_s, at_s) {
        return setup.renderer.black(noise_dn, seed, index);
    }
    let station = |offset_us: f64| {
        let at_us = exposure.mid_us().saturating_add_signed(offset_us.round() as i64);
        setup.station(&state(at_us))
    };
    let (state_now, ground) = (state(exposure.mid_us()), &setup.ground);
    let weather = setup.weather.at(index, at_s, ground.height(state_now.east_m, state_now.north_m));
    let through = (ground, &weather);
    let offsets_us = |row: usize| scenario.sample_offsets_us(exposure.set_us, row, setup.payload.camera.rows);
    if scenario.vehicle.rolling_shutter_ms == 0.0 {
        // All rows share their instants.
        let stations: Vec<_> = offsets_us(0).map(station).collect();
        return setup.renderer.render_through(through, &|_| stations.clone(), levels, seed, index);
    }
    let stations = |row: usize| offsets_us(row).map(station).collect();
    setup.renderer.render_through(through, &stations, levels, seed, index)
}
