//! Whether the sensor has fallen silent: triggers go out and no frame comes in.
//!
//! Time is counted in triggers, so that a board that gives none, as in the safe state, waits for no frame.

/// Triggers in a row without a frame after which the sensor counts as silent: a second of them.
pub const SILENT_AFTER: u32 = 20;
/// Frames after which it counts as back: half a second of them, within twice as many triggers. Stray rows are no return.
pub const BACK_AFTER: u32 = 10;

/// What there is to tell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Change {
    /// The sensor has fallen silent.
    Silent,
    /// It delivers again.
    Back,
}

/// What was seen of the counts so far.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Silence {
    /// Frames at the last look.
    frames: u32,
    /// Triggers at the last look that saw a new frame.
    triggers: u32,
    /// Frames and triggers from which a return is counted, while there is silence.
    silent_since: Option<[u32; 2]>,
}

impl Silence {
    /// Looks at the counts of `triggers` and of `frames` begun since start, both of which wrap; each change is told once.
    /// Between two looks there should be fewer than [`SILENT_AFTER`] triggers.
    pub fn look(&mut self, triggers: u32, frames: u32) -> Option<Change> {
        if frames != self.frames {
            (self.frames, self.triggers) = (frames, triggers);
        }
        match self.silent_since {
            None if triggers.wrapping_sub(self.triggers) >= SILENT_AFTER => {
                self.silent_since = Some([frames, triggers]);
                Some(Change::Silent)
            }
            Some([since, _]) if frames.wrapping_sub(since) >= BACK_AFTER => {
                self.silent_since = None;
                Some(Change::Back)
            }
            Some([_, since]) if triggers.wrapping_sub(since) >= 2 * BACK_AFTER => {
                self.silent_since = Some([frames, triggers]);
                None
            }
            _ => None,
        }
    }
}

#[cfg(test)]
mod tests {
    extern crate std;

    use super::{BACK_AFTER, Change, SILENT_AFTER, Silence};
    use std::vec::Vec;

    /// Looks at every fifth trigger, as the board does; frames come where `comes` says so. Changes with their triggers.
    fn told(start: u32, triggers: u32, comes: impl Fn(u32) -> bool) -> Vec<(u32, Change)> {
        let mut silence = Silence { frames: start, triggers: start, silent_since: None };
        let mut frames = start;
        let mut changes = Vec::new();
        for trigger in 1..=triggers {
            frames = frames.wrapping_add(u32::from(comes(trigger)));
            if trigger % 5 == 0 {
                let change = silence.look(start.wrapping_add(trigger), frames);
                changes.extend(change.map(|change| (trigger, change)));
            }
        }
        changes
    }

    #[test]
    fn silence_and_return_are_told_once_each() {
        let gap = |trigger| !(101..=300).contains(&trigger);
        let wanted = [(100 + SILENT_AFTER, Change::Silent), (300 + BACK_AFTER, Change::Back)];
        assert_eq!(told(0, 1000, gap), wanted);
        // The counts wrap.
        assert_eq!(told(u32::MAX - 110, 1000, gap), wanted);
    }

    #[test]
    fn a_sensor_that_was_never_heard_is_silent() {
        assert_eq!(told(0, 1000, |_| false), [(SILENT_AFTER, Change::Silent)]);
    }

    #[test]
    fn lost_frames_are_no_silence() {
        assert_eq!(told(0, 1000, |trigger| trigger % (SILENT_AFTER - 5) == 0), []);
    }

    #[test]
    fn stray_rows_are_no_return() {
        // One in 50 triggers, for ever; and one in three, which are fewer than half.
        assert_eq!(told(0, 5000, |trigger| trigger % 50 == 0), [(SILENT_AFTER, Change::Silent)]);
        let sparse = told(0, 1000, |trigger| trigger > 200 && trigger % 3 == 0);
        assert_eq!(sparse, [(SILENT_AFTER, Change::Silent)]);
    }

    #[test]
    fn a_board_without_triggers_waits_for_no_frame() {
        let mut silence = Silence::default();
        assert!((0..1000).all(|_| silence.look(0, 0).is_none()));
    }
}
