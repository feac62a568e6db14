//! The microSD card as the log's block device: SDMMC1, four lines, its own DMA.
//!
//! That DMA reaches AXI SRAM and no other RAM, so blocks pass through a buffer there. embassy's driver has the pins and the
//! clock. The rest is done here: its own way to find a card has no end where the card never gets ready, and after a write it
//! asks the card without a pause, a quarter of a second at worst, in which no frame would be worked on. Here every wait
//! sleeps, and has an end.

use super::memory::{Buffer, Zeroes};
use crate::h743::sdio::{
    ALL_FLAGS, Answer, Fault, Identity, command as number, command_outcome, data_outcome, is_ready,
};
use crate::log::block::BLOCK;
use crate::log::card::BlockDevice;
use core::sync::atomic::{AtomicBool, Ordering, fence};
use embassy_stm32::pac::SDMMC1 as REGISTERS;
use embassy_stm32::peripherals::{PC8, PC9, PC10, PC11, PC12, PD2, SDMMC1};
use embassy_stm32::sdmmc::{Config, Sdmmc};
use embassy_stm32::{Peri, bind_interrupts, rcc, sdmmc};
use embassy_time::Timer;

bind_interrupts!(struct Irqs {
    SDMMC1 => sdmmc::InterruptHandler<SDMMC1>;
});

/// Blocks that are written at a time.
const BATCH: usize = 8;
/// Twice the clock that a card is found with, 400 kHz.
const TWICE_SLOW_HZ: u32 = 800_000;
/// Divider of the clock in flight: 48 or 40 MHz by two, which every card takes.
const FAST: u16 = 1;
/// From question to question, microseconds, and how many there are: 0.6 s. A card may take a quarter, an SDXC card half.
const PAUSE_US: u64 = 250;
const QUESTIONS: u32 = 2400;
/// From question to question of a card that gets ready after power-up, microseconds, and how many: it may take a second.
const READY_PAUSE_US: u64 = 10_000;
const READY_QUESTIONS: u32 = 150;
/// Periods of the card's clock that it may be busy, in hardware: 0.5 s.
const BUSY_MAX: u32 = 12_000_000;
/// Looks at the status register, some milliseconds, in which a command must have had its answer or its time-out: 0.8 ms
/// while the card is being found, 10 us in flight.
const LOOKS: u32 = 100_000;
/// Of DCTRL: blocks of two to the power of this.
const BLOCK_POWER: u8 = 9;

/// What the DMA reads and writes.
type Batch = [[u8; BLOCK]; BATCH];

#[unsafe(link_section = ".axisram.card_blocks")]
static BLOCKS: Buffer<Aligned> = Buffer::new();
static BLOCKS_TAKEN: AtomicBool = AtomicBool::new(false);

/// The DMA wants words.
#[repr(align(4))]
struct Aligned(Batch);

// SAFETY: integers.
unsafe impl Zeroes for Aligned {}

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
    identity: Identity,
    batch: &'static mut Batch,
}

impl MicroSd {
    /// Finds the card.
    ///
    /// # Errors
    /// [`Fault::Late`] where none answers; [`Fault::Foreign`] for one of a kind from before 2006.
    pub async fn new(parts: Parts) -> Result<MicroSd, Fault> {
        let Aligned(batch) = BLOCKS.take(&BLOCKS_TAKEN).ok_or(Fault::Foreign)?;
        let (d0, d1, d2, d3) = parts.data;
        let config = Config::default();
        let driver = Sdmmc::new_4bit(parts.sdmmc, Irqs, parts.clock, parts.command, d0, d1, d2, d3, config);
        // Pins and clock stay for ever.
        core::mem::forget(driver);
        let slow = rcc::frequency::<SDMMC1>().0.div_ceil(TWICE_SLOW_HZ);
        Ok(MicroSd { identity: find(slow as u16).await?, batch })
    }

    /// Waits until the card takes the next command for data.
    async fn ready(&self) -> Result<(), Fault> {
        let is_so = || command(number::STATUS, self.identity.address).is_ok_and(is_ready).then_some(());
        asked(QUESTIONS, PAUSE_US, is_so).await
    }

    /// Writes or reads `count` blocks of the batch.
    async fn transfer(&mut self, number: u8, index: u32, count: usize) -> Result<(), Fault> {
        self.ready().await?;
        command(number::SET_BLOCK_LENGTH, BLOCK as u32)?;
        REGISTERS.dlenr().write(|w| w.set_datalength((count * BLOCK) as u32));
        REGISTERS.idmabase0r().write(|w| w.set_idmabase0(self.batch.as_mut_ptr().expose_provenance() as u32));
        REGISTERS.idmactrlr().modify(|w| w.set_idmaen(true));
        REGISTERS.dctrl().modify(|w| {
            w.set_dtmode(0);
            w.set_dblocksize(BLOCK_POWER);
            w.set_dtdir(number == number::READ_BLOCKS);
        });
        // What the DMA reads must have been written.
        fence(Ordering::SeqCst);
        cortex_m::asm::dsb();
        let done = match command(number, self.identity.address(index)) {
            Ok(_) => {
                let ended = asked(QUESTIONS, PAUSE_US, || data_outcome(REGISTERS.star().read().0)).await;
                ended.and_then(|outcome| outcome)
            }
            Err(fault) => Err(fault),
        };
        // After a failure too: it ends whatever the card or the interface may still be at.
        let stopped = command(number::STOP, 0).map(|_| ());
        let is_idle = || (!REGISTERS.star().read().dpsmact()).then_some(());
        let idle = asked(QUESTIONS, PAUSE_US, is_idle).await;
        REGISTERS.idmactrlr().modify(|w| w.set_idmaen(false));
        fence(Ordering::SeqCst);
        let ready = self.ready().await;
        done.and(stopped).and(idle).and(ready)
    }
}

impl BlockDevice for MicroSd {
    type Error = Fault;

    fn blocks(&self) -> u32 {
        self.identity.blocks
    }

    async fn read(&mut self, index: u32, block: &mut [u8; BLOCK]) -> Result<(), Fault> {
        self.transfer(number::READ_BLOCKS, index, 1).await?;
        self.batch.iter().take(1).for_each(|from| *block = *from);
        Ok(())
    }

    async fn write(&mut self, index: u32, blocks: &[[u8; BLOCK]]) -> Result<(), Fault> {
        for (n, part) in blocks.chunks(BATCH).enumerate() {
            self.batch.iter_mut().zip(part).for_each(|(to, from)| *to = *from);
            self.transfer(number::WRITE_BLOCKS, index.saturating_add((n * BATCH) as u32), part.len()).await?;
        }
        Ok(())
    }
}

/// From power to the state "transfer": SD specification, 4.2 and figure 4-13.
async fn find(slow: u16) -> Result<Identity, Fault> {
    clock(slow, false);
    REGISTERS.dtimer().write(|w| w.set_datatime(BUSY_MAX));
    // Every answer is asked for: no interrupt.
    REGISTERS.maskr().write(|_| ());
    REGISTERS.power().modify(|w| w.set_pwrctrl(3));
    // 74 periods at least.
    Timer::after_millis(2).await;
    command(number::IDLE, 0)?;
    if command(number::CONDITION, number::CONDITION_WORD)? & 0xfff != number::CONDITION_WORD {
        return Err(Fault::Foreign);
    }
    let powered = || {
        let answer = command(number::APPLICATION, 0).and_then(|_| command(number::POWER_UP, number::POWER_UP_WORD));
        answer.ok().filter(|ocr| ocr & number::POWERED != 0)
    };
    let ocr = asked(READY_QUESTIONS, READY_PAUSE_US, powered).await?;
    command(number::ALL_IDENTIFY, 0)?;
    let address = command(number::ADDRESS, 0)? & 0xffff_0000;
    command(number::DESCRIBE, address)?;
    let description = [0, 1, 2, 3].map(|n| REGISTERS.respr(n).read().cardstatus());
    command(number::SELECT, address)?;
    command(number::APPLICATION, address)?;
    command(number::WIDTH, number::FOUR_LINES)?;
    clock(FAST, true);
    Ok(Identity::new(ocr, address, description))
}

fn clock(divider: u16, is_wide: bool) {
    REGISTERS.clkcr().modify(|w| {
        w.set_clkdiv(divider);
        w.set_widbus(is_wide.into());
    });
}

/// Asks until there is an answer, and sleeps in between.
async fn asked<T>(questions: u32, pause_us: u64, mut question: impl FnMut() -> Option<T>) -> Result<T, Fault> {
    for _ in 0..questions {
        if let Some(answer) = question() {
            return Ok(answer);
        }
        Timer::after_micros(pause_us).await;
    }
    Err(Fault::Late)
}

/// Sends a command; the first word of its answer. That is waited for.
#[inline(never)]
fn command(number: u8, argument: u32) -> Result<u32, Fault> {
    let answer = Answer::of(number);
    REGISTERS.icr().write(|w| w.0 = ALL_FLAGS);
    REGISTERS.argr().write(|w| w.set_cmdarg(argument));
    REGISTERS.cmdr().write(|w| {
        w.set_cmdindex(number);
        w.set_waitresp(answer.wait());
        w.set_cpsmen(true);
        w.set_cmdstop(number == number::STOP);
        w.set_cmdtrans(matches!(number, number::READ_BLOCKS | number::WRITE_BLOCKS));
    });
    let outcome = (0..LOOKS).find_map(|_| command_outcome(answer, REGISTERS.star().read().0));
    outcome.unwrap_or(Err(Fault::Late)).map(|()| REGISTERS.respr(0).read().cardstatus())
}
