//! The chip's clocks, as [`timing`](crate::h743::timing) plans them, by embassy's driver.

use crate::h743::timing::{HSE_HZ, Plan};
use embassy_stm32::pac;
use embassy_stm32::rcc::{
    AHBPrescaler, APBPrescaler, Hse, HseMode, Hsi48Config, Pll, PllDiv, PllMul, PllPreDiv, PllSource, Sysclk,
    VoltageScale, mux,
};
use embassy_stm32::time::Hertz;
use embassy_stm32::{Config, Peripherals};

/// Starts the clocks and every peripheral's reset state; what they came to.
///
/// Supply by the LDO, which is embassy's setting for this chip. USB has the 48 MHz oscillator, which it trims by the
/// host's frames; the card has PLL1's second output.
pub fn start() -> (Peripherals, Plan) {
    let plan = Plan::for_revision(pac::DBGMCU.idc().read().rev_id());
    let mut config = Config::default();
    let rcc = &mut config.rcc;
    rcc.hse = Some(Hse { freq: Hertz(HSE_HZ), mode: HseMode::Oscillator });
    rcc.hsi48 = Some(Hsi48Config { sync_from_usb: true });
    rcc.pll1 = Some(Pll {
        source: PllSource::HSE,
        prediv: PllPreDiv::from_bits(plan.m as u8),
        mul: PllMul::from_bits(plan.n - 1),
        fracn: None,
        divp: Some(PllDiv::from_bits(plan.p as u8 - 1)),
        divq: Some(PllDiv::from_bits(plan.q as u8 - 1)),
        divr: None,
    });
    rcc.sys = Sysclk::PLL1_P;
    rcc.ahb_pre = AHBPrescaler::DIV2;
    (rcc.apb1_pre, rcc.apb2_pre) = (APBPrescaler::DIV2, APBPrescaler::DIV2);
    (rcc.apb3_pre, rcc.apb4_pre) = (APBPrescaler::DIV2, APBPrescaler::DIV2);
    rcc.voltage_scale = if plan.is_overdriven { VoltageScale::Scale0 } else { VoltageScale::Scale1 };
    rcc.mux.usbsel = mux::Usbsel::HSI48;
    rcc.mux.sdmmcsel = mux::Sdmmcsel::PLL1_Q;
    let peripherals = embassy_stm32::init(config);
    pac::RCC.ahb2enr().modify(|w| {
        // Off after a reset; embassy leaves them so.
        w.set_sram1en(true);
        w.set_sram2en(true);
        w.set_sram3en(true);
    });
    // A crystal that fails becomes a non-maskable interrupt.
    pac::RCC.cr().modify(|w| w.set_hsecsson(true));
    (peripherals, plan)
}
