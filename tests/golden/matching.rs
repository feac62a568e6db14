//! The core's matching on textures whose shift is known exactly, against independent arithmetic, and what it must refuse.
//!
//! The pictures are made without the core: waves integrated over each pixel in closed form, in `f64`, then noise and
//! rounding.

#[path = "matching/refusals.rs"]
mod refusals;
mod seeded;
mod textures;

use plumbline_core::matching::refine::{Prior, SubPixel, refine};
use plumbline_core::matching::search::{Peak, SearchError, peak, search_into};
use plumbline_core::matching::{Limits, View};
use plumbline_core::rectify::Run;
use seeded::Random;
use textures::{Ground, Picture, Placement, all_valid, footprint};

/// The default patch: 150 m high, 60 degrees, 5 m a pixel.
const PATCH: (u16, u16) = (34, 34);
const RADIUS: u16 = 10;
/// Heading to 0.3 degrees, height to 0.1 %.
const PRIOR: Prior = Prior { turn_rad: 0.005, scale: 0.001 };

fn reference_size((cols, rows): (u16, u16)) -> (u16, u16) {
    (cols + 2 * RADIUS, rows + 2 * RADIUS)
}

fn view(picture: &Picture) -> View<'_> {
    View::new(&picture.pixels, picture.size).expect("the sizes fit")
}

/// The plain correlation of every shift.
fn scores(patch: &Picture, runs: &[Run], reference: &Picture) -> Result<Vec<f32>, SearchError> {
    let side = usize::from(2 * RADIUS + 1);
    let mut scores = vec![f32::NAN; side * side];
    search_into(&view(patch), runs, Limits::NONE, &view(reference), RADIUS, &mut scores).map(|()| scores)
}

/// The best place as the pipeline looks for it, both pictures within their limits.
fn best(patch: &Picture, runs: &[Run], reference: &Picture) -> Result<Peak, SearchError> {
    let side = usize::from(2 * RADIUS + 1);
    let (mut scores, mut pixels) = (vec![f32::NAN; side * side], reference.pixels.clone());
    let (patch, reference) = (view(patch), view(reference));
    let limited = reference.limited_into(&mut pixels).expect("the sizes fit");
    search_into(&patch, runs, patch.limits(runs), &limited, RADIUS, &mut scores)?;
    Ok(peak(&scores, RADIUS).expect("scores of this radius"))
}

/// The peak, and the sub-pixel solution around it.
fn matched(patch: &Picture, runs: &[Run], reference: &Picture, prior: Prior) -> (Peak, SubPixel) {
    let peak = best(patch, runs, reference).expect("texture");
    let solution = refine(&view(patch), runs, &view(reference), RADIUS, &peak, prior).expect("texture");
    (peak, solution)
}

/// Error of a match, pixels along each axis.
fn off(solution: &SubPixel, shift: (f64, f64)) -> (f64, f64) {
    (f64::from(solution.d_col) - shift.0, f64::from(solution.d_row) - shift.1)
}

/// A random shift within the search, and its placement: the patch lies where its shift says on the reference's ground.
fn shifted(random: &mut Random) -> ((f64, f64), Placement) {
    let centre = (random.between(-8.0, 8.0), random.between(-8.0, 8.0));
    (centre, Placement { centre, ..Placement::default() })
}

/// Normalised cross-correlation by its definition, in `f64`, with the means taken off first.
fn correlation(patch: &Picture, runs: &[Run], reference: &Picture, col: usize, row: usize) -> f64 {
    let (mut p, mut r) = (Vec::new(), Vec::new());
    for run in runs {
        for x in usize::from(run.start)..usize::from(run.end) {
            let y = usize::from(run.row);
            p.push(f64::from(patch.pixels[y * usize::from(patch.size.0) + x]));
            r.push(f64::from(reference.pixels[(y + row) * usize::from(reference.size.0) + x + col]));
        }
    }
    let centred = |values: &[f64]| {
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        values.iter().map(|v| v - mean).collect::<Vec<f64>>()
    };
    let (p, r) = (centred(&p), centred(&r));
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    dot(&p, &r) / (dot(&p, &p) * dot(&r, &r)).sqrt()
}

#[test]
fn scores_are_the_normalised_cross_correlation() {
    let mut random = Random::new(21);
    let mut worst = 0.0f64;
    for (seed, deviation) in [(1, 40.0), (2, 3.0), (3, 90.0)] {
        let ground = Ground::new(seed, deviation, 5.0);
        for runs in [all_valid(PATCH), footprint(PATCH)] {
            let (_, placement) = shifted(&mut random);
            let patch = ground.picture(PATCH, placement, 3.0, &mut random);
            let reference = ground.picture(reference_size(PATCH), Placement::default(), 3.0, &mut random);
            for (i, &score) in scores(&patch, &runs, &reference).expect("texture").iter().enumerate() {
                let (col, row) = (i % 21, i / 21);
                let off = (f64::from(score) - correlation(&patch, &runs, &reference, col, row)).abs();
                worst = worst.max(off);
                assert!(off < 1e-5, "{score} at {col}, {row}: {off} off");
            }
        }
    }
    println!("correlation: at most {worst:.1e} from its definition");
}

/// Gain and offset are exact here (twice the patch plus 7), so only single precision differs.
#[test]
fn gain_and_offset_do_not_change_the_score() {
    let mut random = Random::new(22);
    let ground = Ground::new(4, 15.0, 5.0);
    let (_, placement) = shifted(&mut random);
    let dark = ground.picture(PATCH, placement, 2.0, &mut random);
    let dark = Picture { pixels: dark.pixels.iter().map(|&p| p / 2).collect(), ..dark };
    let bright = Picture { pixels: dark.pixels.iter().map(|&p| 2 * p + 7).collect(), ..dark };
    let negative = Picture { pixels: dark.pixels.iter().map(|&p| 255 - 2 * p).collect(), ..dark };
    let reference = ground.picture(reference_size(PATCH), Placement::default(), 2.0, &mut random);
    let [dark, bright, negative] =
        [dark, bright, negative].map(|patch| scores(&patch, &footprint(PATCH), &reference).expect("texture"));
    for ((dark, bright), negative) in dark.iter().zip(&bright).zip(&negative) {
        assert!((dark - bright).abs() < 1e-4 && (dark + negative).abs() < 1e-4, "{dark}, {bright}, {negative}");
    }
}

#[test]
fn what_lies_outside_the_runs_does_not_matter() {
    let mut random = Random::new(23);
    let ground = Ground::new(5, 40.0, 5.0);
    let (_, placement) = shifted(&mut random);
    let patch = ground.picture(PATCH, placement, 3.0, &mut random);
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
    assert_eq!(scores(&patch, &runs, &reference), scores(&spoilt, &runs, &reference));
    assert_eq!(matched(&patch, &runs, &reference, PRIOR), matched(&spoilt, &runs, &reference, PRIOR));
}

/// What a series of trials is made of: grounds of `deviation` grey levels and waves from `shortest_px` on, pictures with
/// `noise`, the footprint of a tilted camera or the whole patch.
#[derive(Debug, Clone, Copy)]
struct Series {
    seed: u64,
    deviation: f64,
    shortest_px: f64,
    noise: f64,
    tilted: bool,
}

/// One sigma that the core adds along each axis for what no residual shows: the pictures' sampling, relief. These pictures
/// have none of that, so it is made up: the truth is moved by as much.
const SYSTEMATIC_PX: f64 = 0.05;

/// Shift errors over `trials` random shifts and grounds: mean and largest length, and the mean of e' C⁻¹ e.
fn trials(trials: usize, series: Series) -> (f64, f64, f64) {
    let Series { seed, deviation, shortest_px, noise, tilted } = series;
    let mut random = Random::new(seed);
    let (mut sum, mut worst, mut nees) = (0.0, 0.0f64, 0.0);
    for trial in 0..trials {
        let ground = Ground::new(seed * 1000 + trial as u64 / 10, deviation, shortest_px);
        let (shift, placement) = shifted(&mut random);
        let patch = ground.picture(PATCH, placement, noise, &mut random);
        let reference = ground.picture(reference_size(PATCH), Placement::default(), noise, &mut random);
        let runs = if tilted { footprint(PATCH) } else { all_valid(PATCH) };
        let (peak, solution) = matched(&patch, &runs, &reference, PRIOR);
        let (x, y) = off(&solution, shift);
        let whole = (f64::from(peak.d_col) - shift.0).abs().max((f64::from(peak.d_row) - shift.1).abs());
        assert!(whole < 1.0, "the peak is {whole} px off, trial {trial}");
        sum += x.hypot(y);
        worst = worst.max(x.hypot(y));
        let c = solution.covariance.map(f64::from);
        let determinant = c[(0, 0)] * c[(1, 1)] - c[(0, 1)] * c[(1, 0)];
        let (x, y) = (x + SYSTEMATIC_PX * random.normal(), y + SYSTEMATIC_PX * random.normal());
        nees += (c[(1, 1)] * x * x - 2.0 * c[(0, 1)] * x * y + c[(0, 0)] * y * y) / determinant;
    }
    let (mean, nees) = (sum / trials as f64, nees / trials as f64);
    println!("{series:?}: mean {mean:.4}, max {worst:.4} px, NEES {nees:.2}");
    (mean, worst, nees)
}

/// Noise-free: what remains is rounding (0.29 grey levels in 1156 pixels of 10 grey levels a pixel: 0.001 px) and the
/// cubic interpolation of waves of 5 pixels, of whose slope it loses a few per cent.
#[test]
fn without_noise_the_shift_is_met_to_two_hundredths() {
    for (seed, tilted) in [(31, false), (32, true)] {
        let (_, worst, _) = trials(100, Series { seed, deviation: 40.0, shortest_px: 5.0, noise: 0.0, tilted });
        assert!(worst < 0.02, "{worst} px");
    }
}

#[test]
fn with_noise_the_shift_is_met_to_eight_hundredths() {
    for (seed, deviation, tilted) in [(33, 40.0, false), (34, 40.0, true), (35, 20.0, true)] {
        let (mean, ..) = trials(200, Series { seed, deviation, shortest_px: 5.0, noise: 3.0, tilted });
        assert!(mean < 0.08, "{mean} px");
    }
}

/// e' C⁻¹ e has a mean of 2 and, over 500 trials, a deviation of 0.09: the covariance neither brags nor hides. Waves of 8
/// pixels and more, so that noise decides and not interpolation.
#[test]
fn the_covariance_is_honest() {
    let cases = [(41, 20.0, 3.0, true), (42, 20.0, 6.0, false), (43, 30.0, 8.0, true), (44, 15.0, 5.0, true)];
    let means = cases.map(|(seed, deviation, noise, tilted)| {
        trials(500, Series { seed, deviation, shortest_px: 8.0, noise, tilted }).2
    });
    assert!(means.iter().all(|nees| (1.6..2.6).contains(nees)), "NEES {means:.2?}");
}

/// A heading off by 1 degree and a height off by 1 %, with priors that allow for it: the shift stays right.
#[test]
fn turn_and_scale_leave_the_shift_alone() {
    let prior = Prior { turn_rad: 0.0175, scale: 0.01 };
    let mut random = Random::new(51);
    for trial in 0..40 {
        let ground = Ground::new(5100 + trial, 40.0, 5.0);
        let (shift, placement) = shifted(&mut random);
        let sign = |bit: u64| if trial & bit == 0 { 1.0 } else { -1.0 };
        let placement = Placement { turn_rad: sign(1) * 0.01745, scale: sign(2) * 0.01, ..placement };
        let patch = ground.picture(PATCH, placement, 0.0, &mut random);
        let reference = ground.picture(reference_size(PATCH), Placement::default(), 0.0, &mut random);
        let (_, solution) = matched(&patch, &footprint(PATCH), &reference, prior);
        let (x, y) = off(&solution, shift);
        assert!(x.hypot(y) < 0.03, "{x}, {y} px off in trial {trial}");
    }
}

/// A tenth of the ground has changed: the residuals weigh it down.
#[test]
fn changed_ground_is_weighed_down() {
    let mut random = Random::new(52);
    let (mut sum, trials) = (0.0, 60);
    for trial in 0..trials {
        let ground = Ground::new(5200 + trial, 40.0, 5.0);
        let (shift, placement) = shifted(&mut random);
        let mut patch = ground.picture(PATCH, placement, 3.0, &mut random);
        let reference = ground.picture(reference_size(PATCH), Placement::default(), 3.0, &mut random);
        let (left, top) = (random.below(24), random.below(22));
        let grey = random.byte();
        for i in 0..11 * 10 {
            patch.pixels[(top + i / 10) * 34 + left + i % 10] = grey;
        }
        let (_, solution) = matched(&patch, &all_valid(PATCH), &reference, PRIOR);
        let (x, y) = off(&solution, shift);
        sum += x.hypot(y);
    }
    let mean = sum / trials as f64;
    println!("a tenth changed: mean {mean:.4} px");
    assert!(mean < 0.08, "{mean} px");
}
