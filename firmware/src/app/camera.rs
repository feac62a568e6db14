//! A frame from its first row to its fix.

use super::{App, FrameOut, Out};
use crate::board::{FrameStart, FrontEnd, Gauge, Rows, Timer};
use crate::wire::telemetry::{FrameReport, PoseTold, StampTold};
use plumbline_core::pipeline::{Outcome, Refusal, Situation};
use plumbline_core::pose::Wait;
use plumbline_core::units::Micros;

/// Most lost frames that are reported one by one; more are a restarted counter.
const LOST_MAX: u32 = 16;

/// Works on frames for ever.
pub async fn camera(app: &App<'_>, front_end: &mut impl FrontEnd, timer: &impl Timer, gauge: &impl Gauge) -> ! {
    let mut expected = 0u32;
    loop {
        let start = front_end.frame().await;
        let lost = start.sequence.wrapping_sub(expected);
        if lost <= LOST_MAX {
            for sequence in (0..lost).map(|n| expected.wrapping_add(n)) {
                app.count(|c| c.frames_lost += 1);
                let report = FrameReport { refusal: Refusal::Busy.code(), ..FrameReport::new(sequence) };
                app.outbox.send(Out::Frame(FrameOut { report, ..FrameOut::new(sequence) })).await;
            }
        }
        expected = start.sequence.wrapping_add(1);
        let mut work = Work { out: FrameOut::new(start.sequence) };
        if let Err(refusal) = work.frame(app, start, front_end, timer, gauge).await {
            work.out.report.refusal = refusal.code();
        }
        if work.out.fix.is_some() {
            app.count(|c| c.fixes += 1);
        }
        app.outbox.send(Out::Frame(work.out)).await;
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
        let rows = self.rows(app, start, front_end, gauge).await;
        // A frame without rows has had its edges all the same.
        let (stamp, cost) = gauge.measured(|| app.stamper.borrow_mut().frame(start.arrival));
        self.out.report.instructions[1] = cost;
        if let Ok(stamp) = &stamp {
            let clock = app.stamper.borrow().clock.state(start.arrival);
            self.out.instant.stamp = Some(StampTold::new(stamp, &clock));
            self.out.report.mid_exposure_us = stamp.mid.0;
        }
        rows?;
        let stamp = stamp.map_err(Refusal::from)?;
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
        let pipeline = &mut *app.pipeline.borrow_mut();
        let (rectified, cost) = gauge.measured(|| pipeline.rectify(&situation));
        report.instructions[3] = cost;
        rectified?;
        self.out.patch = Some(app.patch.get());
        let (matched, cost) = gauge.measured(|| pipeline.match_patch(&situation));
        report.instructions[4] = cost;
        let matched = matched?;
        let (outcome, cost) = gauge.measured(|| pipeline.fix(&situation, &matched));
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
        {
            let pipeline = &mut *app.pipeline.borrow_mut();
            let camera = &pipeline.settings().camera;
            if start.size != (camera.cols(), camera.rows()) {
                return Err(Refusal::BadFrame);
            }
            let (begun, cost) = gauge.measured(|| pipeline.begin_frame());
            self.out.report.instructions[0] += cost;
            begun?;
        }
        loop {
            let wanted = app.pipeline.borrow().rows_wanted();
            if wanted == 0 {
                return Ok(());
            }
            match front_end.rows(wanted).await {
                Rows::Pixels(pixels) => {
                    let pipeline = &mut *app.pipeline.borrow_mut();
                    let (taken, cost) = gauge.measured(|| pipeline.rows(pixels));
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
            app.fresh.reset();
            // On a clock that has been tied anew the exposure may lie ahead.
            let now = app.instant(timer.now());
            let (situation, is_late) = {
                let pipeline = &*app.pipeline.borrow();
                let settings = pipeline.settings();
                let is_late = now.is_none_or(|now| now.since(mid_exposure_at).unsigned_abs() > settings.patience_us);
                let wait = if is_late { Wait::No } else { settings.wait() };
                let (situation, cost) = gauge.measured(|| pipeline.situate(mid, wait));
                self.out.report.instructions[2] += cost;
                (situation?, is_late)
            };
            if let Some(situation) = situation {
                return Ok(situation);
            }
            if is_late {
                return Err(app.pipeline.borrow().missing_at(mid_exposure_at));
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
