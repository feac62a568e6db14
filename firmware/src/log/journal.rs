//! The application's events as records of a log.

use super::block::{BLOCK, PAYLOAD};
use super::block_ring::BlockRing;
use super::record::{Blob, Head, Record};
use crate::journal::{Event, Gate, Journal};
use crate::shared::Shared;
use crate::stores::framing::checksum;
use crate::wire::signing::Verdict;
use core::cell::Cell;
use core::task::{Poll, Waker};
use embassy_sync::blocking_mutex::raw::NoopRawMutex;
use embassy_sync::signal::Signal;
use plumbline_core::auto_exposure::Command;
use plumbline_core::budget::RUNS_MAX;
use plumbline_core::image::Run;
use plumbline_core::stamp::Polarity;

/// Bytes of the tile store in a record.
const PIECE: usize = 1024;

/// A journal that becomes a log: `N` borrowed blocks of RAM, and both stores, which are logged too so that a log is all that
/// a replay needs. The tile store goes in the background, as fast as the flight's records leave space.
#[allow(missing_debug_implementations, reason = "embassy-sync's primitives have none")]
pub struct LogJournal<'f, const N: usize> {
    ring: Shared<BlockRing<'f, N>>,
    tiles: &'f [u8],
    tiles_done: Cell<usize>,
    /// Raised whenever there is more to be written.
    more: Signal<NoopRawMutex, ()>,
}

/// The record of an event.
pub fn record<'a>(event: &Event<'a>) -> Record<'a> {
    match *event {
        Event::Bytes(at, bytes) => Record::Bytes(at.0, Blob(bytes)),
        Event::Pulse(at) => Record::Pulse(at.0),
        Event::Edge(edge) => Record::Edge(edge.at.0, edge.polarity == Polarity::Rising),
        Event::Beat(at) => Record::Beat(at.0),
        Event::Start(start) => Record::Start(start.sequence, start.arrival.0, start.size),
        Event::Begin => Record::Begin,
        Event::Rows(rows) => Record::Rows(rows.map_or_else(|refusal| refusal.code(), |()| 0)),
        Event::Pose(at) => Record::Pose(at.0),
        Event::Asked(at) => Record::Asked(at.0),
        Event::Frame(report, instant, fix) => {
            Record::Frame(*report, *instant, fix.map(|position| (position.lat_e7, position.lon_e7)))
        }
    }
}

/// Bytes of as many runs as a patch may have.
pub const RUNS_BYTES: usize = 6 * RUNS_MAX;

/// Runs as a record has them; the part of `buffer` in use.
pub fn runs_in<'b>(runs: &[Run], buffer: &'b mut [u8; RUNS_BYTES]) -> &'b [u8] {
    for (to, run) in buffer.chunks_exact_mut(6).zip(runs) {
        let numbers = [run.row, run.start, run.end].map(u16::to_le_bytes);
        to.iter_mut().zip(numbers.as_flattened()).for_each(|(to, from)| *to = *from);
    }
    buffer.get(..6 * runs.len()).unwrap_or(&[])
}

impl<'f, const N: usize> LogJournal<'f, N> {
    /// A log with this `number`, which no other on the card should have; of an application that boots from these stores and
    /// has so many bytes of frame memory. What waits to be written lies in `blocks`.
    pub fn new(
        number: u32,
        configuration: &[u8],
        tiles: &'f [u8],
        frame_memory: usize,
        blocks: &'f mut [[u8; BLOCK]; N],
    ) -> Self {
        let mut ring = BlockRing::new(number, blocks);
        ring.push(&Record::Head(Head {
            frame_memory: frame_memory as u32,
            tiles_bytes: tiles.len() as u32,
            tiles_crc: checksum(tiles),
        }));
        ring.push(&Record::Configuration(Blob(configuration)));
        LogJournal { ring: Shared::new(ring), tiles, tiles_done: Cell::new(0), more: Signal::new() }
    }

    /// Something of the simulator's.
    pub fn annotate(&self, bytes: &[u8]) {
        self.push(&Record::Annotation(Blob(bytes)));
    }

    /// Ends the log.
    pub fn close(&self) {
        self.push(&Record::Close);
        self.ring.with(BlockRing::seal);
    }

    /// Records dropped since the ring was full.
    pub fn lost(&self) -> u32 {
        self.ring.with(|ring| ring.lost_in_all()).unwrap_or(0)
    }

    /// Blocks to be written, copied into `into`; how many. Goes on with the tile store while it fits.
    pub(super) fn waiting(&self, into: &mut [[u8; BLOCK]]) -> usize {
        self.ring.with(|ring| self.fill(ring).oldest(into)).unwrap_or(0)
    }

    /// Puts pieces of the tile store into `ring`: as far as half of it, the other half is the flight's, and none behind a loss
    /// before the flight's own records go on.
    fn fill<'r>(&self, ring: &'r mut BlockRing<'f, N>) -> &'r BlockRing<'f, N> {
        while !ring.is_losing() && ring.free() > N * PAYLOAD / 2 + PIECE {
            let from = self.tiles_done.get();
            let rest = self.tiles.get(from..).unwrap_or(&[]);
            let piece = rest.get(..PIECE).unwrap_or(rest);
            if piece.is_empty() {
                break;
            }
            ring.push(&Record::Tiles(from as u32, Blob(piece)));
            self.tiles_done.set(from + piece.len());
        }
        ring
    }

    /// They have been written.
    pub(super) fn release(&self, count: usize) {
        self.ring.with(|ring| ring.release(count));
    }

    /// Waits for more.
    pub(super) async fn more(&self) {
        self.more.wait().await;
    }

    fn push(&self, record: &Record<'_>) {
        self.ring.with(|ring| ring.push(record));
        self.more.signal(());
    }
}

impl<const N: usize> Journal for LogJournal<'_, N> {
    fn event(&self, event: Event<'_>) {
        self.push(&record(&event));
    }

    fn patch(&self, size: (u16, u16), runs: &[Run], pixels: &mut [u8]) {
        let mut buffer = [0; RUNS_BYTES];
        self.push(&Record::Patch(size, Blob(runs_in(runs, &mut buffer)), Blob(pixels)));
    }

    fn verdict(&self, number: u8, own: Verdict) -> Verdict {
        // Of nearly all packets there is nothing to tell.
        if own != Verdict::Taken {
            self.push(&Record::Refused(number, own as u8));
        }
        own
    }

    fn exposure(&self, own: Option<Command>) -> Option<Command> {
        if let Some(Command { from, us }) = own {
            self.push(&Record::Exposure(from, us));
        }
        own
    }

    fn gate(&self, _: Gate, _: &Waker) -> Poll<()> {
        Poll::Ready(())
    }
}
