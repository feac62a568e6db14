//! The loop over a board's line.

use super::session::{Machine, Session};
use crate::board::{Reader, Writer};

/// Bytes that are read at once.
const READ_MAX: usize = 256;

/// Why the loop ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum End {
    /// The reader had no more bytes: the line was unplugged. The session goes on on the next one.
    Unplugged,
    /// The simulator asked for a reboot, and was answered.
    Reset,
}

/// Serves `session` over a line until it is unplugged, which a reader reports by reading no bytes at all, or until the
/// board is to reboot. The application's tasks run inside, on an executor of their own: see [`Machine::run`].
pub async fn serve<M: Machine>(session: &mut Session<M>, reader: &mut impl Reader, writer: &mut impl Writer) -> End {
    let mut buffer = [0; READ_MAX];
    loop {
        let count = reader.read(&mut buffer).await;
        if count == 0 {
            return End::Unplugged;
        }
        for &byte in buffer.get(..count).unwrap_or(&[]) {
            if let Some(reply) = session.take(byte) {
                writer.write(reply.bytes).await;
                if reply.resets {
                    return End::Reset;
                }
            }
        }
    }
}
