//! The core's matching on textures whose shift is known exactly, against independent arithmetic, and what it must refuse.
//!
//! The pictures are made without the core: waves integrated over each pixel in closed form, in `f64`, then noise and
//! rounding.

pub mod refusals;
mod tilt;
use plumbline_core::image::{Run, View};
use plumbline_core::matching::refine::{RefineError, SubPixel, refine};
use plumbline_core::matching::search::{Peak, search, working_bytes};
use plumbline_core::matching::{MatchError, Prior, grey_correlation};
use plumbline_tests::seeded::Random;
use plumbline_tests::textures::{Ground, Picture, Placement, all_valid, footprint};

/// The default patch: 150 m high, 60 degrees, 5 m a pixel.
pub const PATCH: (u16, u16) = (34, 34);
pub const RADIUS: u16 = 10;
/// Heading to 0.3 degrees, height to 0.1 %.
pub const PRIOR: Prior = Prior { turn_rad: 0.005, scale: 0.001 };

pub fn reference_size((cols, rows): (u16, u16)) -> (u16, u16) {
    (cols + 2 * RADIUS, rows + 2 * RADIUS)
}

pub fn view(picture: &Picture) -> View<'_> {
    View::new(&picture.pixels, picture.size).expect("the sizes fit")
}

/// What the coarse ranking says of every shift, and the peak.
fn searched(patch: &Picture, runs: &[Run], reference: &Picture) -> Result<(Vec<i16>, Peak), MatchError> {
    let side = usize::from(2 * RADIUS + 1);
    let (mut scores, mut bytes) = (vec![i16::MAX; side * side], vec![0; working_bytes(reference.size)]);
    let peak = search(&view(patch), runs, &view(reference), RADIUS, &mut bytes, &mut scores)?;
    Ok((scores, peak))
}

fn refined(
    patch: &Picture,
    runs: &[Run],
    reference: &Picture,
    peak: &Peak,
    prior: Prior,
) -> Result<SubPixel, RefineError> {
    refine(&view(patch), runs, &view(reference), RADIUS, peak, prior, &mut vec![0; patch.pixels.len()])
}

/// The peak, and the sub-pixel solution around it.
pub fn matched(patch: &Picture, runs: &[Run], reference: &Picture, prior: Prior) -> (Peak, SubPixel) {
    let (_, peak) = searched(patch, runs, reference).expect("texture");
    let solution = refined(patch, runs, reference, &peak, prior).expect("texture");
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

/// Greys of the patch's valid pixels and of the reference under them at a shift.
pub fn pairs(patch: &Picture, runs: &[Run], reference: &Picture, (col, row): (usize, usize)) -> (Vec<f64>, Vec<f64>) {
    let (mut p, mut r) = (Vec::new(), Vec::new());
    for run in runs {
        for x in usize::from(run.start)..usize::from(run.end) {
            let y = usize::from(run.row);
            p.push(f64::from(patch.pixels[y * usize::from(patch.size.0) + x]));
            r.push(f64::from(reference.pixels[(y + row) * usize::from(reference.size.0) + x + col]));
        }
    }
    (p, r)
}

pub fn cosine(p: &[f64], r: &[f64]) -> f64 {
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    dot(p, r) / (dot(p, p) * dot(r, r)).sqrt()
}

/// Normalised cross-correlation by its definition, in `f64`, with the means taken off first.
fn by_definition(patch: &Picture, runs: &[Run], reference: &Picture, shift: (usize, usize)) -> f64 {
    let centred = |values: &[f64]| {
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        values.iter().map(|v| v - mean).collect::<Vec<f64>>()
    };
    let (p, r) = pairs(patch, runs, reference, shift);
    cosine(&centred(&p), &centred(&r))
}

/// The high-pass image by its definition: 6.25 times the difference of a pixel to the mean of the 5 x 5 around it, rounded
/// to nearest, where the nearest pixel of the nearest row stands for one outside the runs; limited to twice the median of
/// their sizes in the first and every fourth run (a grouped median, classes of one). One run a row.
fn high_passed(picture: &Picture, runs: &[Run]) -> Picture {
    let cols = usize::from(picture.size.0);
    let grey = |col: i32, row: i32| {
        let run = runs.iter().min_by_key(|run| (i32::from(run.row) - row).abs()).expect("runs");
        let col = col.clamp(i32::from(run.start), i32::from(run.end) - 1) as usize;
        f64::from(picture.pixels[usize::from(run.row) * cols + col])
    };
    let detail = |col: i32, row: i32| {
        let around = (row - 2..=row + 2).flat_map(|row| (col - 2..=col + 2).map(move |col| grey(col, row)));
        let mean = around.sum::<f64>() / 25.0;
        // Quarters: halves go up.
        (6.25 * (grey(col, row) - mean) + 0.5 + 1e-9).floor().clamp(-128.0, 127.0)
    };
    let of = |run: &Run| {
        let row = i32::from(run.row);
        (run.start..run.end).map(|col| detail(i32::from(col), row)).collect::<Vec<f64>>()
    };
    let mut sizes: Vec<f64> = runs.iter().step_by(4).flat_map(of).map(f64::abs).collect();
    sizes.sort_by(f64::total_cmp);
    let (half, class) = (0.5 * sizes.len() as f64, sizes[(sizes.len() - 1) / 2]);
    let below = sizes.iter().filter(|&&size| size < class).count() as f64;
    let median = class + (half - below) / sizes.iter().filter(|&&size| size == class).count() as f64;
    let limit = (2.0 * median).clamp(2.0, 127.0).floor();
    let mut pixels = vec![128; picture.pixels.len()];
    for run in runs {
        let start = usize::from(run.row) * cols + usize::from(run.start);
        for (pixel, detail) in pixels[start..].iter_mut().zip(of(run)) {
            *pixel = (detail.clamp(-limit, limit) + 128.0) as u8;
        }
    }
    Picture { pixels, size: picture.size }
}

/// The first look, by signs over part of the runs, and then the whole patch: no shift scores higher than the peak.
#[test]
fn scores_are_the_correlation_of_high_pass_images() {
    let mut random = Random::new(21);
    for (seed, deviation) in [(1, 40.0), (2, 3.0), (3, 90.0)] {
        let ground = Ground::new(seed, deviation, 5.0);
        for runs in [all_valid(PATCH), footprint(PATCH)] {
            let (_, placement) = shifted(&mut random);
            let patch = ground.picture(PATCH, placement, 3.0, &mut random);
            let reference = ground.picture(reference_size(PATCH), Placement::default(), 3.0, &mut random);
            let valid: usize = runs.iter().map(|run| usize::from(run.end - run.start)).sum();
            // 300 pixels, or every third row where that is more, spread evenly.
            let whole = valid.clamp(300, 900);
            let is_looked_at = |index: usize| index * 300 % whole < 300;
            let looked: Vec<Run> = (0..runs.len()).filter(|&i| is_looked_at(i)).map(|i| runs[i]).collect();
            let (own, others) = (high_passed(&patch, &runs), high_passed(&reference, &all_valid(reference.size)));
            let signed = |v: &[f64]| v.iter().map(|v| v - 128.0).collect::<Vec<f64>>();
            let largest = own.pixels.iter().map(|&p| f64::from(p) - 128.0).fold(0.0, f64::max);
            let large = (0.5 * largest).ceil().max(2.0);
            let sign = |p: f64| f64::from(u8::from(p >= large)) - f64::from(u8::from(p <= -large));
            let look = |shift| {
                let (p, r) = pairs(&own, &looked, &others, shift);
                let negative = signed(&p).into_iter().zip(signed(&r)).filter(|&(_, r)| r < 0.0);
                -negative.map(|(p, _)| sign(p)).sum::<f64>()
            };
            let score = |shift| {
                let (p, r) = pairs(&own, &runs, &others, shift);
                cosine(&signed(&p), &signed(&r))
            };
            let (scores, peak) = searched(&patch, &runs, &reference).expect("texture");
            let first = f64::from(scores[0]) - look((0, 0));
            for (i, &found) in scores.iter().enumerate() {
                assert_eq!(f64::from(found), look((i % 21, i / 21)) + first, "at {i}");
            }
            let best = (0..21 * 21).map(|i| (i % 21, i / 21)).max_by(|&a, &b| score(a).total_cmp(&score(b)));
            let at = (peak.d_col, peak.d_row);
            let from_corner = ((at.0 + 10) as usize, (at.1 + 10) as usize);
            assert_eq!(Some(from_corner), best);
            assert!((f64::from(peak.score) - score(from_corner)).abs() < 1e-5, "{peak:?}");
            let plain = grey_correlation(&view(&patch), &runs, &view(&reference), RADIUS, at);
            let by_definition = by_definition(&patch, &runs, &reference, from_corner);
            assert!((f64::from(plain) - by_definition).abs() < 1e-5, "{plain}, not {by_definition}");
        }
    }
}

/// Gain and offset are exact here (twice the patch plus 7): the correlation differs by single precision, the peak's
/// score by the rounding of the high-pass images, and the place not at all.
#[test]
fn gain_and_offset_do_not_change_the_score() {
    let mut random = Random::new(22);
    let ground = Ground::new(4, 15.0, 5.0);
    let (shift, placement) = shifted(&mut random);
    let dark = ground.picture(PATCH, placement, 2.0, &mut random);
    let dark = Picture { pixels: dark.pixels.iter().map(|&p| p / 2).collect(), ..dark };
    let bright = Picture { pixels: dark.pixels.iter().map(|&p| 2 * p + 7).collect(), ..dark };
    let negative = Picture { pixels: dark.pixels.iter().map(|&p| 255 - 2 * p).collect(), ..dark };
    let reference = ground.picture(reference_size(PATCH), Placement::default(), 2.0, &mut random);
    let runs = footprint(PATCH);
    let peak = |patch: &Picture| searched(patch, &runs, &reference).expect("texture").1;
    let plain = |patch: &Picture, at| grey_correlation(&view(patch), &runs, &view(&reference), RADIUS, at);
    let (d, b) = (peak(&dark), peak(&bright));
    assert!((d.d_col, d.d_row) == (b.d_col, b.d_row) && (d.score - b.score).abs() < 0.03, "{d:?}, {b:?}");
    for i in 0..21 * 21 {
        let at = (i % 21 - 10, i / 21 - 10);
        let (d, b, n) = (plain(&dark, at), plain(&bright, at), plain(&negative, at));
        assert!((d - b).abs() < 1e-4 && (d + n).abs() < 1e-4, "{d}, {b}, {n}");
    }
    for patch in [&dark, &bright] {
        let (x, y) = off(&matched(patch, &runs, &reference, PRIOR).1, shift);
        assert!(x.hypot(y) < 0.1, "{x}, {y}");
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
    assert_eq!(searched(&patch, &runs, &reference), searched(&spoilt, &runs, &reference));
    assert_eq!(matched(&patch, &runs, &reference, PRIOR), matched(&spoilt, &runs, &reference, PRIOR));
}

/// What a series of trials is made of: grounds of `deviation` grey levels and waves from `shortest_px` on, pictures with
/// `noise`, the footprint of a tilted camera or the whole patch.
#[derive(Debug, Clone, Copy)]
struct Series {
    seed: u64,
    deviation: f64,
    shortest_px: f64,
    /// Of the reference, and of the patch.
    noise: f64,
    patch_noise: f64,
    tilted: bool,
}

/// One sigma that the core adds along each axis for what no residual shows: the pictures' sampling, relief. These pictures
/// have none of that, so it is added: the truth is moved by as much.
const SYSTEMATIC_PX: f64 = 0.005;

/// Shift errors over `trials` random shifts and grounds: mean and largest length, and the mean of e' C⁻¹ e.
fn trials(trials: usize, series: Series) -> (f64, f64, f64) {
    let Series { seed, deviation, shortest_px, noise, patch_noise, tilted } = series;
    let mut random = Random::new(seed);
    let (mut sum, mut worst, mut nees, mut peaks_off) = (0.0, 0.0f64, 0.0, 0);
    for trial in 0..trials {
        let ground = Ground::new(seed * 1000 + trial as u64 / 10, deviation, shortest_px);
        let (shift, placement) = shifted(&mut random);
        let patch = ground.picture(PATCH, placement, patch_noise, &mut random);
        let reference = ground.picture(reference_size(PATCH), Placement::default(), noise, &mut random);
        let runs = if tilted { footprint(PATCH) } else { all_valid(PATCH) };
        let (_, peak) = searched(&patch, &runs, &reference).expect("texture");
        let whole = (f64::from(peak.d_col) - shift.0).abs().max((f64::from(peak.d_row) - shift.1).abs());
        peaks_off += usize::from(whole > 1.0);
        // The search may fail where noise is large; what the solution is worth does not depend on that.
        let nearest = Peak { d_col: shift.0.round() as i16, d_row: shift.1.round() as i16, ..peak };
        let solution = refined(&patch, &runs, &reference, &nearest, PRIOR).expect("texture");
        let (x, y) = off(&solution, shift);
        sum += x.hypot(y);
        worst = worst.max(x.hypot(y));
        let c = solution.covariance().map(f64::from);
        let determinant = c[(0, 0)] * c[(1, 1)] - c[(0, 1)] * c[(1, 0)];
        let (x, y) = (x + SYSTEMATIC_PX * random.normal(), y + SYSTEMATIC_PX * random.normal());
        nees += (c[(1, 1)] * x * x - 2.0 * c[(0, 1)] * x * y + c[(0, 0)] * y * y) / determinant;
    }
    let (mean, nees) = (sum / trials as f64, nees / trials as f64);
    println!("{series:?}: mean {mean:.4}, max {worst:.4} px, NEES {nees:.2}, peaks off {peaks_off}");
    (mean, worst, nees)
}

/// Noise-free: what remains is rounding (0.29 grey levels in 1156 pixels of 10 grey levels a pixel: 0.001 px) and the
/// cubic interpolation of waves of 5 pixels, of whose slope it loses a few per cent.
#[test]
fn without_noise_the_shift_is_met_to_two_hundredths() {
    for (seed, tilted) in [(31, false), (32, true)] {
        let (_, worst, _) =
            trials(100, Series { seed, deviation: 40.0, shortest_px: 5.0, noise: 0.0, patch_noise: 0.0, tilted });
        assert!(worst < 0.02, "{worst} px");
    }
}

#[test]
fn with_noise_the_shift_is_met_to_eight_hundredths() {
    for (seed, deviation, tilted) in [(33, 40.0, false), (34, 40.0, true), (35, 20.0, true)] {
        let (mean, ..) =
            trials(200, Series { seed, deviation, shortest_px: 5.0, noise: 3.0, patch_noise: 3.0, tilted });
        assert!(mean < 0.08, "{mean} px");
    }
}

/// e' C⁻¹ e has a mean of 2 and, over 500 trials, a deviation of 0.09: the covariance neither brags nor hides. Waves of 8
/// pixels and more, so that noise decides and not interpolation.
#[test]
fn the_covariance_is_honest() {
    let cases = [(41, 20.0, 3.0, true), (42, 20.0, 6.0, false), (43, 30.0, 8.0, true), (44, 15.0, 5.0, true)];
    let means = cases.map(|(seed, deviation, noise, tilted)| {
        let series = Series { seed, deviation, shortest_px: 8.0, noise, patch_noise: noise / 5.0, tilted };
        trials(500, series).2
    });
    assert!(means.iter().all(|nees| (1.6..2.4).contains(nees)), "NEES {means:.2?}");
}

/// A patch pixel is the mean of many of the frame and its noise is neglected. Where it is as noisy as the reference, its
/// gradients are too, and on weak texture the covariance brags a little; never by more than half.
#[test]
fn a_noisy_patch_is_trusted_a_little_too_much() {
    let cases = [(42, 20.0, 6.0, false), (44, 15.0, 5.0, true)];
    for (seed, deviation, noise, tilted) in cases {
        let series = Series { seed, deviation, shortest_px: 8.0, noise, patch_noise: noise, tilted };
        let nees = trials(500, series).2;
        assert!((1.6..3.0).contains(&nees), "NEES {nees:.2}");
    }
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
