//! Bytes between an interrupt and a task.

use core::cell::RefCell;
use core::sync::atomic::{AtomicU32, Ordering};
use embassy_sync::blocking_mutex::CriticalSectionMutex;
use embassy_sync::waitqueue::AtomicWaker;
use heapless::Deque;

/// What a ring holds, bytes.
pub const CAPACITY: usize = 512;

/// A ring of bytes with one waiting reader and a count of all that went in.
#[allow(missing_debug_implementations, reason = "embassy-sync's primitives have none")]
pub struct ByteRing {
    bytes: CriticalSectionMutex<RefCell<Deque<u8, CAPACITY>>>,
    total: AtomicU32,
    reader: AtomicWaker,
}

impl ByteRing {
    /// An empty ring.
    pub const fn new() -> Self {
        ByteRing {
            bytes: CriticalSectionMutex::new(RefCell::new(Deque::new())),
            total: AtomicU32::new(0),
            reader: AtomicWaker::new(),
        }
    }

    /// Takes bytes from `source` until it has none or the ring is full, and wakes the reader. A source that is not
    /// emptied keeps its bytes: nothing is lost.
    pub fn fill(&self, mut source: impl FnMut() -> Option<u8>) {
        let moved = self.bytes.lock(|bytes| {
            // Held for no longer than a call of this file, so it is never taken.
            let Ok(mut bytes) = bytes.try_borrow_mut() else { return 0 };
            let before = bytes.len();
            while !bytes.is_full() {
                let Some(byte) = source() else { break };
                // Never full here, so nothing is pushed back.
                let _ = bytes.push_back(byte);
            }
            bytes.len() - before
        });
        if moved > 0 {
            self.total.fetch_add(moved as u32, Ordering::Relaxed);
            self.reader.wake();
        }
    }

    /// Moves what there is into `buffer`, as much as fits; how much.
    pub fn take(&self, buffer: &mut [u8]) -> usize {
        self.bytes.lock(|bytes| {
            let Ok(mut bytes) = bytes.try_borrow_mut() else { return 0 };
            buffer.iter_mut().map_while(|to| bytes.pop_front().map(|byte| *to = byte)).count()
        })
    }

    /// Whether there is nothing to take.
    pub fn is_empty(&self) -> bool {
        self.bytes.lock(|bytes| bytes.try_borrow().is_ok_and(|bytes| bytes.is_empty()))
    }

    /// Bytes that ever went in, wrapping.
    pub fn total(&self) -> u32 {
        self.total.load(Ordering::Relaxed)
    }

    /// Who is to be woken by the next byte.
    pub fn register(&self, waker: &core::task::Waker) {
        self.reader.register(waker);
    }
}

impl Default for ByteRing {
    fn default() -> Self {
        Self::new()
    }
}
