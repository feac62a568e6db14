//! The exposures of a plan: checked as attitudes and positions arrive, reported before they happen, and found again when their
//! frames have been stamped.

use super::{App, Out};
use crate::shared::{Queue, Shared};
use crate::stores::plan::Plan;
use crate::wire::telemetry::{PhotoReport, PlanReport};
use core::cell::Cell;
use plumbline_core::exposure::{COMMIT_US, Exposure, Exposures};
use plumbline_core::stamp::ShutterSettings;
use plumbline_core::units::{Micros, Ticks};

/// A plan that is being flown.
pub(super) struct Flown<'t> {
    plan: Plan<'t>,
    exposures: Shared<Exposures>,
    /// From the edge that opens the shutter to mid-exposure, microseconds.
    lead_us: i32,
    /// The ticks at which the shutter's edges are to be, in their order.
    due: Queue<Ticks, DUE>,
    /// When the plan was checked last.
    checked: Cell<Option<Ticks>>,
}

/// Least time from one check of the plan to the next, ticks: a quarter of how far ahead an exposure is committed to.
const CHECK_TICKS: u32 = COMMIT_US / 4;

/// Exposures that may be committed to and not yet triggered: they are committed to at most [`COMMIT_US`] ahead, and no
/// camera of ours takes two within 25 ms.
const DUE: usize = COMMIT_US as usize / 25_000;

impl<'t> Flown<'t> {
    /// Nothing flown yet.
    pub fn new(plan: Plan<'t>, shutter: &ShutterSettings) -> Self {
        let half_us = shutter.exposure.map_or(0, |exposure| exposure.us / 2);
        Flown {
            plan,
            exposures: Shared::new(Exposures::new(plan.limits())),
            lead_us: half_us as i32 - shutter.open_delay_us,
            due: Queue::new(),
            checked: Cell::new(None),
        }
    }

    /// Has the board trigger an exposure that was committed to at `now`, which is `tick`.
    fn commit(&self, exposure: &Exposure, (tick, now): (Ticks, Micros)) {
        let ahead_us = exposure.mid.since(now) - self.lead_us;
        let edge = Ticks(tick.0.wrapping_add(ahead_us as u32));
        // A board whose camera is triggered by others takes none: there the oldest give way.
        if let Err(edge) = self.due.try_send(edge) {
            self.due.try_receive();
            let _ = self.due.try_send(edge);
        }
    }
}

impl App<'_> {
    /// Whether photos are planned: then exposures come by [`App::exposure`] and at no other time.
    pub fn has_plan(&self) -> bool {
        self.flown.is_some()
    }

    /// Waits for the next planned exposure; the tick at which a board that triggers its camera itself is to have the
    /// opening edge. Without a plan for ever.
    pub async fn exposure(&self) -> Ticks {
        match &self.flown {
            Some(flown) => flown.due.receive().await,
            None => core::future::pending().await,
        }
    }

    /// Commits to an exposure that is due, and reports it. By the task that takes samples and by no other: what it decides
    /// depends on which samples came before, and tasks that are woken together run in any order.
    pub(super) fn look_for_exposure(&self, tick: Ticks) {
        let Some(flown) = &self.flown else { return };
        if flown.checked.get().is_some_and(|checked| tick.0.wrapping_sub(checked.0) < CHECK_TICKS) {
            return;
        }
        flown.checked.set(Some(tick));
        // What cannot be reported is not done; the next check is in time.
        let Some(now) = self.instant(tick).filter(|_| self.outbox.takes_photo()) else { return };
        let committed = self.pipeline.with(|pipeline| {
            let camera = pipeline.camera_at(now)?;
            let plan = flown.plan.on(pipeline.tile().georeference());
            flown.exposures.with(|exposures| exposures.commit(&plan, &camera, now))?
        });
        if let Some(Some(exposure)) = committed {
            flown.commit(&exposure, (tick, now));
            self.outbox.put(Out::Photo(PhotoReport {
                photo: exposure.photo,
                mid_exposure_us: exposure.mid.0,
                frame: None,
            }));
        }
    }

    /// The planned photo that was exposed at `mid`, as frame `frame`.
    pub(super) fn photo(&self, mid: Micros, frame: u32) -> Option<PhotoReport> {
        let exposures = &self.flown.as_ref()?.exposures;
        let photo = exposures.with(|exposures| exposures.photo_at(mid))??;
        Some(PhotoReport { photo, mid_exposure_us: mid.0, frame: Some(frame) })
    }

    /// How far the plan has been flown.
    pub(super) fn plan_report(&self) -> Option<PlanReport> {
        let flown = self.flown.as_ref()?;
        flown.exposures.with(|exposures| PlanReport::new(flown.plan.photos(), exposures))
    }
}

#[cfg(test)]
mod tests {
    use super::Flown;
    use crate::stores::plan;
    use core::pin::pin;
    use core::task::{Context, Poll, Waker};
    use plumbline_core::exposure::{Exposure, Limits};
    use plumbline_core::stamp::{KnownExposure, Polarity, ShutterSettings, Wired};
    use plumbline_core::units::{Micros, Ticks};

    const SHUTTER: ShutterSettings = ShutterSettings {
        wired: Wired::Opening,
        opens_on: Polarity::Rising,
        open_delay_us: 0,
        close_delay_us: 0,
        hold_off_us: 0,
        edge_sigma_us: 1.0,
        exposure: Some(KnownExposure { us: 2_000, sigma_us: 1.0 }),
        readout_us: 10_000,
        arrival_sigma_us: 1.0,
    };

    #[test]
    fn each_of_several_exposures_that_are_committed_to_is_triggered() {
        let (strip, photos) = (plan::entry(0, 0), [plan::entry(0, 0), plan::entry(1, 0)]);
        let limits = Limits { interval_us: 50_000, across_m: 10.0 };
        let mut store = [0; 48 + 3 * 8];
        let parts = [&plan::before(limits, &strip, photos.as_flattened())[..], &strip, photos.as_flattened()];
        store.iter_mut().zip(parts.into_iter().flatten()).for_each(|(to, from)| *to = *from);
        let flown = Flown::new(plan::read(&store).unwrap().unwrap(), &SHUTTER);
        // Points 50 ms apart, committed to 200 ms ahead: three before the first is due.
        for photo in 0..3 {
            let exposure = Exposure { photo, mid: Micros(1_200_000 + 50_000 * u64::from(photo)) };
            flown.commit(&exposure, (Ticks(5_000), Micros(1_000_000)));
        }
        let context = &mut Context::from_waker(Waker::noop());
        for photo in 0..3 {
            assert_eq!(pin!(flown.due.receive()).poll(context), Poll::Ready(Ticks(204_000 + 50_000 * photo)));
        }
        assert!(pin!(flown.due.receive()).poll(context).is_pending());
    }
}
