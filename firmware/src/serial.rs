//! The simulator's line to a board: the steps of a simulated flight over any pair of byte streams, in lockstep.
//!
//! | module | what |
//! |---|---|
//! | [`message`] | requests of the simulator, answers of the board |
//! | [`frame`] | messages to bytes and back: postcard, CRC32, COBS |
//! | [`stores`] | what is uploaded before a flight: the blobs that stand for flash |
//! | [`wires`] | link and capture timer as the application sees them |
//! | [`front_end`] | the front end as the application sees it |
//! | [`session`] | requests in, answers out: each request is done once |
//! | [`boot`] | the application, made of what was uploaded |
//! | [`serve`] | the loop over a board's line |
//!
//! The simulator sends a request and waits for its answer; it alone resends. Requests of a session are numbered from 1.
//! The board does the request that follows the last one, repeats its stored answer to the last one, and is silent on all
//! others: whatever the line loses, doubles, delays or damages, each request is done once and in order. A step's answer
//! says what the application sent and what it waits for: rows of its frame, or free space for more bytes. So a board holds a
//! piece of the frame at a time, never a frame.
//!
//! A board flies once between two resets: its tasks never end. A second session is refused as [`message::Refused::Busy`]
//! until the simulator has asked for a reset.

pub mod boot;
pub mod front_end;
pub mod frame;
pub mod message;
pub mod serve;
pub mod session;
pub mod stores;
pub mod wires;

/// Version of the protocol. Framing, the envelope and `Hello` and `Welcome` up to their version stay as they are in all
/// versions, so that two versions recognise each other.
pub const VERSION: u16 = 3;
/// Most bytes of payload in a message: a piece of an upload, of a frame's rows, or of what the application sent.
pub const PIECE_MAX: usize = 2048;
/// Most bytes that the application may have sent and the simulator not yet fetched; a writer beyond waits. More than a
/// frame's messages with the largest patch.
pub const SENT_MAX: usize = 8192;
/// Most bytes of a message besides its payload: numbers and texts.
const HEAD_MAX: usize = 160;
/// Most bytes of a message on the line: CRC, COBS (one byte in 254 and one), and a zero on either side.
pub const FRAME_MAX: usize = framed(PIECE_MAX + HEAD_MAX);
/// Most bytes on the line of an answer without payload.
pub const SHORT_MAX: usize = framed(HEAD_MAX);

/// What the simulator sends before its hello: a board in flight listens for it to leave the flight, and does nothing else
/// with what comes over USB. A line that no other program sends by accident; a board in a session drops it as noise.
pub const GREETING: &[u8] = b"plumbline simulator: hello\n";

const fn framed(message: usize) -> usize {
    let body = message + 4;
    body + body / 254 + 1 + 2
}
