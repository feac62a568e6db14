//! The board's tasks: the application's, and those of lamps, servo, trigger, USB and notices.
//!
//! Each is polled with a companion that marks its life for the watchdog.

use super::boot::Booted;
use super::capture::{self, CaptureTimer};
use super::port::{BoardReader, BoardWriter, Mode};
use super::watchdog::watched;
use super::{fault, front_end, kept, supply, trigger, usb};
use crate::app::{App, Line, grounded};
use crate::board::Reader;
use crate::h743::hello::{Listener, may_leave};
use crate::h743::led::{Indication, lamps};
use crate::h743::life::BoardTask;
use crate::h743::record::{GOOD_S, SAFE_S};
use crate::h743::servo::pulse_us;
use crate::h743::silence::{Change, Counts, Silence};
use crate::wire::signing::Signing;
use core::cell::Cell;
use embassy_futures::join::join;
use embassy_stm32::gpio::Output;
use embassy_stm32::peripherals::TIM4;
use embassy_stm32::timer::simple_pwm::SimplePwm;
use embassy_sync::blocking_mutex::Mutex;
use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;
use embassy_time::Timer;
use heapless::Vec;
use mavlink::dialects::common::MavSeverity;

/// What the lamps say.
static STATE: Mutex<CriticalSectionRawMutex, Cell<Indication>> = Mutex::new(Cell::new(Indication::Searching));

/// Lines that are sent when somebody listens.
pub type Notices = Vec<(MavSeverity, Line), 6>;

/// From exposure to exposure, microseconds.
const INTERVAL_US: u32 = 50_000;

crate::application_tasks!(crate::embassy_tasks, Mode);

/// Exposures, by the plan if there is one; after faults in a row only when the safe state has passed.
#[embassy_executor::task]
pub async fn trigger_task(booted: Booted, is_safe_state: bool) -> ! {
    let work = async {
        if is_safe_state {
            Timer::after_secs(SAFE_S.into()).await;
            show(Indication::Searching);
        }
        trigger::trigger(booted.app, INTERVAL_US, booted.opens_on).await
    };
    watched(BoardTask::Trigger, work).await
}

/// The follow-up axis, as often as its servo takes a pulse.
#[embassy_executor::task]
pub async fn servo_task(app: &'static App<'static>, mut pwm: SimplePwm<'static, TIM4>) -> ! {
    let period_us = 1_000_000 / crate::h743::servo::RATE_HZ;
    pwm.ch1().enable();
    let work = async {
        loop {
            let us = app.servo().map_or(crate::h743::servo::MIDDLE_US, pulse_us);
            pwm.ch1().set_duty_cycle_fraction(us.into(), period_us);
            Timer::after_micros(period_us.into()).await;
        }
    };
    watched(BoardTask::Servo, work).await
}

/// The lamps; beside them, what is kept over a reset, and after good running, what went before is forgiven.
#[embassy_executor::task]
pub async fn lamps_task(app: Option<&'static App<'static>>, mut pins: [Output<'static>; 3]) -> ! {
    let work = async {
        let (mut fixes, mut since_fix, mut ms) = (0, u32::MAX, 0u32);
        loop {
            if let Some(app) = app {
                since_fix = if app.fixes() == fixes { since_fix.saturating_add(1) } else { 0 };
                fixes = app.fixes();
                kept::keep(app);
            }
            let state = match (STATE.lock(Cell::get), app) {
                (Indication::Searching, Some(app)) if !app.is_tied(capture::now()) => Indication::NoClock,
                (Indication::Searching, Some(_)) if since_fix < 40 => Indication::Fixing,
                (state, _) => state,
            };
            // The lamps are on when their pins are low.
            for (pin, is_on) in pins.iter_mut().zip(lamps(state, ms)) {
                pin.set_level((!is_on).into());
            }
            if ms == GOOD_S * 1000 {
                fault::forgive();
            }
            ms = ms.wrapping_add(25);
            Timer::after_millis(25).await;
        }
    };
    watched(BoardTask::Lamps, work).await
}

/// What the lamps show from now on.
pub fn show(indication: Indication) {
    STATE.lock(|cell| cell.set(indication));
}

/// The USB device.
#[embassy_executor::task]
pub async fn usb_task(mut device: usb::Device) -> ! {
    watched(BoardTask::Usb, device.run()).await
}

/// Listens for the simulator.
#[embassy_executor::task]
pub async fn hello_task(app: Option<&'static App<'static>>, mut line: usb::UsbReader) -> ! {
    let work = async {
        let mut listener = Listener::default();
        let mut buffer = [0; usb::PACKET];
        loop {
            let count = line.read(&mut buffer).await;
            let heard = listener.hear(buffer.get(..count).unwrap_or(&[]));
            if heard && may_leave(kept::has_been_armed(app), app.and_then(App::armed)) {
                fault::restart_as_simulator();
            }
        }
    };
    watched(BoardTask::Hello, work).await
}

/// Sends these lines once the autopilot is heard, or after ten seconds; then a supply that runs low, and a sensor
/// that falls silent or comes back.
#[embassy_executor::task]
pub async fn notices_task(app: &'static App<'static>, notices: Notices) -> ! {
    let work = async {
        for _ in 0..20 {
            if app.armed().is_some() {
                break;
            }
            Timer::after_millis(500).await;
        }
        for (severity, line) in notices {
            app.say(severity, line).await;
        }
        let (mut silence, mut is_low_told, mut is_full_told) = (Silence::default(), false, false);
        loop {
            let (triggers, frames) = (trigger::triggers(), front_end::frames());
            let counts = Counts { triggers, frames, answered: front_end::answered() };
            match silence.check(capture::now(), counts) {
                Some(Change::Silent) => {
                    show(Indication::NoSensor);
                    app.say(MavSeverity::MAV_SEVERITY_CRITICAL, Line::new("no fixes: no frames from the sensor")).await;
                }
                Some(Change::Back) => {
                    show(Indication::Searching);
                    app.say(MavSeverity::MAV_SEVERITY_NOTICE, Line::new("camera: the sensor delivers again")).await;
                }
                None => {}
            }
            if kept::is_full() && !is_full_told {
                is_full_told = true;
                app.say(MavSeverity::MAV_SEVERITY_WARNING, Line::new("signing: flash takes no more of its time")).await;
            }
            if supply::was_low() && !is_low_told {
                is_low_told = true;
                app.say(MavSeverity::MAV_SEVERITY_CRITICAL, Line::new("camera: supply was below 2.7 V")).await;
            }
            Timer::after_millis(250).await;
        }
    };
    watched(BoardTask::Notices, work).await
}

/// No application: heartbeats, and why.
#[embassy_executor::task]
pub async fn grounded_task(
    mut line_in: BoardReader,
    mut line_out: BoardWriter,
    reason: [&'static str; 2],
    notices: Notices,
    signing: Option<Signing>,
) -> ! {
    let mut timer = CaptureTimer;
    let reporting = grounded::report(reason, &notices, signing, &mut line_out, &mut timer);
    watched(BoardTask::Grounded, join(grounded::drain(&mut line_in), reporting)).await.0
}
