//! What waits to be sent, the most urgent first.
//!
//! Nothing that is asked for at a fixed rate waits behind what is large: each kind has a slot or queue of its own, so
//! heartbeats, time requests and photo commitments do not compete with frames. Of the servo's commands only the newest
//! counts.

use super::{FrameOut, Line, Out};
use crate::shared::{Queue, Shared};
use crate::wire::command::{Acknowledgement, Ask};
use crate::wire::telemetry::{ExposureReport, PhotoReport};
use core::cell::Cell;
use embassy_sync::blocking_mutex::raw::NoopRawMutex;
use embassy_sync::signal::Signal;
use mavlink::dialects::common::MavSeverity;
use plumbline_core::tile::Geographic;
use plumbline_core::units::Radians;

/// Photo commitments that may wait. A check of the plan makes one at most, and checks are 50 ms apart: these are 200 ms of
/// them, and a message takes a millisecond.
const PHOTOS: usize = 4;

/// Commands that may wait: one for a stream, and one for the autopilot's sources, on each beat.
const ASKS: usize = 2;

/// The outbox.
pub(super) struct Outbox {
    is_beat_due: Cell<bool>,
    is_time_wanted: Cell<bool>,
    is_reference_due: Cell<bool>,
    asks: Queue<Ask, ASKS>,
    parameter: Cell<Option<&'static str>>,
    acknowledgement: Cell<Option<Acknowledgement>>,
    origin: Cell<Option<(Geographic, i32)>>,
    /// The time in the newest TIMESYNC request.
    timesync: Cell<Option<i64>>,
    photos: Queue<PhotoReport, PHOTOS>,
    exposure: Cell<Option<ExposureReport>>,
    servo: Cell<Option<Radians>>,
    frame: Shared<Option<FrameOut>>,
    text: Cell<Option<(MavSeverity, Line)>>,
    filled: Signal<NoopRawMutex, ()>,
    frame_taken: Signal<NoopRawMutex, ()>,
    text_taken: Signal<NoopRawMutex, ()>,
}

impl Outbox {
    /// Empty.
    pub const fn new() -> Self {
        Outbox {
            is_beat_due: Cell::new(false),
            is_time_wanted: Cell::new(false),
            is_reference_due: Cell::new(false),
            asks: Queue::new(),
            parameter: Cell::new(None),
            acknowledgement: Cell::new(None),
            origin: Cell::new(None),
            timesync: Cell::new(None),
            photos: Queue::new(),
            exposure: Cell::new(None),
            servo: Cell::new(None),
            frame: Shared::new(None),
            text: Cell::new(None),
            filled: Signal::new(),
            frame_taken: Signal::new(),
            text_taken: Signal::new(),
        }
    }

    /// Puts something in, instead of what waits of its kind; photos queue up, and one too many is dropped.
    pub fn put(&self, out: Out) {
        match out {
            Out::Beat => self.is_beat_due.set(true),
            Out::TimesyncRequest => self.is_time_wanted.set(true),
            Out::Reference => self.is_reference_due.set(true),
            Out::Ask(ask) => {
                // One too many is asked again.
                let _ = self.asks.try_send(ask);
            }
            Out::Parameter(name) => self.parameter.set(Some(name)),
            Out::Acknowledgement(acknowledgement) => self.acknowledgement.set(Some(acknowledgement)),
            Out::Origin(place, altitude_mm) => self.origin.set(Some((place, altitude_mm))),
            Out::TimesyncAnswer(theirs) => self.timesync.set(Some(theirs)),
            Out::Photo(report) => {
                let _ = self.photos.try_send(report);
            }
            Out::Exposure(report) => self.exposure.set(Some(report)),
            Out::Servo(command) => self.servo.set(Some(command)),
            Out::Frame(frame) => {
                self.frame.with(|slot| *slot = Some(frame));
            }
            Out::Text(severity, line) => self.text.set(Some((severity, line))),
        }
        self.filled.signal(());
    }

    /// Takes what is most urgent of what is there.
    pub fn take(&self) -> Option<Out> {
        if self.is_beat_due.take() {
            return Some(Out::Beat);
        }
        if let Some(theirs) = self.timesync.take() {
            return Some(Out::TimesyncAnswer(theirs));
        }
        if self.is_time_wanted.take() {
            return Some(Out::TimesyncRequest);
        }
        if self.is_reference_due.take() {
            return Some(Out::Reference);
        }
        if let Some(asked) = self.asked() {
            return Some(asked);
        }
        if let Some(report) = self.photos.try_receive() {
            return Some(Out::Photo(report));
        }
        if let Some(report) = self.exposure.take() {
            return Some(Out::Exposure(report));
        }
        if let Some(command) = self.servo.take() {
            return Some(Out::Servo(command));
        }
        if let Some(frame) = self.frame.with(Option::take).flatten() {
            self.frame_taken.signal(());
            return Some(Out::Frame(frame));
        }
        let (severity, line) = self.text.take()?;
        self.text_taken.signal(());
        Some(Out::Text(severity, line))
    }

    /// What is asked of the autopilot, or answered to who asked us.
    fn asked(&self) -> Option<Out> {
        let ask = self.asks.try_receive().map(Out::Ask);
        let acknowledgement = || self.acknowledgement.take().map(Out::Acknowledgement);
        let origin = || self.origin.take().map(|(place, altitude_mm)| Out::Origin(place, altitude_mm));
        let parameter = || self.parameter.take().map(Out::Parameter);
        ask.or_else(acknowledgement).or_else(origin).or_else(parameter)
    }

    /// Waits until something has been put in since the last wait.
    pub async fn filled(&self) {
        self.filled.wait().await;
    }

    /// Whether the queue takes a photo.
    pub fn takes_photo(&self) -> bool {
        self.photos.has_free_slot()
    }

    /// Waits until the queue takes a frame. It is put in afterwards: a future that held it would need its size again.
    pub async fn takes_frame(&self) {
        while self.frame.with(|frame| frame.is_some()) == Some(true) {
            self.frame_taken.wait().await;
        }
    }

    /// Waits until the queue takes a line of text.
    pub async fn takes_text(&self) {
        while self.text.get().is_some() {
            self.text_taken.wait().await;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::{FrameOut, Line, Out};
    use super::Outbox;
    use core::pin::pin;
    use core::task::{Context, Waker};
    use mavlink::dialects::common::MavSeverity;
    use plumbline_core::units::Radians;

    #[test]
    fn what_is_urgent_overtakes_a_frame_and_a_command_gives_way_to_a_newer_one() {
        let outbox = Outbox::new();
        let (frame, text) =
            (Out::Frame(FrameOut::new(7)), Out::Text(MavSeverity::MAV_SEVERITY_NOTICE, Line::new("text")));
        for out in [frame, text, Out::Servo(Radians(0.1)), Out::Servo(Radians(0.2)), Out::TimesyncAnswer(5), Out::Beat]
        {
            outbox.put(out);
        }
        for wanted in [Out::Beat, Out::TimesyncAnswer(5), Out::Servo(Radians(0.2)), frame, text] {
            assert_eq!(outbox.take(), Some(wanted));
        }
        assert_eq!(outbox.take(), None);
    }

    #[test]
    fn a_frame_waits_for_its_slot_and_nothing_else_does() {
        let outbox = Outbox::new();
        outbox.put(Out::Frame(FrameOut::new(1)));
        let context = &mut Context::from_waker(Waker::noop());
        let mut waiting = pin!(outbox.takes_frame());
        assert!(waiting.as_mut().poll(context).is_pending());
        assert!(outbox.takes_photo() && pin!(outbox.takes_text()).poll(context).is_ready());
        assert_eq!(outbox.take(), Some(Out::Frame(FrameOut::new(1))));
        assert!(waiting.as_mut().poll(context).is_ready());
        assert!(pin!(outbox.filled()).poll(context).is_ready() && pin!(outbox.filled()).poll(context).is_pending());
        outbox.put(Out::Beat);
        assert!(pin!(outbox.filled()).poll(context).is_ready());
    }
}
