//! The time in our signatures: the newest that was sent or validly received, one unit later with each message, and moved on
//! by the timer. It never goes back.

use plumbline_core::units::Ticks;

/// Units in a second.
pub const SECOND: u64 = 100_000;
/// The latest time that 48 bits hold, in the year 2104. There the clock stands: what is sent then is refused by others, and
/// nothing goes back.
pub const LATEST: u64 = (1 << 48) - 1;
/// Microseconds in a unit.
const UNIT_US: u32 = 10;

/// A clock in units of 10 us since 2015-01-01.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StampClock {
    stamp: u64,
    /// The timer when the clock was last moved on, less what is below a unit.
    at: Option<Ticks>,
}

impl StampClock {
    /// Begins behind `stamp`.
    pub const fn new(stamp: u64) -> Self {
        StampClock { stamp: if stamp < LATEST { stamp } else { LATEST }, at: None }
    }

    /// The newest time.
    pub fn stamp(&self) -> u64 {
        self.stamp
    }

    /// The time of the next message.
    pub fn issue(&mut self) -> u64 {
        self.stamp = self.stamp.saturating_add(1).min(LATEST);
        self.stamp
    }

    /// A valid message had this time.
    pub fn received(&mut self, stamp: u64) {
        self.stamp = self.stamp.max(stamp.min(LATEST));
    }

    /// Goes on with the timer, which wraps.
    pub fn advance(&mut self, now: Ticks) {
        let Some(at) = self.at else {
            self.at = Some(now);
            return;
        };
        let units = now.0.wrapping_sub(at.0) / UNIT_US;
        self.stamp = self.stamp.saturating_add(units.into()).min(LATEST);
        self.at = Some(Ticks(at.0.wrapping_add(units * UNIT_US)));
    }
}

#[cfg(test)]
mod tests {
    use super::{LATEST, SECOND, StampClock};
    use plumbline_core::units::Ticks;

    #[test]
    fn it_goes_on_by_messages_by_the_timer_and_by_what_is_received_and_never_back() {
        let mut clock = StampClock::new(1000);
        assert_eq!((clock.issue(), clock.issue()), (1001, 1002));
        clock.received(5000);
        clock.received(4000);
        assert_eq!(clock.issue(), 5001);
        // A reading of the timer by itself says nothing; its wrap is none of the clock's, and nothing is lost below a unit.
        clock.advance(Ticks(u32::MAX - 4));
        assert_eq!(clock.stamp(), 5001);
        clock.advance(Ticks(4));
        assert_eq!(clock.stamp(), 5001);
        clock.advance(Ticks(5));
        assert_eq!(clock.stamp(), 5002);
        clock.advance(Ticks(1_000_005));
        assert_eq!(clock.stamp(), 5002 + SECOND);
    }

    #[test]
    fn at_the_end_of_its_bits_it_stands() {
        let mut clock = StampClock::new(u64::MAX);
        assert_eq!(clock.issue(), LATEST);
        clock.advance(Ticks(0));
        clock.advance(Ticks(1_000_000));
        assert_eq!(clock.issue(), LATEST);
        let mut clock = StampClock::new(7);
        clock.received(u64::MAX);
        assert_eq!(clock.issue(), LATEST);
    }
}
