//! Whether the map is of the ground's own year, by the share of frames with a valid least-squares match.
//!
//! In the same year six to nine of ten frames have one, between years up to two, but all of them while an unchanged field is in view.

/// Frames over which the share is averaged: a minute, longer than unchanged ground stays in view. Over a quarter of that a wood of fifty
/// frames between two years passed for a map of the ground's own year.
const FRAMES: u8 = 250;
/// Prior of the share, its weight in frames, and the share from which on the map is taken to be of the ground's own year: of 560
/// least-squares matches between years 22, most of them in the first second, were off by more than five of their sigmas when it was taken
/// to be of the ground's own year until frames showed otherwise.
const SHARE_PRIOR: f32 = 0.2;
const PRIOR_FRAMES: u8 = 15;
const SHARE_MIN: f32 = 0.4;
/// That share with which there is little doubt. Chosen: the lower end of what was seen in the same year.
const CERTAIN_SHARE_MIN: f32 = 0.6;

/// What the frames say of the map's year.
#[derive(Clone, Copy, Debug)]
pub struct MapYear {
    /// Share of frames with a valid least-squares match, and the number of frames in it, the prior's included.
    share: f32,
    frames: u8,
}

impl Default for MapYear {
    fn default() -> Self {
        MapYear::new()
    }
}

impl MapYear {
    /// No frame yet.
    pub const fn new() -> Self {
        MapYear { share: SHARE_PRIOR, frames: PRIOR_FRAMES }
    }

    /// Counts a frame with or without a valid least-squares match.
    pub fn count(&mut self, holds: bool) {
        self.frames = (self.frames + 1).min(FRAMES);
        self.share += (f32::from(u8::from(holds)) - self.share) / f32::from(self.frames + 1);
    }

    /// Whether the map seems to be of another year than the ground.
    pub fn is_another(&self) -> bool {
        self.share < SHARE_MIN
    }

    /// Whether it is of the ground's own year with little doubt.
    pub fn is_own(&self) -> bool {
        self.share >= CERTAIN_SHARE_MIN
    }
}

#[cfg(test)]
mod tests {
    use super::MapYear;

    fn seen(frames: impl IntoIterator<Item = bool>) -> MapYear {
        let mut year = MapYear::new();
        frames.into_iter().for_each(|holds| year.count(holds));
        year
    }

    #[test]
    fn another_year_is_told_by_the_share_of_valid_least_squares() {
        assert!(MapYear::new().is_another(), "until frames say otherwise");
        let six_of_ten = seen((0..40).map(|frame| frame % 5 > 1));
        assert!(!six_of_ten.is_another() && !six_of_ten.is_own());
        assert!(seen([true; 40]).is_own());
    }

    #[test]
    fn an_unchanged_wood_is_no_map_of_the_same_year() {
        assert!(seen([true; 4]).is_another());
        let two_of_ten = (0..400).map(|frame| frame % 100 < 20);
        assert!(seen(two_of_ten.chain([true; 50])).is_another());
    }
}
