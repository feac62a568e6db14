//! The microSD card as the log's block device: SDMMC1, four lines, its own DMA.
//!
//! That DMA reaches AXI SRAM and no other RAM, so blocks pass through a buffer there. embassy's driver finds the card and
//! reads. It does not write: after a write it asks the card without a pause until that is ready, a quarter of a second at
//! worst, and nothing else would be done in that time. Here the same registers are written in the same order, with sleep
//! between the questions and an end to them.

use super::memory::{Buffer, Zeroes};
use super::sdio::{Outcome, SET_BLOCK_LENGTH, STATUS, STOP, WRITE_BLOCKS, command_outcome, data_outcome, is_ready};
use crate::log::block::BLOCK;
use crate::log::card::BlockDevice;
use core::sync::atomic::{AtomicBool, Ordering, fence};
use embassy_stm32::pac::SDMMC1 as REGISTERS;
use embassy_stm32::peripherals::{PC8, PC9, PC10, PC11, PC12, PD2, SDMMC1};
use embassy_stm32::sdmmc::sd::{Addressable, Card, CmdBlock, DataBlock, StorageDevice};
use embassy_stm32::sdmmc::{Config, Error, Sdmmc};
use embassy_stm32::time::Hertz;
use embassy_stm32::{Peri, bind_interrupts, sdmmc};
use embassy_time::Timer;
use static_cell::StaticCell;

bind_interrupts!(struct Irqs {
    SDMMC1 => sdmmc::InterruptHandler<SDMMC1>;
});

/// Blocks that are written at a time.
const BATCH: usize = 8;
/// The card's clock: 48 or 40 MHz by two, which every card takes.
const CLOCK: Hertz = Hertz(24_000_000);
/// From question to question, microseconds, and how many there are: 0.6 s. A card may take a quarter, an SDXC card half.
const PAUSE_US: u64 = 250;
const QUESTIONS: u32 = 2400;
/// Periods of the card's clock that it may be busy, in hardware: 0.5 s.
const BUSY_MAX: u32 = CLOCK.0 / 2;
/// Looks at the status register until a command must have had its answer or its time-out: 7 us at 24 MHz.
const LOOKS: u32 = 10_000;
/// Of DCTRL: blocks of two to the power of this.
const BLOCK_POWER: u8 = 9;

/// Blocks, and room for the commands' answers.
struct Blocks {
    one: DataBlock,
    batch: [[u8; BLOCK]; BATCH],
    command: CmdBlock,
}

// SAFETY: all are arrays of integers.
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
    one: &'static mut DataBlock,
    batch: &'static mut [[u8; BLOCK]; BATCH],
}

impl MicroSd {
    /// Finds the card.
    ///
    /// # Errors
    /// embassy's: no card, or none that answers; `NoCard` too where it was taken before.
    pub async fn new(parts: Parts) -> Result<MicroSd, Error> {
        let blocks = BLOCKS.take(&BLOCKS_TAKEN).ok_or(Error::NoCard)?;
        let (d0, d1, d2, d3) = parts.data;
        let mut config = Config::default();
        config.data_transfer_timeout = BUSY_MAX;
        let driver = Sdmmc::new_4bit(parts.sdmmc, Irqs, parts.clock, parts.command, d0, d1, d2, d3, config);
        let device = StorageDevice::new_sd_card(DRIVER.init(driver), &mut blocks.command, CLOCK).await?;
        Ok(MicroSd { device, one: &mut blocks.one, batch: &mut blocks.batch })
    }

    /// Waits until the card takes the next command for data.
    async fn ready(&self) -> Result<(), Error> {
        let address = u32::from(self.device.card().get_address()) << 16;
        asked(|| command(STATUS, address).ok().filter(|status| is_ready(*status)).map(|_| ())).await
    }

    /// Writes the first `count` blocks of the batch.
    async fn write_batch(&mut self, index: u32, count: usize) -> Result<(), Error> {
        self.ready().await?;
        command(SET_BLOCK_LENGTH, BLOCK as u32)?;
        // Cards up to 2 GB count bytes.
        let is_large = self.device.card().ocr.high_capacity();
        let place = if is_large { index } else { index.saturating_mul(BLOCK as u32) };
        REGISTERS.maskr().write(|_| ());
        REGISTERS.dlenr().write(|w| w.set_datalength((count * BLOCK) as u32));
        REGISTERS.idmabase0r().write(|w| w.set_idmabase0(self.batch.as_ptr().addr() as u32));
        REGISTERS.idmactrlr().modify(|w| w.set_idmaen(true));
        REGISTERS.dctrl().modify(|w| {
            w.set_dtmode(0);
            w.set_dblocksize(BLOCK_POWER);
            w.set_dtdir(false);
        });
        // What the DMA reads must have been written.
        fence(Ordering::SeqCst);
        cortex_m::asm::dsb();
        let sent = match command(WRITE_BLOCKS, place) {
            Ok(_) => asked(|| answer(data_outcome(REGISTERS.star().read().0))).await.and_then(|outcome| outcome),
            Err(error) => Err(error),
        };
        // Also after a failure: it ends what the card or the interface may still be at. The card's own answer counts.
        let stopped = command(STOP, 0).map(|_| ());
        let idle = asked(|| (!REGISTERS.star().read().dpsmact()).then_some(())).await;
        REGISTERS.idmactrlr().modify(|w| w.set_idmaen(false));
        clear_flags();
        let ready = self.ready().await;
        sent.and(stopped).and(idle).and(ready)
    }
}

impl BlockDevice for MicroSd {
    type Error = Error;

    fn blocks(&self) -> u32 {
        (self.device.card().size() / BLOCK as u64).try_into().unwrap_or(u32::MAX)
    }

    async fn read(&mut self, index: u32, block: &mut [u8; BLOCK]) -> Result<(), Error> {
        self.device.read_block(index, self.one).await?;
        block.copy_from_slice(&self.one[..]);
        Ok(())
    }

    async fn write(&mut self, index: u32, blocks: &[[u8; BLOCK]]) -> Result<(), Error> {
        for (n, part) in blocks.chunks(BATCH).enumerate() {
            self.batch.iter_mut().zip(part).for_each(|(to, from)| *to = *from);
            self.write_batch(index.saturating_add((n * BATCH) as u32), part.len()).await?;
        }
        Ok(())
    }
}

/// Asks until there is an answer, and sleeps in between.
async fn asked<T>(mut question: impl FnMut() -> Option<T>) -> Result<T, Error> {
    for _ in 0..QUESTIONS {
        if let Some(answer) = question() {
            return Ok(answer);
        }
        Timer::after_micros(PAUSE_US).await;
    }
    Err(Error::SoftwareTimeout)
}

/// Sends a command with a short answer; that answer. Its few microseconds are waited for.
fn command(number: u8, argument: u32) -> Result<u32, Error> {
    clear_flags();
    REGISTERS.argr().write(|w| w.set_cmdarg(argument));
    REGISTERS.cmdr().write(|w| {
        w.set_cmdindex(number);
        w.set_waitresp(1);
        w.set_cpsmen(true);
        w.set_cmdstop(number == STOP);
        w.set_cmdtrans(number == WRITE_BLOCKS);
    });
    let outcome = (0..LOOKS).find_map(|_| answer(command_outcome(REGISTERS.star().read().0)));
    outcome.unwrap_or(Err(Error::SoftwareTimeout))?;
    Ok(REGISTERS.respr(0).read().cardstatus())
}

fn answer(outcome: Outcome) -> Option<Result<(), Error>> {
    match outcome {
        Outcome::Running => None,
        Outcome::Done => Some(Ok(())),
        Outcome::Checksum => Some(Err(Error::Crc)),
        Outcome::Late => Some(Err(Error::Timeout)),
        Outcome::Starved => Some(Err(Error::Underrun)),
    }
}

fn clear_flags() {
    REGISTERS.icr().write(|w| w.0 = super::sdio::ALL_FLAGS);
}
