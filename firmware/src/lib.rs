//! The application a board runs: async tasks, one a stream, generic over [`board::Board`].
//!
//! The images in `src/bin` and the simulator's in-process link compile this code alike, so a flight on the host,
//! in the emulated Cortex-M7 and on a board differ in who delivers the bytes and in nothing else.
//!
//! [`stores`]: what lies in flash (camera and settings, reference tile). [`boot`]: from there to the application.
//! [`wire`]: MAVLink 2 in and out. [`app`]: the tasks. [`journal`]: what they record so that a flight can be run again,
//! [`mod@log`]: where it is kept. [`run`]: the executor's loop. [`shared_memory`]: what the emulator and the simulator both see.
//! [`serial`]: the simulator's line to a board. [`mod@bench`]: what a frame costs. `an500` and [`h743`]: the boards.
#![no_std]

#[cfg(all(feature = "an500", feature = "h743"))]
compile_error!("one board a build: the features an500 and h743 bring a clock and vectors each");

#[cfg(all(target_os = "none", feature = "an500"))]
pub mod an500;
pub mod app;
pub mod autopilot;
pub mod bench;
pub mod board;
pub mod boot;
pub mod h743;
pub mod journal;
pub mod log;
pub mod run;
pub mod serial;
pub mod shared;
pub mod shared_memory;
pub mod stores;
pub mod task_list;
pub mod tasks;

pub mod wire;
