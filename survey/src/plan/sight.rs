//! Which photos see a ground point.

use super::axes::Axes;
use super::lines::{Strip, View};
use super::terrain::Terrain;

/// A photo that sees a point: which, and the direction of the ray as tangents from the vertical.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ray {
    /// Place of the strip in its list.
    pub strip: usize,
    /// Number of the photo in the strip.
    pub photo: usize,
    /// Along and across, from photo to point, over the depth.
    pub tangent: [f64; 2],
    /// Depth of the point below the photo.
    pub depth_m: f64,
}

/// Level photos of strips, looked up by place.
#[derive(Debug)]
pub struct Photos<'p> {
    strips: &'p [Strip],
    terrain: &'p Terrain<'p>,
    axes: Axes,
    /// Height of each photo, strip by strip.
    up_m: Vec<Vec<f64>>,
    /// The highest of them.
    highest_m: f64,
    /// Half a footprint over the height.
    half_tangent: [f64; 2],
}

impl<'p> Photos<'p> {
    /// Photos of `strips`, which are in the order of their lines.
    #[must_use]
    pub fn new(strips: &'p [Strip], terrain: &'p Terrain<'p>, axes: Axes, view: &View) -> Self {
        let up_m: Vec<Vec<f64>> = strips.iter().map(|strip| view.ups_m(strip).collect()).collect();
        let highest_m = up_m.iter().flatten().copied().fold(f64::NEG_INFINITY, f64::max);
        Photos { strips, terrain, axes, up_m, highest_m, half_tangent: view.half_tangent() }
    }

    /// Their strips.
    #[must_use]
    pub fn strips(&self) -> &'p [Strip] {
        self.strips
    }

    /// The rays of all photos that see the ground point at (x, y), strip by strip; no terrain stands between. `clear` is the
    /// slope from which none can ([`Terrain::clear_slope`]).
    pub fn rays(&self, [x, y]: [f64; 2], ground_m: f64, clear: f64, rays: &mut Vec<Ray>) {
        rays.clear();
        let deepest_m = self.highest_m - ground_m;
        if deepest_m.is_nan() || deepest_m <= 0.0 {
            return;
        }
        let [along, across] = self.axes.of([x, y]);
        let [far_along, far_across] = self.half_tangent.map(|half| half * deepest_m);
        let first = self.strips.partition_point(|strip| strip.across_m < across - far_across);
        let seeing =
            self.strips[first..].iter().enumerate().take_while(|(_, strip)| strip.across_m <= across + far_across);
        for (offset, strip) in seeing {
            let from = strip.along_m.partition_point(|at| *at < along - far_along);
            let photos = strip.along_m[from..].iter().enumerate().take_while(|(_, at)| **at <= along + far_along);
            for (photo, at) in photos {
                let up_m = self.up_m[first + offset][from + photo];
                let depth_m = up_m - ground_m;
                if !(depth_m > 0.0 && self.is_within([along, across], [*at, strip.across_m], depth_m)) {
                    continue;
                }
                let tangent = [(along - at) / depth_m, (across - strip.across_m) / depth_m];
                let [a, b] = tangent;
                if clear * clear * (a * a + b * b) <= 1.0
                    || self.is_clear([x, y, ground_m], [*at, strip.across_m], up_m)
                {
                    rays.push(Ray { strip: first + offset, photo: from + photo, tangent, depth_m });
                }
            }
        }
    }

    /// Whether a point lies within the footprint of a photo so far above it.
    fn is_within(&self, point: [f64; 2], photo: [f64; 2], depth_m: f64) -> bool {
        (0..2).all(|axis| {
            let reach_m = self.half_tangent[axis] * depth_m;
            photo[axis] >= point[axis] - reach_m && photo[axis] <= point[axis] + reach_m
        })
    }

    /// Whether no terrain stands between a ground point and a photo, step by step. Ground that is not known hides nothing.
    fn is_clear(&self, ground: [f64; 3], photo: [f64; 2], up_m: f64) -> bool {
        let [x, y] = self.axes.point(photo);
        let (run_m, rise_m) = ((x - ground[0]).hypot(y - ground[1]), up_m - ground[2]);
        let Some(highest_m) = self.terrain.highest() else { return true };
        let dem = self.terrain.dem();
        let step_m = 0.5 * dem.step_m[0].min(dem.step_m[1]);
        // Above all terrain nothing stands in the way.
        let until = ((highest_m - ground[2]) / rise_m).min(1.0);
        let steps = (until * run_m / step_m).ceil() as usize;
        (1..=steps).all(|k| {
            let part = until * k as f64 / steps as f64;
            let at = [ground[0] + part * (x - ground[0]), ground[1] + part * (y - ground[1])];
            dem.height(at[0], at[1]).is_none_or(|height| height <= ground[2] + part * rise_m)
        })
    }
}
