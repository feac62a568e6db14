//! The exposures of a plan: looked for at each position and each beat, told before they happen, and found again when their
//! frames have been stamped.

use super::{App, Out};
use crate::shared::Shared;
use crate::stores::plan::Plan;
use crate::wire::telemetry::{PhotoReport, PlanReport};
use embassy_sync::blocking_mutex::raw::NoopRawMutex;
use embassy_sync::signal::Signal;
use plumbline_core::exposure::Exposures;
use plumbline_core::stamp::ShutterSettings;
use plumbline_core::units::{Micros, Ticks};

/// A plan that is being flown.
pub(super) struct Flown<'t> {
    plan: Plan<'t>,
    exposures: Shared<Exposures>,
    /// From the edge that opens the shutter to mid-exposure, microseconds.
    lead_us: i32,
    /// The tick at which the shutter's edge is to be.
    due: Signal<NoopRawMutex, Ticks>,
}

impl<'t> Flown<'t> {
    /// Nothing flown yet.
    pub fn new(plan: Plan<'t>, shutter: &ShutterSettings) -> Self {
        let half_us = shutter.exposure.map_or(0, |exposure| exposure.us / 2);
        Flown {
            plan,
            exposures: Shared::new(Exposures::new(plan.limits())),
            lead_us: half_us as i32 - shutter.open_delay_us,
            due: Signal::new(),
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
            Some(flown) => flown.due.wait().await,
            None => core::future::pending().await,
        }
    }

    /// Commits to an exposure that is due, and tells it.
    pub(super) fn look_for_exposure(&self, tick: Ticks) {
        let Some(flown) = &self.flown else { return };
        // What cannot be told is not done; the next look is in time.
        let Some(now) = self.instant(tick).filter(|_| self.outbox.has_room()) else { return };
        let committed = self.pipeline.with(|pipeline| {
            let place = pipeline.camera_at(now)?;
            let plan = flown.plan.on(pipeline.tile().georeference());
            flown.exposures.with(|exposures| exposures.look(&plan, &place, now))?
        });
        if let Some(Some(exposure)) = committed {
            let ahead_us = exposure.mid.since(now) - flown.lead_us;
            flown.due.signal(Ticks(tick.0.wrapping_add(ahead_us as u32)));
            self.post(Out::Photo(PhotoReport { photo: exposure.photo, mid_exposure_us: exposure.mid.0, frame: None }));
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
