//! The MT9V034 on its bus: power, clock, identity, settings.

use crate::h743::mt9v034::{ADDRESS, CHIP_VERSION, SensorError, Setting, Write, register};
use crate::h743::timing::Square;
use embassy_stm32::gpio::{AfType, Flex, Level, Output, OutputType, Speed};
use embassy_stm32::i2c::{self, I2c, Master};
use embassy_stm32::mode::Blocking;
use embassy_stm32::pac::TIM1;
use embassy_stm32::pac::timer::vals::OcmGp;
use embassy_stm32::peripherals::{I2C1, PA8, PA10, PB8, PB9, PD7};
use embassy_stm32::time::Hertz;
use embassy_stm32::timer::{Ch1, TimerPin};
use embassy_stm32::{Peri, peripherals, rcc};
use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;
use embassy_sync::signal::Signal;
use embassy_time::Timer;

/// The exposure that the sensor is to have from now on.
static EXPOSURE: Signal<CriticalSectionRawMutex, Setting> = Signal::new();
/// How often a write of the exposure is tried: a bus that is disturbed once has recovered by then.
const TRIES: u32 = 3;

/// Has the sensor expose as `setting` says; returns at once.
pub fn expose(setting: Setting) {
    EXPOSURE.signal(setting);
}

/// Why there is no sensor.
#[derive(Clone, Copy, Debug, PartialEq, Eq, defmt::Format)]
pub enum NoSensor {
    /// It does not answer.
    Bus,
    /// It is another one: what it calls itself.
    Identity(u16),
    /// What is asked of it.
    Setting(SensorError),
    /// A register does not read back as written: which.
    ReadBack(u8),
}

/// What the sensor hangs on.
#[allow(missing_debug_implementations, reason = "pins")]
pub struct Parts {
    /// Bus.
    pub i2c: Peri<'static, I2C1>,
    /// Its clock.
    pub scl: Peri<'static, PB8>,
    /// Its data.
    pub sda: Peri<'static, PB9>,
    /// The sensor's clock, by TIM1.
    pub clock: Peri<'static, PA8>,
    /// Reset, low.
    pub reset: Peri<'static, PA10>,
    /// Power down, high.
    pub power: Peri<'static, PD7>,
}

/// The sensor, running.
#[allow(missing_debug_implementations, reason = "a driver")]
pub struct Sensor {
    bus: I2c<'static, Blocking, Master>,
    _pins: (Flex<'static>, Output<'static>, Output<'static>),
}

impl Sensor {
    /// Powers the sensor, clocks it and asks who it is.
    ///
    /// # Errors
    /// [`NoSensor`].
    pub async fn start(parts: Parts, square: Square) -> Result<Sensor, NoSensor> {
        let mut reset = Output::new(parts.reset, Level::Low, Speed::Low);
        let power = Output::new(parts.power, Level::Low, Speed::Low);
        let clock = start_clock(parts.clock, square);
        // 20 clocks of reset are asked for, and as many before the first access: a tenth of a millisecond is plenty.
        Timer::after_millis(10).await;
        reset.set_high();
        Timer::after_millis(10).await;
        let mut config = i2c::Config::default();
        config.frequency = Hertz(100_000);
        config.timeout = embassy_time::Duration::from_millis(20);
        let bus = I2c::new_blocking(parts.i2c, parts.scl, parts.sda, config);
        let mut sensor = Sensor { bus, _pins: (clock, reset, power) };
        match sensor.read(register::CHIP_VERSION)? {
            CHIP_VERSION => Ok(sensor),
            other => Err(NoSensor::Identity(other)),
        }
    }

    /// Writes `setting`, and checks that it stands.
    ///
    /// # Errors
    /// [`NoSensor`].
    pub async fn set(&mut self, setting: &Setting) -> Result<(), NoSensor> {
        self.write((register::RESET, 1))?;
        Timer::after_millis(1).await;
        for write in setting.writes().into_iter().chain([Setting::automatic()]) {
            self.write(write)?;
        }
        for (number, value) in setting.writes() {
            if self.read(number)? != value {
                return Err(NoSensor::ReadBack(number));
            }
        }
        Ok(())
    }

    /// Writes the exposures that are asked for, for ever: some 0.8 ms of the bus each, between two frames, as nothing is
    /// asked for otherwise.
    pub async fn follow(mut self) -> ! {
        loop {
            let writes = EXPOSURE.wait().await.exposure_writes();
            let is_written = writes.into_iter().all(|write| (0..TRIES).any(|_| self.write(write).is_ok()));
            if !is_written {
                defmt::warn!("the sensor does not take its exposure");
            }
        }
    }

    fn write(&mut self, (number, value): Write) -> Result<(), NoSensor> {
        let [high, low] = value.to_be_bytes();
        self.bus.blocking_write(ADDRESS, &[number, high, low]).map_err(|_| NoSensor::Bus)
    }

    fn read(&mut self, number: u8) -> Result<u16, NoSensor> {
        let mut value = [0; 2];
        self.bus.blocking_write_read(ADDRESS, &[number], &mut value).map_err(|_| NoSensor::Bus)?;
        Ok(u16::from_be_bytes(value))
    }
}

/// The sensor's clock: TIM1 runs it from now on by itself.
fn start_clock(pin: Peri<'static, PA8>, square: Square) -> Flex<'static> {
    rcc::enable_and_reset::<peripherals::TIM1>();
    let af = TimerPin::<peripherals::TIM1, Ch1>::af_num(&*pin);
    let mut pin = Flex::new(pin);
    TIM1.psc().write_value(0);
    TIM1.arr().write(|w| w.set_arr(square.period - 1));
    TIM1.ccr(0).write(|w| w.set_ccr(square.high));
    TIM1.ccmr_output(0).write(|w| w.set_ocm(0, OcmGp::PWM_MODE1));
    TIM1.ccer().write(|w| w.set_cce(0, true));
    TIM1.bdtr().write(|w| w.set_moe(true));
    TIM1.egr().write(|w| w.set_ug(true));
    TIM1.cr1().write(|w| w.set_cen(true));
    pin.set_as_af_unchecked(af, AfType::output(OutputType::PushPull, Speed::VeryHigh));
    pin
}
