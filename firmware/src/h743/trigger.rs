//! When the next exposure is triggered, and what the 16-bit timer behind the trigger's pin is set to.
//!
//! TIM3 counts as TIM2 does, from the same instant on, and so shows its lower half. A compare register of 16 bits means a
//! tick within the next 65 ms, so the trigger is armed when it is nearer than [`ARM_AHEAD_US`] and farther than
//! [`ARM_LEAST_US`].

use plumbline_core::units::Ticks;

/// The trigger is armed when it is at most so far ahead, microseconds: less than half of what 16 bits hold.
pub const ARM_AHEAD_US: i32 = 30_000;
/// The trigger is not armed when it is nearer than this: setting the registers takes time.
pub const ARM_LEAST_US: i32 = 50;
/// Length of the pulse, microseconds. The sensor wants a pixel clock at least; a scope wants to see it.
pub const PULSE_US: u16 = 100;

/// What to do about a trigger that is due at a tick.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Due {
    /// It is too far ahead: try again at this tick.
    Later(Ticks),
    /// Arm the compare register with this value.
    Arm(u16),
    /// It was missed: the next is due at this tick.
    Missed(Ticks),
}

/// What to do at `now` about a trigger at `at`, of triggers `interval_us` apart.
pub fn due(now: Ticks, at: Ticks, interval_us: u32) -> Due {
    let ahead = at.since(now);
    if ahead > ARM_AHEAD_US {
        Due::Later(Ticks(at.0.wrapping_sub(ARM_AHEAD_US as u32)))
    } else if ahead >= ARM_LEAST_US {
        Due::Arm(at.0 as u16)
    } else {
        // The first of those to come that can be reached, on the same beat.
        let late = (ARM_LEAST_US - ahead) as u32;
        let skipped = late.div_ceil(interval_us.max(1)).saturating_mul(interval_us);
        Due::Missed(Ticks(at.0.wrapping_add(skipped)))
    }
}

/// The full reading that a captured lower half belongs to: the last one before or at `now`.
pub fn widen(now: Ticks, low: u16) -> Ticks {
    Ticks(now.0.wrapping_sub(u32::from((now.0 as u16).wrapping_sub(low))))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_trigger_is_armed_with_its_lower_half_when_it_is_near() {
        let now = Ticks(0xffff_f000);
        let at = Ticks(now.0.wrapping_add(20_000));
        assert_eq!(due(now, at, 50_000), Due::Arm(at.0 as u16));
        assert_eq!(due(now, Ticks(at.0.wrapping_add(40_000)), 50_000), Due::Later(Ticks(now.0.wrapping_add(30_000))));
    }

    #[test]
    fn a_missed_trigger_is_skipped_to_the_next_beat_that_can_be_reached() {
        let at = Ticks(1_000_000);
        for (now, next) in
            [(1_000_000, 1_050_000), (999_960, 1_050_000), (1_049_990, 1_100_000), (1_400_000, 1_450_000)]
        {
            assert_eq!(due(Ticks(now), at, 50_000), Due::Missed(Ticks(next)), "{now}");
            assert_eq!((next - at.0) % 50_000, 0);
            assert!((next - now) as i32 >= ARM_LEAST_US);
        }
    }

    #[test]
    fn a_lower_half_is_widened_to_the_past() {
        assert_eq!(widen(Ticks(0x0001_0010), 0x0008), Ticks(0x0001_0008));
        assert_eq!(widen(Ticks(0x0001_0010), 0xfff0), Ticks(0x0000_fff0));
        assert_eq!(widen(Ticks(0x0000_0002), 0xffff), Ticks(0xffff_ffff));
    }
}
