//! The camera interface's pins: alternate functions from embassy's table of the chip, by the trait of each signal.

/// Gives each pin its function at the camera interface; the pins must be kept.
macro_rules! dcmi_pins {
    ($(($pin:ident, $signal:ident)),+ ; $board:ident) => {
        ($({
            use embassy_stm32::gpio::{AfType, Flex, Pull};
            let number = embassy_stm32::dcmi::$signal::<embassy_stm32::peripherals::DCMI>::af_num(&*$board.$pin);
            let mut pin = Flex::new($board.$pin);
            pin.set_as_af_unchecked(number, AfType::input(Pull::None));
            pin
        }),+)
    };
}
