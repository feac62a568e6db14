//! Whether the heights of a model can be those of ground, in metres.
//!
//! Looked at are differences of height over their distance, along rows and columns. The mean of their magnitudes over ground that faces all
//! directions is 2/pi of the mean slope. It tells metres from other units: ground as flat as mountains are whose heights are kilometres has not
//! been measured, since posts differ by the noise of the measurement and by furrows and ditches: 1 cm between posts that are 10 m apart is
//! already a mean of 1e-3.

use super::Dem;
use serde::{Deserialize, Serialize};
use std::ops::RangeInclusive;
use std::path::Path;

/// Why the heights of a model are probably none of ground in metres.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Doubt {
    /// All of them are 0.
    ZeroThroughout,
    /// In metres they would be flatter than measured ground is, and in kilometres they would be hills.
    Kilometres,
    /// They are steeper than ground is.
    TooSteep,
}

/// Heights of land in kilometres: from below the shore of the Dead Sea to above Mount Everest, as the limits of heights in metres.
const LAND_KM: RangeInclusive<f64> = -0.45..=9.0;
/// Most that it is, heights taken for metres, where they are kilometres of the steepest landscape: a mean slope of 45 degrees, 2/pi of it, by
/// a thousand. Measured as kilometres on four models of mountains, 10 to 90 m from post to post: 0.16e-3 to 0.3e-3; in
/// metres on a town on a plain, 1 m from post to post: 42e-3.
const FLAT: f64 = 2.0 / std::f64::consts::PI * 1e-3;
/// More of it than any landscape has, heights in metres: 57 degrees of slope. Cliffs have it, with level ground above and below them.
const STEEP: f64 = 1.0;
/// Distance over which steepness is looked at, metres: of a surface model of finer posts the walls of houses and crowns of trees have other
/// slopes than its ground. Measured on one of a town, posts of 0.8 m: 0.5 from post to post, 0.2 over 30 m.
const STEEP_OVER_M: f64 = 30.0;
/// Share of posts that have other heights than those some posts away at least, where they are taken for kilometres: water and made-up plains
/// are level.
const UNEVEN_SHARE: f64 = 0.5;
/// How many posts away: hills whose kilometres are rounded to two decimals are level from post to post.
const UNEVEN_POSTS: usize = 10;
/// Fewest pairs that say anything. Chosen: a mean of them is then good to a fifth or so, and what is measured is twice as far from the limits.
const PAIRS_MIN: usize = 100;

impl Dem {
    /// What speaks against its heights. `is_unit_stated`: whether its file says in which unit they are.
    #[must_use]
    pub fn doubt(&self, is_unit_stated: bool) -> Option<Doubt> {
        let [low_m, high_m] = self.range_m()?;
        if low_m == 0.0 && high_m == 0.0 {
            return Some(Doubt::ZeroThroughout);
        }
        if !is_unit_stated && LAND_KM.contains(&low_m) && LAND_KM.contains(&high_m) {
            let away = [self.cols, self.rows].map(|posts| UNEVEN_POSTS.min(posts / 2).max(1));
            let (near, away) = (self.differences([1; 2]), self.differences(away));
            let is_uneven = away.uneven as f64 >= UNEVEN_SHARE * away.pairs as f64;
            if near.pairs >= PAIRS_MIN && is_uneven && near.mean_slope() <= FLAT {
                return Some(Doubt::Kilometres);
            }
        }
        let far = self.differences(self.step_m.map(|step_m| (STEEP_OVER_M / step_m).ceil().max(1.0) as usize));
        (far.pairs >= PAIRS_MIN && far.mean_slope() > STEEP).then_some(Doubt::TooSteep)
    }

    /// Whether all of its known heights are one.
    #[must_use]
    pub fn is_level(&self) -> bool {
        self.range_m().is_some_and(|[low_m, high_m]| low_m == high_m)
    }

    /// Between posts that are so many columns, or so many rows, apart.
    fn differences(&self, strides: [usize; 2]) -> Differences {
        let mut found = Differences::default();
        for row in 0..self.rows {
            for col in 0..self.cols {
                let height_m = self.at(col, row);
                let pairs = [
                    (self.at(col + strides[0], row), strides[0] as f64 * self.step_m[0]),
                    (self.at(col, row + strides[1]), strides[1] as f64 * self.step_m[1]),
                ];
                for (other_m, distance_m) in pairs {
                    let difference_m = (other_m - height_m).abs();
                    if difference_m.is_finite() {
                        found.pairs += 1;
                        found.uneven += usize::from(difference_m > 0.0);
                        found.slopes += difference_m / distance_m;
                    }
                }
            }
        }
        found
    }
}

/// What differs between posts.
#[derive(Default)]
struct Differences {
    pairs: usize,
    uneven: usize,
    /// Sum of the differences over the distances.
    slopes: f64,
}

impl Differences {
    fn mean_slope(&self) -> f64 {
        self.slopes / self.pairs.max(1) as f64
    }
}

impl Doubt {
    /// As [`Self::why`], with the name of the model.
    #[must_use]
    pub fn of(self, path: &Path) -> String {
        format!("{}: {}", path.display(), self.why())
    }

    /// In one sentence, with what to do.
    #[must_use]
    pub fn why(self) -> &'static str {
        match self {
            Self::ZeroThroughout => {
                "the elevation model is 0 throughout, as an empty export is and as the sea is: over land it takes another model"
            }
            Self::Kilometres => {
                "the elevation model is flatter than measured ground, as hills are whose heights are kilometres: if they are, multiply them by \
                 1000 (gdal_calc.py -A MODEL --calc='A*1000.0' --outfile=OUT.tif); if they are metres, gdal_edit.py -units m MODEL says so"
            }
            Self::TooSteep => {
                "the elevation model is steeper than ground is, 57 degrees and more in the mean: its heights are probably not metres but feet, \
                 decimetres or centimetres (gdal_edit.py -units ft, or -scale 0.1 or 0.01, MODEL says so), or no heights"
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Hills of several wavelengths, metres, with noise of a level.
    fn hills(x: f64, y: f64, noise_m: f64) -> f64 {
        let wave = |length_m: f64, phase: f64| {
            (x / length_m + phase).sin() * (y / length_m - 0.7 * phase).cos() * 0.15 * length_m
        };
        let noise = ((x * 12.9898 + y * 78.233).sin() * 43_758.545_3).fract();
        900.0 + wave(700.0, 0.3) + wave(300.0, 1.9) + wave(90.0, 2.7) + noise_m * noise
    }

    fn model(step_m: f64, height: impl Fn(f64, f64) -> f64) -> Dem {
        Dem::from_fn((120, 100), [0.0, 0.0], [step_m; 2], height)
    }

    #[test]
    fn kilometres_are_seen_and_plains_are_not_taken_for_them() {
        for step_m in [1.0, 10.0, 30.0, 90.0] {
            let in_km = model(step_m, |x, y| 1e-3 * hills(x, y, 0.0));
            assert_eq!((in_km.doubt(false), in_km.doubt(true)), (Some(Doubt::Kilometres), None), "{step_m}");
            assert_eq!(model(step_m, |x, y| hills(x, y, 0.0)).doubt(false), None, "{step_m}");
        }
        let small = Dem::from_fn((9, 8), [0.0, 0.0], [90.0; 2], |x, y| 1e-3 * hills(x, y, 0.0));
        assert_eq!(small.doubt(false), Some(Doubt::Kilometres));
        let rounded = model(25.0, |x, y| (0.1 * hills(x, y, 0.0)).round() / 100.0);
        assert_eq!(rounded.doubt(false), Some(Doubt::Kilometres));
        // A polder of 0 to 3 m with a noise of some centimetres; the same rounded to centimetres; one below the sea; low dunes.
        let noise = |x: f64, y: f64| ((x * 12.9898 + y * 78.233).sin() * 43_758.545_3).fract();
        let polder = |x: f64, y: f64| 1.5 + (x / 900.0).sin() + 0.05 * noise(x, y);
        for step_m in [0.5, 5.0, 25.0] {
            assert_eq!(model(step_m, polder).doubt(false), None, "{step_m}");
            assert_eq!(model(step_m, |x, y| (100.0 * polder(x, y)).round() / 100.0).doubt(false), None, "{step_m}");
            assert_eq!(model(step_m, |x, y| polder(x, y) - 5.0).doubt(false), None, "{step_m}");
        }
        // Made-up ground: a plane, a plain with a mast, a level.
        assert_eq!(model(10.0, |x, _| 0.002 * x).doubt(false), None);
        assert_eq!(model(10.0, |x, y| if x == 500.0 && y == 500.0 { 8.0 } else { 2.0 }).doubt(false), None);
        assert_eq!(model(10.0, |_, _| 2.0).doubt(false), None);
    }

    #[test]
    fn nothing_but_zero_is_asked_about_whatever_the_file_says() {
        let mut empty = model(10.0, |_, _| 0.0);
        empty.heights[77] = f64::NAN;
        assert_eq!((empty.doubt(false), empty.doubt(true)), (Some(Doubt::ZeroThroughout), Some(Doubt::ZeroThroughout)));
        empty.heights[78] = 0.1;
        assert_eq!((empty.doubt(false), empty.is_level()), (None, false));
        assert!(model(10.0, |_, _| 100.0).is_level());
    }

    #[test]
    fn ground_is_not_as_steep_as_hills_in_centimetres() {
        assert_eq!(model(10.0, |x, y| 100.0 * hills(x, y, 0.0)).doubt(true), Some(Doubt::TooSteep));
        // A wall every few metres, as in a surface model of a town, is steep from post to post alone; so is a cliff.
        assert_eq!(
            model(1.0, |x, _| if (x as usize / 7).is_multiple_of(2) { 110.0 } else { 100.0 }).doubt(false),
            None
        );
        assert_eq!(model(10.0, |x, _| if x > 500.0 { 400.0 } else { 100.0 }).doubt(false), None);
    }
}
