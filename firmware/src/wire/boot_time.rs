//! Stamps since the sender's boot, as messages have them.

use plumbline_core::units::Micros;

/// A stamp of a message.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BootTime {
    /// Microseconds. Some autopilots count them in 32 bits, which wrap after 71.6 minutes.
    Micros(u64),
    /// Whole milliseconds in 32 bits, which wrap after 49.7 days. What lies behind the last whole one is cut off.
    Millis(u32),
}

/// What a millisecond's cutting off makes late in the mean, microseconds.
const CUT_US: u64 = 500;
/// Spread of what is cut off, evenly within a millisecond, about its mean: 1000 / √12.
const CUT_SIGMA_US: f32 = 288.675;

impl BootTime {
    /// The instant: of all that the stamp may mean, the one nearest to `near`, at most half a wrap away.
    pub fn unwrapped(self, near: Micros) -> Micros {
        match self {
            // Counted in 64 bits by this sender.
            BootTime::Micros(us) if us > u32::MAX as u64 => Micros(us),
            BootTime::Micros(us) => {
                let away = (us as u32).wrapping_sub(near.0 as u32) as i32;
                Micros(near.0.checked_add_signed(away as i64).unwrap_or(us))
            }
            BootTime::Millis(ms) => {
                let near_ms = near.0 / 1000;
                let away = ms.wrapping_sub(near_ms as u32) as i32;
                Micros(near_ms.checked_add_signed(away as i64).unwrap_or(ms as u64) * 1000 + CUT_US)
            }
        }
    }

    /// One sigma of the stamp, as it was rounded, microseconds.
    pub fn sigma_us(self) -> f32 {
        match self {
            BootTime::Micros(_) => 0.0,
            BootTime::Millis(_) => CUT_SIGMA_US,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::BootTime;
    use plumbline_core::units::Micros;

    /// 2³² microseconds.
    const WRAP: u64 = 1 << 32;

    #[test]
    fn thirty_two_bits_are_unwrapped_both_ways() {
        for near in [0, 5_000_000, WRAP - 3, WRAP, WRAP + 9, 3 * WRAP - 1, 3 * WRAP + 1] {
            for away in [-20_000i64, -1, 0, 1, 20_000] {
                let Some(true_us) = near.checked_add_signed(away) else { continue };
                let stamp = BootTime::Micros(u64::from(true_us as u32));
                assert_eq!(stamp.unwrapped(Micros(near)), Micros(true_us), "{away} from {near}");
            }
        }
        // An autopilot that counts on says so by its stamps, once they are beyond.
        assert_eq!(BootTime::Micros(WRAP + 5).unwrapped(Micros(7 * WRAP)), Micros(WRAP + 5));
    }

    #[test]
    fn what_is_cut_off_is_added_in_the_mean() {
        let wrap_us = WRAP * 1000;
        for near in [0, 12_345_678, wrap_us - 1, wrap_us, wrap_us + 400_000] {
            for away in [-200_000i64, 0, 200_000] {
                let Some(true_us) = near.checked_add_signed(away) else { continue };
                let stamp = BootTime::Millis((true_us / 1000) as u32);
                assert_eq!(stamp.unwrapped(Micros(near)), Micros(true_us / 1000 * 1000 + 500), "{away} from {near}");
            }
        }
    }
}
