//! The flight's log: everything the application took and came to, on a card, so that `plumbline replay` can run it again.
//!
//! [`record`]: what is kept. [`block`]: 512 bytes that stand for themselves. [`block_ring`]: blocks in RAM, of which there are so
//! many and no more: what does not fit is dropped and counted, and the log says so where it happened; no frame ever waits.
//! [`journal`]: events to records. [`card`]: where a log begins. [`writer`]: blocks to the card, in the background.

pub mod block;
pub mod card;
pub mod journal;
pub mod record;
pub mod block_ring;
pub mod writer;
