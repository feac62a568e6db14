//! The capture timer: TIM2 counts microseconds in 32 bits and latches pulses per second; TIM3 counts the lower half with
//! it for the trigger ([`trigger`](super::trigger)).
//!
//! TIM3 starts by TIM2's start (its ITR1), with the same divider and clock, so it always shows TIM2's
//! lower half, off by the few timer clocks that the trigger takes. Nothing sets either afterwards.

use crate::board::Timer;
use embassy_stm32::gpio::{AfType, Flex, OutputType, Pull, Speed};
use embassy_stm32::interrupt::InterruptExt;
use embassy_stm32::pac::timer::vals::{CcmrInputCcs, FilterValue, Mms, OcmGp, Sms, Ts};
use embassy_stm32::pac::{TIM2, TIM3};
use embassy_stm32::peripherals::{PA5, PB4};
use embassy_stm32::timer::{Ch1, TimerPin};
use embassy_stm32::{Peri, interrupt, peripherals, rcc};
use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;
use embassy_sync::channel::Channel;
use embassy_sync::signal::Signal;
use plumbline_core::stamp::Edge;
use plumbline_core::units::Ticks;

static PULSE: Signal<CriticalSectionRawMutex, Ticks> = Signal::new();
static EDGES: Channel<CriticalSectionRawMutex, Edge, 4> = Channel::new();

/// The pins keep their function for ever.
#[allow(missing_debug_implementations, reason = "pins")]
pub struct Pins {
    _pulse: Flex<'static>,
    _trigger: Flex<'static>,
}

/// Starts both timers. `prescaler`: see [`timing::prescaler`](crate::h743::timing::prescaler).
pub fn start(pulse: Peri<'static, PA5>, trigger: Peri<'static, PB4>, prescaler: u16) -> Pins {
    rcc::enable_and_reset::<peripherals::TIM2>();
    rcc::enable_and_reset::<peripherals::TIM3>();
    let pulse_af = TimerPin::<peripherals::TIM2, Ch1>::af_num(&*pulse);
    let trigger_af = TimerPin::<peripherals::TIM3, Ch1>::af_num(&*trigger);
    let (mut pulse, mut trigger) = (Flex::new(pulse), Flex::new(trigger));

    // TIM3 first: it waits for TIM2.
    TIM3.psc().write_value(prescaler);
    TIM3.arr().write(|w| w.set_arr(u16::MAX));
    TIM3.ccmr_output(0).write(|w| w.set_ocm(0, OcmGp::FORCE_INACTIVE));
    TIM3.ccer().write(|w| w.set_cce(0, true));
    TIM3.egr().write(|w| w.set_ug(true));
    TIM3.sr().write(|_| ());
    TIM3.smcr().write(|w| {
        w.set_ts(Ts::ITR1);
        w.set_sms(Sms::TRIGGER_MODE);
    });
    TIM2.psc().write_value(prescaler);
    TIM2.arr().write_value(u32::MAX);
    TIM2.ccmr_input(0).write(|w| {
        w.set_ccs(0, CcmrInputCcs::TI4);
        // Eight clocks of the timer alike: 40 ns of noise are none.
        w.set_icf(0, FilterValue::FCK_INT_N8);
    });
    TIM2.ccer().write(|w| w.set_cce(0, true));
    // Before its update, which would be the trigger otherwise.
    TIM2.cr2().write(|w| w.set_mms(Mms::ENABLE));
    TIM2.egr().write(|w| w.set_ug(true));
    TIM2.sr().write(|_| ());
    TIM2.dier().write(|w| w.set_ccie(0, true));
    TIM2.cr1().write(|w| w.set_cen(true));

    pulse.set_as_af_unchecked(pulse_af, AfType::input(Pull::Down));
    trigger.set_as_af_unchecked(trigger_af, AfType::output(OutputType::PushPull, Speed::Medium));
    // SAFETY: the handlers below are in place.
    unsafe {
        interrupt::TIM2.enable();
        interrupt::TIM3.enable();
    }
    Pins { _pulse: pulse, _trigger: trigger }
}

/// Whether both timers count as one: else no trigger's tick is known.
pub fn agree() -> bool {
    // Read around each other: an interrupt or a tick in between shows as a difference of more than one, and is tried again.
    (0..8).any(|_| {
        let before = TIM2.cnt().read() as u16;
        let lower = TIM3.cnt().read().cnt();
        lower.wrapping_sub(before) <= 1
    })
}

/// Now.
pub fn now() -> Ticks {
    Ticks(TIM2.cnt().read())
}

/// Takes an edge of the trigger's line. A full queue means that the application stands still: it will find the edge missing.
pub(super) fn latch(edge: Edge) {
    let _ = EDGES.try_send(edge);
}

/// Waits until the timer has passed `at`.
pub(super) async fn until(at: Ticks) {
    loop {
        let left = at.since(now());
        if left <= 0 {
            return;
        }
        embassy_time::Timer::after_micros(left as u64).await;
    }
}

#[interrupt]
unsafe fn TIM2() {
    // Reading CCR1 takes the flag back.
    if TIM2.sr().read().ccif(0) {
        PULSE.signal(Ticks(TIM2.ccr(0).read()));
    }
}

/// The capture timer as the application sees it.
#[derive(Clone, Copy, Debug, Default)]
pub struct CaptureTimer;

impl Timer for CaptureTimer {
    fn now(&self) -> Ticks {
        now()
    }

    async fn until(&mut self, at: Ticks) {
        until(at).await;
    }

    async fn pulse(&mut self) -> Ticks {
        PULSE.wait().await
    }

    async fn edge(&mut self) -> Edge {
        EDGES.receive().await
    }
}
