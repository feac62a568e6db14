//! The matcher for maps of another year on textures whose shift is known exactly, against independent arithmetic, and what it must refuse.

mod aboard;
mod refusals;
use crate::matching::{PATCH, RADIUS, cosine, pairs, reference_size, view};
use plumbline_core::image::Run;
use plumbline_core::matching::directions::Peak;
use plumbline_core::matching::directions::search::{search, working_bytes};
use plumbline_core::matching::{MatchError, grey_correlation};
use plumbline_tests::seeded::Random;
use plumbline_tests::textures::{Ground, Picture, Placement, all_valid, footprint};

fn searched(patch: &Picture, runs: &[Run], reference: &Picture) -> Result<Peak, MatchError> {
    let side = usize::from(2 * RADIUS + 1);
    let (mut scores, mut bytes) = (vec![i16::MAX; side * side], vec![0; working_bytes(patch.size, reference.size)]);
    search(&view(patch), runs, &view(reference), RADIUS, &mut bytes, &mut scores)
}

/// A random shift within the search, and its placement: the patch lies where its shift says on the reference's ground.
fn shifted(random: &mut Random) -> Placement {
    Placement { centre: (random.between(-8.0, 8.0), random.between(-8.0, 8.0)), ..Placement::default() }
}

/// The ground in another state: each grey turned into another by a curve that falls and rises again.
fn changed(picture: Picture) -> Picture {
    let curve = |p: u8| (220.0 - 190.0 * (f64::from(p) / 255.0 * 2.2).sin()).round().clamp(0.0, 255.0) as u8;
    Picture { pixels: picture.pixels.into_iter().map(curve).collect(), ..picture }
}

/// Gradient directions by their definition, ±127 for a length of 1: Sobel's gradients, the angle doubled, the squared length m² over
/// m² and half of its median, and the mean of 3 x 3 around with the weights 1 2 1. Where the runs end the nearest pixel of the nearest row
/// goes on. One run a row.
fn directions(picture: &Picture, runs: &[Run]) -> [Picture; 2] {
    let cols = usize::from(picture.size.0);
    let grey = |col: i32, row: i32| {
        let run = runs.iter().min_by_key(|run| (i32::from(run.row) - row).abs()).expect("runs");
        let col = col.clamp(i32::from(run.start), i32::from(run.end) - 1) as usize;
        f64::from(picture.pixels[usize::from(run.row) * cols + col])
    };
    let weights = [(-1, 1.0), (0, 2.0), (1, 1.0)];
    let gradient = |col: i32, row: i32| {
        let along = |by: &dyn Fn(i32, i32) -> f64| {
            weights.iter().map(|&(side, weight)| weight * (by(1, side) - by(-1, side))).sum::<f64>()
        };
        (along(&|ahead, side| grey(col + ahead, row + side)), along(&|ahead, side| grey(col + side, row + ahead)))
    };
    let places = |run: &Run| (run.start..run.end).map(|col| (i32::from(col), i32::from(run.row))).collect::<Vec<_>>();
    let energy = |(x, y): (f64, f64)| x * x + y * y;
    let counted = runs.iter().skip(3).step_by(4).flat_map(places);
    let mut energies: Vec<f64> = counted.map(|(col, row)| energy(gradient(col, row))).collect();
    energies.sort_by(f64::total_cmp);
    let floor = (0.5 * energies[energies.len() / 2]).max(4.0);
    let doubled = |col: i32, row: i32| {
        let (x, y) = gradient(col, row);
        let per = 127.0 / (energy((x, y)) + floor);
        [(x * x - y * y) * per, 2.0 * x * y * per]
    };
    [0, 1].map(|channel| {
        let mut pixels = vec![128; picture.pixels.len()];
        for (col, row) in runs.iter().flat_map(places) {
            let around = weights.iter().flat_map(|down| weights.iter().map(move |right| (right, down)));
            let sum: f64 =
                around.map(|(right, down)| right.1 * down.1 * doubled(col + right.0, row + down.0)[channel]).sum();
            pixels[row as usize * cols + col as usize] = ((sum / 16.0).round() + 128.0) as u8;
        }
        Picture { pixels, size: picture.size }
    })
}

/// No shift scores higher than the peak, by f64 arithmetic of its own. Its median of the squared lengths is the middle one of them,
/// the core's is good to a sixteenth of it, which is a sixtieth of a value at most.
#[test]
fn scores_are_the_correlation_of_gradient_directions() {
    let mut random = Random::new(21);
    for (seed, deviation) in [(1, 40.0), (2, 5.0), (3, 90.0)] {
        let ground = Ground::new(seed, deviation, 5.0);
        for runs in [all_valid(PATCH), footprint(PATCH)] {
            let placement = shifted(&mut random);
            let patch = ground.picture(PATCH, placement, 3.0, &mut random);
            let reference = ground.picture(reference_size(PATCH), Placement::default(), 3.0, &mut random);
            let (own, others) = (directions(&patch, &runs), directions(&reference, &all_valid(reference.size)));
            let both = |shift| {
                let channels = own.iter().zip(&others).map(|(own, others)| pairs(own, &runs, others, shift));
                let signed = |v: Vec<f64>| v.into_iter().map(|v| v - 128.0);
                channels.fold((Vec::new(), Vec::new()), |(mut p, mut r), (own, other)| {
                    p.extend(signed(own));
                    r.extend(signed(other));
                    (p, r)
                })
            };
            let score = |shift| {
                let (p, r) = both(shift);
                cosine(&p, &r)
            };
            let peak = searched(&patch, &runs, &reference).expect("texture");
            let best = (0..21 * 21).map(|i| (i % 21, i / 21)).max_by(|&a, &b| score(a).total_cmp(&score(b)));
            let at = (peak.d_col, peak.d_row);
            let from_corner = ((at.0 + 10) as usize, (at.1 + 10) as usize);
            assert_eq!(Some(from_corner), best);
            assert!((f64::from(peak.score) - score(from_corner)).abs() < 0.005, "{peak:?}, {}", score(from_corner));
            assert!((peak.evidence.score - peak.score).abs() < 1e-5, "the parts are the whole: {peak:?}");
            let beside = [(1, 0), (-1, 0), (0, 1), (0, -1)]
                .map(|(right, down)| score(((at.0 + 10 + right) as usize, (at.1 + 10 + down) as usize)));
            let curvature = 4.0 * score(from_corner) - beside.iter().sum::<f64>();
            assert!((f64::from(peak.evidence.curvature) - curvature).abs() < 0.01, "{peak:?}, {curvature}");
        }
    }
}

/// Gain and offset are exact here (twice the patch plus 7): the scores differ by the rounding of the directions, and the place not at
/// all; nor does it in the negative, of which the greys say nothing.
#[test]
fn gain_offset_and_the_sign_of_contrast_do_not_matter() {
    let mut random = Random::new(22);
    let ground = Ground::new(4, 15.0, 5.0);
    let dark = ground.picture(PATCH, shifted(&mut random), 2.0, &mut random);
    let dark = Picture { pixels: dark.pixels.iter().map(|&p| p / 2).collect(), ..dark };
    let bright = Picture { pixels: dark.pixels.iter().map(|&p| 2 * p + 7).collect(), ..dark };
    let negative = Picture { pixels: dark.pixels.iter().map(|&p| 255 - 2 * p).collect(), ..dark };
    let reference = ground.picture(reference_size(PATCH), Placement::default(), 2.0, &mut random);
    let runs = footprint(PATCH);
    let peak = |patch: &Picture| searched(patch, &runs, &reference).expect("texture");
    let d = peak(&dark);
    for other in [peak(&bright), peak(&negative)] {
        assert!((d.d_col, d.d_row) == (other.d_col, other.d_row), "{d:?}, {other:?}");
        assert!((d.score - other.score).abs() < 0.03, "{d:?}, {other:?}");
    }
    let greys = grey_correlation(&view(&negative), &runs, &view(&reference), RADIUS, (d.d_col, d.d_row));
    assert!(greys < -0.5, "{greys}");
}

#[test]
fn what_lies_outside_the_runs_does_not_matter() {
    let mut random = Random::new(23);
    let ground = Ground::new(5, 40.0, 5.0);
    let patch = ground.picture(PATCH, shifted(&mut random), 3.0, &mut random);
    let reference = ground.picture(reference_size(PATCH), Placement::default(), 3.0, &mut random);
    let runs = footprint(PATCH);
    let mut spoilt = patch.clone();
    for (i, pixel) in spoilt.pixels.iter_mut().enumerate() {
        let (col, row) = ((i % 34) as u16, (i / 34) as u16);
        if !runs.iter().any(|run| run.row == row && (run.start..run.end).contains(&col)) {
            *pixel = random.byte();
        }
    }
    assert_ne!(patch.pixels, spoilt.pixels);
    assert_eq!(searched(&patch, &runs, &reference), searched(&spoilt, &runs, &reference));
}
