//! The search far from the predicted place, on textures whose shift is known exactly, and what it must refuse.

mod seeded;
#[allow(dead_code, reason = "each test target that includes this module needs other parts")]
mod textures;

use plumbline_core::matching::judge::AcceptRule;
use plumbline_core::matching::reacquire::room;
use plumbline_core::matching::refine::Prior;
use plumbline_core::matching::{Located, View, locate_far};
use plumbline_core::rectify::Run;
use seeded::Random;
use textures::{Ground, Picture, Placement, all_valid, footprint};

const PRIOR: Prior = Prior { turn_rad: 0.005, scale: 0.001 };
const RADIUS: u16 = 64;
const TILE: (u16, u16) = (200, 200);

fn view(picture: &Picture) -> View<'_> {
    View::new(&picture.pixels, picture.size).expect("the sizes fit")
}

/// What comes of a patch whose centre is predicted `off` the tile's centre.
fn far(patch: &Picture, runs: &[Run], tile: &Picture, radius: u16, off: (i32, i32)) -> Located {
    let at = (i32::from(tile.size.0 - patch.size.0) / 2 + off.0, i32::from(tile.size.1 - patch.size.1) / 2 + off.1);
    let mut bytes = vec![0; room(patch.size, radius)];
    let rule = (PRIOR, &AcceptRule::default());
    locate_far(&view(patch), runs, (&view(tile), at), radius, rule, &mut bytes).expect("texture")
}

fn darkened(picture: Picture, gain: f64, offset: f64) -> Picture {
    let pixels = picture.pixels.iter().map(|&p| (f64::from(p) * gain + offset).round().clamp(0.0, 255.0) as u8);
    Picture { pixels: pixels.collect(), size: picture.size }
}

#[test]
fn explore() {
    for size in [(18, 18), (26, 26), (34, 34), (35, 35), (44, 44), (48, 48), (49, 49), (64, 64)] {
        for (deviation, shortest, noise) in
            [(40.0, 5.0, 3.0), (20.0, 5.0, 6.0), (40.0, 2.5, 3.0), (10.0, 5.0, 5.0), (40.0, 2.1, 3.0)]
        {
            let mut random = Random::new(5);
            let (mut found, mut accepted, mut wrong) = (0, 0, 0);
            let (mut score, mut second) = (0.0, 0.0);
            for seed in 0..60 {
                let ground = Ground::new(9000 + seed, deviation, shortest);
                let centre = (random.between(-60.0, 60.0), random.between(-60.0, 60.0));
                let patch =
                    ground.picture(size, Placement { centre, ..Placement::default() }, noise / 3.0, &mut random);
                let patch = darkened(patch, random.between(0.6, 1.0), random.between(0.0, 40.0));
                let tile =
                    ground.picture((208 + size.0 % 2, 208 + size.1 % 2), Placement::default(), noise, &mut random);
                let runs = if seed % 2 == 0 { footprint(size) } else { all_valid(size) };
                let located = far(&patch, &runs, &tile, RADIUS, (0, 0));
                let shift = located.shift();
                let off = (f64::from(shift.0) - centre.0).hypot(f64::from(shift.1) - centre.1);
                found += usize::from(off < 0.5);
                accepted += usize::from(located.accepted.is_ok());
                wrong += usize::from(located.accepted.is_ok() && off > 0.5);
                score += f64::from(located.peak.score) / 60.0;
                second += f64::from(located.peak.second) / 60.0;
            }
            println!(
                "{size:?} deviation {deviation} from {shortest} px noise {noise}: {found} found, {accepted} accepted, {wrong} wrong; score {score:.2} second {second:.2}"
            );
        }
    }
}
