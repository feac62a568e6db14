//! Clocks and dividers, computed: what the core runs at, and how the timers make microseconds and the camera's clock of it.
//!
//! Sources: RM0433 (clock tree, PLL, voltage scaling); DS12110 (480 MHz needs revision V and VOS0, every other revision ends
//! at 400 MHz in VOS1).

/// Crystal of the board, Hz.
pub const HSE_HZ: u32 = 12_000_000;
/// DBGMCU_IDC.REV_ID of silicon revision V (RM0433).
pub const REVISION_V: u16 = 0x2003;
/// Rate of the capture timer, Hz: its ticks are the application's.
pub const TICK_HZ: u32 = 1_000_000;
/// What the MT9V034 wants at most (data sheet), Hz.
pub const CAMERA_CLOCK_MAX_HZ: u32 = 27_000_000;
/// What this board aims at: 240 MHz by 9. Timers at 200 MHz come to 25 MHz, 200 MHz by 8.
pub const CAMERA_CLOCK_HZ: u32 = 26_666_667;

/// PLL1 and what hangs on it. Every bus is at half or a quarter of the core, and timers count at half.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Plan {
    /// Divider before the PLL.
    pub m: u16,
    /// Multiplier.
    pub n: u16,
    /// Divider of the core's output.
    pub p: u16,
    /// Divider of the output that the card's interface takes.
    pub q: u16,
    /// Whether the core's voltage is VOS0 (overdrive) instead of VOS1.
    pub is_overdriven: bool,
}

impl Plan {
    /// For silicon of this revision: only the one that is known to take 480 MHz gets them.
    pub fn for_revision(rev_id: u16) -> Plan {
        if rev_id == REVISION_V {
            Plan { m: 3, n: 240, p: 2, q: 20, is_overdriven: true }
        } else {
            Plan { m: 3, n: 200, p: 2, q: 20, is_overdriven: false }
        }
    }

    /// The oscillator inside the PLL, Hz. It runs between 192 and 960 MHz.
    pub fn oscillator_hz(&self) -> u32 {
        HSE_HZ / self.m as u32 * self.n as u32
    }

    /// The core, Hz.
    pub fn core_hz(&self) -> u32 {
        self.oscillator_hz() / self.p as u32
    }

    /// AXI and AHB, Hz.
    pub fn bus_hz(&self) -> u32 {
        self.core_hz() / 2
    }

    /// Every timer, Hz: the APBs run at half the bus, and timers at twice their APB.
    pub fn timer_hz(&self) -> u32 {
        self.bus_hz()
    }
}

/// PSC that makes a timer at `timer_hz` count microseconds; `None` where it cannot exactly.
pub fn prescaler(timer_hz: u32) -> Option<u16> {
    let ratio = timer_hz / TICK_HZ;
    if ratio == 0 || !timer_hz.is_multiple_of(TICK_HZ) {
        return None;
    }
    u16::try_from(ratio - 1).ok()
}

/// A timer's period and high part, in its counts, and the frequency that they make, Hz.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Square {
    /// Counts of a period; ARR is one less.
    pub period: u16,
    /// Counts of the high part; CCR.
    pub high: u16,
    /// Hz, rounded.
    pub hz: u32,
}

/// The fastest square wave of at most `wanted_hz` that `timer_hz` divides into: a sensor's limit is one to faster clocks. An
/// odd period is high one count less than low.
pub fn square(timer_hz: u32, wanted_hz: u32) -> Option<Square> {
    let period =
        if wanted_hz == 0 { None } else { u16::try_from(timer_hz.div_ceil(wanted_hz)).ok().filter(|&n| n >= 2) }?;
    let hz = (timer_hz + period as u32 / 2) / period as u32;
    Some(Square { period, high: period / 2, hz })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_plans_keep_the_limits_of_the_data_sheet() {
        for (revision, core, apb_max) in [(REVISION_V, 480_000_000, 120_000_000), (0x1003, 400_000_000, 100_000_000)] {
            let plan = Plan::for_revision(revision);
            assert_eq!(plan.core_hz(), core);
            assert_eq!(plan.is_overdriven, core > 400_000_000);
            assert!((192_000_000..=960_000_000).contains(&plan.oscillator_hz()));
            assert!((2_000_000..=16_000_000).contains(&(HSE_HZ / plan.m as u32)));
            assert!(plan.bus_hz() / 2 <= apb_max);
            assert!(plan.oscillator_hz() / plan.q as u32 <= 50_000_000);
        }
        // A revision that nobody knows yet is not overdriven.
        assert_eq!(Plan::for_revision(0x2004).core_hz(), 400_000_000);
    }

    #[test]
    fn a_tick_is_a_microsecond_to_the_clock_pulse() {
        for revision in [REVISION_V, 0x1003] {
            let timer = Plan::for_revision(revision).timer_hz();
            assert_eq!((prescaler(timer).unwrap() as u32 + 1) * TICK_HZ, timer);
        }
        assert_eq!(prescaler(240_500_000), None);
        assert_eq!(prescaler(0), None);
    }

    #[test]
    fn the_camera_gets_26_67_megahertz_from_either_clock() {
        let at_480 = square(240_000_000, CAMERA_CLOCK_HZ).unwrap();
        assert_eq!((at_480.period, at_480.high, at_480.hz), (9, 4, 26_666_667));
        // 200 MHz has no such divider: 8 makes 25 MHz, 7 would pass the sensor's limit.
        let at_400 = square(200_000_000, CAMERA_CLOCK_HZ).unwrap();
        assert_eq!((at_400.period, at_400.high, at_400.hz), (8, 4, 25_000_000));
        assert!(at_480.hz <= CAMERA_CLOCK_MAX_HZ && at_400.hz <= CAMERA_CLOCK_MAX_HZ);
        assert_eq!((square(1, 1_000_000), square(240_000_000, 0), square(240_000_000, 1)), (None, None, None));
    }
}
