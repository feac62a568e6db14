//! From reset to flight.

use super::boot::{Booted, Grounded, boot};
use super::camera::{Camera, Staging};
use super::gauge::Figures;
use super::led::State;
use super::life::TIMEOUT_US;
use super::port::{self, Clock, Eye};
use super::record::Reason;
use super::sensor::{self, NoSensor, Sensor};
use super::tasks::{self, LIFE, Notices};
use super::timing::{CAMERA_CLOCK_HZ, Square, prescaler, square};
use super::{capture, card, clocks, fault, gauge, link, logging, memory, mt9v034, servo, simulator, supply, usb};
use crate::app::Line;
use crate::journal::{Journal, NoJournal};
use crate::run::{self, Pending};
use core::fmt::Write as _;
use embassy_executor::Spawner;
use embassy_executor::raw::Executor;
use embassy_stm32::gpio::{Level, Output, OutputType, Speed};
use embassy_stm32::interrupt::{InterruptExt, Priority};
use embassy_stm32::peripherals::{DMA2_CH1, IWDG1};
use embassy_stm32::time::Hertz;
use embassy_stm32::timer::low_level::CountingMode;
use embassy_stm32::timer::simple_pwm::{PwmPin, SimplePwm};
use embassy_stm32::wdg::IndependentWatchdog;
use embassy_stm32::{Peri, Peripherals};
use mavlink::dialects::common::MavSeverity;
use static_cell::{ConstStaticCell, StaticCell};

static PENDING: Pending = Pending::new();
static EXECUTOR: StaticCell<Executor> = StaticCell::new();
static STAGING: ConstStaticCell<Staging> = ConstStaticCell::new([0; size_of::<Staging>() / 4]);

/// Starts the chip, reads the mission and flies for ever.
pub fn start() -> ! {
    // A bootloader may have left interrupts on; nothing of ours is ready for them.
    cortex_m::interrupt::disable();
    // SAFETY: first of all, before any function that lies there.
    unsafe { memory::fill_itcm() };
    // SAFETY: `start` runs once, and nobody else takes the core's peripherals.
    let mut core = unsafe { cortex_m::Peripherals::steal() };
    memory::set_vectors(&core.SCB);
    memory::protect(&core.MPU, &mut core.SCB, &mut core.CPUID);
    fault::enable(&mut core.SCB, &mut core.SYST);
    for (clear, pend) in core.NVIC.icer.iter().zip(&core.NVIC.icpr) {
        // SAFETY: takes back what a bootloader enabled.
        unsafe {
            clear.write(u32::MAX);
            pend.write(u32::MAX);
        }
    }
    gauge::start(&mut core.DCB, &mut core.DWT);
    supply::watch_boot();
    // SAFETY: every handler is in place.
    unsafe { cortex_m::interrupt::enable() };

    let (board, plan) = clocks::start();
    fault::open_backup();
    supply::start();
    defmt::info!("core at {} Hz", plan.core_hz());
    let executor = EXECUTOR.init(run::executor(&PENDING));
    let watchdog = start_tasks(executor.spawner(), board, (plan.core_hz(), plan.timer_hz()));
    prioritise();
    fly(executor, watchdog)
}

/// What latches instants (pulses, triggers, the rows' ends) interrupts everything else. Two levels: so at most two handlers
/// lie on the stack.
fn prioritise() {
    use embassy_stm32::interrupt as line;
    line::DMA1_STREAM0.set_priority(Priority::P4);
    line::DMA1_STREAM1.set_priority(Priority::P4);
    line::USART3.set_priority(Priority::P4);
    line::OTG_FS.set_priority(Priority::P4);
    line::SDMMC1.set_priority(Priority::P4);
    line::MDMA.set_priority(Priority::P4);
    line::TIM5.set_priority(Priority::P4);
    line::PVD_AVD.set_priority(Priority::P4);
}

/// Everything there is on the board, and its tasks.
#[inline(never)]
fn start_tasks(
    spawner: Spawner,
    board: Peripherals,
    (core_hz, timer_hz): (u32, u32),
) -> IndependentWatchdog<'static, IWDG1> {
    let cause = supply::reset_cause();
    if cause.watchdog {
        fault::note_watchdog();
    }
    let is_simulator = fault::take_simulator_wish();
    let record = fault::last().filter(|record| record.in_a_row > 0);
    let is_safe_state = record.is_some_and(|record| record.is_safe_state());
    let mut notices = Notices::new();
    if let Some(record) = record {
        let mut text = heapless::String::<50>::new();
        let _ = write!(text, "{record}");
        note(&mut notices, MavSeverity::MAV_SEVERITY_CRITICAL, &text);
    }
    if is_safe_state {
        note(&mut notices, MavSeverity::MAV_SEVERITY_CRITICAL, "safe state: no fixes for 30 s");
    }
    if cause.brown_out {
        note(&mut notices, MavSeverity::MAV_SEVERITY_WARNING, "camera: restarted after a brown-out");
    }
    if supply::brown_out_level() != supply::BROWN_OUT_WANTED {
        note(&mut notices, MavSeverity::MAV_SEVERITY_NOTICE, "camera: brown-out level is not 2.4 V");
    }

    // Both are exact for either plan of the clocks; see `timing`.
    let pins = prescaler(timer_hz).map(|prescaler| capture::start(board.PA5, board.PB4, prescaler));
    core::mem::forget(pins);
    if !capture::agree() {
        note(&mut notices, MavSeverity::MAV_SEVERITY_CRITICAL, "camera: TIM3 does not follow TIM2");
    }
    let lamps = [
        Output::new(board.PC0, Level::High, Speed::Low),
        Output::new(board.PC1, Level::High, Speed::Low),
        Output::new(board.PC2, Level::High, Speed::Low),
    ];
    let pwm = SimplePwm::new(
        board.TIM4,
        Some(PwmPin::new(board.PD12, OutputType::PushPull)),
        None,
        None,
        None,
        Hertz(servo::RATE_HZ),
        CountingMode::EdgeAlignedUp,
    );
    let line = link::start(link::Parts {
        usart: board.USART3,
        rx: board.PB11,
        tx: board.PB10,
        rx_dma: board.DMA1_CH0,
        tx_dma: board.DMA1_CH1,
    });
    let serial = usb::start(board.USB_OTG_FS, board.PA12, board.PA11);
    let sensor = sensor::Parts {
        i2c: board.I2C1,
        scl: board.PB8,
        sda: board.PB9,
        clock: board.PA8,
        reset: board.PA10,
        power: board.PD7,
    };
    let card = card::Parts {
        sdmmc: board.SDMMC1,
        clock: board.PC12,
        command: board.PD2,
        data: (board.PC8, board.PC9, board.PC10, board.PC11),
    };
    let dcmi = dcmi_pins!(
        (PC6, D0Pin), (PC7, D1Pin), (PE0, D2Pin), (PE1, D3Pin), (PE4, D4Pin), (PB6, D5Pin), (PE5, D6Pin),
        (PE6, D7Pin), (PA4, HSyncPin), (PB7, VSyncPin), (PA6, PixClkPin); board
    );
    core::mem::forget(dcmi);

    // Without an exact divider there is no camera either: the mission is refused, not flown.
    let wave = square(timer_hz, CAMERA_CLOCK_HZ).unwrap_or(Square { period: 2, high: 1, hz: 0 });
    if let Some(((line_in, line_out), (device, usb_in, usb_out))) = line.zip(serial) {
        spawn(spawner, tasks::usb_task(device));
        let (receiver, sender) = (port::Receiver::Link(line_in), port::Sender::Link(line_out));
        if is_simulator {
            tasks::show(State::Simulator);
            spawn(spawner, tasks::lamps_task(None, lamps));
            spawn(spawner, simulator::line_task(core_hz, usb_in, usb_out));
        } else {
            // The safe state leaves the card alone; and the stores, where reading them has led there.
            let log = if is_safe_state { None } else { logging::log() };
            let journal: &'static dyn Journal = log.map_or(&NoJournal, |log| log);
            let is_unreadable = is_safe_state && record.is_some_and(|record| record.reason == Reason::Bus);
            let booted = if is_unreadable { Err(Grounded::Unreadable) } else { boot(wave.hz, journal) };
            match booted {
                Ok(booted) => {
                    let app = booted.app;
                    if booted.blurs {
                        note(&mut notices, MavSeverity::MAV_SEVERITY_WARNING, "camera: exposure blurs beyond 0.5 px");
                    }
                    spawn(spawner, tasks::receive_task(app, receiver, Clock::Chip));
                    spawn(spawner, tasks::transmit_task(app, sender, Clock::Chip, Figures(None)));
                    spawn(spawner, tasks::beat_task(app, Clock::Chip));
                    spawn(spawner, tasks::latches_task(app, Clock::Chip));
                    spawn(spawner, tasks::servo_task(app, pwm));
                    spawn(spawner, tasks::lamps_task(Some(app), lamps));
                    spawn(spawner, tasks::notices_task(app, notices));
                    if let Some(log) = log {
                        spawn(spawner, logging::card_task(app, log, card));
                    }
                    spawn(spawner, tasks::hello_task(Some(app), usb_in));
                    spawn(spawner, eyes_task(spawner, booted, sensor, wave, board.DMA2_CH1, is_safe_state));
                    if is_safe_state {
                        tasks::show(State::Safe);
                    }
                }
                Err(grounded) => {
                    tasks::show(State::Grounded);
                    spawn(spawner, tasks::lamps_task(None, lamps));
                    spawn(spawner, tasks::grounded_task(receiver, sender, grounded.words(), notices));
                    spawn(spawner, tasks::hello_task(None, usb_in));
                }
            }
        }
    }
    let mut watchdog = IndependentWatchdog::new(board.IWDG1, TIMEOUT_US);
    watchdog.unleash();
    watchdog
}

/// Each task is spawned once, at boot: none can be refused.
fn spawn<S>(spawner: Spawner, task: Result<embassy_executor::SpawnToken<S>, embassy_executor::SpawnError>) {
    if let Ok(task) = task {
        spawner.spawn(task);
    }
}

fn note(notices: &mut Notices, severity: MavSeverity, text: &str) {
    let _ = notices.push((severity, Line::new(text)));
}

/// Wakes the sensor, then lets it see.
#[embassy_executor::task]
async fn eyes_task(
    spawner: Spawner,
    booted: Booted,
    parts: sensor::Parts,
    wave: Square,
    dma: Peri<'static, DMA2_CH1>,
    is_safe_state: bool,
) {
    let woken: Result<Sensor, NoSensor> = async {
        let mut sensor = Sensor::start(parts, wave).await?;
        sensor.set(&booted.setting).await?;
        Ok(sensor)
    }
    .await;
    let camera = Camera::new(dma, booted.frame, STAGING.take());
    match (woken, camera) {
        (Ok(sensor), Some(camera)) => {
            // Its pins keep their levels for ever.
            core::mem::forget(sensor);
            spawn(spawner, tasks::camera_task(booted.app, Eye::Chip(camera), Clock::Chip, Figures(None)));
            spawn(spawner, tasks::trigger_task(booted, is_safe_state));
        }
        (woken, _) => {
            tasks::show(State::NoSensor);
            let mut text = heapless::String::<50>::new();
            let _ = match woken.err() {
                Some(NoSensor::Bus) => write!(text, "no fixes: the sensor does not answer"),
                Some(NoSensor::Identity(mt9v034::CHIP_VERSION_MT9V032)) => {
                    write!(text, "no fixes: the sensor is an MT9V032")
                }
                Some(NoSensor::Identity(id)) => write!(text, "no fixes: the sensor calls itself {id:04x}"),
                Some(NoSensor::ReadBack(number)) => {
                    write!(text, "no fixes: sensor register {number:02x} does not hold")
                }
                Some(NoSensor::Setting(_)) | None => write!(text, "no fixes: no ring for such rows"),
            };
            booted.app.say(MavSeverity::MAV_SEVERITY_CRITICAL, Line::new(&text)).await;
        }
    }
}

/// Polls the tasks for ever, sleeps when there is nothing to do, and feeds the watchdog when all show life.
fn fly(executor: &'static Executor, mut watchdog: IndependentWatchdog<'static, IWDG1>) -> ! {
    loop {
        run::until_idle(executor, &PENDING);
        if LIFE.all() {
            watchdog.pet();
        }
        // Held off between the question and the sleep, which a pending interrupt ends: none slips through.
        cortex_m::interrupt::free(|_| {
            if !PENDING.is_set() {
                cortex_m::asm::dsb();
                cortex_m::asm::wfi();
            }
        });
    }
}
