//! Trees: painted crowns with a bright and a dark side and a shadow on the ground. They have no height in the surface.

use super::buildings::House;
use super::layout::Layout;
use super::parcels::{Edge, Use};
use super::{SIDE, STEP_M, clipped, local_m, pixel_of, streams};
use crate::noise::pixels::{stream, uniform, unit};

#[derive(Clone, Copy, Debug)]
pub(super) struct Tree {
    at: [f64; 2],
    radius_m: f64,
    tone: f64,
}

impl Tree {
    /// Where it stands.
    pub(super) fn at(&self) -> [f64; 2] {
        self.at
    }
}

/// Candidates stand on a jittered lattice of this pitch; what grows at each depends on where it is.
const PITCH_M: f64 = 5.6;

/// All trees, from north to south, so that a crown is drawn over the shadow and the crown behind it.
pub(super) fn place(seed: u64, layout: &Layout, houses: &[House]) -> Vec<Tree> {
    let mut rng = stream(seed, streams::TREES);
    let lattice = (2.0 * local_m(SIDE - 1) / PITCH_M) as usize;
    let mut trees = Vec::new();
    for candidate in 0..lattice * lattice {
        let (i, j) = (candidate % lattice, candidate / lattice);
        let mut along = |k: usize| local_m(0) + (k as f64 + uniform(&mut rng, 0.05, 0.95)) * PITCH_M;
        let at = [along(i), along(j)];
        let (luck, size, tone) = (unit(&mut rng), unit(&mut rng), uniform(&mut rng, 78.0, 118.0));
        let spot = layout.spot(at);
        let [from_bank, from_road] = layout.beyond_river_and_road(at);
        let clear = layout.soil(at) > 1.3; // a glade
        let paved = matches!(spot.edge, Edge::Lane | Edge::Street | Edge::Track) && spot.beyond_m < 1.0;
        let wanted = match spot.parcel.kind {
            _ if from_bank < 2.5 || from_road < 2.0 || paved => 0.0,
            _ if from_bank < 13.0 => 0.45,
            Use::Wood if spot.beyond_m > 2.0 && !clear => 0.95,
            _ if spot.edge == Edge::Hedge && spot.beyond_m < 1.5 => 0.7,
            _ if (4.0..7.0).contains(&from_road) => 0.16,
            Use::Yard => 0.2,
            Use::Meadow => 0.012,
            _ if matches!(spot.edge, Edge::Lane) && spot.beyond_m < 4.0 => 0.08,
            _ => 0.0,
        };
        let radius_m = match spot.parcel.kind {
            Use::Wood => 2.3 + 1.9 * size,
            _ => 1.3 + 2.7 * size * size,
        };
        if luck < wanted && houses.iter().all(|house| !house.within(at, radius_m * 0.7)) {
            let tone = if spot.parcel.kind == Use::Wood { tone - 10.0 } else { tone };
            trees.push(Tree { at, radius_m, tone });
        }
    }
    trees.sort_by(|a, b| b.at[1].total_cmp(&a.at[1]));
    trees
}

/// Paints shadow and crown of each tree; its tone has the season's gain and offset.
pub(super) fn draw(albedo: &mut [f32], trees: &[Tree], grain: &[f32], sun: [f64; 3], [gain, offset]: [f64; 2]) {
    for tree in trees {
        // The crown's middle is about 1.4 radii above the ground.
        let fall = 1.4 * tree.radius_m / sun[2];
        let shadow = [tree.at[0] - fall * sun[0], tree.at[1] - fall * sun[1]];
        disc(shadow, tree.radius_m, |index, [u, v]| {
            let edge = ((1.0 - u.hypot(v)) * tree.radius_m / STEP_M).clamp(0.0, 1.0) as f32;
            albedo[index] *= 1.0 - 0.45 * edge;
        });
        disc(tree.at, tree.radius_m, |index, [u, v]| {
            let rough = f64::from(grain[index]);
            let reach = u.hypot(v) * (1.0 + 0.12 * rough);
            let edge = ((1.0 - reach) * tree.radius_m / STEP_M).clamp(0.0, 1.0);
            let up = (1.0 - reach * reach).max(0.0).sqrt();
            let light = (u * sun[0] + v * sun[1] + up * sun[2]).max(0.0);
            let crown = (tree.tone * gain + offset) * (0.42 + 0.72 * light) + 9.0 * rough;
            albedo[index] += ((crown - f64::from(albedo[index])) * edge) as f32;
        });
    }
}

/// Calls `touch(pixel index, position relative to the radius, east and north)` for the pixels of a disc.
fn disc(at: [f64; 2], radius_m: f64, mut touch: impl FnMut(usize, [f64; 2])) {
    let ([col, row], reach) = (pixel_of(at), 1.15 * radius_m / STEP_M);
    for r in clipped(row - reach, row + reach) {
        for c in clipped(col - reach, col + reach) {
            touch(r * SIDE + c, [(local_m(c) - at[0]) / radius_m, (-local_m(r) - at[1]) / radius_m]);
        }
    }
}
