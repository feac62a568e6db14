//! The trigger: TIM3 raises the sensor's line at a tick of the capture timer, whose lower half it counts, and each time a
//! frame is armed.

use super::capture::{latch, now, until};
use super::front_end::arm;
use crate::app::App;
use crate::h743::trigger::{Due, PULSE_US, due, widen};
use core::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use embassy_stm32::interrupt;
use embassy_stm32::pac::TIM3;
use embassy_stm32::pac::timer::vals::OcmGp;
use plumbline_core::stamp::{Edge, Polarity};
use plumbline_core::units::Ticks;

/// Whether the trigger's line is high.
static IS_HIGH: AtomicBool = AtomicBool::new(false);
/// Triggers so far: the frames' numbers.
static TRIGGERS: AtomicU32 = AtomicU32::new(0);
/// Whether the opening edge counts as rising in the configuration's settings.
static OPENS_RISING: AtomicBool = AtomicBool::new(true);

/// Exposures triggered since start.
pub fn triggers() -> u32 {
    TRIGGERS.load(Ordering::Relaxed)
}

/// Triggers exposures for ever: those that the application commits to where it has a plan, `interval_us` apart otherwise.
/// `opens_on`: what the configuration takes for the opening edge.
pub async fn trigger(app: &App<'_>, interval_us: u32, opens_on: Polarity) -> ! {
    OPENS_RISING.store(opens_on == Polarity::Rising, Ordering::Relaxed);
    TIM3.dier().write(|w| w.set_ccie(0, true));
    let is_planned = app.has_plan();
    let mut at = if is_planned { app.exposure().await } else { Ticks(now().0.wrapping_add(interval_us)) };
    loop {
        match due(now(), at, interval_us) {
            Due::Later(tick) => until(tick).await,
            // A planned one has its own place: it is missed, not made up for.
            Due::Missed(_) if is_planned => at = app.exposure().await,
            Due::Missed(next) => at = next,
            Due::Arm(compare) => {
                TIM3.ccr(0).write(|w| w.set_ccr(compare));
                TIM3.ccmr_output(0).write(|w| w.set_ocm(0, OcmGp::ACTIVE_ON_MATCH));
                let past = Ticks(at.0.wrapping_add(u32::from(PULSE_US) + 1000));
                until(past).await;
                at = if is_planned { app.exposure().await } else { Ticks(at.0.wrapping_add(interval_us)) };
            }
        }
    }
}

#[interrupt]
unsafe fn TIM3() {
    TIM3.sr().write(|w| {
        // Zero takes a flag back, one leaves it: all but ours.
        w.0 = !0;
        w.set_ccif(0, false);
    });
    let compare = TIM3.ccr(0).read().ccr();
    if IS_HIGH.swap(false, Ordering::Relaxed) {
        TIM3.ccmr_output(0).write(|w| w.set_ocm(0, OcmGp::FORCE_INACTIVE));
    } else if TIM3.ccmr_output(0).read().ocm(0) == OcmGp::ACTIVE_ON_MATCH {
        // A match of an earlier compare, while the new one is still ahead.
        if (now().0 as u16).wrapping_sub(compare) > 0x8000 {
            return;
        }
        TIM3.ccr(0).write(|w| w.set_ccr(compare.wrapping_add(PULSE_US)));
        TIM3.ccmr_output(0).write(|w| w.set_ocm(0, OcmGp::INACTIVE_ON_MATCH));
        IS_HIGH.store(true, Ordering::Relaxed);
        let sequence = TRIGGERS.fetch_add(1, Ordering::Relaxed);
        arm(sequence);
        let polarity = if OPENS_RISING.load(Ordering::Relaxed) { Polarity::Rising } else { Polarity::Falling };
        latch(Edge { at: widen(now(), compare), polarity });
    }
}
