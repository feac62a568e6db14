//! The microSD card as a block device: SDMMC1, four lines, its own DMA.
//!
//! That DMA reaches AXI SRAM and no other RAM, so blocks pass through a buffer there.

use super::memory::{Buffer, Zeroes};
use core::sync::atomic::AtomicBool;
use embassy_stm32::peripherals::{PC8, PC9, PC10, PC11, PC12, PD2, SDMMC1};
use embassy_stm32::sdmmc::sd::{Addressable, Card, CmdBlock, DataBlock, StorageDevice};
use embassy_stm32::sdmmc::{Config, Error, Sdmmc};
use embassy_stm32::time::Hertz;
use embassy_stm32::{Peri, bind_interrupts, sdmmc};
use static_cell::StaticCell;

bind_interrupts!(struct Irqs {
    SDMMC1 => sdmmc::InterruptHandler<SDMMC1>;
});

/// Bytes of a block.
pub const BLOCK: usize = 512;
/// The card's clock: 48 or 40 MHz by two, which every card takes.
const CLOCK: Hertz = Hertz(24_000_000);

/// A block, and room for the commands' answers.
struct Blocks {
    data: DataBlock,
    command: CmdBlock,
}

// SAFETY: both are arrays of integers.
unsafe impl Zeroes for Blocks {}

#[unsafe(link_section = ".axisram.card_blocks")]
static BLOCKS: Buffer<Blocks> = Buffer::new();
static BLOCKS_TAKEN: AtomicBool = AtomicBool::new(false);
static DRIVER: StaticCell<Sdmmc<'static>> = StaticCell::new();

/// What the card hangs on.
#[allow(missing_debug_implementations, reason = "pins")]
pub struct Parts {
    /// Interface.
    pub sdmmc: Peri<'static, SDMMC1>,
    /// Clock.
    pub clock: Peri<'static, PC12>,
    /// Command.
    pub command: Peri<'static, PD2>,
    /// Data.
    pub data: (Peri<'static, PC8>, Peri<'static, PC9>, Peri<'static, PC10>, Peri<'static, PC11>),
}

/// A card that answers.
#[allow(missing_debug_implementations, reason = "a driver")]
pub struct MicroSd {
    device: StorageDevice<'static, 'static, Card>,
    data: &'static mut DataBlock,
}

impl MicroSd {
    /// Finds the card.
    ///
    /// # Errors
    /// embassy's: no card, or none that answers; `Busy` where it was taken before.
    pub async fn new(parts: Parts) -> Result<MicroSd, Error> {
        let blocks = BLOCKS.take(&BLOCKS_TAKEN).ok_or(Error::NoCard)?;
        let (d0, d1, d2, d3) = parts.data;
        let driver = Sdmmc::new_4bit(parts.sdmmc, Irqs, parts.clock, parts.command, d0, d1, d2, d3, Config::default());
        let device = StorageDevice::new_sd_card(DRIVER.init(driver), &mut blocks.command, CLOCK).await?;
        Ok(MicroSd { device, data: &mut blocks.data })
    }

    /// Blocks of the card.
    pub fn blocks(&self) -> u32 {
        (self.device.card().size() / BLOCK as u64).try_into().unwrap_or(u32::MAX)
    }

    /// Reads block `number`.
    ///
    /// # Errors
    /// embassy's.
    pub async fn read(&mut self, number: u32, into: &mut [u8; BLOCK]) -> Result<(), Error> {
        self.device.read_block(number, self.data).await?;
        into.copy_from_slice(&self.data[..]);
        Ok(())
    }

    /// Writes block `number`.
    ///
    /// # Errors
    /// embassy's.
    pub async fn write(&mut self, number: u32, from: &[u8; BLOCK]) -> Result<(), Error> {
        self.data.copy_from_slice(from);
        self.device.write_block(number, self.data).await
    }
}
