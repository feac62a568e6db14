//! A frame from its first row to its fix.

use super::autopilot::Kind;
use super::{App, FrameOut, Out};
use crate::board::{FrameStart, FrontEnd, PerformanceCounters, Rows, Timer};
use crate::journal::{Event, Gate};
use crate::wire::telemetry::{
    FixReport, FrameReport, MatchReport, PlaceReport, PoseReport, PositionReport, Risk, SituationReport, StampReport,
};
use plumbline_core::pipeline::{Outcome, Pipeline, Refusal, Situation};
use plumbline_core::pose::Wait;
use plumbline_core::stamp::{Stamp, StampError};
use plumbline_core::units::Ticks;

/// Most lost frames that are reported one by one; more are counted only, and more than half of all numbers are a restarted
/// counter.
const LOST_MAX: u32 = 16;
/// A clock that is moved by more sigmas of a frame's stamp, and a microsecond that rounding may make, has made a step: fewer than one in two
/// million normal errors are beyond.
const STEP_SIGMAS: f32 = 5.0;

/// Works on frames for ever.
pub async fn camera(
    app: &App<'_>,
    front_end: &mut impl FrontEnd,
    timer: &impl Timer,
    performance: &impl PerformanceCounters,
) -> ! {
    let mut expected = 0u32;
    let mut moving = None;
    loop {
        let start = front_end.frame().await;
        app.event(Event::Start(start));
        app.autopilot.with(|autopilot| autopilot.taken(Kind::Frame, start.arrival));
        let lost = start.sequence.wrapping_sub(expected);
        if lost <= LOST_MAX {
            // All are in the journal before the first is sent: the outbox may make us wait, and others go on meanwhile.
            for frame in (0..lost).map(|n| FrameOut::busy(expected.wrapping_add(n))) {
                app.count(|c| c.frames_lost += 1);
                frame.report_to(app);
            }
            for frame in (0..lost).map(|n| FrameOut::busy(expected.wrapping_add(n))) {
                app.outbox.takes_frame().await;
                app.outbox.put(Out::Frame(frame));
            }
        }
        if (LOST_MAX + 1..1 << 31).contains(&lost) {
            // Too many to be reported one by one.
            app.count(|c| c.frames_lost = c.frames_lost.saturating_add(lost));
        }
        expected = start.sequence.wrapping_add(1);
        app.exposure_moved(moving.take());
        let mut work = Work { out: FrameOut::new(start.sequence) };
        if let Err(refusal) = work.frame(app, start, front_end, timer, performance).await {
            work.out.report.refusal = refusal.code();
        }
        work.out.instant.place = work.place(app);
        if work.out.fix.is_some() {
            app.count(|c| c.fixes += 1);
        }
        work.out.report_to(app);
        moving = work.out.situation.filter(|_| app.controls_exposure()).map(|situation| situation.moving());
        app.outbox.takes_frame().await;
        app.outbox.put(Out::Frame(work.out));
    }
}

impl FrameOut {
    /// A frame that was lost while another was being worked on.
    fn busy(sequence: u32) -> Self {
        let report = FrameReport { refusal: Refusal::Busy.code(), ..FrameReport::new(sequence) };
        FrameOut { report, ..FrameOut::new(sequence) }
    }

    fn report_to(&self, app: &App<'_>) {
        app.event(Event::Frame(&self.report, &self.instant, self.fix.map(|fix| fix.position)));
        app.watch(&self.report);
    }
}

/// What is known of the frame so far.
struct Work {
    out: FrameOut,
}

impl Work {
    /// Where the vehicle is by now.
    fn place(&self, app: &App<'_>) -> Option<PlaceReport> {
        let situation = self.out.situation.as_ref()?;
        let map_sigma_m = app.autopilot.with(|autopilot| autopilot.fixes.map_sigma_m())?;
        let place = |pipeline: &mut Pipeline<'_>| pipeline.place(situation, self.out.fix.as_ref(), map_sigma_m);
        app.pipeline.with(place)?.as_ref().map(PlaceReport::new)
    }

    async fn frame(
        &mut self,
        app: &App<'_>,
        start: FrameStart,
        front_end: &mut impl FrontEnd,
        timer: &impl Timer,
        performance: &impl PerformanceCounters,
    ) -> Result<(), Refusal> {
        app.gate(Gate::Begin).await;
        let rows = self.rows(app, start, front_end, performance).await;
        app.event(Event::Rows(rows));
        app.control_exposure(start.sequence, front_end);
        // A frame without rows has had its edges all the same.
        let stamped = app.stamper.with(|stamper| {
            app.expect_exposure(start.sequence, stamper);
            let (stamp, cost) = performance.counted(|| stamper.frame(start.arrival));
            (stamp.map(|stamp| (stamp, stamper.clock.state(start.arrival))), cost)
        });
        let (stamped, cost) = stamped.ok_or(Refusal::Busy)?;
        self.out.report.instructions[1] = cost;
        if let Ok((stamp, clock)) = &stamped {
            self.out.instant.stamp = Some(StampReport::new(stamp, clock));
            self.out.report.mid_exposure_us = stamp.mid.0;
        }
        // Without a clock no range is taken, and without a range no row is: the clock is what is missing.
        if stamped != Err(StampError::NoClock) {
            rows?;
        }
        let (stamp, _) = stamped.map_err(Refusal::from)?;
        let situation = self.situation(app, &stamp, start.arrival, timer, performance).await?;
        self.out.situation = Some(situation);
        self.out.instant.pose = Some(PoseReport::new(&situation));
        let report = &mut self.out.report;
        report.predicted = Some(PositionReport::new(situation.prediction.local));
        report.situation = Some(SituationReport::new(&situation));
        // From here on the patch's buffer belongs to this frame.
        app.patch.set(app.patch.get().wrapping_add(1));
        app.pipeline
            .with(|pipeline| self.register(app, pipeline, &situation, performance))
            .unwrap_or(Err(Refusal::Busy))
    }

    /// From the frame to the fix, once its situation is known.
    fn register(
        &mut self,
        app: &App<'_>,
        pipeline: &mut Pipeline<'_>,
        situation: &Situation,
        performance: &impl PerformanceCounters,
    ) -> Result<(), Refusal> {
        let report = &mut self.out.report;
        let (rectified, cost) = performance.counted(|| pipeline.rectify(situation));
        report.instructions[3] = cost;
        rectified?;
        let (pixels, size, runs) = pipeline.patch_mut();
        app.journal.patch(size, runs, pixels);
        self.out.patch = Some(app.patch.get());
        let (matched, cost) = performance.counted(|| pipeline.match_patch(situation));
        report.instructions[4] = cost;
        let matched = matched?;
        let (outcome, cost) = performance.counted(|| pipeline.fix(situation, &matched));
        report.instructions[5] = cost;
        self.outcome(&outcome)
    }

    /// Rows as they arrive, summed as soon as those of a row of boxes are there. A frame of another size is refused before
    /// its first row is touched.
    async fn rows(
        &mut self,
        app: &App<'_>,
        start: FrameStart,
        front_end: &mut impl FrontEnd,
        performance: &impl PerformanceCounters,
    ) -> Result<(), Refusal> {
        app.event(Event::Begin);
        let begun = app.pipeline.with(|pipeline| {
            let camera = &pipeline.settings().camera;
            if start.size != (camera.cols(), camera.rows()) {
                return Err(Refusal::BadFrame);
            }
            let (begun, cost) = performance.counted(|| pipeline.begin_frame());
            self.out.report.instructions[0] += cost;
            begun
        });
        begun.unwrap_or(Err(Refusal::Busy))?;
        loop {
            let wanted = app.pipeline.with(|pipeline| pipeline.rows_wanted()).ok_or(Refusal::Busy)?;
            if wanted == 0 {
                return Ok(());
            }
            match front_end.rows(wanted).await {
                Rows::Pixels(pixels) => {
                    let taken = app.pipeline.with(|pipeline| performance.counted(|| pipeline.rows(pixels)));
                    let (taken, cost) = taken.ok_or(Refusal::Busy)?;
                    self.out.report.instructions[0] += cost;
                    taken?;
                }
                Rows::End => return Err(Refusal::BadFrame),
                Rows::Overrun => return Err(Refusal::Overrun),
            }
        }
    }

    /// Waits until every stream has the samples after mid-exposure that its smoothing wants, or patience ends: then what is
    /// there must do. A clock that makes a step meanwhile leaves the frame with a stamp of the clock before, while later samples
    /// are stamped by the new one.
    async fn situation(
        &mut self,
        app: &App<'_>,
        stamp: &Stamp,
        arrival: Ticks,
        timer: &impl Timer,
        performance: &impl PerformanceCounters,
    ) -> Result<Situation, Refusal> {
        let arrived_at = app.instant(arrival);
        loop {
            app.gate(Gate::Pose).await;
            app.fresh.reset();
            // On a clock that has been tied anew the exposure may lie ahead.
            let tick = timer.now();
            let now = app.instant(tick);
            let situate = |pipeline: &mut Pipeline<'_>| {
                let settings = pipeline.settings();
                let is_late = now.is_none_or(|now| now.since(stamp.mid).unsigned_abs() > settings.patience_us);
                let wait = if is_late { Wait::No } else { settings.wait() };
                let (situation, cost) = performance.counted(|| pipeline.situate((stamp.mid, stamp.sigma_us), wait));
                self.out.report.instructions[2] += cost;
                situation.map_err(Refusal::from)
            };
            let moved_us = arrived_at.zip(app.instant(arrival)).map(|(before, after)| after.since(before));
            let has_stepped = moved_us.is_none_or(|us| us.unsigned_abs() as f32 > 1.0 + STEP_SIGMAS * stamp.sigma_us);
            let situation = if has_stepped {
                Err(Refusal::UncertainClock)
            } else {
                app.pipeline.with(situate).unwrap_or(Err(Refusal::Busy))
            };
            if situation != Ok(None) {
                app.event(Event::Pose(tick));
                return situation?.ok_or(Refusal::Busy);
            }
            app.fresh.wait().await;
        }
    }

    fn outcome(&mut self, outcome: &Outcome) -> Result<(), Refusal> {
        let report = &mut self.out.report;
        (report.search_px, report.risk) = (outcome.search_px as u8, Risk::new(outcome.risk));
        report.matched = Some(MatchReport::new(outcome));
        let fix = outcome.fix?;
        report.fix = Some(FixReport::new(&fix));
        self.out.fix = Some(fix);
        Ok(())
    }
}
