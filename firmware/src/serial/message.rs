//! What simulator and board say to each other.

use serde::{Deserialize, Serialize};

/// What every message begins with.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Envelope<M> {
    /// The session it belongs to, a number that the simulator chose.
    pub session: u32,
    /// Number of the request within its session, from 1; the answer repeats it. Of a `Hello` any number.
    pub id: u32,
    /// The message.
    pub message: M,
}

/// What the simulator asks for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Request<'a> {
    /// Who is there? Answered always, with [`Answer::Welcome`], and changes nothing.
    Hello {
        /// [`super::VERSION`].
        version: u16,
    },
    /// Begins a session. Its id is 1.
    Open,
    /// What will be uploaded to a store.
    Announce {
        /// Which.
        store: Store,
        /// Its length.
        bytes: u32,
        /// Its CRC32 (ISO-HDLC).
        crc: u32,
    },
    /// The next piece of a store.
    Piece {
        /// Which.
        store: Store,
        /// Where it begins.
        offset: u32,
        /// At most [`super::PIECE_MAX`].
        bytes: &'a [u8],
    },
    /// Boots the application with what was uploaded.
    Start,
    /// A step.
    Step {
        /// The capture timer's reading.
        timer: u32,
        /// What happens.
        #[serde(borrow)]
        event: Event<'a>,
    },
    /// The rows that the last answer asked for.
    Rows {
        /// Number of the frame.
        sequence: u32,
        /// Pixels of the frame before these.
        offset: u32,
        /// At most [`super::PIECE_MAX`].
        bytes: &'a [u8],
    },
    /// More of what the application sent.
    Continue,
    /// Reboots the board, if this is its boot number. Belongs to no session.
    Reset {
        /// As in [`Welcome`].
        boot: u32,
    },
    /// The end of the session.
    Bye,
}

/// What happens in a step.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Event<'a> {
    /// Time passes.
    Nothing,
    /// Bytes from the autopilot, at most [`super::PIECE_MAX`].
    Bytes(&'a [u8]),
    /// A pulse per second, latched at this tick.
    Pulse(u32),
    /// An edge of the shutter's line.
    Edge {
        /// The tick that it was latched at.
        tick: u32,
        /// Which way the line went.
        rising: bool,
    },
    /// A frame whose first row has arrived.
    Frame {
        /// Number of the frame.
        sequence: u32,
        /// Tick at which its first row arrived.
        arrival: u32,
        /// (cols, rows).
        size: (u16, u16),
    },
}

/// One of the blobs that stand for flash.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Store {
    /// Camera, settings, georeference.
    Configuration,
    /// The reference tile.
    Tile,
    /// Where photos are to be taken; it may be left out.
    Plan,
    /// What messages are signed with; it may be left out.
    Key,
}

/// What the board answers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Answer<'a> {
    /// To `Hello`.
    #[serde(borrow)]
    Welcome(Welcome<'a>),
    /// Done.
    Done,
    /// Not done.
    #[serde(borrow)]
    Refused(Refused<'a>),
    /// To a step, to rows, and to `Continue`.
    Stepped {
        /// What the application's work took, in what the board counts; 0 where it counts nothing.
        cost: u32,
        /// What the simulator has to do next.
        next: Next,
        /// Whether the application has begun a frame and not yet reported what came of it.
        is_at_work: bool,
        /// What the application sent.
        sent: &'a [u8],
    },
    /// The request's session is not the board's.
    Stranger {
        /// As in [`Welcome`].
        boot: u32,
    },
}

/// Who the board is and what it can take.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Welcome<'a> {
    /// [`super::VERSION`].
    pub version: u16,
    /// Another number after each reboot.
    pub boot: u32,
    /// Clock of the core, Hz; 0 where there is none.
    pub core_clock_hz: u32,
    /// What its counters count.
    pub counts: Counts,
    /// Largest piece it takes, bytes.
    pub piece_max: u16,
    /// Largest configuration store it takes, bytes.
    pub configuration_capacity: u32,
    /// Largest tile store, bytes.
    pub tile_capacity: u32,
    /// Largest plan store, bytes.
    pub plan_capacity: u32,
    /// Largest key store, bytes.
    pub key_capacity: u32,
    /// Name of the board, at most 32 bytes.
    pub board: &'a str,
    /// Version of the firmware, at most 32 bytes.
    pub firmware: &'a str,
}

/// What a board's counters count.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Counts {
    /// Nothing.
    #[default]
    Nothing,
    /// Instructions executed.
    Instructions,
    /// Cycles of the core's clock.
    Cycles,
}

/// Why a request was not done.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Refused<'a> {
    /// An application was started since the last reset: another one needs a reset.
    Busy,
    /// A store is larger than the memory for it.
    TooLarge {
        /// That memory, bytes.
        capacity: u32,
    },
    /// What was uploaded is not what was announced.
    Damaged(Store),
    /// The application cannot fly with what was uploaded, and why; at most 64 bytes.
    Boot(#[serde(borrow)] [&'a str; 2]),
    /// The request is out of order: a step before the start, a piece out of order.
    Order,
}

/// What the simulator has to do next.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Next {
    /// The step is done.
    Idle,
    /// Fetch more of what the application sent.
    More,
    /// Send rows.
    Rows {
        /// Of this frame.
        sequence: u32,
        /// Pixels of the frame that have been taken.
        offset: u32,
    },
}
