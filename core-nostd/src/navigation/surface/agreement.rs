//! Whether single frames agree with the decision of the surface.
//!
//! The decided position is propagated by the velocity. Where the velocity is off by more than it states, or the attitude has jumped, it
//! drifts away together with all its evidence, and over a map of another year there is nearly always some local peak near it. The residuals
//! of the last frames' own peaks reveal that: around the right position they scatter to all sides, otherwise they are biased to one side or
//! scattered over the whole search.

use crate::math::hypot;

/// Gains of the exponential averages of residual and share. Chosen: the last ten or so, 2 to 3 seconds, are about the length of a
/// footprint.
const OFF_GAIN: f32 = 0.1;
const SHARE_GAIN: f32 = 1.0 / 12.0;
/// Residual up to which a frame agrees, pixels. Chosen: two sigmas of a frame's own peak.
const BESIDE_PX: f32 = 1.2;
/// Least share of frames that agree, and largest mean residual, pixels, for a fix at the decided position. By chance, within the three
/// pixels that peaks are searched in, one of six agrees. Of 22,000 fixes in 84 flights between years 3, 14 and 14 of 100 (patches of 64, 35
/// and 24 pixels) fail this; of 293 that were wrong while a velocity was off by 0.5, 1 and 3 m/s, five to thirty of its sigmas, all but 16.
const SHARE_MIN: f32 = 0.4;
const OFF_MAX_PX: f32 = 1.1;
/// Once beyond that limit, the mean residual has to come back to this, pixels, and the share begins anew: sooner or later there are false
/// peaks near a position that has drifted away, too. While a velocity was off by 0.5, 1 and 3 m/s 2 of 8,800 fixes were wrong with this, 8 of
/// 9,000 with 0.6, and 28 without; in flights on which nothing was chosen 5 of 8,600 with this and 6 of 9,600 without. Chosen: a little
/// more than the sigma of the decided position.
const OFF_BACK_PX: f32 = 0.5;

/// Consecutive frames, the newest included, that have to be within the gate where dead reckoning is so bad that the gate is at its minimum:
/// of 4,000 fixes after the loss of satellites three were wrong, after one such frame, or two after a gap of fifteen seconds; of 2,000
/// without this condition five.
const IN_A_ROW_ADRIFT: u8 = 4;

/// All constants of this test.
pub const COEFFICIENTS: [f32; 7] =
    [OFF_GAIN, SHARE_GAIN, BESIDE_PX, SHARE_MIN, OFF_MAX_PX, OFF_BACK_PX, IN_A_ROW_ADRIFT as f32];

/// Residuals of the last frames' own peaks against the decided position.
#[derive(Clone, Copy, Debug)]
pub struct Agreement {
    /// Mean residual, pixels to the right and downwards.
    off_px: [f32; 2],
    /// Share of the frames whose peak is within [`BESIDE_PX`].
    share: f32,
    /// Consecutive newest frames within the gate.
    in_a_row: u8,
    /// The mean residual was beyond its limit and has not come back.
    is_astray: bool,
}

impl Default for Agreement {
    fn default() -> Self {
        Agreement::new()
    }
}

impl Agreement {
    /// No frame yet.
    pub const fn new() -> Self {
        Agreement { off_px: [0.0; 2], share: 0.0, in_a_row: 0, is_astray: false }
    }

    /// A frame without a decision.
    pub fn gap(&mut self) {
        self.in_a_row = 0;
    }

    /// A frame's residual, own peak less decided position, pixels (columns, rows); none where it has no peak there. `near_px`: gate.
    pub fn frame(&mut self, off_px: Option<(f32, f32)>, near_px: f32) {
        let is_within = |px: f32| off_px.is_some_and(|(cols, rows)| hypot(cols, rows) <= px);
        self.in_a_row = if is_within(near_px) { self.in_a_row.saturating_add(1) } else { 0 };
        self.share += SHARE_GAIN * (f32::from(u8::from(is_within(BESIDE_PX))) - self.share);
        if let Some((cols, rows)) = off_px {
            let [to_right, down] = self.off_px;
            self.off_px = [to_right + OFF_GAIN * (cols - to_right), down + OFF_GAIN * (rows - down)];
        }
        let was_astray = self.is_astray;
        self.is_astray = self.off_px() > if was_astray { OFF_BACK_PX } else { OFF_MAX_PX };
        if self.is_astray && !was_astray {
            self.share = 0.0;
        }
    }

    /// Length of the mean residual, pixels.
    pub fn off_px(&self) -> f32 {
        hypot(self.off_px[0], self.off_px[1])
    }

    /// Whether the residuals are biased to one side, so that the decided position may be wrong.
    pub fn is_astray(&self) -> bool {
        self.is_astray
    }

    /// Whether frames agree enough for a fix. `is_adrift`: dead reckoning is so bad that the gate is at its minimum.
    pub fn is_enough(&self, is_adrift: bool) -> bool {
        let is_row = !is_adrift || self.in_a_row >= IN_A_ROW_ADRIFT;
        is_row && self.share >= SHARE_MIN && !self.is_astray()
    }
}

#[cfg(test)]
mod tests {
    use super::{Agreement, OFF_BACK_PX, OFF_MAX_PX};

    const NEAR_PX: f32 = 2.0;

    fn after(frames: impl IntoIterator<Item = Option<(f32, f32)>>) -> Agreement {
        let mut agreement = Agreement::new();
        frames.into_iter().for_each(|off_px| agreement.frame(off_px, NEAR_PX));
        agreement
    }

    #[test]
    fn peaks_to_all_sides_agree_and_to_one_side_do_not() {
        let around = |frame: u16| Some(if frame.is_multiple_of(2) { (1.0, -0.4) } else { (-0.9, 0.5) });
        assert!(after((0..20).map(around)).is_enough(true));
        let aside = |off_px: f32| after((0..40).map(move |_| Some((0.6 * off_px, -0.8 * off_px))));
        assert!(aside(0.9 * OFF_MAX_PX).is_enough(true) && !aside(1.05 * OFF_MAX_PX).is_enough(true));
        assert!(!aside(0.9 * OFF_MAX_PX).is_astray() && aside(1.05 * OFF_MAX_PX).is_astray());
    }

    #[test]
    fn a_position_that_was_astray_has_to_be_confirmed_anew() {
        let mut agreement = after((0..40).map(|_| Some((1.05 * OFF_MAX_PX, 0.0))));
        assert!(agreement.is_astray());
        // Peaks come back to a mean between the limits.
        (0..60).for_each(|_| agreement.frame(Some((0.5 * (OFF_BACK_PX + OFF_MAX_PX), 0.0)), NEAR_PX));
        assert!(agreement.is_astray() && !agreement.is_enough(false));
        (0..30).for_each(|_| agreement.frame(Some((0.1, 0.0)), NEAR_PX));
        assert!(!agreement.is_astray() && agreement.is_enough(false));
        // A few peaks far to the other side bring the mean back: that alone is not enough.
        let mut agreement = after((0..30).map(|_| Some((0.9, 0.0))).chain((0..4).map(|_| Some((2.9, 0.0)))));
        assert!(agreement.is_astray());
        (0..4).for_each(|_| agreement.frame(Some((-2.9, 0.0)), NEAR_PX));
        assert!(!agreement.is_astray() && !agreement.is_enough(false), "{agreement:?}");
    }

    #[test]
    fn it_takes_some_frames_and_not_all() {
        let first = |frames: u16| after((0..frames).map(|_| Some((0.1, 0.1))));
        assert!(!first(5).is_enough(false) && first(6).is_enough(false));
        // One of two has a peak there, or one of five, or all have one anywhere.
        let some = |of: usize| after((0..60).map(move |frame| (frame % of == 0).then_some((0.2, 0.0))));
        assert!(some(2).is_enough(false) && !some(5).is_enough(false));
        let anywhere = [(1.6, 0.0), (-1.0, 1.5), (-1.0, -1.5), (1.0, 1.0), (0.3, 0.1), (-1.4, 0.2)];
        assert!(!after((0..60).map(|frame| anywhere.get(frame % 6).copied())).is_enough(false));
    }

    #[test]
    fn adrift_they_have_to_agree_anew_behind_a_gap() {
        let mut agreement = after((0..40).map(|_| Some((0.1, 0.1))));
        assert!(agreement.is_enough(true));
        agreement.gap();
        let mut again = || {
            agreement.frame(Some((0.1, 0.1)), NEAR_PX);
            (agreement.is_enough(false), agreement.is_enough(true))
        };
        assert_eq!([again(), again(), again(), again()], [(true, false), (true, false), (true, false), (true, true)]);
        // One outside the gate is a gap, too.
        agreement.frame(Some((0.9, 0.0)), 0.8);
        assert!(!agreement.is_enough(true));
    }
}
