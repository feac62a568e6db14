//! A number that is another one at each start.

use embassy_stm32::pac;

/// Tries before the generator is given up; it takes about 40 cycles of its 48 MHz clock.
const TRIES: u32 = 10_000;

/// From the chip's random generator on the 48 MHz oscillator that USB has too. Should it not answer, or find
/// fault with itself: the chip's identity and the cycles since reset, which the crystal's start makes uneven.
pub fn number() -> u32 {
    pac::RCC.ahb2enr().modify(|w| w.set_rngen(true));
    pac::RNG.cr().modify(|w| w.set_rngen(true));
    let drawn = (0..TRIES).find_map(|_| {
        let status = pac::RNG.sr().read();
        let is_good = status.drdy() && !status.seis() && !status.ceis();
        // A zero is what the register holds before its first number.
        is_good.then(|| pac::RNG.dr().read()).filter(|number| *number != 0)
    });
    pac::RNG.cr().modify(|w| w.set_rngen(false));
    drawn.unwrap_or_else(|| {
        let identity = embassy_stm32::uid::uid().iter().fold(0u32, |sum, byte| sum.rotate_left(5) ^ u32::from(*byte));
        identity ^ cortex_m::peripheral::DWT::cycle_count()
    })
}
