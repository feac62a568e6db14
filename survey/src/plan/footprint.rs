//! Where frames meet the ground.

use super::lines::{Layout, Strip};
use crate::dem::Dem;

/// Steps of bisection between a place above the ground and one below it: half a post to less than a millimetre.
const BISECTIONS: u32 = 24;

/// Level photos over terrain.
#[derive(Debug)]
pub struct Sight<'p> {
    layout: &'p Layout<'p>,
    dem: &'p Dem,
    /// Lowest and highest known post.
    range_m: [f64; 2],
    /// Half a frame as tangents, along and across.
    half_tangent: [f64; 2],
}

impl<'p> Sight<'p> {
    /// Looks once through all posts.
    #[must_use]
    pub fn new(layout: &'p Layout<'p>) -> Self {
        let (dem, view) = (layout.terrain.dem(), &layout.view);
        Sight {
            layout,
            dem,
            range_m: dem.range_m().unwrap_or([f64::INFINITY, f64::NEG_INFINITY]),
            half_tangent: view.half_tangent(),
        }
    }

    /// Where the rays of a frame's corners first meet the terrain, working metres, counter-clockwise in the strip's own axes. A
    /// ray that meets none, as the elevation model ends before, ends on the plane H below it.
    #[must_use]
    pub fn corners(&self, strip: &Strip, along_m: f64) -> [[f64; 2]; 4] {
        let [half_along, half_across] = self.half_tangent;
        [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]]
            .map(|[i, j]| self.meets(strip, along_m, [i * half_along, j * half_across]))
    }

    /// Where the ray of a strip's photo with these tangents meets the terrain.
    pub(super) fn meets(&self, strip: &Strip, along_m: f64, tangent: [f64; 2]) -> [f64; 2] {
        let (photo, up_m) = ([along_m, strip.across_m], self.layout.view.up_m(strip.course.rise_m(along_m)));
        let at =
            |depth_m: f64| self.layout.axes.point([photo[0] + depth_m * tangent[0], photo[1] + depth_m * tangent[1]]);
        let is_below = |depth_m: f64| {
            let [x, y] = at(depth_m);
            self.dem.height(x, y).is_some_and(|height| height >= up_m - depth_m)
        };
        let [from_m, to_m] = [up_m - self.range_m[1], up_m - self.range_m[0]];
        let step_m = 0.5 * self.dem.step_m[0].min(self.dem.step_m[1]) / tangent[0].hypot(tangent[1]);
        let steps = ((to_m - from_m) / step_m).ceil().max(1.0) as u64;
        let depth_of = |step: u64| from_m + (to_m - from_m) * step as f64 / steps as f64;
        let Some(first) = (0..=steps).find(|step| is_below(depth_of(*step))) else {
            return at(self.layout.view.height_m);
        };
        let mut between = [depth_of(first.saturating_sub(1)), depth_of(first)];
        for _ in 0..BISECTIONS {
            let middle_m = 0.5 * (between[0] + between[1]);
            between[usize::from(is_below(middle_m))] = middle_m;
        }
        at(between[1])
    }
}
