//! The width of ground that neighbouring strips truly see in common.
//!
//! The overlap is that of photos over level ground at the height of the highest terrain that both see. On a slope the edges of
//! two swaths lie at different heights, so the ground between them is wider or narrower than that. Here the edge rays are
//! followed to the terrain, at the position along of each exposure.

use super::footprint::Sight;
use super::lines::{Layout, Strip};
use rayon::prelude::*;

impl Layout<'_> {
    /// The smallest width between the edges of neighbouring strips, as a share of the wider of their swaths at that position
    /// along; `None` where all strips lie on one line. Below 0 they leave a gap.
    #[must_use]
    pub fn swath_min(&self, strips: &[Strip]) -> Option<f64> {
        let sight = Sight::new(self);
        let [_, half] = self.view.half_tangent();
        let across =
            |strip: &Strip, along_m: f64, tangent: f64| self.axes.of(sight.meets(strip, along_m, [0.0, tangent]))[1];
        let lines: Vec<&[Strip]> = strips.chunk_by(|a, b| a.line == b.line).collect();
        let pairs: Vec<(f64, &Strip, &Strip)> = lines
            .windows(2)
            .flat_map(|pair| {
                let positions = pair.iter().copied().flatten().flat_map(|strip| &strip.along_m);
                positions.map(move |along_m| (*along_m, &pair[0][0], &pair[1][0]))
            })
            .collect();
        let share = |&(along_m, low, high): &(f64, &Strip, &Strip)| {
            let low = [-half, half].map(|tangent| across(low, along_m, tangent));
            let high = [-half, half].map(|tangent| across(high, along_m, tangent));
            (low[1] - high[0]) / (low[1] - low[0]).max(high[1] - high[0])
        };
        pairs.par_iter().map(share).reduce_with(f64::min)
    }
}
