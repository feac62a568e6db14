//! Whether the sensor has fallen silent: a trigger went out and no frame has come since.
//!
//! A trigger is waited for by time, since a plan triggers seldom; a board that gives none, as in the safe state, waits for no
//! frame.

use plumbline_core::units::Ticks;

/// So long after a trigger without its frame the sensor counts as silent, microseconds: a second, twenty frames where the
/// camera runs free. An exposure and its readout take less than a tenth of that.
pub const SILENT_US: i32 = 1_000_000;
/// A return is counted over this time, microseconds, and over at most twice as long: stray rows are no return.
pub const BACK_US: i32 = 500_000;

/// What changed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Change {
    /// The sensor has fallen silent.
    Silent,
    /// It delivers again.
    Back,
}

/// What the board has counted since start. All wrap.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Triggers.
    pub triggers: u32,
    /// Frames of which a row has come.
    pub frames: u32,
    /// Number behind that of the newest frame's trigger: equal to `triggers` where none is waited for.
    pub answered: u32,
}

/// What was seen of the counts so far.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Silence {
    /// The newest answer at the last check.
    answered: u32,
    /// Since when a trigger has been waiting for its frame.
    waiting_since: Option<Ticks>,
    /// While there is silence: from where on a return is counted.
    silent: Option<(Ticks, Counts)>,
}

impl Silence {
    /// Compares the counts; each change is reported once. To be asked some four times a second.
    pub fn check(&mut self, now: Ticks, counts: Counts) -> Option<Change> {
        let has_progress = counts.answered != self.answered;
        self.answered = counts.answered;
        self.waiting_since = match self.waiting_since {
            _ if counts.answered == counts.triggers => None,
            Some(since) if !has_progress => Some(since),
            _ => Some(now),
        };
        let Some((since, before)) = self.silent else {
            let is_silent = self.waiting_since.is_some_and(|since| now.since(since) >= SILENT_US);
            self.silent = is_silent.then_some((now, counts));
            return is_silent.then_some(Change::Silent);
        };
        let (frames, triggers) =
            (counts.frames.wrapping_sub(before.frames), counts.triggers.wrapping_sub(before.triggers));
        let elapsed_us = now.since(since);
        if frames > 0 && 2 * frames >= triggers && elapsed_us >= BACK_US {
            self.silent = None;
            return Some(Change::Back);
        }
        if elapsed_us >= 2 * BACK_US {
            self.silent = Some((now, counts));
        }
        None
    }
}

#[cfg(test)]
mod tests {
    extern crate std;

    use super::{BACK_US, Change, Counts, SILENT_US, Silence};
    use plumbline_core::units::Ticks;
    use std::vec::Vec;

    /// From check to check, as the board does it, milliseconds.
    const LOOK_MS: u32 = 250;

    /// Triggers every `interval_ms`; a frame comes 20 ms behind each where `comes` says so of the trigger's number from 1.
    /// Changes with their milliseconds since the first trigger; all counts begin at `start`.
    fn changes(start: u32, interval_ms: u32, seconds: u32, comes: impl Fn(u32) -> bool) -> Vec<(u32, Change)> {
        let mut counts = Counts { triggers: start, frames: start, answered: start };
        let mut silence = Silence { answered: start, ..Silence::default() };
        let (mut number, mut changes) = (0, Vec::new());
        for ms in 0..seconds * 1000 {
            if ms % interval_ms == 0 {
                number += 1;
                counts.triggers = counts.triggers.wrapping_add(1);
            }
            if ms % interval_ms == 20 && comes(number) {
                counts.frames = counts.frames.wrapping_add(1);
                counts.answered = start.wrapping_add(number);
            }
            if ms % LOOK_MS == 0 {
                let now = Ticks(start.wrapping_add(ms * 1000));
                changes.extend(silence.check(now, counts).map(|change| (ms, change)));
            }
        }
        changes
    }

    /// Whether the one change is a silence, reported at most a check after its time.
    fn is_silent_in_time(changes: &[(u32, Change)], from_ms: u32) -> bool {
        let due = from_ms + SILENT_US as u32 / 1000;
        matches!(changes, [(ms, Change::Silent)] if (due..=due + LOOK_MS).contains(ms))
    }

    #[test]
    fn silence_and_return_are_told_once_each_and_in_time() {
        let gap = |number| !(101..=300).contains(&number);
        // The counts wrap, and so does the timer.
        for start in [0, u32::MAX - 110] {
            let changes = changes(start, 50, 50, gap);
            assert!(is_silent_in_time(&changes[..1], 5_000), "{changes:?}");
            let [_, (back_ms, Change::Back)] = changes[..] else { panic!("{changes:?}") };
            assert!((15_000..15_000 + 3 * BACK_US as u32 / 1000 + LOOK_MS).contains(&back_ms), "{back_ms}");
        }
    }

    #[test]
    fn a_sensor_that_is_dead_under_a_plan_is_reported_within_a_second_and_a_check() {
        // A photo every three seconds: never a frame, or none from the fourth on.
        assert!(is_silent_in_time(&changes(0, 3000, 60, |_| false), 0));
        assert!(is_silent_in_time(&changes(0, 3000, 60, |number| number < 4), 9_000));
        // It comes back with its first photos.
        let changes = changes(0, 3000, 60, |number| number != 4);
        assert!(matches!(changes[..], [(_, Change::Silent), (_, Change::Back)]), "{changes:?}");
    }

    #[test]
    fn lost_frames_are_no_silence() {
        assert_eq!(changes(0, 50, 60, |number| number % 15 == 0), []);
    }

    #[test]
    fn stray_rows_are_no_return() {
        // One in 50 triggers, for ever; and one in three, which are fewer than half.
        assert!(is_silent_in_time(&changes(0, 50, 250, |number| number % 50 == 0), 0));
        assert!(is_silent_in_time(&changes(0, 50, 50, |number| number > 200 && number % 3 == 0), 0));
    }

    #[test]
    fn a_board_without_triggers_waits_for_no_frame() {
        let mut silence = Silence::default();
        assert!((0..1000).all(|check| silence.check(Ticks(check * 250_000), Counts::default()).is_none()));
    }
}
