//! What the application tells of itself so that it can be run again, and the order in which it may go on.
//!
//! The tasks share one thread. Everything that decides comes to them from their board, at a few points: there they
//! [`note`](Journal::note) what they took, in the order in which they took it. A run of the application that is given the
//! same in the same order comes to the same fixes, however interrupts and work interleaved the first time.
//!
//! In flight the journal is a log ([`crate::log`]) or nothing; in a replay it compares, and holds each task back until what
//! it is to do next is what the log says next.

use crate::app::App;
use crate::board::FrameStart;
use crate::wire::telemetry::{FrameReport, InstantReport};
use core::future::poll_fn;
use core::task::{Poll, Waker};
use plumbline_core::pipeline::Refusal;
use plumbline_core::rectify::Run;
use plumbline_core::stamp::Edge;
use plumbline_core::tile::Geographic;
use plumbline_core::units::Ticks;

/// Something that the application took, or came to.
#[derive(Clone, Copy, Debug)]
pub enum Note<'a> {
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
    /// The look at the streams after which the frame waits no longer: the timer.
    Look(Ticks),
    /// What a frame came to, and its fix in degrees.
    Frame(&'a FrameReport, &'a InstantReport, Option<Geographic>),
}

/// Something that a task does without its board having handed it anything.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Turn {
    /// [`Note::Beat`].
    Beat,
    /// [`Note::Begin`].
    Begin,
    /// [`Note::Look`].
    Look,
}

/// Where notes go.
pub trait Journal {
    /// Takes a note.
    fn note(&self, note: Note<'_>);

    /// A patch of `size` that has just been rectified, with its valid `runs`. A replay, which has no frame, puts in the
    /// pixels.
    fn patch(&self, size: (u16, u16), runs: &[Run], pixels: &mut [u8]);

    /// Whether the application may do this now; in flight always.
    fn turn(&self, turn: Turn, waker: &Waker) -> Poll<()>;
}

/// Keeps nothing.
#[derive(Clone, Copy, Debug, Default)]
pub struct NoJournal;

impl Journal for NoJournal {
    fn note(&self, _: Note<'_>) {}

    fn patch(&self, _: (u16, u16), _: &[Run], _: &mut [u8]) {}

    fn turn(&self, _: Turn, _: &Waker) -> Poll<()> {
        Poll::Ready(())
    }
}

impl App<'_> {
    /// Takes a note.
    pub(crate) fn note(&self, note: Note<'_>) {
        self.journal.note(note);
    }

    /// Waits until it may do this.
    pub(crate) async fn turn(&self, turn: Turn) {
        poll_fn(|context| self.journal.turn(turn, context.waker())).await;
    }
}
