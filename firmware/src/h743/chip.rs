//! The chip itself: what only the image for the flight computer compiles.
//!
//! | module | what |
//! |---|---|
//! | [`start`](mod@start), [`boot`], [`flight`], [`tasks`], [`watchdog`] | from reset to flight |
//! | [`clocks`], [`memory`], [`fault`], [`supply`], [`counters`] | the chip itself |
//! | [`capture`], [`trigger`], [`sensor`], [`front_end`] | the camera front end |
//! | [`link`], [`usb`], [`port`], [`card`] | what it talks to |
//! | [`simulator`] | the flight that comes over USB instead |
//! | [`flash`], [`kept`] | what outlives a lost power and a reset |
//! | [`logging`], [`random`] | the flight's log onto the card |

#[macro_use]
mod pins;
pub mod boot;
pub mod front_end;
pub mod capture;
pub mod card;
pub mod clocks;
pub mod fault;
pub mod flash;
pub mod flight;
pub mod counters;
pub mod kept;
pub mod link;
pub mod logging;
pub mod memory;
pub mod port;
pub mod random;
pub mod sensor;
pub mod simulator;
pub mod start;
pub mod supply;
pub mod tasks;
pub mod trigger;
pub mod usb;
pub mod watchdog;

use defmt_rtt as _;
pub use start::start;
