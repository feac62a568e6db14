//! The camera's front end: DCMI and DMA2 into a ring of rows in AXI SRAM, MDMA from there to DTCM as rows are asked for.
//!
//! A frame is armed by its trigger and takes the ring from the start. The interface's interrupt at each row's end counts
//! rows; where the DMA stands is arithmetic ([`ring`](crate::h743::row_ring)). Rows are checked against overwriting after
//! they have been copied, so what the application gets is whole.

use super::memory::Buffer;
use super::{capture, sensor};
use crate::board::{FrameStart, FrontEnd, Rows};
use crate::h743::mt9v034::{PIXELS, Setting};
use crate::h743::row_ring::RowRing;
use core::future::poll_fn;
use core::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use core::task::Poll;
use embassy_futures::select::{Either, select};
use embassy_stm32::dcmi::FrameDma;
use embassy_stm32::interrupt::InterruptExt;
use embassy_stm32::pac::dma::vals::{Burst, Dir, Dmdis, Fth, Pl, Size};
use embassy_stm32::pac::mdma::vals as mdma;
use embassy_stm32::pac::{DCMI, DMA2, DMAMUX1, MDMA, RCC};
use embassy_stm32::peripherals::{self, DMA2_CH1};
use embassy_stm32::{Peri, interrupt, rcc};
use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;
use embassy_sync::signal::Signal;
use embassy_sync::waitqueue::AtomicWaker;
use plumbline_core::units::Ticks;

/// Rows of the ring.
pub const RING_ROWS: u16 = 32;
/// Most rows that are handed out at once.
const ROWS_MAX: usize = RING_ROWS as usize / 2;
/// Stream of DMA2, and its channel of DMAMUX1, whose first eight are DMA1's.
const STREAM: usize = 1;
const MUX: usize = 8 + STREAM;
/// Channel of MDMA.
const COPY: usize = 0;

#[unsafe(link_section = ".axisram.camera_ring")]
static RING: Buffer<[u32; PIXELS.0 as usize * RING_ROWS as usize / 4]> = Buffer::new();
static RING_TAKEN: AtomicBool = AtomicBool::new(false);
/// Rows as the application gets them, in DTCM.
pub type Staging = [u32; PIXELS.0 as usize * ROWS_MAX / 4];

/// Rows of the frame under way that have ended.
static ROWS_ENDED: AtomicU32 = AtomicU32::new(0);
/// Number of the frame under way.
static SEQUENCE: AtomicU32 = AtomicU32::new(0);
/// Rows that somebody waits for.
static WANTED: AtomicU32 = AtomicU32::new(u32::MAX);
/// Whether the frame under way was cut off by the interface or its DMA.
static IS_BROKEN: AtomicBool = AtomicBool::new(false);
static OVERRUNS: AtomicU32 = AtomicU32::new(0);
/// Frames of which a row has come since start.
static FRAMES: AtomicU32 = AtomicU32::new(0);
/// Number behind that of the newest of them.
static ANSWERED: AtomicU32 = AtomicU32::new(0);
/// Words of the ring, for the handler.
static RING_WORDS: AtomicU32 = AtomicU32::new(0);
static BEGUN: Signal<CriticalSectionRawMutex, (u32, Ticks)> = Signal::new();
static ROW: AtomicWaker = AtomicWaker::new();
static COPIED: Signal<CriticalSectionRawMutex, bool> = Signal::new();

/// Rows lost to overruns since start.
pub fn overruns() -> u32 {
    OVERRUNS.load(Ordering::Relaxed)
}

/// Frames of which a row has come since start.
pub fn frames() -> u32 {
    FRAMES.load(Ordering::Relaxed)
}

/// Number behind that of the newest of them, as triggers are numbered.
pub fn answered() -> u32 {
    ANSWERED.load(Ordering::Relaxed)
}

/// The front end of frames of `size` pixels.
#[allow(missing_debug_implementations, reason = "holds a buffer")]
pub struct DcmiFrontEnd {
    size: (u16, u16),
    /// As the sensor was set first, and its clock.
    setting: (Setting, u32),
    ring: RowRing,
    staging: &'static mut Staging,
    sequence: u32,
    row: u32,
}

impl DcmiFrontEnd {
    /// Sets up interface and controllers; `None` where no ring fits such rows, or there is a front end already.
    ///
    /// Polarities as the camera's own public driver has them for this sensor; R0x72 belongs to it
    /// ([`mt9v034`](crate::h743::mt9v034)).
    pub fn new(
        dma: Peri<'static, DMA2_CH1>,
        (size, setting, clock_hz): ((u16, u16), Setting, u32),
        staging: &'static mut Staging,
    ) -> Option<DcmiFrontEnd> {
        let ring = RowRing::new(size.0, RING_ROWS)?;
        RING.take(&RING_TAKEN)?;
        RING_WORDS.store(ring.words().into(), Ordering::Relaxed);
        rcc::enable_and_reset::<peripherals::DCMI>();
        RCC.ahb3enr().modify(|w| w.set_mdmaen(true));

        DMAMUX1.ccr(MUX).write(|w| w.set_dmareq_id(FrameDma::<peripherals::DCMI>::request(&*dma)));
        // One frame, then stop: the trigger arms the next. Both syncs are low between data, pixels at the falling edge.
        DCMI.cr().write(|w| w.set_cm(true));
        DCMI.cr().modify(|w| w.set_enable(true));
        DCMI.ier().write(|w| {
            w.set_line_ie(true);
            w.set_frame_ie(true);
            w.set_ovr_ie(true);
        });
        let copy = MDMA.ch(COPY);
        copy.cr().write(|w| {
            w.set_pl(mdma::Pl::HIGH);
            w.set_ctcie(true);
            w.set_teie(true);
        });
        copy.tcr().write(|w| {
            w.set_sinc(mdma::Incmode::INCREMENT);
            w.set_dinc(mdma::Incmode::INCREMENT);
            w.set_ssize(mdma::Wordsize::WORD);
            w.set_dsize(mdma::Wordsize::WORD);
            w.set_sincos(mdma::Wordsize::WORD);
            w.set_dincos(mdma::Wordsize::WORD);
            w.set_sburst(mdma::Burst::INCR16);
            w.set_tlen(127);
            w.set_trgm(mdma::Trgm::BLOCK);
            w.set_swrm(true);
        });
        // From the AXI bus to the core's own memory.
        copy.tbr().write(|w| {
            w.set_sbus(mdma::Bus::SYSTEM);
            w.set_dbus(mdma::Bus::AHB);
        });
        // SAFETY: the handlers below are in place.
        unsafe {
            interrupt::DCMI.enable();
            interrupt::MDMA.enable();
        }
        Some(DcmiFrontEnd { size, setting: (setting, clock_hz), ring, staging, sequence: 0, row: 0 })
    }

    fn written(&self) -> u32 {
        self.ring.written(DMA2.st(STREAM).ndtr().read().ndt(), ROWS_ENDED.load(Ordering::Acquire))
    }

    /// Whether another frame has been armed, or this one was cut off.
    fn is_gone(&self) -> bool {
        SEQUENCE.load(Ordering::Acquire) != self.sequence || IS_BROKEN.load(Ordering::Acquire)
    }

    fn lost(&self, count: u16) -> Rows<'_> {
        OVERRUNS.fetch_add(count.into(), Ordering::Relaxed);
        Rows::Overrun
    }

    /// Waits until the controller has moved the rows from `first` on; whether it did. It takes microseconds. One that has not
    /// ended when those rows are overwritten, or the next frame is armed, is given up and stopped: each row's end and each
    /// trigger wakes this wait.
    async fn copied(&self, first: u32) -> bool {
        let overdue = poll_fn(|context| {
            ROW.register(context.waker());
            if self.is_gone() || !self.ring.holds(first, self.written()) { Poll::Ready(()) } else { Poll::Pending }
        });
        match select(COPIED.wait(), overdue).await {
            Either::First(is_good) => is_good,
            Either::Second(()) => false,
        }
    }

    /// Moves rows from the ring to DTCM; whether the controller did.
    async fn copy(&mut self, first: u32, count: u32) -> bool {
        let bytes = self.ring.row_bytes();
        let (mut row, end) = (first, first + count);
        while row < end {
            let (offset, until_wrap) = self.ring.slot(row);
            let rows = until_wrap.min(end - row);
            let channel = MDMA.ch(COPY);
            // A copy that would not stop holds its registers locked, and its end would count as this one's.
            if channel.cr().read().en() {
                return false;
            }
            COPIED.reset();
            channel.sar().write_value(embassy_stm32::pac::mdma::regs::Sar(RING.address() + offset));
            let to = self.staging.as_mut_ptr().expose_provenance() as u32 + (row - first) * bytes;
            channel.dar().write_value(embassy_stm32::pac::mdma::regs::Dar(to));
            channel.bndtr().write(|w| w.set_bndt(rows * bytes));
            channel.cr().modify(|w| w.set_en(true));
            channel.cr().modify(|w| w.set_swrq(true));
            if !self.copied(first).await {
                channel.cr().modify(|w| w.set_en(false));
                // What it has read is written first, and must not lie among the next rows.
                for _ in 0..64 {
                    if !channel.cr().read().en() {
                        break;
                    }
                }
                return false;
            }
            core::sync::atomic::fence(Ordering::Acquire);
            row += rows;
        }
        true
    }
}

impl FrontEnd for DcmiFrontEnd {
    async fn frame(&mut self) -> FrameStart {
        let (sequence, arrival) = BEGUN.wait().await;
        (self.sequence, self.row) = (sequence, 0);
        FrameStart { sequence, arrival, size: self.size }
    }

    async fn rows(&mut self, count: u16) -> Rows<'_> {
        let (first, end) = (self.row, self.row + u32::from(count));
        if end > u32::from(self.size.1) {
            return Rows::End;
        }
        if count as usize > ROWS_MAX {
            return self.lost(count);
        }
        let arrived = poll_fn(|context| {
            ROW.register(context.waker());
            WANTED.store(end, Ordering::Release);
            if self.is_gone() {
                Poll::Ready(false)
            } else if self.ring.has(end, self.written()) {
                Poll::Ready(true)
            } else {
                Poll::Pending
            }
        })
        .await;
        let is_copied = arrived && self.copy(first, count.into()).await;
        // After the copy: what was overwritten before or meanwhile is found now.
        if !is_copied || self.is_gone() || !self.ring.holds(first, self.written()) {
            return self.lost(count);
        }
        // A frame of more or fewer pixels than there should be is shifted somewhere.
        if end == u32::from(self.size.1) && self.written() != end * self.ring.row_bytes() {
            return self.lost(count);
        }
        self.row = end;
        let bytes = count as usize * usize::from(self.size.0);
        let words = self.staging.get(..bytes / 4).unwrap_or(&[]);
        // SAFETY: the controller has finished, and the next copy needs this borrow to end; bytes have no alignment.
        Rows::Pixels(unsafe { core::slice::from_raw_parts(words.as_ptr().cast(), words.len() * 4) })
    }

    fn expose(&mut self, us: u32) -> Option<u32> {
        let (setting, clock_hz) = self.setting;
        let setting = setting.exposed(us, clock_hz).ok()?;
        sensor::expose(setting);
        Some((setting.exposure_ns(clock_hz) + 500).div_euclid(1000) as u32)
    }
}

/// Readies the ring for the frame that a trigger has just opened. Called by the trigger's handler; the sensor exposes
/// before it sends, so there is time.
pub(super) fn arm(sequence: u32) {
    let stream = DMA2.st(STREAM);
    // Off and on again, which empties its own FIFO of what a frame cut short has left.
    DCMI.cr().modify(|w| {
        w.set_capture(false);
        w.set_enable(false);
    });
    stream.cr().modify(|w| w.set_en(false));
    // A word under way is finished first.
    for _ in 0..64 {
        if !stream.cr().read().en() {
            break;
        }
    }
    DMA2.ifcr(0).write(|w| {
        w.set_tcif(STREAM, true);
        w.set_htif(STREAM, true);
        w.set_teif(STREAM, true);
        w.set_dmeif(STREAM, true);
        w.set_feif(STREAM, true);
    });
    ROWS_ENDED.store(0, Ordering::Release);
    IS_BROKEN.store(false, Ordering::Release);
    SEQUENCE.store(sequence, Ordering::Release);
    stream.par().write_value(DCMI.dr().as_ptr() as u32);
    stream.m0ar().write_value(RING.address());
    stream.ndtr().write(|w| w.set_ndt(RING_WORDS.load(Ordering::Relaxed) as u16));
    stream.fcr().write(|w| {
        w.set_dmdis(Dmdis::DISABLED);
        // Words go on to memory as they come: what NDTR has counted is there.
        w.set_fth(Fth::QUARTER);
    });
    stream.cr().write(|w| {
        w.set_dir(Dir::PERIPHERAL_TO_MEMORY);
        w.set_circ(true);
        w.set_minc(true);
        w.set_psize(Size::BITS32);
        w.set_msize(Size::BITS32);
        w.set_mburst(Burst::SINGLE);
        w.set_pl(Pl::VERY_HIGH);
        w.set_en(true);
    });
    DCMI.icr().write(|w| {
        w.set_line_isc(true);
        w.set_frame_isc(true);
        w.set_ovr_isc(true);
    });
    DCMI.cr().modify(|w| w.set_enable(true));
    DCMI.cr().modify(|w| w.set_capture(true));
    // Who waits for rows of the frame before learns that it is gone.
    ROW.wake();
}

#[interrupt]
unsafe fn DCMI() {
    let status = DCMI.mis().read();
    DCMI.icr().write(|w| w.0 = status.0);
    if status.line_mis() {
        let ended = ROWS_ENDED.load(Ordering::Relaxed) + 1;
        ROWS_ENDED.store(ended, Ordering::Release);
        if ended == 1 {
            let sequence = SEQUENCE.load(Ordering::Relaxed);
            FRAMES.fetch_add(1, Ordering::Relaxed);
            ANSWERED.store(sequence.wrapping_add(1), Ordering::Relaxed);
            BEGUN.signal((sequence, capture::now()));
        }
        if ended >= WANTED.load(Ordering::Acquire) {
            ROW.wake();
        }
    }
    if status.ovr_mis() {
        IS_BROKEN.store(true, Ordering::Release);
    }
    if status.ovr_mis() || status.frame_mis() {
        ROW.wake();
    }
}

#[interrupt]
unsafe fn MDMA() {
    let channel = MDMA.ch(COPY);
    let is_good = !channel.isr().read().teif();
    channel.ifcr().write(|w| {
        w.set_cctcif(true);
        w.set_cbtif(true);
        w.set_cbrtif(true);
        w.set_cltcif(true);
        w.set_cteif(true);
    });
    COPIED.signal(is_good);
}
