//! The board's PSRAM, which the emulator maps onto a file that the simulator maps too. Offsets are those of
//! [`crate::shared_memory`].
//!
//! The simulator writes while the firmware waits for the doorbell, and only then: the lockstep is what makes plain
//! slices sound. Words that both sides use are read and written as volatile.

use crate::shared_memory::{ADDRESS, FRAME_MEMORY, SIZE};
use core::ptr::{read_volatile, write_volatile};
use core::sync::atomic::{Ordering, compiler_fence};
use plumbline_core::budget::FRAME_MEMORY_BYTES;

/// The word at `offset`; `None` outside the shared memory or off a word's boundary.
pub fn word(offset: usize) -> Option<u32> {
    if !is_word(offset) {
        return None;
    }
    // SAFETY: an aligned word of the PSRAM, which is plain memory.
    let value = unsafe { read_volatile((ADDRESS + offset) as *const u32) };
    compiler_fence(Ordering::Acquire);
    Some(value)
}

/// Sets the word at `offset`; `false` outside the shared memory or off a word's boundary.
pub fn set_word(offset: usize, value: u32) -> bool {
    if is_word(offset) {
        compiler_fence(Ordering::Release);
        // SAFETY: an aligned control word; slices are given out above `FLOOR` only.
        unsafe { write_volatile((ADDRESS + offset) as *mut u32, value) };
        return true;
    }
    false
}

/// `length` bytes from `offset` on; `None` where they are not all inside the shared memory, or among the control words below
/// 4096, which change.
///
/// # Safety
/// The simulator must not change these bytes as long as the slice lives.
pub unsafe fn bytes(offset: usize, length: usize) -> Option<&'static [u8]> {
    let end = offset.checked_add(length)?;
    if offset < FLOOR || end > SIZE {
        return None;
    }
    // SAFETY: inside the PSRAM; the firmware writes below `FLOOR` and in the frame's memory only, and the caller speaks for
    // the simulator.
    Some(unsafe { core::slice::from_raw_parts((ADDRESS + offset) as *const u8, length) })
}

/// The frame's memory.
///
/// # Safety
/// Called once.
pub unsafe fn frame_memory() -> &'static mut [u8] {
    // SAFETY: plain memory that both share, which the simulator never touches and no other slice covers; the caller makes
    // it the only one.
    unsafe { core::slice::from_raw_parts_mut((ADDRESS + FRAME_MEMORY) as *mut u8, FRAME_MEMORY_BYTES) }
}

/// Memory of an image that shares nothing with the simulator; `None` where it is not all inside the PSRAM.
///
/// # Safety
/// Nobody else uses these bytes.
pub unsafe fn memory(offset: usize, length: usize) -> Option<&'static mut [u8]> {
    if offset.checked_add(length)? > SIZE {
        return None;
    }
    // SAFETY: plain memory inside the PSRAM, which the caller has for itself.
    Some(unsafe { core::slice::from_raw_parts_mut((ADDRESS + offset) as *mut u8, length) })
}

/// Where the control words end.
const FLOOR: usize = 0x1000;

fn is_word(offset: usize) -> bool {
    offset.is_multiple_of(4) && offset < SIZE
}
