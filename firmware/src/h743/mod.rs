//! The flight computer: OpenMV Cam H7, an STM32H743VI with the MT9V034 in front of it.
//!
//! What is arithmetic compiles and is tested on the host; what touches the chip is below.
//!
//! | module | what |
//! |---|---|
//! | [`timing`] | clocks and dividers |
//! | [`ring`] | where the camera's DMA stands |
//! | [`trigger`] | when the next exposure is triggered |
//! | [`mt9v034`] | the sensor's registers |
//! | [`regions`] | the MPU's words |
//! | [`record`] | the record of a fault |
//! | [`life`] | when the watchdog is fed |
//! | [`led`] | what the lamps say |
//! | [`servo`] | an angle as a pulse |
//! | [`hello`] | the simulator's hello on USB |
//! | [`sdio`] | what card and interface say |
//! | `start`, `boot`, `tasks` | from reset to flight |
//! | `clocks`, `memory`, `fault`, `supply`, `gauge` | the chip itself |
//! | `capture`, `sensor`, `camera` | the eye |
//! | `link`, `usb`, `port`, `card` | what it talks to |
//! | `simulator` | the flight that comes over USB instead |
//! | `logging`, `random` | the flight's log onto the card |

pub mod hello;
pub mod led;
pub mod life;
pub mod mt9v034;
pub mod record;
pub mod regions;
pub mod ring;
pub mod sdio;
pub mod servo;
pub mod timing;
pub mod trigger;

#[cfg(all(target_os = "none", feature = "h743"))]
#[macro_use]
mod pins;
#[cfg(all(target_os = "none", feature = "h743"))]
pub mod boot;
#[cfg(all(target_os = "none", feature = "h743"))]
pub mod camera;
#[cfg(all(target_os = "none", feature = "h743"))]
pub mod capture;
#[cfg(all(target_os = "none", feature = "h743"))]
pub mod card;
#[cfg(all(target_os = "none", feature = "h743"))]
pub mod clocks;
#[cfg(all(target_os = "none", feature = "h743"))]
pub mod fault;
#[cfg(all(target_os = "none", feature = "h743"))]
pub mod gauge;
#[cfg(all(target_os = "none", feature = "h743"))]
pub mod link;
#[cfg(all(target_os = "none", feature = "h743"))]
pub mod logging;
#[cfg(all(target_os = "none", feature = "h743"))]
pub mod memory;
#[cfg(all(target_os = "none", feature = "h743"))]
pub mod port;
#[cfg(all(target_os = "none", feature = "h743"))]
pub mod random;
#[cfg(all(target_os = "none", feature = "h743"))]
pub mod sensor;
#[cfg(all(target_os = "none", feature = "h743"))]
pub mod simulator;
#[cfg(all(target_os = "none", feature = "h743"))]
pub mod start;
#[cfg(all(target_os = "none", feature = "h743"))]
pub mod supply;
#[cfg(all(target_os = "none", feature = "h743"))]
pub mod tasks;
#[cfg(all(target_os = "none", feature = "h743"))]
pub mod usb;

#[cfg(all(target_os = "none", feature = "h743"))]
use defmt_rtt as _;
#[cfg(all(target_os = "none", feature = "h743"))]
pub use start::start;
