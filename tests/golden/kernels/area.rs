//! Area averages against the exact ones of the oracle.
//!
//! What a cell may be off is summed up cell by cell from what the kernel's description allows (module `rectify::area`): a
//! corner that is not exact, a sum read to 1/128 of a box at the middle of a piece of the border, the mean of a box for the
//! part of it that a cell has. Where a picture leaves no room for one of them its term is 0: a picture of one grey, one
//! that is constant along rows of boxes, one that is constant in each box.

use super::scene::{Angles, Scene, image_noise, image_smooth};
use super::seeded::Random;
use super::{NO_DISTORTION, corner_px};
use plumbline_sim::oracle::Distortion;

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

/// A cell in boxes.
struct Outline {
    corners: Vec<(f64, f64)>,
    /// How far an edge is from the chord that the kernel takes for it.
    bent: f64,
}

impl Outline {
    fn new(scene: &Scene, (col, row): (usize, usize), factor: u16) -> Option<Self> {
        let at = |(right, down): (f64, f64)| {
            let (x, y) = scene.position(col as f64 + right, row as f64 + down)?;
            Some(((x + 0.5) / f64::from(factor), (y + 0.5) / f64::from(factor)))
        };
        let corners: Vec<_> =
            [(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)].into_iter().map(at).collect::<Option<_>>()?;
        let middles: Vec<_> =
            [(0.0, -0.5), (0.5, 0.0), (0.0, 0.5), (-0.5, 0.0)].into_iter().map(at).collect::<Option<_>>()?;
        let sagitta = |n: usize| {
            let (a, m, b) = (corners[n], middles[n], corners[(n + 1) % 4]);
            let (dx, dy) = (b.0 - a.0, b.1 - a.1);
            ((m.0 - a.0) * dy - (m.1 - a.1) * dx).abs() / dx.hypot(dy)
        };
        let bent = (0..4).map(sagitta).fold(0.0, f64::max);
        Some(Outline { corners, bent })
    }

    fn edges(&self) -> impl Iterator<Item = (f64, f64)> {
        (0..4).map(|n| {
            let (a, b) = (self.corners[n], self.corners[(n + 1) % 4]);
            (b.0 - a.0, b.1 - a.1)
        })
    }

    fn area(&self) -> f64 {
        let [a, b, c, d] = [0, 1, 2, 3].map(|n| self.corners[n]);
        0.5 * ((c.0 - a.0) * (d.1 - b.1) - (c.1 - a.1) * (d.0 - b.0)).abs()
    }

    /// Columns and rows of boxes that the cell may touch.
    fn boxes(&self, slack: f64, (cols, rows): (usize, usize)) -> [std::ops::Range<usize>; 2] {
        let range = |axis: fn(&(f64, f64)) -> f64, count: usize| {
            let (low, high) =
                self.corners.iter().map(axis).fold((f64::MAX, f64::MIN), |(l, h), x| (l.min(x), h.max(x)));
            (low - slack).max(0.0) as usize..((high + slack).max(0.0) as usize + 1).min(count)
        };
        [range(|p| p.0, cols), range(|p| p.1, rows)]
    }

    /// Grey levels that the kernel may be off.
    ///
    /// Corners off by d move the border by d: what the swept strip adds differs from the mean by no more than greys in the
    /// cell differ. The integrals of both chains of borders are off by at most what a sum is, over their height: 1/128
    /// (and 2⁻¹² of the slope's rounding) of a box of a grey less 128, and what the shift has cut off; both chains are cut to
    /// the same side, so that greys on one side of 128 count once. A sum at the
    /// middle of a piece is off by an eighth of its length times the difference of greys along it (with slopes that
    /// differ by D, the part of a function that is not straight has a slope of D/2, and the mean distance from the middle
    /// is a quarter of the length). Areas are whole 2⁻¹⁵.
    fn allowed(&self, cell: &Greys, corner: f64, shift: u32) -> f64 {
        let off = std::f64::consts::SQRT_2 * corner + self.bent;
        let (mut around, mut height, mut crossed) = (0.0, 0.0, 0.0);
        for (dx, dy) in self.edges() {
            around += dx.hypot(dy);
            height += dy.abs();
            // Pieces end where a row of boxes does.
            let (dx, dy) = (dx.abs() + 2.0 * corner, dy.abs() + 2.0 * corner);
            crossed += dx * dy / f64::max(1.0, dy);
        }
        let strip = (around + 8.0 * off) * off;
        let area = self.area() - strip;
        if area <= 0.0 {
            return 256.0;
        }
        let cut = f64::from((1u32 << shift) - 1);
        let sums = 0.5 * height * (cell.beside_mid * (1.0 / 128.0 + 1.0 / 4096.0) + cut);
        let middles = crossed * cell.along_rows / 8.0;
        0.5 + (cell.difference * strip + sums + middles + 256.0 / 32768.0) / area
    }
}

/// Greys in and around a cell.
#[derive(Clone, Copy, Debug, Default)]
struct Greys {
    /// Largest less smallest.
    difference: f64,
    /// The same along a row.
    along_rows: f64,
    /// Largest distance above 128 and largest below it, added.
    beside_mid: f64,
}

/// Whether sums read to 1/128 of a box can show in a cell of one grey.
pub fn one_grey_may_be_off(corners: &[Option<(f64, f64)>], factor: u16) -> bool {
    let per = 1.0 / f64::from(factor);
    let corners: Option<Vec<_>> = corners.iter().map(|p| p.map(|(x, y)| ((x + 0.5) * per, (y + 0.5) * per))).collect();
    let Some(corners) = corners else { return true };
    let greys = Greys { beside_mid: 128.0, ..Greys::default() };
    Outline { corners, bent: 0.0 }.allowed(&greys, corner_px(factor) * per, 1) >= 1.0
}

/// A picture that is constant in each box, and what is kept of it is.
struct Boxes {
    factor: usize,
    size: (usize, usize),
    greys: Vec<u8>,
}

impl Boxes {
    fn new(frame: (u16, u16), factor: u16, grey: impl FnMut((usize, usize)) -> u8) -> Self {
        let factor = usize::from(factor);
        let size = (usize::from(frame.0).div_ceil(factor), usize::from(frame.1).div_ceil(factor));
        let cells = (0..size.1).flat_map(|row| (0..size.0).map(move |col| (col, row)));
        Boxes { factor, size, greys: cells.map(grey).collect() }
    }

    fn frame(&self, (cols, rows): (u16, u16)) -> Vec<u8> {
        let at = |row: usize, col: usize| self.greys[row / self.factor * self.size.0 + col / self.factor];
        (0..usize::from(rows)).flat_map(|row| (0..usize::from(cols)).map(move |col| at(row, col))).collect()
    }

    fn around(&self, outline: &Outline, slack: f64) -> Greys {
        let [cols, rows] = outline.boxes(slack, self.size);
        let (mut low, mut high, mut along_rows) = (255u8, 0u8, 0.0);
        for row in rows {
            let line = &self.greys[row * self.size.0..][cols.clone()];
            let (Some(&least), Some(&most)) = (line.iter().min(), line.iter().max()) else { continue };
            (low, high) = (low.min(least), high.max(most));
            along_rows = f64::max(along_rows, f64::from(most - least));
        }
        let (low, high) = (f64::from(low), f64::from(high));
        Greys { difference: high - low, along_rows, beside_mid: f64::max(high, 128.0) - f64::min(low, 128.0) }
    }
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

fn scenes() -> impl Iterator<Item = (Scene, (u16, u16), u16, &'static str)> {
    let lenses = [(NO_DISTORTION, "no distortion"), (BARREL, "5 % barrel")];
    FRAMES.into_iter().flat_map(move |frame| {
        RATIOS.into_iter().flat_map(move |(factor, ratio)| {
            ANGLES.into_iter().enumerate().map(move |(n, angles)| {
                let (lens, name) = lenses[n % 2];
                (scene(frame, lens, angles, ratio), frame, factor, name)
            })
        })
    })
}

/// Every cell of every scene within what is allowed; and on the whole neither brighter nor darker than the exact average,
/// to five standard errors: a rounding that is left out is half a grey level.
fn holds(what: &str, mut picture: impl FnMut((u16, u16), u16) -> Boxes) {
    let (mut all, mut scenes_seen) = (Tally::default(), 0);
    for (scene, size, factor, lens) in scenes() {
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
    assert!(scenes_seen > 160 && all.cells > 100_000, "{scenes_seen} scenes, {} cells", all.cells);
    assert!(all.mean().abs() < 5.0 * error + 1e-3, "{what}: {} grey levels on the whole", all.mean());
}

/// Boxes of one grey a row: sums are straight along a row, and what is left are corners, readings and rounding.
#[test]
fn rows_of_boxes_of_one_grey_each() {
    let mut random = Random::new(21);
    holds("greys by rows", |size, factor| {
        let rows: Vec<u8> = (0..size.1).map(|_| random.byte()).collect();
        Boxes::new(size, factor, |(_, row)| rows[row])
    });
}

/// The same from straight above, where lines are straight and evenly divided: the node's cutting off to 1/256 of a box is
/// then all that moves it, by 1/512 in the mean and 1/256 / √12 besides, 0.0023 along each axis. Moved by d, a cell of h
/// boxes a side gains and loses d / h of greys of deviation 74 at two sides, at most √2 more when it is turned; readings
/// add 74 / 128 / √12 √(2 h) / h², and rounding 1 / √12.
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

/// Boxes that have nothing to do with each other.
#[test]
fn boxes_of_any_grey() {
    let mut random = Random::new(22);
    holds("noise by boxes", |size, factor| Boxes::new(size, factor, |_| random.byte()));
}

/// A ramp along the columns and one along the rows: corners that stray or sums read beside the middle move it.
#[test]
fn ramps_of_boxes() {
    let wave = |at: usize| (8 + 30 * (at % 16).abs_diff(8)) as u8;
    holds("ramp along columns", |size, factor| Boxes::new(size, factor, |(col, _)| wave(col)));
    holds("ramp along rows", |size, factor| Boxes::new(size, factor, |(_, row)| wave(row)));
}

/// One grey comes out exactly, black and white and in between, wherever sums read to 1/128 of a box and cut off by the
/// shift cannot be half a grey level off; and nowhere is it off by more than they can be.
#[test]
fn one_grey_stays_one_grey() {
    for grey in [0u8, 1, 77, 128, 255] {
        let (mut cells, mut off, mut sure, mut usual, mut usual_off) = (0, 0, 0, 0, 0);
        for (scene, size, factor, lens) in scenes() {
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
        assert!(usual > 40_000 && usual_off * 100_000 <= usual, "{usual_off} of {usual}");
        assert!(sure > 40_000, "only {sure} cells that cannot be off");
    }
}

/// On a smooth picture of a steepest slope of s grey levels a box, the part of a box that a cell has differs from the box's
/// mean: for a part a of it, cut off along a straight line, by at most s √2 a (1 − a) / 2, at most s √2 / 8, in each box
/// that the border cuts. A border of length L cuts at most √2 L + 4 of them. Sums make up the picture of the boxes' means,
/// which differ by less than s √2 from box to box, and are rounded by half a grey level (pairs) or cut off as a whole.
#[test]
fn a_smooth_picture() {
    let mut all = Tally::default();
    for (scene, size, factor, lens) in scenes() {
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
