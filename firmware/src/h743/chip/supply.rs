//! The supply voltage: what resets the chip, and what warns before.
//!
//! The brown-out level is an option byte. It is read and reported, never written: a write that the voltage interrupts leaves a
//! board that does not start.

use core::sync::atomic::{AtomicBool, Ordering};
use embassy_stm32::interrupt;
use embassy_stm32::interrupt::InterruptExt;
use embassy_stm32::pac::iwdg::vals::{Key, Pr};
use embassy_stm32::pac::{EXTI, FLASH, IWDG1, PWR, RCC};

/// Brown-out reset level wanted: 2, which holds the chip in reset below 2.4 V.
pub const BROWN_OUT_WANTED: u8 = 2;
/// Level of the warning, PLS 5: 2.7 V.
const WARNING: u8 = 5;
/// Line of the extended interrupts that the detector is wired to.
const LINE: usize = 16;

static IS_LOW: AtomicBool = AtomicBool::new(false);

/// Starts the warning.
pub fn start() {
    PWR.cr1().modify(|w| {
        w.set_pls(WARNING);
        w.set_pvde(true);
    });
    EXTI.rtsr(0).modify(|w| w.set_line(LINE, true));
    EXTI.imr(0).modify(|w| w.set_line(LINE, true));
    // SAFETY: the handler below is in place.
    unsafe { interrupt::PVD_AVD.enable() };
}

/// Brown-out reset level by the option bytes, 0 to 3.
pub fn brown_out_level() -> u8 {
    FLASH.optsr_cur().read().bor_lev()
}

/// Whether the voltage was below the warning's level since start.
pub fn was_low() -> bool {
    IS_LOW.load(Ordering::Relaxed)
}

/// Starts the watchdog with its longest time, half a minute, until the board's own is set: a crystal that does not swing
/// would hang the start for ever.
pub fn watch_boot() {
    IWDG1.kr().write(|w| w.set_key(Key::START));
    IWDG1.kr().write(|w| w.set_key(Key::ENABLE));
    IWDG1.pr().write(|w| w.set_pr(Pr::DIVIDE_BY256));
    IWDG1.rlr().write(|w| w.set_rl(0xfff));
    IWDG1.kr().write(|w| w.set_key(Key::RESET));
}

/// Why the chip was reset last. The flags are taken back.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ResetCause {
    /// The watchdog.
    pub watchdog: bool,
    /// The supply sagged; not that it came on, which sets the same flag and another.
    pub brown_out: bool,
    /// The supply came on.
    pub power_on: bool,
}

/// See [`ResetCause`].
pub fn reset_cause() -> ResetCause {
    let flags = RCC.rsr().read();
    RCC.rsr().modify(|w| w.set_rmvf(true));
    let power_on = flags.porrstf();
    ResetCause { watchdog: flags.iwdg1rstf(), brown_out: flags.borrstf() && !power_on, power_on }
}

#[interrupt]
unsafe fn PVD_AVD() {
    EXTI.pr(0).write(|w| w.set_line(LINE, true));
    IS_LOW.store(true, Ordering::Relaxed);
}
