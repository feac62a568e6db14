//! The overlap that strips have on the ground.
//!
//! A ground point at height dh above the base plane lies in the next photo B / (1 - dh / H) further back on the base plane's
//! scale, so the share of a photo that the next one sees too is 1 - B / (l (1 - dh / H)), smallest at the highest terrain of
//! the overlap.

use super::course::Course;
use super::lines::{Layout, Strip};

/// Smallest overlaps of a set of strips; `None` where it has no such pair.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Achieved {
    /// Of neighbouring photos of a strip.
    pub forward: Option<f64>,
    /// Of neighbouring lines, over the whole line.
    pub side: Option<f64>,
}

impl Layout<'_> {
    /// The smallest overlaps of strips laid over this area, at the highest terrain of each pair's own zone.
    #[must_use]
    pub fn achieved(&self, strips: &[Strip]) -> Achieved {
        let smallest = |values: &mut dyn Iterator<Item = f64>| values.reduce(f64::min);
        let mut forward = strips.iter().flat_map(|strip| {
            strip
                .along_m
                .windows(2)
                .map(|pair| self.forward_overlap_on(&strip.course, strip.across_m, pair[0], pair[1] - pair[0]))
        });
        let lines: Vec<&Strip> = strips.chunk_by(|a, b| a.line == b.line).map(|parts| &parts[0]).collect();
        let mut side = lines.windows(2).map(|pair| {
            let [low_m, high_m] = [pair[0].across_m, pair[1].across_m];
            self.side_overlap_on([&pair[0].course, &pair[1].course], low_m, high_m - low_m)
        });
        Achieved { forward: smallest(&mut forward), side: smallest(&mut side) }
    }

    /// Overlap of a photo with the next, a base further, both at the level flying height.
    #[must_use]
    pub fn forward_overlap(&self, across_m: f64, along_m: f64, base_m: f64) -> f64 {
        self.forward_overlap_on(&Course::default(), across_m, along_m, base_m)
    }

    /// Overlap of a line with the next, both at the level flying height.
    #[must_use]
    pub fn side_overlap(&self, across_m: f64, distance_m: f64) -> f64 {
        self.side_overlap_on([&Course::default(); 2], across_m, distance_m)
    }
}

/// Positions across of the lines, ascending.
#[must_use]
pub fn lines(strips: &[Strip]) -> Vec<f64> {
    let mut across_m: Vec<f64> = strips.iter().map(|strip| strip.across_m).collect();
    across_m.dedup();
    across_m
}
