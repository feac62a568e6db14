//! Whether the map is of the ground's own year, by the share of frames with a valid least-squares match.
//!
//! In the same year six to nine of ten frames have one, between years up to two, but all of them while an unchanged field is in view.

use crate::tile::Local;

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
/// Probability that the map is of another year although it seems to be of the ground's own, while all matches are within a footprint:
/// seven of 336 flights between years began over a field that had not changed, and so did all of 56 of the same year. Chosen: odds of three
/// to one for another year before the flight, as most maps are old.
const ONE_FOOTPRINT_RISK: f32 = 0.06;

/// What the frames say of the map's year.
#[derive(Clone, Copy, Debug)]
pub struct MapYear {
    /// Share of frames with a valid least-squares match, and the number of frames in it, the prior's included.
    share: f32,
    frames: u8,
    /// Where such matches were since the map seems to be of the ground's own year.
    extent: Extent,
}

/// How far apart matches were.
#[derive(Clone, Copy, Debug)]
enum Extent {
    /// There is none.
    Nothing,
    /// All within a footprint of this nadir.
    Footprint(Local),
    /// Further.
    Further,
}

impl Default for MapYear {
    fn default() -> Self {
        MapYear::new()
    }
}

impl MapYear {
    /// No frame yet.
    pub const fn new() -> Self {
        MapYear { share: SHARE_PRIOR, frames: PRIOR_FRAMES, extent: Extent::Nothing }
    }

    /// Counts a frame. `held`: nadir of its valid least-squares match, if it has one. `side_m`: larger side of its footprint, metres.
    pub fn count(&mut self, held: Option<Local>, side_m: f32) {
        self.frames = (self.frames + 1).min(FRAMES);
        self.share += (f32::from(u8::from(held.is_some())) - self.share) / f32::from(self.frames + 1);
        self.extent = match (self.extent, held) {
            _ if self.is_another() => Extent::Nothing,
            (Extent::Nothing, Some(nadir)) => Extent::Footprint(nadir),
            (Extent::Footprint(first), Some(nadir)) if nadir.off_m(first) >= side_m => Extent::Further,
            (extent, _) => extent,
        };
    }

    /// Whether the map seems to be of another year than the ground.
    pub fn is_another(&self) -> bool {
        self.share < SHARE_MIN
    }

    /// Whether it is of the ground's own year with little doubt.
    pub fn is_own(&self) -> bool {
        self.share >= CERTAIN_SHARE_MIN
    }

    /// Probability that a least-squares match has the local offset of a map of another year.
    pub fn offset_probability(&self) -> f32 {
        match self.extent {
            _ if self.is_another() => 1.0,
            Extent::Nothing | Extent::Footprint(_) => ONE_FOOTPRINT_RISK,
            Extent::Further => 0.0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{MapYear, ONE_FOOTPRINT_RISK};
    use crate::tile::Local;

    const SIDE_M: f32 = 100.0;

    impl MapYear {
        /// Frames with or without a match, all at one place.
        fn seen(mut self, east_m: f32, frames: impl IntoIterator<Item = bool>) -> Self {
            let nadir = Local { east_m, north_m: 40.0 };
            frames.into_iter().for_each(|holds| self.count(holds.then_some(nadir), SIDE_M));
            self
        }
    }

    #[test]
    fn another_year_is_told_by_the_share_of_valid_least_squares() {
        assert!(MapYear::new().is_another(), "until frames say otherwise");
        let six_of_ten = MapYear::new().seen(0.0, (0..40).map(|frame| frame % 5 > 1));
        assert!(!six_of_ten.is_another() && !six_of_ten.is_own());
        assert!(MapYear::new().seen(0.0, [true; 40]).is_own());
    }

    #[test]
    fn an_unchanged_wood_is_no_map_of_the_same_year() {
        assert!(MapYear::new().seen(0.0, [true; 4]).is_another());
        let two_of_ten = (0..400).map(|frame| frame % 100 < 20);
        assert!(MapYear::new().seen(0.0, two_of_ten.chain([true; 50])).is_another());
    }

    #[test]
    fn one_footprint_does_not_show_that_the_map_has_no_offset() {
        assert_eq!(MapYear::new().offset_probability(), 1.0);
        // Hovering, however long.
        let hovering = MapYear::new().seen(0.0, [true; 200]);
        assert_eq!(hovering.offset_probability(), ONE_FOOTPRINT_RISK);
        assert_eq!(hovering.seen(0.99 * SIDE_M, [true]).offset_probability(), ONE_FOOTPRINT_RISK);
        assert_eq!(hovering.seen(1.01 * SIDE_M, [false]).offset_probability(), ONE_FOOTPRINT_RISK);
        let away = hovering.seen(1.01 * SIDE_M, [true]);
        assert_eq!(away.offset_probability(), 0.0);
        assert_eq!(away.seen(0.0, [true, false]).offset_probability(), 0.0);
    }

    /// A field that has not changed, long after the first matches.
    #[test]
    fn matches_while_the_map_seems_of_another_year_count_for_nothing() {
        let changed =
            MapYear::new().seen(0.0, [true, false, false, false]).seen(10.0 * SIDE_M, [true, false, false, false]);
        let unchanged = changed.seen(20.0 * SIDE_M, [true; 20]);
        assert!(!unchanged.is_another());
        assert_eq!(unchanged.offset_probability(), ONE_FOOTPRINT_RISK);
        // And begins anew where it ends.
        let again = unchanged.seen(22.0 * SIDE_M, [true]).seen(22.0 * SIDE_M, [false; 60]);
        assert_eq!(again.offset_probability(), 1.0);
        assert_eq!(again.seen(30.0 * SIDE_M, [true; 60]).offset_probability(), ONE_FOOTPRINT_RISK);
    }
}
