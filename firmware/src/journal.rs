//! What the application takes from its board, in order, so that a flight can be run again.
//!
//! The tasks share one thread. Everything that decides comes to them from their board, at a few points: there they report
//! each [`Event`], in the order in which they took it. A run of the application that is given the same events in the same
//! order comes to the same fixes, however interrupts and work interleaved the first time.
//!
//! In flight the journal is a log ([`crate::log`]) or nothing; in a replay it compares, and each [`Gate`] holds a task back
//! until what it is to do next is what the log has next.

use crate::board::FrameStart;
use crate::wire::signing::Verdict;
use crate::wire::telemetry::{FrameReport, InstantReport};
use core::task::{Poll, Waker};
use plumbline_core::auto_exposure::Command;
use plumbline_core::image::Run;
use plumbline_core::pipeline::Refusal;
use plumbline_core::stamp::Edge;
use plumbline_core::tile::Geographic;
use plumbline_core::units::Ticks;

/// Something that the application took from its board, or computed.
#[derive(Clone, Copy, Debug)]
pub enum Event<'a> {
    /// Bytes from the link, and the timer when they were read: the arrival of every message that they complete.
    Bytes(Ticks, &'a [u8]),
    /// A pulse per second.
    Pulse(Ticks),
    /// An edge of the shutter's line.
    Edge(Edge),
    /// Ten times a second: the timer.
    Beat(Ticks),
    /// A frame's first row.
    Start(FrameStart),
    /// The choice of what is kept of the frame, by the newest range.
    Begin,
    /// What became of its rows; its stamp is made at once.
    Rows(Result<(), Refusal>),
    /// The pose is computed from the streams as they are, and the frame waits no longer: the timer.
    Pose(Ticks),
    /// A time request goes out: the timer, which is its stamp.
    Asked(Ticks),
    /// A frame's result, and its fix in degrees.
    Frame(&'a FrameReport, &'a InstantReport, Option<Geographic>),
}

/// A point at which a task goes on without its board having handed it anything.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Gate {
    /// Before [`Event::Beat`].
    Beat,
    /// Before [`Event::Begin`].
    Begin,
    /// Before [`Event::Pose`].
    Pose,
    /// Before [`Event::Asked`].
    Asked,
}

/// Where events go.
pub trait Journal {
    /// Takes an event.
    fn event(&self, event: Event<'_>);

    /// A patch of `size` that has just been rectified, with its valid `runs`. A replay, which has no frame, puts in the
    /// pixels.
    fn patch(&self, size: (u16, u16), runs: &[Run], pixels: &mut [u8]);

    /// The verdict on a packet, which is this one, from 0, of those that the newest [`Event::Bytes`] completed. A replay, which
    /// has no key, answers that of the flight; in flight it is the application's own.
    fn verdict(&self, number: u8, own: Verdict) -> Verdict;

    /// The command to the camera that follows the newest frame's rows. A replay, which has no pixels, answers what was commanded in
    /// flight; in flight it is the application's own.
    fn exposure(&self, own: Option<Command>) -> Option<Command>;

    /// Whether the application may pass; in flight always.
    fn gate(&self, gate: Gate, waker: &Waker) -> Poll<()>;
}

/// Keeps nothing.
#[derive(Clone, Copy, Debug, Default)]
pub struct NoJournal;

impl Journal for NoJournal {
    fn event(&self, _: Event<'_>) {}

    fn patch(&self, _: (u16, u16), _: &[Run], _: &mut [u8]) {}

    fn verdict(&self, _: u8, own: Verdict) -> Verdict {
        own
    }

    fn exposure(&self, own: Option<Command>) -> Option<Command> {
        own
    }

    fn gate(&self, _: Gate, _: &Waker) -> Poll<()> {
        Poll::Ready(())
    }
}
