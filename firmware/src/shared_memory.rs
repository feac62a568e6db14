//! The memory that an emulated board shares with the simulator: registers of a simulated camera front end, the
//! stores that stand for flash, and the frame the sensor is exposing.
//!
//! Both sides use these offsets (bytes from its start, little-endian words). The simulator advances in steps:
//! it sets [`TIMER`] and whatever happens in the step (bytes on the link up to [`RECEIVED_TOTAL`], an edge, a frame),
//! writes [`STEP`] and rings the doorbell; the firmware works until it is idle, writes [`STEP_DONE`] and answers.

use crate::stores::tiles::BEFORE_PIXELS;
use plumbline_core::budget::FRAME_MEMORY_BYTES;

/// Size of the shared memory.
pub const SIZE: usize = 16 << 20;
/// Where an `mps2-an500` sees it.
pub const ADDRESS: usize = 0x6000_0000;

/// Word: [`MAGIC_VALUE`] when the simulator has prepared it.
pub const MAGIC: usize = 0x00;
/// "PLB3".
pub const MAGIC_VALUE: u32 = 0x3342_4c50;
/// Word: number of the step to be done, from 1.
pub const STEP: usize = 0x04;
/// Word: the capture timer's reading in this step.
pub const TIMER: usize = 0x08;
/// Word: bytes sent to the firmware since the start, all of which belong to this step or earlier ones.
pub const RECEIVED_TOTAL: usize = 0x0c;
/// Word: pulses per second latched so far.
pub const PULSES: usize = 0x10;
/// Word: the tick of the newest pulse.
pub const PULSE_TICK: usize = 0x14;
/// Word: frames delivered so far.
pub const FRAMES: usize = 0x18;
/// Word: number of the newest frame.
pub const FRAME_SEQUENCE: usize = 0x1c;
/// Word: tick at which its first row arrived.
pub const FRAME_ARRIVAL: usize = 0x20;
/// Word: edges of the shutter's line latched so far.
pub const EDGES: usize = 0x24;
/// Word: columns the sensor delivers.
pub const FRAME_COLS: usize = 0x28;
/// Word: rows the sensor delivers.
pub const FRAME_ROWS: usize = 0x2c;
/// Word: nanoseconds a row takes to read out.
pub const ROW_TIME_NS: usize = 0x30;
/// Word: rows the front end's ring holds before the oldest is overwritten.
pub const RING_ROWS: usize = 0x34;

/// Ring of the newest edges, two words each: the tick, and 1 for a rising or 0 for a falling edge. Edge k, counted from 0,
/// lies in slot k modulo [`EDGE_RING`].
pub const EDGE_WORDS: usize = 0x40;
/// Slots of that ring.
pub const EDGE_RING: usize = 8;

/// Word, written by the firmware: the last step done.
pub const STEP_DONE: usize = 0x80;
/// Word, written by the firmware: 0 while the stores are being read, 1 ready to fly, otherwise why it is grounded
/// ([`crate::boot::BootError::code`]).
pub const STATUS: usize = 0x84;

/// The configuration store.
pub const CONFIGURATION: usize = 0x1000;
/// Bytes of its region.
pub const CONFIGURATION_BYTES: usize = 0xe00;
/// The key store; zeros where messages are not signed.
pub const KEY: usize = CONFIGURATION + CONFIGURATION_BYTES;
/// Bytes of its region.
pub const KEY_BYTES: usize = 0x200;
/// The plan store; erased where photos are not planned.
pub const PLAN: usize = 0x2000;
/// Bytes of its region.
pub const PLAN_BYTES: usize = 0xe000;
/// The frame, row-major.
pub const FRAME: usize = 0x1_0000;
/// The tile store, read-only: it stands for flash.
pub const TILES: usize = 0x80_0000;
/// Bytes of its region.
pub const TILES_BYTES: usize = AREA_MAX + BEFORE_PIXELS;
/// The frame's memory: what the firmware keeps of it, which the simulator never touches. It stands for on-chip RAM behind
/// the data cache.
pub const FRAME_MEMORY: usize = 0x7d_0000;
/// Most pixels of a frame and of a tile.
pub const AREA_MAX: usize = 0x7c_0000;
const _: () = assert!(KEY + KEY_BYTES <= PLAN && PLAN + PLAN_BYTES <= FRAME);
const _: () = assert!(FRAME + AREA_MAX <= FRAME_MEMORY && FRAME_MEMORY + FRAME_MEMORY_BYTES <= TILES);
const _: () = assert!(TILES + TILES_BYTES <= SIZE);
const _: () = assert!(EDGE_WORDS + 8 * EDGE_RING <= STEP_DONE);
