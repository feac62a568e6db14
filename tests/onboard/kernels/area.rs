//! Area averages against the exact ones of the oracle.
//!
//! What a cell may be off is summed up cell by cell from what the kernel's description allows (module `rectify::area`): a
//! corner that is not exact, a sum read to 1/128 of a box at the middle of a piece of the border, the mean of a box for the
//! part of it that a cell has. Where a picture leaves no room for one of them its term is 0: a picture of one grey, one
//! that is constant along rows of boxes, one that is constant in each box.

mod allowed;

pub use allowed::one_grey_may_be_off;

use super::scene::{Angles, Scene, image_noise, image_smooth};
use super::{NO_DISTORTION, corner_px};
use allowed::{Boxes, Greys, Outline};
use plumbline_sim::oracle::Distortion;
use plumbline_tests::seeded::Random;

const BARREL: Distortion = Distortion { k1: -0.075, k2: 0.0, k3: 0.0, p1: 0.001, p2: -0.0005 };

/// Tilts from none to 45 degrees, all round the compass, follow-up angles that follow badly.
const ANGLES: [Angles; 8] = [
    [0.0, 0.0, 0.0, 0.0],
    [30.0, 0.0, 0.0, 0.0],
    [33.0, 10.0, 8.0, 31.0],
    [90.0, 8.0, 10.0, 0.0],
    [120.0, -20.0, 5.0, 130.0],
    [200.0, 0.0, 30.0, 200.0],
    [260.0, 33.0, -33.0, -90.0],
    [300.0, 45.0, 0.0, 15.0],
];

/// Boxes, and frame pixels a cell spans: as [`Reduction::choose`](plumbline_core::reduce::Reduction::choose) pairs them,
/// and as too little memory would.
const RATIOS: [(u16, f64); 12] = [
    (1, 2.1),
    (1, 3.7),
    (1, 5.9),
    (1, 11.0),
    (2, 6.1),
    (2, 9.3),
    (2, 4.1),
    (4, 12.3),
    (4, 8.0),
    (8, 24.5),
    (8, 40.0),
    (16, 38.0),
];

/// Frames: 16 x 16 divides the first; the second is no multiple of anything, and above 256 boxes wide for factors to 4.
const FRAMES: [(u16, u16); 2] = [(256, 320), (1031, 401)];

/// Every how many of the 192 scenes an everyday run looks at. It shares no divisor with the numbers of angles and ratios,
/// so that all of them occur.
const SAMPLE: usize = 7;

/// A camera of 60 degrees over the larger side, with a patch that covers the frame and some ground around it.
fn scene(frame: (u16, u16), lens: Distortion, angles: Angles, ratio: f64) -> Scene {
    let larger = f64::from(frame.0.max(frame.1));
    let tangent_per_px = f64::to_radians(30.0).tan() / (0.5 * larger);
    let fov = |px: u16| 2.0 * (0.5 * f64::from(px) * tangent_per_px).atan().to_degrees();
    let height_m = 150.0;
    let side = |px: u16| ((1.1 * f64::from(px) / ratio) as u16).clamp(8, 60);
    let patch = ((side(frame.0), side(frame.1)), ratio * tangent_per_px * height_m, height_m);
    Scene::new(frame, (fov(frame.0), fov(frame.1)), lens, angles, patch)
}

/// What was found over some cells.
#[derive(Debug, Default)]
struct Tally {
    cells: usize,
    sum: f64,
    squares: f64,
    worst: f64,
    /// The largest share of what was allowed.
    share: f64,
}

impl Tally {
    fn add(&mut self, off: f64, allowed: f64) {
        self.cells += 1;
        self.sum += off;
        self.squares += off * off;
        self.worst = self.worst.max(off.abs());
        self.share = self.share.max(off.abs() / allowed);
    }

    fn rms(&self) -> f64 {
        (self.squares / self.cells as f64).sqrt()
    }

    fn mean(&self) -> f64 {
        self.sum / self.cells as f64
    }
}

/// Rectifies and calls `each` with a valid cell's outline in boxes, what the core has made of it, and the exact average.
fn each_cell(scene: &Scene, frame: &[u8], factor: u16, mut each: impl FnMut(&Outline, f64, f64, u32)) -> usize {
    let (kept, reduction) = scene.reduce(frame, factor);
    let patch = scene.rectify(&kept, reduction).expect("the sizes fit");
    let mut seen = 0;
    // Of one grey the average is known.
    let is_bland = frame.windows(2).all(|pair| pair[0] == pair[1]);
    let exact = if is_bland {
        vec![frame.first().map(|&grey| grey.into()); patch.pixels.len()]
    } else {
        scene.exact_area(frame)
    };
    for (i, exact) in exact.into_iter().enumerate() {
        let cell = (i % scene.grid.cols, i / scene.grid.cols);
        if let (Some(exact), true, Some(outline)) = (exact, patch.valid[i], Outline::new(scene, cell, factor)) {
            each(&outline, f64::from(patch.pixels[i]), exact, reduction.shift());
            seen += 1;
        }
    }
    seen
}

/// Every `every`th scene.
fn scenes(every: usize) -> impl Iterator<Item = (Scene, (u16, u16), u16, &'static str)> {
    let lenses = [(NO_DISTORTION, "no distortion"), (BARREL, "5 % barrel")];
    let all = FRAMES.into_iter().flat_map(move |frame| {
        RATIOS.into_iter().flat_map(move |(factor, ratio)| {
            ANGLES.into_iter().enumerate().map(move |(n, angles)| {
                let (lens, name) = lenses[n % 2];
                (scene(frame, lens, angles, ratio), frame, factor, name)
            })
        })
    });
    all.step_by(every)
}

/// Every cell of every `every`th scene within what is allowed; and on the whole neither brighter nor darker than the exact
/// average, to five standard errors: a rounding that is left out is half a grey level.
fn holds(what: &str, every: usize, mut picture: impl FnMut((u16, u16), u16) -> Boxes) {
    let (mut all, mut scenes_seen) = (Tally::default(), 0);
    for (scene, size, factor, lens) in scenes(every) {
        let picture = picture(size, factor);
        let corner = corner_px(factor) / f64::from(factor);
        let mut tally = Tally::default();
        let seen = each_cell(&scene, &picture.frame(size), factor, |outline, found, exact, shift| {
            let greys = picture.around(outline, 2.0 * corner);
            let allowed = outline.allowed(&greys, corner, shift);
            tally.add(found - exact, allowed);
            all.add(found - exact, allowed);
            assert!(
                (found - exact).abs() <= allowed,
                "{what}, {lens}, {factor}: {found} for {exact:.3}, {allowed:.3} allowed, at {:?} of {scene:?}",
                outline.corners
            );
        });
        scenes_seen += usize::from(seen > 0);
    }
    let error = all.rms() / (all.cells as f64).sqrt();
    println!("{what}: mean {:.4} ± {error:.4}, RMS {:.3}, {scenes_seen} scenes, {all:?}", all.mean(), all.rms());
    assert!(scenes_seen * every > 160 && all.cells * every > 100_000, "{scenes_seen} scenes, {} cells", all.cells);
    assert!(all.mean().abs() < 5.0 * error + 1e-3, "{what}: {} grey levels on the whole", all.mean());
}

/// Boxes of one grey a row: sums are straight along a row, and what is left are corners, readings and rounding.
fn rows_of_one_grey(every: usize) {
    let mut random = Random::new(21);
    holds("greys by rows", every, |size, factor| {
        let rows: Vec<u8> = (0..size.1).map(|_| random.byte()).collect();
        Boxes::new(size, factor, |(_, row)| rows[row])
    });
}

/// Boxes that have nothing to do with each other.
fn boxes_of_any_grey(every: usize) {
    let mut random = Random::new(22);
    holds("noise by boxes", every, |size, factor| Boxes::new(size, factor, |_| random.byte()));
}

/// A ramp along the columns and one along the rows: corners that are off or sums read beside the middle move it.
fn ramps_of_boxes(every: usize) {
    let wave = |at: usize| (8 + 30 * (at % 16).abs_diff(8)) as u8;
    holds("ramp along columns", every, |size, factor| Boxes::new(size, factor, |(col, _)| wave(col)));
    holds("ramp along rows", every, |size, factor| Boxes::new(size, factor, |(_, row)| wave(row)));
}

#[test]
fn averages_of_boxes_are_within_what_is_allowed() {
    rows_of_one_grey(SAMPLE);
    boxes_of_any_grey(SAMPLE);
    ramps_of_boxes(SAMPLE);
}

#[test]
#[ignore = "long: the averages of five kinds of picture in all 192 scenes"]
fn averages_in_every_scene() {
    rows_of_one_grey(1);
    boxes_of_any_grey(1);
    ramps_of_boxes(1);
    one_grey(1, 40_000);
    smooth(1);
}

/// Rows of one grey from straight above, where lines are straight and evenly divided: the node's cutting off to 1/256 of a
/// box is then all that moves it, by 1/512 in the mean and 1/256 / √12 besides, 0.0023 along each axis. Moved by d, a cell
/// of h boxes a side gains and loses d / h of greys of deviation 74 at two sides, at most √2 more when it is turned;
/// readings add 74 / 128 / √12 √(2 h) / h², and rounding 1 / √12.
#[test]
fn corners_are_cut_off_to_a_256th() {
    let mut random = Random::new(23);
    for (factor, ratio) in [(2, 6.1), (4, 12.3), (8, 24.5), (8, 40.0)] {
        for heading in [0.0, 30.0, 71.0] {
            let size = (1000, 800);
            let scene = scene(size, NO_DISTORTION, [heading, 0.0, 0.0, 0.0], ratio);
            let rows: Vec<u8> = (0..size.1.div_ceil(factor)).map(|_| random.byte()).collect();
            let picture = Boxes::new(size, factor, |(_, row)| rows[row]);
            let (mut tally, mut boxes) = (Tally::default(), f64::MAX);
            each_cell(&scene, &picture.frame(size), factor, |outline, found, exact, shift| {
                if shift == 0 {
                    boxes = boxes.min(outline.area().sqrt());
                    tally.add(found - exact, 1.0);
                }
            });
            if tally.cells > 0 {
                let moved = 0.0023 * 2.0 * 74.0 / boxes;
                let read = 74.0 / 128.0 / 12f64.sqrt() * (2.0 * boxes).sqrt() / boxes.powi(2);
                let limit = (moved * moved + read * read + 1.0 / 12.0).sqrt();
                println!("from above, {factor}, {heading}: RMS {:.3}, limit {limit:.3}", tally.rms());
                // So many cells tell a deviation to 10 %.
                assert!(tally.cells > 300 && tally.rms() < 1.1 * limit, "{} of {limit}, {}", tally.rms(), tally.cells);
            } else {
                assert!(factor == 2, "more than 256 boxes a row are cut off by more");
            }
        }
    }
}

/// One grey comes out exactly, black and white and in between, wherever sums read to 1/128 of a box and cut off by the
/// shift cannot be half a grey level off; and nowhere is it off by more than they can be.
fn one_grey(every: usize, least_cells: usize) {
    for grey in [0u8, 1, 77, 128, 255] {
        let (mut cells, mut off, mut sure, mut usual, mut usual_off) = (0, 0, 0, 0, 0);
        for (scene, size, factor, lens) in scenes(every) {
            let frame = vec![grey; usize::from(size.0) * usize::from(size.1)];
            let corner = corner_px(factor) / f64::from(factor);
            let beside_mid = (f64::from(grey) - 128.0).abs();
            let greys = Greys { beside_mid, ..Greys::default() };
            cells += each_cell(&scene, &frame, factor, |outline, found, _, shift| {
                let allowed = outline.allowed(&greys, corner, shift);
                let wrong = (found - f64::from(grey)).abs();
                off += usize::from(wrong > 0.0);
                sure += usize::from(allowed < 1.0);
                let is_usual = shift == 0 && outline.area() >= 9.0;
                usual += usize::from(is_usual);
                usual_off += usize::from(is_usual && wrong > 0.0);
                assert!(wrong == 0.0 || (allowed >= 1.0 && wrong <= allowed), "{found} for {grey}, {lens}, {factor}");
            });
        }
        println!("grey {grey}: {off} of {cells} cells are off, {sure} cannot be; {usual_off} of {usual} usual ones");
        // Readings of about six pieces a border, off by up to 1/128 of a box of 128: 0.3 grey levels deviation each, 0.1 in a
        // cell of three boxes a side, which takes five deviations to be seen.
        assert!(usual > least_cells && usual_off * 100_000 <= usual, "{usual_off} of {usual}");
        assert!(sure > least_cells, "only {sure} cells that cannot be off");
    }
}

/// On a smooth picture of a steepest slope of s grey levels a box, the part of a box that a cell has differs from the box's
/// mean: for a part a of it, cut off along a straight line, by at most s √2 a (1 − a) / 2, at most s √2 / 8, in each box
/// that the border cuts. A border of length L cuts at most √2 L + 4 of them. Sums make up the picture of the boxes' means,
/// which differ by less than s √2 from box to box, and are rounded by half a grey level (pairs) or cut off as a whole.
fn smooth(every: usize) {
    let mut all = Tally::default();
    for (scene, size, factor, lens) in scenes(every) {
        let stretch = f64::from(factor);
        let slope = 5.3;
        let frame = image_smooth(size.0.into(), size.1.into(), stretch);
        let corner = corner_px(factor) / f64::from(factor);
        each_cell(&scene, &frame, factor, |outline, found, exact, shift| {
            let around: f64 = outline.edges().map(|(dx, dy)| dx.hypot(dy)).sum();
            let height: f64 = outline.edges().map(|(_, dy)| dy.abs()).sum();
            let across = |axis: fn(&(f64, f64)) -> f64| {
                let (low, high) =
                    outline.corners.iter().map(axis).fold((f64::MAX, f64::MIN), |(l, h), x| (l.min(x), h.max(x)));
                high - low + 2.0
            };
            // The picture is rounded to whole greys before anything else.
            let greys = Greys {
                difference: slope * across(|p| p.0).hypot(across(|p| p.1)) + 1.0,
                along_rows: slope * across(|p| p.0) + 1.0,
                beside_mid: 80.0,
            };
            let cut_boxes = std::f64::consts::SQRT_2 * around + 4.0;
            let parts = cut_boxes * (slope * std::f64::consts::SQRT_2 / 8.0 + 0.25);
            let whole = f64::max(0.5 * outline.area(), 0.5 * height);
            let allowed = outline.allowed(&greys, corner, shift) + (parts + whole) / outline.area();
            all.add(found - exact, allowed);
            assert!((found - exact).abs() <= allowed, "{found} for {exact:.3}, {allowed:.3}, {lens}, {factor}");
        });
    }
    let error = all.rms() / (all.cells as f64).sqrt();
    println!("smooth: mean {:.4} ± {error:.4}, RMS {:.3}, {all:?}", all.mean(), all.rms());
    // Half of a grey level would be a rounding left out.
    assert!(all.mean().abs() < 0.05 && all.rms() < 0.5, "{all:?}");
}

#[test]
fn one_grey_stays_one_grey() {
    one_grey(SAMPLE, 4_000);
}

#[test]
fn a_smooth_picture() {
    smooth(SAMPLE);
}

/// On noise, neighbouring pixels unrelated with deviation s, what a box hides is which of its pixels a cell has. A box of
/// f x f of which a part a is cut off along its columns differs from that part of its sum by a variance of s² f² a (1 − a),
/// less what a pixel that is cut itself does not hide: f (f − 1) / 6 s² on the average. The border, 4 r pixels long, cuts at
/// most √2 4 r / f boxes. Sums read at the middle of a piece, a random walk of steps s / f there, add 2 √2 / 12 f s² / r³.
/// The mean over r² pixels so has the deviation σ = s √((0.94 (f − 1) + 0.24 f) / r³); r is that of the smallest cell.
#[test]
fn the_error_on_noise_is_what_boxes_hide() {
    for (factor, ratio) in [(1, 2.5), (1, 4.4), (2, 8.0), (4, 14.8), (4, 8.0), (8, 26.0), (16, 33.0)] {
        for angles in [[0.0; 4], [30.0, 6.0, -4.0, 25.0], [200.0, -5.0, 7.0, 0.0], [67.0, 0.0, 0.0, 0.0]] {
            let size = (803, 611);
            let scene = scene(size, NO_DISTORTION, angles, ratio);
            let frame = image_noise(size.0.into(), size.1.into());
            // Deviation of even numbers from 0 to 255.
            let s = 73.9;
            let (mut tally, mut least) = (Tally::default(), f64::MAX);
            each_cell(&scene, &frame, factor, |outline, found, exact, _| {
                least = least.min(outline.area());
                tally.add(found - exact, 1.0);
            });
            let (f, r) = (f64::from(factor), least.sqrt() * f64::from(factor));
            // Rounding: to whole grey levels, of sums cut off at both sides, of sums read to 1/128 of a box.
            let rounding = (1.0 / 12.0 + 2.0 / 12.0 * (f / r).powi(2) * 4.0).sqrt();
            let sigma = (s * s * (0.94 * (f - 1.0) + 0.24 * f) / r.powi(3) + rounding * rounding).sqrt();
            println!(
                "noise, factor {factor}, ratio {ratio}: RMS {:.2} of {sigma:.2}, worst {:.2}, mean {:.3}, {} cells",
                tally.rms(),
                tally.worst,
                tally.mean(),
                tally.cells
            );
            assert!(tally.cells > 100 && tally.rms() < sigma && tally.worst < 5.0 * sigma);
            let error = tally.rms() / (tally.cells as f64).sqrt();
            assert!(tally.mean().abs() < 5.0 * error, "{} grey levels on the whole", tally.mean());
        }
    }
}
