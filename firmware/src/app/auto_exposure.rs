//! The exposure's control: each frame's brightness in, a command to the camera and the stamps' known exposure out.
//!
//! All of it is the camera task's, in the order of its frames, so that a flight and its replay decide alike. A frame decides
//! when its last row is there and before its pose is: the next one must not have begun. How far the picture moves in an
//! exposure is that of the frame before, which is reckoned while the rows of this one arrive.

use super::{App, Out};
use crate::board::FrontEnd;
use plumbline_core::auto_exposure::{AutoExposure, Command, LATENCY_FRAMES};
use plumbline_core::motion::{Moving, image_motion};
use plumbline_core::stamp::{StampSettings, Stamper};

/// The control that the settings ask for. Planned exposures keep theirs: the shutter is opened half of it before the instant
/// that is committed to, and whose frame it will be is not known then.
pub(super) fn of(stamps: &StampSettings, is_planned: bool) -> Option<AutoExposure> {
    let (limits, known) = (stamps.exposure?, stamps.shutter.exposure?);
    (!is_planned).then(|| AutoExposure::new(limits, known.us))
}

impl App<'_> {
    /// Whether the exposure is controlled.
    pub(super) fn controls_exposure(&self) -> bool {
        self.auto_exposure.is_some()
    }

    /// How the vehicle moved in the frame before, where that is known: while a frame's rows arrive there is time to reckon with
    /// it.
    pub(super) fn exposure_moved(&self, moving: Option<Moving>) {
        let Some(control) = &self.auto_exposure else { return };
        let sharp_us = moving.and_then(|moving| {
            let camera = self.pipeline.with(|pipeline| pipeline.settings().camera)?;
            image_motion(&camera, &moving, 0).ok().map(|motion| motion.exposure_max_us)
        });
        control.with(|control| control.moved(sharp_us));
    }

    /// All rows of frame `frame` are there, or as many as will come: commands another exposure where it is too bright, too dark
    /// or may be blurred.
    pub(super) fn control_exposure(&self, frame: u32, front_end: &mut impl FrontEnd) {
        let Some(control) = &self.auto_exposure else { return };
        let brightness = self.pipeline.with(|pipeline| {
            let histogram = pipeline.histogram.as_mut()?;
            let brightness = histogram.brightness();
            // A frame that is refused before its first row has none.
            histogram.clear();
            brightness
        });
        let own = control.with(|control| {
            let us = control.after(frame, brightness.flatten().as_ref()?)?;
            Some(Command { from: frame.wrapping_add(LATENCY_FRAMES), us: front_end.expose(us)? })
        });
        if let Some(command) = self.journal.exposure(own.flatten()) {
            control.with(|control| control.command(command));
            self.outbox.put(Out::Exposure(command.into()));
        }
    }

    /// Has the stamp of frame `frame` go by what it was exposed for.
    pub(super) fn expect_exposure(&self, frame: u32, stamper: &mut Stamper) {
        if let Some(us) = self.auto_exposure.as_ref().and_then(|control| control.with(|control| control.of(frame))) {
            stamper.expect_exposure(us);
        }
    }
}
