//! The flight computer: OpenMV Cam H7, an STM32H743VI with the MT9V034 in front of it.
//!
//! What is arithmetic compiles and is tested on the host; what touches the chip is in `chip`.
//!
//! | module | what |
//! |---|---|
//! | [`timing`] | clocks and dividers |
//! | [`row_ring`] | where the camera's DMA stands |
//! | [`trigger`] | when the next exposure is triggered |
//! | [`silence`] | whether the sensor answers triggers |
//! | [`mt9v034`] | the sensor's registers |
//! | [`regions`] | the MPU's words |
//! | [`record`] | the record of a fault |
//! | [`resume`] | what outlives a reset beside it |
//! | [`life`] | when the watchdog is fed |
//! | [`led`] | what the lamps say |
//! | [`servo`] | an angle as a pulse |
//! | [`hello`] | the simulator's hello on USB |
//! | [`sdio`] | what card and interface say |

pub mod hello;
pub mod led;
pub mod life;
pub mod mt9v034;
pub mod record;
pub mod regions;
pub mod resume;
pub mod row_ring;
pub mod sdio;
pub mod servo;
pub mod silence;
pub mod timing;
pub mod trigger;

#[cfg(all(target_os = "none", feature = "h743"))]
pub mod chip;
