//! Shaded relief of the terrain, as a picture.

use plumbline_charts::png::{Colour, encode, uri};
use plumbline_survey::dem::Dem;

/// Most pixels of the longer side.
const PIXELS_MAX: f64 = 800.0;
/// A pixel is no smaller than this share of the distance of two posts: there is nothing more to be seen.
const POST_SHARE: f64 = 0.25;
/// Light from the north-west, this high.
const SUN_ELEVATION_DEG: f64 = 45.0;
/// Share of the light that comes from all around.
const SKY: f64 = 0.35;
/// Slope that the average one is raised to, so that gentle ground shows its forms, and the most that it is raised.
const SLOPE: f64 = 0.35;
const RAISED_MAX: f64 = 8.0;
/// Low, middle and high ground.
pub const TINTS: [[f64; 3]; 3] = [[205.0, 219.0, 196.0], [240.0, 233.0, 208.0], [233.0, 219.0, 208.0]];
/// Where nothing is known: the page's tint.
const UNKNOWN: [u8; 3] = [244, 242, 236];

/// A shaded relief.
#[derive(Debug)]
pub struct Relief {
    /// The picture's address.
    pub uri: String,
    /// Lowest and highest terrain in it; nothing where none is known.
    pub heights_m: Option<[f64; 2]>,
}

/// The terrain within x0, y0, x1, y1 (working metres), north up.
pub fn picture(dem: &Dem, bounds: [f64; 4]) -> Relief {
    let [x0, y0, x1, y1] = bounds;
    let (width_m, height_m) = (x1 - x0, y1 - y0);
    let least_m = POST_SHARE * dem.step_m[0].min(dem.step_m[1]);
    let pixel_m = (width_m.max(height_m) / PIXELS_MAX).max(least_m);
    let count = |side_m: f64| (side_m / pixel_m).round().clamp(2.0, PIXELS_MAX) as usize;
    let (cols, rows) = (count(width_m), count(height_m));
    // One pixel more to each side than is shown, for the slopes.
    let (step_x, step_y) = (width_m / cols as f64, height_m / rows as f64);
    let heights: Vec<Option<f64>> = (0..(cols + 2) * (rows + 2))
        .map(|index| {
            let (col, row) = ((index % (cols + 2)) as f64 - 0.5, (index / (cols + 2)) as f64 - 0.5);
            dem.height(x0 + col * step_x, y1 - row * step_y)
        })
        .collect();
    let at = |col: usize, row: usize| heights[row * (cols + 2) + col];
    // Rise east and north for each metre; level where a neighbour is not known.
    let slope = |index: usize| {
        let (col, row) = (index % cols + 1, index / cols + 1);
        let rise = |a: Option<f64>, b: Option<f64>, run_m: f64| a.zip(b).map_or(0.0, |(a, b)| (b - a) / run_m);
        [rise(at(col - 1, row), at(col + 1, row), 2.0 * step_x), rise(at(col, row + 1), at(col, row - 1), 2.0 * step_y)]
    };
    let squares: f64 = (0..cols * rows).map(slope).map(|[east, north]| east * east + north * north).sum();
    let average = (squares / (cols * rows) as f64).sqrt();
    let raised = if average > 0.0 { (SLOPE / average).clamp(1.0, RAISED_MAX) } else { 1.0 };
    let known = || heights.iter().flatten();
    let (low, high) =
        (known().copied().fold(f64::INFINITY, f64::min), known().copied().fold(f64::NEG_INFINITY, f64::max));
    let pixels: Vec<u8> = (0..cols * rows)
        .flat_map(|index| {
            let height = at(index % cols + 1, index / cols + 1);
            height.map_or(UNKNOWN, |height| {
                let share = if high > low { (height - low) / (high - low) } else { 0.5 };
                let light = shade(slope(index).map(|rise| rise * raised));
                tint(share).map(|value| (value * light).clamp(0.0, 255.0) as u8)
            })
        })
        .collect();
    Relief { uri: uri(&encode(cols, rows, Colour::Rgb, &pixels)), heights_m: (low <= high).then_some([low, high]) }
}

/// Light of a slope, 1 on level ground.
fn shade([east, north]: [f64; 2]) -> f64 {
    let (sin, cos) = SUN_ELEVATION_DEG.to_radians().sin_cos();
    // The sun's direction east, north, up; the normal is (-east, -north, 1).
    let sun = [-cos * std::f64::consts::FRAC_1_SQRT_2, cos * std::f64::consts::FRAC_1_SQRT_2, sin];
    let light = (-east * sun[0] - north * sun[1] + sun[2]) / (east * east + north * north + 1.0).sqrt();
    // A part of it is the sky's, or the shades would drown what is drawn over them.
    SKY + (1.0 - SKY) * (light.max(0.0) / sin).min(1.3)
}

fn tint(share: f64) -> [f64; 3] {
    let place = 2.0 * share.clamp(0.0, 1.0);
    let lower = if place < 1.0 { 0 } else { 1 };
    let part = place - lower as f64;
    std::array::from_fn(|k| TINTS[lower][k] + part * (TINTS[lower + 1][k] - TINTS[lower][k]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slopes_towards_the_light_are_brighter() {
        assert_eq!(shade([0.0, 0.0]), 1.0);
        // Ground that rises to the east faces west, where the light comes from.
        assert!(shade([0.3, 0.0]) > 1.0 && shade([-0.3, 0.0]) < 1.0);
        assert!(shade([0.0, -0.3]) > 1.0 && shade([0.0, 0.3]) < 1.0);
    }
}
