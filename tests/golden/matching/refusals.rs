//! What must not become a fix.

use super::seeded::{Random, config};
use super::textures::{Ground, Picture, Placement, all_valid, footprint};
use super::{PATCH, PRIOR, RADIUS, matched, reference_size, scores, view};
use plumbline_core::matching::View;
use plumbline_core::matching::judge::{AcceptRule, Doubt};
use plumbline_core::matching::refine::{RefineError, refine};
use plumbline_core::matching::search::{Peak, SearchError, peak, search_into};
use plumbline_core::rectify::Run;
use proptest::prelude::{any, prop_assert, proptest};

const VALID: u32 = 1000;

fn flat(size: (u16, u16)) -> Picture {
    Picture { pixels: vec![90; usize::from(size.0) * usize::from(size.1)], size }
}

/// A picture of `size` whose grey level is a function of (col, row).
fn drawn(size: (u16, u16), grey: impl Fn(usize, usize) -> u8) -> Picture {
    let cols = usize::from(size.0);
    let pixels = (0..cols * usize::from(size.1)).map(|i| grey(i % cols, i / cols)).collect();
    Picture { pixels, size }
}

fn rough(seed: u64, size: (u16, u16), centre: (f64, f64)) -> Picture {
    Ground::new(seed, 40.0, 2.5).picture(size, Placement { centre, ..Placement::default() }, 3.0, &mut Random::new(seed))
}

/// What the default rule says of the best place.
fn judged(patch: &Picture, reference: &Picture) -> Result<(), Doubt> {
    let scores = scores(patch, &all_valid(PATCH), reference).expect("a patch with texture");
    AcceptRule::default().peak(&peak(&scores, RADIUS).expect("scores of this radius"), VALID)
}

#[test]
fn a_good_match_is_accepted() {
    let (patch, reference) = (rough(61, PATCH, (4.3, -6.8)), rough(61, reference_size(PATCH), (0.0, 0.0)));
    assert_eq!(judged(&patch, &reference), Ok(()));
    let (_, solution) = matched(&patch, &all_valid(PATCH), &reference, PRIOR);
    assert_eq!(AcceptRule::default().solution(&solution), Ok(()));
}

#[test]
fn patches_without_texture_are_refused() {
    let reference = rough(62, reference_size(PATCH), (0.0, 0.0));
    assert_eq!(scores(&flat(PATCH), &all_valid(PATCH), &reference), Err(SearchError::Featureless));
    let patch = rough(62, PATCH, (0.0, 0.0));
    assert_eq!(scores(&patch, &[], &reference), Err(SearchError::Featureless), "no valid pixel");
    let one = [Run { row: 3, start: 5, end: 6 }];
    assert_eq!(scores(&patch, &one, &reference), Err(SearchError::Featureless), "one valid pixel");
}

#[test]
fn a_flat_reference_scores_nothing() {
    let patch = rough(63, PATCH, (0.0, 0.0));
    let reference = flat(reference_size(PATCH));
    assert!(scores(&patch, &all_valid(PATCH), &reference).expect("texture").iter().all(|&score| score == 0.0));
    assert_eq!(judged(&patch, &reference), Err(Doubt::OnBorder).or(judged(&patch, &reference)));
    assert!(judged(&patch, &reference).is_err());
}

#[test]
fn another_place_is_refused() {
    let mut accepted = 0;
    for seed in 0..100 {
        let (patch, reference) = (rough(6400 + seed, PATCH, (0.0, 0.0)), rough(7400 + seed, reference_size(PATCH), (0.0, 0.0)));
        accepted += usize::from(judged(&patch, &reference).is_ok());
    }
    assert_eq!(accepted, 0, "of 100 patches of other ground");
}

#[test]
fn a_peak_on_the_border_is_refused() {
    for centre in [(10.4, 0.0), (-12.0, 3.0), (2.0, 11.0), (-1.0, -10.0)] {
        let (patch, reference) = (rough(65, PATCH, centre), rough(65, reference_size(PATCH), (0.0, 0.0)));
        let scores = scores(&patch, &all_valid(PATCH), &reference).expect("texture");
        let peak = peak(&scores, RADIUS).expect("scores of this radius");
        assert!(peak.on_border, "{peak:?} for {centre:?}");
        assert_eq!(AcceptRule::default().peak(&peak, VALID), Err(Doubt::OnBorder));
    }
}

#[test]
fn a_pattern_that_repeats_is_refused() {
    // Rows of trees: 7 pixels apart along the columns, or a chequer of 6.
    let stripes = |col: usize, _: usize| [60, 80, 150, 200, 150, 80, 60][col % 7];
    let chequer = |col: usize, row: usize| if (col / 3 + row / 3) % 2 == 0 { 60 } else { 200 };
    assert!(judged(&drawn(PATCH, stripes), &drawn(reference_size(PATCH), stripes)).is_err());
    assert!(judged(&drawn(PATCH, chequer), &drawn(reference_size(PATCH), chequer)).is_err());
    // The same with the true place off the border and noise on both: it is the second place that is doubtful.
    let mut random = Random::new(66);
    let mut noisy = |picture: Picture| Picture {
        pixels: picture.pixels.iter().map(|&p| (f64::from(p) + 3.0 * random.normal()).round() as u8).collect(),
        ..picture
    };
    let (patch, reference) = (noisy(drawn(PATCH, chequer)), noisy(drawn(reference_size(PATCH), chequer)));
    let scores = scores(&patch, &all_valid(PATCH), &reference).expect("texture");
    let peak = Peak { on_border: false, ..peak(&scores, RADIUS).expect("scores of this radius") };
    assert!(peak.score > 0.9 && peak.second > 0.9, "{peak:?}");
    assert_eq!(AcceptRule::default().peak(&peak, VALID), Err(Doubt::Ambiguous));
}

#[test]
fn the_rule_names_its_doubt() {
    let rule = AcceptRule::default();
    let good = Peak { d_col: 0, d_row: 0, score: 0.8, second: 0.3, on_border: false };
    assert_eq!(rule.peak(&good, 1000), Ok(()));
    assert_eq!(rule.peak(&good, 99), Err(Doubt::FewPixels));
    assert_eq!(rule.peak(&Peak { on_border: true, ..good }, 1000), Err(Doubt::OnBorder));
    assert_eq!(rule.peak(&Peak { score: 0.34, second: 0.0, ..good }, 1000), Err(Doubt::LowScore));
    assert_eq!(rule.peak(&Peak { score: f32::NAN, ..good }, 1000), Err(Doubt::LowScore));
    assert_eq!(rule.peak(&Peak { second: f32::NAN, ..good }, 1000), Err(Doubt::Ambiguous));
    // atanh(0.8) − atanh(0.72) = 0.191; 1000 valid pixels count as 250, 1/√247: 3.0 deviations.
    assert_eq!(rule.peak(&Peak { second: 0.715, ..good }, 1000), Ok(()));
    assert_eq!(rule.peak(&Peak { second: 0.725, ..good }, 1000), Err(Doubt::Ambiguous));
    // The same lead says less of fewer pixels.
    assert_eq!(rule.peak(&Peak { second: 0.6, ..good }, 1000), Ok(()));
    assert_eq!(rule.peak(&Peak { second: 0.6, ..good }, 150), Err(Doubt::Ambiguous));
}

#[test]
fn texture_in_one_direction_is_too_imprecise() {
    let mut random = Random::new(67);
    // One edge along the columns: nothing says where the patch lies along it.
    let mut edge = |size: (u16, u16), at: usize| {
        let grey = |col: usize| if col < at { 70.0 } else { 170.0 };
        let cols = usize::from(size.0);
        let count = cols * usize::from(size.1);
        let pixels = (0..count).map(|i| (grey(i % cols) + 3.0 * random.normal()).round() as u8).collect();
        Picture { pixels, size }
    };
    let (patch, reference) = (edge(PATCH, 17), edge(reference_size(PATCH), 27));
    let place = Peak { d_col: 0, d_row: 0, score: 0.98, second: 0.5, on_border: false };
    let solution = refine(&view(&patch), &all_valid(PATCH), &view(&reference), RADIUS, &place, PRIOR);
    let refused = solution.map_or(true, |solution| AcceptRule::default().solution(&solution).is_err());
    assert!(refused, "{solution:?}");
}

#[test]
fn too_few_pixels_and_far_off_starts_are_refused() {
    let (patch, reference) = (rough(68, PATCH, (0.2, 0.3)), rough(68, reference_size(PATCH), (0.0, 0.0)));
    let start = |d_col, d_row| Peak { d_col, d_row, score: 0.9, second: 0.1, on_border: false };
    let few: Vec<Run> = (4..8).map(|row| Run { row, start: 4, end: 10 }).collect();
    let refined = |runs: &[Run], at| refine(&view(&patch), runs, &view(&reference), RADIUS, &at, PRIOR);
    assert_eq!(refined(&few, start(0, 0)), Err(RefineError::TooLittle));
    assert_eq!(refined(&[], start(0, 0)), Err(RefineError::TooLittle));
    assert!(refined(&all_valid(PATCH), start(0, 0)).is_ok());
    assert_eq!(refined(&all_valid(PATCH), start(3, -2)), Err(RefineError::Diverged));
}

#[test]
fn buffers_and_windows_that_do_not_fit_are_refused() {
    let (patch, reference) = (rough(69, PATCH, (0.0, 0.0)), rough(69, reference_size(PATCH), (0.0, 0.0)));
    let runs = footprint(PATCH);
    let mut few = [0.0; 440];
    assert_eq!(search_into(&view(&patch), &runs, &view(&reference), RADIUS, &mut few), Err(SearchError::Capacity));
    let mut enough = [0.0; 23 * 23];
    let larger = search_into(&view(&patch), &runs, &view(&reference), RADIUS + 1, &mut enough);
    assert_eq!(larger, Err(SearchError::ReferenceTooSmall));
    for bad in [Run { row: 34, start: 0, end: 4 }, Run { row: 0, start: 30, end: 35 }, Run { row: 0, start: 5, end: 4 }] {
        assert_eq!(scores(&patch, &[bad], &reference), Err(SearchError::Capacity), "{bad:?}");
    }
    assert_eq!(peak(&few, RADIUS), None);
    assert!(View::new(&patch.pixels, (34, 35)).is_none());
    assert!(view(&patch).window(0, 0, PATCH).is_some());
    for (col, row, size) in [(1, 0, PATCH), (0, -1, PATCH), (0, 0, (0, 4)), (i32::MIN, 0, (4, 4)), (33, 33, (2, 1))] {
        assert!(view(&patch).window(col, row, size).is_none(), "{col}, {row}, {size:?}");
    }
    assert!(view(&patch).window(i32::MAX, 0, (4, 4)).is_none());
}

proptest! {
    #![proptest_config(config(71, 300))]

    /// Any pixels, any sorted runs: no panic, scores within ±1, and a covariance that is one.
    #[test]
    fn any_picture_is_searched(seed in any::<u64>(), cols in 1u16..20, rows in 1u16..20, levels in 1usize..256) {
        let mut random = Random::new(seed);
        let mut picture = |size: (u16, u16)| {
            let count = usize::from(size.0) * usize::from(size.1);
            Picture { pixels: (0..count).map(|_| random.below(levels) as u8).collect(), size }
        };
        let (patch, reference) = (picture((cols, rows)), picture(reference_size((cols, rows))));
        let runs = [all_valid((cols, rows)), (0..rows).step_by(2).map(|row| Run { row, start: 0, end: cols / 2 }).collect()];
        for runs in runs {
            let Ok(scores) = scores(&patch, &runs, &reference) else { continue };
            prop_assert!(scores.iter().all(|score| score.abs() <= 1.0 + 1e-5));
            let Some(peak) = peak(&scores, RADIUS) else { continue };
            prop_assert!(scores.iter().all(|&score| score <= peak.score));
            if let Ok(s) = refine(&view(&patch), &runs, &view(&reference), RADIUS, &peak, PRIOR) {
                let c = s.covariance;
                prop_assert!(c[(0, 0)] > 0.0 && c[(1, 1)] > 0.0 && c[(0, 0)] * c[(1, 1)] > c[(0, 1)] * c[(1, 0)], "{c:?}");
            }
        }
    }
}
