//! Matches that depart together from where they are expected: attitude or position may have jumped.
//!
//! Over a map of another year hardly any match is accepted alone, and the decision of several key frames does not follow a jump. A minute
//! later the prediction would be as uncertain as the jump is large, and what had jumped be forgotten. But the peaks of consecutive frames,
//! which are unambiguous though not accepted, show the jump at once: until then they were where the fixes were, from then on they are
//! together elsewhere.

use crate::math::hypot;
use crate::units::Micros;

/// Longest time from a fix to the first of them, and from each to the next, microseconds. Chosen: five frames; a jump takes up to 0.6 s.
const APART_MAX_US: i32 = 1_300_000;
/// How many there have to be, and how far each may lie from the first, pixels: the sigma of a frame's own peak. Of unambiguous peaks, in 56
/// flights between years of 500 frames each one run of three happens by chance and none of four; where the attitude jumped by 4 pixels ten
/// of 28 flights show one of four to twelve at once.
const FRAMES: u8 = 4;
const ALIKE_PX: f32 = 1.0;

/// A run of such matches.
#[derive(Clone, Copy, Debug)]
pub struct Departure {
    /// The newest fix, and the newest match of the run.
    fixed_at: Option<Micros>,
    newest_at: Micros,
    /// Displacement of the first one, metres, and how many there are.
    off_m: [f32; 2],
    frames: u8,
}

impl Departure {
    /// No frame yet.
    pub const fn new() -> Self {
        Departure { fixed_at: None, newest_at: Micros(0), off_m: [0.0; 2], frames: 0 }
    }

    /// A frame with a fix.
    pub fn fixed(&mut self, at: Micros) {
        *self = Departure { fixed_at: Some(at), ..Departure::new() };
    }

    /// Whether a match of the frame at an instant may begin or continue a run.
    pub fn is_awaited(&self, at: Micros) -> bool {
        self.continues(at) || self.begins(at)
    }

    /// Whether an instant is soon enough after the newest frame of the run.
    fn continues(&self, at: Micros) -> bool {
        self.frames > 0 && is_soon(at, self.newest_at)
    }

    /// Whether an instant is soon enough after a fix for a run to begin.
    fn begins(&self, at: Micros) -> bool {
        self.fixed_at.is_some_and(|fixed_at| is_soon(at, fixed_at))
    }

    /// A frame without a fix. `off_m`: how far its match is off the prediction, east and north, metres, where that is beyond the gate.
    /// Whether it completes a run.
    pub fn unfixed(&mut self, at: Micros, off_m: Option<[f32; 2]>, px_m: f32) -> bool {
        let is_alike = |off: &[f32; 2]| hypot(off[0] - self.off_m[0], off[1] - self.off_m[1]) <= ALIKE_PX * px_m;
        match off_m {
            Some(off) if self.continues(at) && is_alike(&off) => self.frames += 1,
            Some(off) if self.begins(at) => (self.off_m, self.frames) = (off, 1),
            _ => self.frames = 0,
        }
        self.newest_at = at;
        let is_whole = self.frames >= FRAMES;
        if is_whole {
            *self = Departure::new();
        }
        is_whole
    }
}

fn is_soon(at: Micros, before: Micros) -> bool {
    (0..=APART_MAX_US).contains(&at.since(before))
}

impl Default for Departure {
    fn default() -> Self {
        Departure::new()
    }
}

#[cfg(test)]
mod tests {
    use super::{ALIKE_PX, APART_MAX_US, Departure, FRAMES};
    use crate::units::Micros;

    const PX_M: f32 = 5.0;
    const FRAME_US: u64 = 250_000;

    /// Whether frames after a fix, the first one `begins_us` later, are a whole run.
    fn is_run(begins_us: u64, frames: impl IntoIterator<Item = Option<[f32; 2]>>) -> bool {
        let mut departure = Departure::new();
        departure.fixed(Micros(7));
        let at = (0u64..).map(|frame| Micros(7 + begins_us + FRAME_US * frame));
        at.zip(frames).fold(false, |is_run, (at, off_m)| departure.unfixed(at, off_m, PX_M) || is_run)
    }

    fn aside(frames: u8) -> impl Iterator<Item = Option<[f32; 2]>> {
        // To both sides of the first one by not quite a pixel.
        (0..frames).map(|frame| Some([20.0, -15.0 + 0.9 * ALIKE_PX * PX_M * [0.0, 1.0, -1.0][usize::from(frame % 3)]]))
    }

    #[test]
    fn several_in_a_row_at_one_place_soon_after_a_fix_are_a_run() {
        assert!(is_run(FRAME_US, aside(FRAMES)));
        assert!(!is_run(FRAME_US, aside(FRAMES - 1)));
        let interrupted = aside(FRAMES - 1).chain([None]).chain(aside(FRAMES - 1));
        assert!(!is_run(FRAME_US, interrupted));
        let scattered = (0..3 * FRAMES).map(|frame| Some([f32::from(frame) * 1.1 * ALIKE_PX * PX_M, 20.0]));
        assert!(!is_run(FRAME_US, scattered));
    }

    #[test]
    fn it_begins_soon_after_a_fix() {
        let soon_us = APART_MAX_US as u64;
        assert!(is_run(soon_us, aside(FRAMES)) && !is_run(soon_us + 1, aside(2 * FRAMES)));
        // Before the first fix there is none.
        let mut departure = Departure::new();
        assert!(!aside(9).any(|off_m| departure.unfixed(Micros(9), off_m, PX_M)));
    }

    #[test]
    fn it_counts_once() {
        let mut departure = Departure::new();
        departure.fixed(Micros(0));
        let at = (1u64..).map(|frame| Micros(FRAME_US * frame));
        let runs = at.zip(aside(3 * FRAMES)).filter(|(at, off_m)| departure.unfixed(*at, *off_m, PX_M)).count();
        assert_eq!(runs, 1);
    }

    /// Frames that are refused before they are matched leave no trace, and neither does a clock that is set.
    #[test]
    fn a_gap_ends_it() {
        let runs = |last_us: u64| {
            let mut departure = Departure::new();
            departure.fixed(Micros(0));
            let at = (1..u64::from(FRAMES)).map(|frame| FRAME_US * frame).chain([last_us]);
            at.zip(aside(FRAMES)).filter(|(at, off_m)| departure.unfixed(Micros(*at), *off_m, PX_M)).count()
        };
        let newest_us = FRAME_US * u64::from(FRAMES - 1);
        assert_eq!([FRAME_US, APART_MAX_US as u64].map(|gap_us| runs(newest_us + gap_us)), [1, 1]);
        assert_eq!([runs(newest_us + APART_MAX_US as u64 + 1), runs(newest_us - 1)], [0, 0]);
    }
}
