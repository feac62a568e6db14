//! Rays over terrain, step by step.

use super::terrain::Terrain;

/// Part of a post's distance that a ray steps, horizontally.
const STEP: f64 = 0.25;
/// Steepest rays step by height instead, metres.
const DROP: f64 = 5.0;

/// Where the ray from `from` along `direction`, which leads down, first meets the terrain; `None` where it leaves the model.
pub fn cast(terrain: &Terrain, from: [f64; 3], direction: [f64; 3]) -> Option<[f64; 3]> {
    let at = |t: f64| [0, 1, 2].map(|axis| from[axis] + t * direction[axis]);
    let run = direction[0].hypot(direction[1]);
    let step = (STEP * terrain.step[0].min(terrain.step[1]) / run).min(DROP / -direction[2]);
    let highest = terrain.heights.iter().copied().filter(|h| h.is_finite()).fold(f64::MIN, f64::max);
    let mut above = ((from[2] - highest) / -direction[2]).max(0.0);
    loop {
        let [x, y, z] = at(above + step);
        if terrain.height(x, y)? >= z {
            break;
        }
        above += step;
    }
    let mut below = above + step;
    for _ in 0..60 {
        let middle = 0.5 * (above + below);
        let [x, y, z] = at(middle);
        if terrain.height(x, y)? >= z { below = middle } else { above = middle }
    }
    Some(at(below))
}
