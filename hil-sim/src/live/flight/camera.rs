//! The camera in flight: exposures when they are due, pictures when their truth has come, frames when they are made.

use super::{Flying, STEP_MAX_US};
use crate::link::{Event, FrameEvent, annotation};
use crate::live::LiveError;
use crate::live::frames::{Job, Made, camera_of};
use crate::run::{FrameRecord, Observer};
use crate::scenario::{COOL_DOWN_US, FollowUpMode};
use crate::vehicle::motion::{Recorded, TrueState};

/// How long an exposure waits for its truth, microseconds of the autopilot's clock. Chosen: an intact connection is ten times as
/// quick.
const TRUTH_WAIT_US: f64 = 500_000.0;

impl Flying<'_> {
    /// Lets happen what is due at an instant of ours.
    pub(super) fn go_on(&mut self, wall_s: f64, observer: &mut dyn Observer) -> Result<(), LiveError> {
        let Some(now_us) = self.board_us(wall_s) else { return Ok(()) };
        self.begin(now_us);
        self.expose(now_us);
        self.edges(now_us)?;
        self.take_pictures(now_us);
        self.deliver(now_us, observer)?;
        if now_us - self.now_us >= STEP_MAX_US {
            self.step(now_us, Event::Nothing)?;
        }
        self.close(now_us - COOL_DOWN_US as f64);
        Ok(())
    }

    /// The camera is switched on at a height.
    fn begin(&mut self, now_us: f64) {
        if self.exposures.has_begun() || !self.was_armed {
            return;
        }
        let height_m = self.truth.newest().map(|state| state.up_m);
        if height_m.is_some_and(|height_m| height_m >= self.setup.scenario.run.live.from_height_m) {
            self.exposures.begin(now_us);
            self.begin_us = Some(now_us);
        }
    }

    fn expose(&mut self, now_us: f64) {
        let under_way = self.waiting.len() + self.in_making + self.ready.len();
        let taken = self.frames.len() + under_way;
        if self.wanted.frames.is_some_and(|frames| taken >= frames as usize) {
            return;
        }
        if let Some(exposure) = self.exposures.opened(&self.setup.scenario, now_us, under_way) {
            self.waiting.push_back(exposure);
        }
    }

    /// The edges that the board has seen by `now_us`.
    pub(super) fn edges(&mut self, now_us: f64) -> Result<(), LiveError> {
        while let Some(edge) = self.exposures.edge(now_us) {
            let tick = self.timer.latch(edge.at_us);
            self.step(edge.seen_us() as f64, Event::Edge { tick, rising: edge.rising })?;
        }
        Ok(())
    }

    /// Has pictures made of the exposures whose truth has come.
    fn take_pictures(&mut self, now_us: f64) {
        while let Some(exposure) = self.waiting.front().copied() {
            let [from_us, to_us] = Job::span_us(&exposure, self.setup);
            if self.truth.newest_us().is_none_or(|newest_us| newest_us < to_us) {
                if now_us < to_us + TRUTH_WAIT_US {
                    return;
                }
                self.counts.without_truth += 1;
                self.waiting.pop_front();
                continue;
            }
            self.waiting.pop_front();
            let samples = self.truth.around(from_us, to_us);
            let job = Job { exposure, samples, follow_up_rad: self.follow_up_rad(exposure.mid_us() as f64) };
            if job.state(exposure.mid_us() as f64, self.setup).is_some() && self.jobs.send(job).is_ok() {
                self.in_making += 1;
            } else {
                self.counts.without_truth += 1;
            }
        }
    }

    /// Where an ideal servo has the camera: at the newest command before the instant.
    fn follow_up_rad(&self, at_us: f64) -> f64 {
        if self.setup.scenario.vehicle.follow_up.mode == FollowUpMode::Fixed {
            return 0.0;
        }
        let after = self.commands.partition_point(|(commanded_us, _)| *commanded_us <= at_us);
        after.checked_sub(1).map_or(0.0, |newest| self.commands[newest].1)
    }

    /// Hands over the frames that are made, not before their first row arrives.
    fn deliver(&mut self, now_us: f64, observer: &mut dyn Observer) -> Result<(), LiveError> {
        while let Ok(made) = self.made.try_recv() {
            self.in_making -= 1;
            if made.rendered.outside > 0 {
                self.counts.beyond_ground += 1;
            } else {
                self.ready.push_back(made);
            }
        }
        while let Some(made) = self.ready.pop_front_if(|made| made.exposure.readout_start_us as f64 <= now_us) {
            self.frame(made, now_us, observer)?;
        }
        Ok(())
    }

    fn frame(&mut self, made: Made, now_us: f64, observer: &mut dyn Observer) -> Result<(), LiveError> {
        let Made { exposure, truth, rendered } = made;
        let camera = &self.setup.payload.camera;
        self.link.annotate(&annotation::frame(exposure.frame, [truth.east_m, truth.north_m]));
        let event = FrameEvent {
            sequence: exposure.frame,
            arrival: self.timer.ticks(exposure.readout_start_us),
            size: (camera.cols as u16, camera.rows as u16),
            pixels: &rendered.pixels,
        };
        self.step(now_us, Event::Frame(event))?;
        let late_ms = 1e-3 * (self.now_us - exposure.mid_us() as f64);
        self.deliveries_ms = (self.deliveries_ms.0 + late_ms, self.deliveries_ms.1.max(late_ms));
        self.counts.delivered += 1;
        let (report, instant) = (None, None);
        let frame = Some(rendered.pixels);
        self.frames.push(FrameRecord { exposure, truth, report, instant, frame, patch: None, photo: None });
        observer.exposed(self.counts.delivered - 1);
        Ok(())
    }

    /// Ends the frames that arrived before `before_us`: their reports have come, or never will.
    pub(super) fn close(&mut self, before_us: f64) {
        while let Some(record) = self.frames.get_mut(self.closed) {
            if record.exposure.readout_start_us as f64 > before_us {
                return;
            }
            record.take_reports(&mut self.station);
            // A judge that has gone judges no more.
            let _ = self.to_judge.send(FrameRecord { patch: None, ..record.clone() });
            self.wanted.keep.tidy(record);
            self.closed += 1;
        }
    }

    /// The camera's truth of the whole flight.
    pub(super) fn motion(&self) -> Vec<Recorded> {
        let camera = |(at_us, state): (f64, TrueState)| {
            let state = TrueState { follow_up_rad: self.follow_up_rad(at_us), ..state };
            (at_us, camera_of(&state, self.setup))
        };
        self.truth.all().into_iter().map(camera).collect()
    }
}
