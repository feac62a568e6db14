//! The board's tasks: the application's, and those of lamps, servo, trigger, USB and notices.
//!
//! Each is polled with a companion that marks its life for the watchdog.

use super::boot::Booted;
use super::capture::{self, CaptureTimer};
use super::gauge::Figures;
use super::port::{self, Clock, Eye};
use super::{camera as eye, fault, supply, usb};
use crate::app::{App, Line, beat, camera, edges, grounded, receive, transmit};
use crate::board::Reader;
use crate::h743::hello::{Listener, may_leave};
use crate::h743::led::{State, lamps};
use crate::h743::life::{Life, MARK_MS};
use crate::h743::record::{GOOD_S, SAFE_S};
use crate::h743::servo::pulse_us;
use crate::h743::silence::{Change, Silence};
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

/// Who lives.
pub static LIFE: Life = Life::new();
/// What the lamps say.
static STATE: Mutex<CriticalSectionRawMutex, Cell<State>> = Mutex::new(Cell::new(State::Searching));

/// Lines that are told when somebody listens.
pub type Notices = Vec<(MavSeverity, Line), 6>;

/// From exposure to exposure, microseconds.
const INTERVAL_US: u32 = 50_000;

/// Runs a task with its mark.
pub fn alive<T>(task: u8, work: impl Future<Output = T>) -> impl Future<Output = T> {
    marked(task, true, work)
}

/// The same for the application's tasks, but for the simulator's mode: there they work when they are told to, and the line
/// shows life.
fn living<T>(task: u8, clock: Clock, work: impl Future<Output = T>) -> impl Future<Output = T> {
    marked(task, matches!(clock, Clock::Chip), work)
}

async fn marked<T>(task: u8, is_expected: bool, work: impl Future<Output = T>) -> T {
    if is_expected {
        LIFE.expect(task);
    }
    let marks = async {
        if is_expected {
            loop {
                LIFE.mark(task);
                Timer::after_millis(MARK_MS).await;
            }
        }
    };
    join(work, marks).await.0
}

/// Bytes in.
#[embassy_executor::task]
pub async fn receive_task(app: &'static App<'static>, mut line: port::Receiver, clock: Clock) -> ! {
    living(0, clock, receive::receive(app, &mut line, &clock)).await
}

/// Frames.
#[embassy_executor::task]
pub async fn camera_task(app: &'static App<'static>, mut front_end: Eye, clock: Clock, figures: Figures) -> ! {
    living(1, clock, camera::camera(app, &mut front_end, &clock, &figures)).await
}

/// Bytes out.
#[embassy_executor::task]
pub async fn transmit_task(app: &'static App<'static>, mut line: port::Sender, clock: Clock, figures: Figures) -> ! {
    living(2, clock, transmit::transmit(app, &mut line, &clock, &figures)).await
}

/// What happens by the clock.
#[embassy_executor::task]
pub async fn beat_task(app: &'static App<'static>, mut clock: Clock) -> ! {
    living(3, clock, beat::beat(app, &mut clock)).await
}

/// Pulses and edges.
#[embassy_executor::task]
pub async fn latches_task(app: &'static App<'static>, clock: Clock) -> ! {
    let (mut pulse_timer, mut edge_timer) = (clock, clock);
    living(4, clock, join(edges::pulses(app, &mut pulse_timer), edges::edges(app, &mut edge_timer))).await.0
}

/// Exposures, by the plan if there is one; after faults in a row only when the safe state has passed.
#[embassy_executor::task]
pub async fn trigger_task(booted: Booted, is_safe_state: bool) -> ! {
    let work = async {
        if is_safe_state {
            Timer::after_secs(SAFE_S.into()).await;
            show(State::Searching);
        }
        capture::trigger(booted.app, INTERVAL_US, booted.opens_on).await
    };
    alive(5, work).await
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
    alive(6, work).await
}

/// The lamps; and after good running, what went before is forgiven.
#[embassy_executor::task]
pub async fn lamps_task(app: Option<&'static App<'static>>, mut pins: [Output<'static>; 3]) -> ! {
    let work = async {
        let (mut fixes, mut since_fix, mut ms) = (0, u32::MAX, 0u32);
        loop {
            if let Some(app) = app {
                since_fix = if app.fixes() == fixes { since_fix.saturating_add(1) } else { 0 };
                fixes = app.fixes();
            }
            let state = match (STATE.lock(Cell::get), app) {
                (State::Searching, Some(app)) if !app.is_tied(capture::now()) => State::NoClock,
                (State::Searching, Some(_)) if since_fix < 40 => State::Fixing,
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
    alive(7, work).await
}

/// What the lamps show from now on.
pub fn show(state: State) {
    STATE.lock(|cell| cell.set(state));
}

/// The USB device.
#[embassy_executor::task]
pub async fn usb_task(mut device: usb::Device) -> ! {
    alive(8, device.run()).await
}

/// Listens for the simulator.
#[embassy_executor::task]
pub async fn hello_task(app: Option<&'static App<'static>>, mut line: usb::Receiver) -> ! {
    let work = async {
        let mut listener = Listener::default();
        let mut buffer = [0; usb::PACKET];
        loop {
            let count = line.read(&mut buffer).await;
            let heard = listener.hear(buffer.get(..count).unwrap_or(&[]));
            if heard && may_leave(app.and_then(App::armed)) {
                fault::restart_as_simulator();
            }
        }
    };
    alive(9, work).await
}

/// Tells what there is to tell once the autopilot is heard, or after ten seconds; then a supply that runs low, and a sensor
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
        let (mut silence, mut is_low_told) = (Silence::default(), false);
        loop {
            match silence.look(capture::triggers(), eye::frames()) {
                Some(Change::Silent) => {
                    show(State::NoSensor);
                    app.say(MavSeverity::MAV_SEVERITY_CRITICAL, Line::new("no fixes: no frames from the sensor")).await;
                }
                Some(Change::Back) => {
                    show(State::Searching);
                    app.say(MavSeverity::MAV_SEVERITY_NOTICE, Line::new("camera: the sensor delivers again")).await;
                }
                None => {}
            }
            if supply::was_low() && !is_low_told {
                is_low_told = true;
                app.say(MavSeverity::MAV_SEVERITY_CRITICAL, Line::new("camera: supply was below 2.7 V")).await;
            }
            Timer::after_millis(250).await;
        }
    };
    alive(10, work).await
}

/// No application: heartbeats, and why.
#[embassy_executor::task]
pub async fn grounded_task(
    mut line_in: port::Receiver,
    mut line_out: port::Sender,
    reason: [&'static str; 2],
    notices: Notices,
) -> ! {
    let mut timer = CaptureTimer;
    let telling = grounded::tell(reason, &notices, &mut line_out, &mut timer);
    alive(11, join(grounded::drain(&mut line_in), telling)).await.0
}
