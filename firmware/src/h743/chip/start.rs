//! From reset to flight.

use super::flight::{Vehicle, notice, spawn, start_flight};
use super::tasks::{self, Notices};
use super::watchdog::LIFE;
use super::{capture, card, clocks, counters, fault, kept, link, memory, sensor, simulator, supply, usb};
use crate::h743::led::Indication;
use crate::h743::life::TIMEOUT_US;
use crate::h743::record::Record;
use crate::h743::servo;
use crate::h743::timing::{CAMERA_CLOCK_HZ, Square, prescaler, square};
use crate::run::{self, Pending};
use core::fmt::Write as _;
use embassy_executor::Spawner;
use embassy_executor::raw::Executor;
use embassy_stm32::gpio::{Level, Output, OutputType, Speed};
use embassy_stm32::interrupt::{InterruptExt, Priority};
use embassy_stm32::peripherals::IWDG1;
use embassy_stm32::time::Hertz;
use embassy_stm32::timer::low_level::CountingMode;
use embassy_stm32::timer::simple_pwm::{PwmPin, SimplePwm};
use embassy_stm32::wdg::IndependentWatchdog;
use embassy_stm32::{Peri, Peripherals};
use mavlink::dialects::common::MavSeverity;
use static_cell::StaticCell;

static PENDING: Pending = Pending::new();
static EXECUTOR: StaticCell<Executor> = StaticCell::new();

/// Starts the chip, reads the configuration and flies for ever.
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
    counters::start(&mut core.DCB, &mut core.DWT);
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
    kept::begin(cause.power_on);
    let is_simulator = fault::take_simulator_wish();
    let record = fault::last().filter(|record| record.in_a_row > 0);
    let mut notices = notices(record.as_ref(), cause);

    let (taken, watchdog) = peripherals(board, timer_hz, &mut notices);
    if let Some((vehicle, device, usb_out)) = taken {
        spawn(spawner, tasks::usb_task(device));
        if is_simulator {
            tasks::show(Indication::Simulator);
            spawn(spawner, tasks::lamps_task(None, vehicle.lamps));
            spawn(spawner, simulator::line_task(core_hz, vehicle.usb_in, usb_out));
        } else {
            start_flight(spawner, vehicle, notices, record);
        }
    }
    let mut watchdog = IndependentWatchdog::new(watchdog, TIMEOUT_US);
    watchdog.unleash();
    watchdog
}

/// The peripherals by their use: those of the vehicle with USB's device and its sender, if link and USB start, and the
/// watchdog's.
// Inlined, since the drivers are large and their copies would lie on the stack.
#[inline(always)]
fn peripherals(
    board: Peripherals,
    timer_hz: u32,
    notices: &mut Notices,
) -> (Option<(Vehicle, usb::Device, usb::UsbWriter)>, Peri<'static, IWDG1>) {
    // Both are exact for either plan of the clocks; see `timing`.
    let pins = prescaler(timer_hz).map(|prescaler| capture::start(board.PA5, board.PB4, prescaler));
    core::mem::forget(pins);
    if !capture::agree() {
        notice(notices, MavSeverity::MAV_SEVERITY_CRITICAL, "camera: TIM3 does not follow TIM2");
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

    // Without an exact divider there is no camera either: the configuration is refused, not flown.
    let wave = square(timer_hz, CAMERA_CLOCK_HZ).unwrap_or(Square { period: 2, high: 1, hz: 0 });
    let taken = line.zip(serial).map(|(line, (device, usb_in, usb_out))| {
        (Vehicle { line, usb_in, lamps, pwm, card, sensor, dma: board.DMA2_CH1, wave }, device, usb_out)
    });
    (taken, board.IWDG1)
}

/// What there is to report of the start.
fn notices(record: Option<&Record>, cause: supply::ResetCause) -> Notices {
    let mut notices = Notices::new();
    if let Some(record) = record {
        let mut text = heapless::String::<50>::new();
        let _ = write!(text, "{record}");
        notice(&mut notices, MavSeverity::MAV_SEVERITY_CRITICAL, &text);
    }
    if record.is_some_and(Record::is_safe_state) {
        notice(&mut notices, MavSeverity::MAV_SEVERITY_CRITICAL, "safe state: no fixes for 30 s");
    }
    if cause.brown_out {
        notice(&mut notices, MavSeverity::MAV_SEVERITY_WARNING, "camera: restarted after a brown-out");
    }
    if supply::brown_out_level() != supply::BROWN_OUT_WANTED {
        notice(&mut notices, MavSeverity::MAV_SEVERITY_NOTICE, "camera: brown-out level is not 2.4 V");
    }
    notices
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
