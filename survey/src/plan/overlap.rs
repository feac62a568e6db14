//! The overlap that strips have on the ground.
//!
//! A ground point at height dh above the base plane lies in the next photo B / (1 - dh / H) further back on the base plane's
//! scale, so the share of a photo that the next one sees too is 1 - B / (l (1 - dh / H)), smallest at the highest terrain of
//! the overlap.

use super::lines::{Layout, Strip};
use super::terrain::Zone;

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
            strip.along_m.windows(2).map(|pair| self.forward_overlap(strip.across_m, pair[0], pair[1] - pair[0]))
        });
        let lines = lines(strips);
        let mut side = lines.windows(2).map(|pair| self.side_overlap(pair[0], pair[1] - pair[0]));
        Achieved { forward: smallest(&mut forward), side: smallest(&mut side) }
    }

    /// Overlap of a photo with the next, a base further.
    #[must_use]
    pub fn forward_overlap(&self, across_m: f64, along_m: f64, base_m: f64) -> f64 {
        self.overlap(base_m, self.view.footprint_m[0], &self.view.forward_zone(along_m, base_m, across_m))
    }

    /// Overlap of a line with the next.
    #[must_use]
    pub fn side_overlap(&self, across_m: f64, distance_m: f64) -> f64 {
        let zone = self.view.side_zone(across_m, distance_m, self.planned_m(across_m));
        self.overlap(distance_m, self.view.footprint_m[1], &zone)
    }

    fn overlap(&self, distance_m: f64, footprint_m: f64, zone: &Zone) -> f64 {
        let highest_m = self.terrain.highest_in(&self.axes, zone).unwrap_or(self.view.base_height_m);
        let share = 1.0 - (highest_m - self.view.base_height_m) / self.view.height_m;
        // Terrain that reaches the camera leaves nothing to overlap.
        if share > 0.0 { 1.0 - distance_m / (footprint_m * share) } else { f64::NEG_INFINITY }
    }
}

/// Positions across of the lines, ascending.
#[must_use]
pub fn lines(strips: &[Strip]) -> Vec<f64> {
    let mut across_m: Vec<f64> = strips.iter().map(|strip| strip.across_m).collect();
    across_m.dedup();
    across_m
}
