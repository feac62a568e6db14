//! A flight's tasks, from what lies in flash to frames.

use super::boot::{Booted, Grounded, boot};
use super::counters::ChipCounters;
use super::front_end::{DcmiFrontEnd, Staging};
use super::port::{self, BoardFrontEnd, BoardReader, BoardTimer, BoardWriter, Mode};
use super::sensor::{self, NoSensor, Sensor};
use super::tasks::{self, Notices};
use super::{card, kept, link, logging, usb};
use crate::app::Line;
use crate::board::Parts;
use crate::h743::led::Indication;
use crate::h743::mt9v034;
use crate::h743::record::{Reason, Record};
use crate::h743::timing::Square;
use crate::journal::{Journal, NoJournal};
use core::fmt::Write as _;
use embassy_executor::Spawner;
use embassy_stm32::Peri;
use embassy_stm32::gpio::Output;
use embassy_stm32::peripherals::{DMA2_CH1, TIM4};
use embassy_stm32::timer::simple_pwm::SimplePwm;
use mavlink::dialects::common::MavSeverity;
use static_cell::ConstStaticCell;

static STAGING: ConstStaticCell<Staging> = ConstStaticCell::new([0; size_of::<Staging>() / 4]);

/// What a flight takes of the board.
#[allow(missing_debug_implementations, reason = "drivers")]
pub struct Vehicle {
    /// The autopilot's link.
    pub line: (link::LinkReader, link::LinkWriter),
    /// Where the simulator's hello may come from.
    pub usb_in: usb::UsbReader,
    /// Red, green, blue.
    pub lamps: [Output<'static>; 3],
    /// The servo's pulses.
    pub pwm: SimplePwm<'static, TIM4>,
    /// The card's pins.
    pub card: card::Parts,
    /// What the sensor hangs on.
    pub sensor: sensor::Parts,
    /// Moves its rows.
    pub dma: Peri<'static, DMA2_CH1>,
    /// Its clock.
    pub wave: Square,
}

/// The tasks of a flight, or of a board that stays on the ground since its stores were refused.
pub fn start_flight(spawner: Spawner, vehicle: Vehicle, mut notices: Notices, record: Option<Record>) {
    let Vehicle { line: (line_in, line_out), usb_in, lamps, pwm, card, sensor, dma, wave } = vehicle;
    let (reader, writer) = (BoardReader::Link(line_in), BoardWriter::Link(line_out));
    let is_safe_state = record.as_ref().is_some_and(Record::is_safe_state);
    // The safe state leaves the card alone; and the stores, where reading them has led there.
    let log = if is_safe_state { None } else { logging::log() };
    let journal: &'static dyn Journal = log.map_or(&NoJournal, |log| log);
    let is_unreadable = is_safe_state && record.is_some_and(|record| record.reason == Reason::Bus);
    let signing = if is_unreadable { Err(Grounded::Unreadable) } else { kept::signing().map_err(Grounded::Stores) };
    // What a board says that stays on the ground is signed too.
    let known = signing.clone().ok().flatten();
    let booted = match signing.and_then(|signing| boot(wave.hz, signing, journal)) {
        Ok(booted) => booted,
        Err(grounded) => {
            tasks::show(Indication::Grounded);
            spawn(spawner, tasks::lamps_task(None, lamps));
            spawn(spawner, tasks::grounded_task(reader, writer, grounded.words(), notices, known));
            spawn(spawner, tasks::hello_task(None, usb_in));
            return;
        }
    };
    let app = booted.app;
    if booted.blurs {
        notice(&mut notices, MavSeverity::MAV_SEVERITY_WARNING, "camera: exposure blurs beyond 0.5 px");
    }
    if is_safe_state {
        tasks::show(Indication::Safe);
    }
    let (timer, counters) = (BoardTimer::Chip, ChipCounters(None));
    let parts = Parts { board: Mode::Flight, front_end: BoardFrontEnd::Chip(None), reader, writer, timer, counters };
    tasks::spawn_application(spawner, app, parts);
    spawn(spawner, tasks::servo_task(app, pwm));
    spawn(spawner, tasks::lamps_task(Some(app), lamps));
    spawn(spawner, tasks::notices_task(app, notices));
    if let Some(log) = log {
        spawn(spawner, logging::card_task(app, log, card));
    }
    spawn(spawner, tasks::hello_task(Some(app), usb_in));
    spawn(spawner, front_end_task(spawner, booted, sensor, wave, dma, is_safe_state));
}

/// Each task is spawned once, at boot: none can be refused.
pub fn spawn<S>(spawner: Spawner, task: Result<embassy_executor::SpawnToken<S>, embassy_executor::SpawnError>) {
    if let Ok(task) = task {
        spawner.spawn(task);
    }
}

/// Adds a line to be sent.
pub fn notice(notices: &mut Notices, severity: MavSeverity, text: &str) {
    let _ = notices.push((severity, Line::new(text)));
}

/// Wakes the sensor, then lets it see.
#[embassy_executor::task]
async fn front_end_task(
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
    let front_end = DcmiFrontEnd::new(dma, (booted.frame, booted.setting, wave.hz), STAGING.take());
    match (woken, front_end) {
        (Ok(sensor), Some(front_end)) => {
            port::awake(front_end);
            spawn(spawner, tasks::trigger_task(booted, is_safe_state));
            // It is never dropped: its pins keep their levels.
            sensor.follow().await;
        }
        (woken, _) => {
            tasks::show(Indication::NoSensor);
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
