//! A frame from its first row to its fix.

use super::{App, FrameOut, Out};
use crate::board::{FrameStart, FrontEnd, Gauge, Rows, Timer};
use crate::journal::{Note, Turn};
use crate::wire::telemetry::{FrameReport, PoseTold, StampTold};
use plumbline_core::pipeline::{Outcome, Pipeline, Refusal, Situation};
use plumbline_core::pose::Wait;
use plumbline_core::units::Micros;

/// Most lost frames that are reported one by one; more are counted only, and more than half of all numbers are a restarted
/// counter.
const LOST_MAX: u32 = 16;

/// Works on frames for ever.
pub async fn camera(app: &App<'_>, front_end: &mut impl FrontEnd, timer: &impl Timer, gauge: &impl Gauge) -> ! {
    let mut expected = 0u32;
    loop {
        let start = front_end.frame().await;
        app.note(Note::Start(start));
        let lost = start.sequence.wrapping_sub(expected);
        if lost <= LOST_MAX {
            // All are noted before the first is sent: the outbox may make us wait, and others go on meanwhile.
            for frame in (0..lost).map(|n| FrameOut::busy(expected.wrapping_add(n))) {
                app.count(|c| c.frames_lost += 1);
                frame.note(app);
            }
            for frame in (0..lost).map(|n| FrameOut::busy(expected.wrapping_add(n))) {
                app.outbox.room().await;
                app.post(Out::Frame(frame));
            }
        }
        if (LOST_MAX + 1..1 << 31).contains(&lost) {
            // Too many to be reported one by one.
            app.count(|c| c.frames_lost = c.frames_lost.saturating_add(lost));
        }
        expected = start.sequence.wrapping_add(1);
        let mut work = Work { out: FrameOut::new(start.sequence) };
        if let Err(refusal) = work.frame(app, start, front_end, timer, gauge).await {
            work.out.report.refusal = refusal.code();
        }
        if work.out.fix.is_some() {
            app.count(|c| c.fixes += 1);
        }
        work.out.note(app);
        app.outbox.room().await;
        app.post(Out::Frame(work.out));
    }
}

impl FrameOut {
    /// A frame that was lost while another was being worked on.
    fn busy(sequence: u32) -> Self {
        let report = FrameReport { refusal: Refusal::Busy.code(), ..FrameReport::new(sequence) };
        FrameOut { report, ..FrameOut::new(sequence) }
    }

    fn note(&self, app: &App<'_>) {
        app.note(Note::Frame(&self.report, &self.instant, self.fix.map(|fix| fix.position)));
    }
}

/// What is known of the frame so far.
struct Work {
    out: FrameOut,
}

impl Work {
    async fn frame(
        &mut self,
        app: &App<'_>,
        start: FrameStart,
        front_end: &mut impl FrontEnd,
        timer: &impl Timer,
        gauge: &impl Gauge,
    ) -> Result<(), Refusal> {
        app.turn(Turn::Begin).await;
        let rows = self.rows(app, start, front_end, gauge).await;
        app.note(Note::Rows(rows));
        // A frame without rows has had its edges all the same.
        let stamped = app.stamper.with(|stamper| {
            let (stamp, cost) = gauge.measured(|| stamper.frame(start.arrival));
            (stamp.map(|stamp| (stamp, stamper.clock.state(start.arrival))), cost)
        });
        let (stamped, cost) = stamped.ok_or(Refusal::Busy)?;
        self.out.report.instructions[1] = cost;
        if let Ok((stamp, clock)) = &stamped {
            self.out.instant.stamp = Some(StampTold::new(stamp, clock));
            self.out.report.mid_exposure_us = stamp.mid.0;
        }
        rows?;
        let (stamp, _) = stamped.map_err(Refusal::from)?;
        let situation = self.situation(app, (stamp.mid, stamp.sigma_us), timer, gauge).await?;
        self.out.situation = Some(situation);
        self.out.instant.pose = Some(PoseTold::new(&situation));
        let report = &mut self.out.report;
        report.predicted = Some([situation.prediction.local.east_m, situation.prediction.local.north_m]);
        report.situation = Some([
            situation.height_m,
            situation.attitude.heading.0,
            situation.attitude.pitch.0,
            situation.attitude.roll.0,
            situation.follow_up.0,
        ]);
        // From here on the patch's buffer belongs to this frame.
        app.patch.set(app.patch.get().wrapping_add(1));
        app.pipeline.with(|pipeline| self.register(app, pipeline, &situation, gauge)).unwrap_or(Err(Refusal::Busy))
    }

    /// From the frame to the fix, once its situation is known.
    fn register(
        &mut self,
        app: &App<'_>,
        pipeline: &mut Pipeline<'_>,
        situation: &Situation,
        gauge: &impl Gauge,
    ) -> Result<(), Refusal> {
        let report = &mut self.out.report;
        let (rectified, cost) = gauge.measured(|| pipeline.rectify(situation));
        report.instructions[3] = cost;
        rectified?;
        let (pixels, size, runs) = pipeline.patch_mut();
        app.journal.patch(size, runs, pixels);
        self.out.patch = Some(app.patch.get());
        let (matched, cost) = gauge.measured(|| pipeline.match_patch(situation));
        report.instructions[4] = cost;
        let matched = matched?;
        let (outcome, cost) = gauge.measured(|| pipeline.fix(situation, &matched));
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
        gauge: &impl Gauge,
    ) -> Result<(), Refusal> {
        app.note(Note::Begin);
        let begun = app.pipeline.with(|pipeline| {
            let camera = &pipeline.settings().camera;
            if start.size != (camera.cols(), camera.rows()) {
                return Err(Refusal::BadFrame);
            }
            let (begun, cost) = gauge.measured(|| pipeline.begin_frame());
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
                    let taken = app.pipeline.with(|pipeline| gauge.measured(|| pipeline.rows(pixels)));
                    let (taken, cost) = taken.ok_or(Refusal::Busy)?;
                    self.out.report.instructions[0] += cost;
                    taken?;
                }
                Rows::End => return Err(Refusal::BadFrame),
                Rows::Overrun => return Err(Refusal::Overrun),
            }
        }
    }

    /// Waits until every stream has the samples after mid-exposure that its smoothing wants, or patience ends: then what
    /// is there must do.
    async fn situation(
        &mut self,
        app: &App<'_>,
        mid: (Micros, f32),
        timer: &impl Timer,
        gauge: &impl Gauge,
    ) -> Result<Situation, Refusal> {
        let mid_exposure_at = mid.0;
        loop {
            app.turn(Turn::Look).await;
            app.fresh.reset();
            // On a clock that has been tied anew the exposure may lie ahead.
            let tick = timer.now();
            let now = app.instant(tick);
            let look = |pipeline: &mut Pipeline<'_>| {
                let settings = pipeline.settings();
                let is_late = now.is_none_or(|now| now.since(mid_exposure_at).unsigned_abs() > settings.patience_us);
                let wait = if is_late { Wait::No } else { settings.wait() };
                let (situation, cost) = gauge.measured(|| pipeline.situate(mid, wait));
                self.out.report.instructions[2] += cost;
                match situation {
                    Ok(None) if is_late => Err(pipeline.missing_at(mid_exposure_at)),
                    situation => situation,
                }
            };
            let situation = app.pipeline.with(look).unwrap_or(Err(Refusal::Busy));
            if situation != Ok(None) {
                app.note(Note::Look(tick));
                return situation?.ok_or(Refusal::Busy);
            }
            app.fresh.wait().await;
        }
    }

    fn outcome(&mut self, outcome: &Outcome) -> Result<(), Refusal> {
        let report = &mut self.out.report;
        report.search_px = outcome.search_px;
        let [off_col, off_row] = outcome.window_off;
        let peak = &outcome.peak;
        report.matched = Some([
            outcome.d_col,
            outcome.d_row,
            outcome.scores[0],
            outcome.scores[1],
            peak.d_col as f32 + off_col,
            peak.d_row as f32 + off_row,
        ]);
        let fix = outcome.fix?;
        let c = &fix.covariance;
        report.fix = Some([fix.local.east_m, fix.local.north_m, c[(0, 0)], c[(0, 1)], c[(1, 1)]]);
        self.out.fix = Some(fix);
        Ok(())
    }
}
