//! What must not become a fix.

use super::{PATCH, PRIOR, RADIUS, reference_size, refined, searched, view};
use plumbline_core::image::{Run, View};
use plumbline_core::matching::acceptance::AcceptRule;
use plumbline_core::matching::correlation::locate;
use plumbline_core::matching::refine::{RefineError, SubPixel};
use plumbline_core::matching::search::{Peak, search, working_bytes};
use plumbline_core::matching::{MatchError, Rejection};
use plumbline_tests::seeded::{Random, config};
use plumbline_tests::textures::{Ground, Picture, Placement, all_valid, footprint};
use proptest::prelude::{any, prop_assert, proptest};

pub fn flat(size: (u16, u16)) -> Picture {
    Picture { pixels: vec![90; usize::from(size.0) * usize::from(size.1)], size }
}

/// A picture of `size` whose grey level is a function of (col, row).
pub fn drawn(size: (u16, u16), grey: impl Fn(usize, usize) -> u8) -> Picture {
    let cols = usize::from(size.0);
    let pixels = (0..cols * usize::from(size.1)).map(|i| grey(i % cols, i / cols)).collect();
    Picture { pixels, size }
}

pub fn rough(seed: u64, size: (u16, u16), centre: (f64, f64)) -> Picture {
    Ground::new(seed, 40.0, 2.5).picture(
        size,
        Placement { centre, ..Placement::default() },
        3.0,
        &mut Random::new(seed),
    )
}

/// What the default rule decides about the best place.
fn decided(patch: &Picture, reference: &Picture) -> Result<SubPixel, Rejection> {
    let (mut bytes, mut scores) = (vec![0; working_bytes(reference.size)], vec![0; 441]);
    let rule = (PRIOR, &AcceptRule::default());
    let room = (bytes.as_mut_slice(), scores.as_mut_slice());
    let located = locate(&view(patch), &all_valid(patch.size), &view(reference), RADIUS, rule, room);
    located.expect("a patch with texture").accepted
}

fn rejected(patch: &Picture, reference: &Picture) -> Option<Rejection> {
    decided(patch, reference).err()
}

#[test]
fn a_good_match_is_accepted() {
    for seed in 6100..6150 {
        let (patch, reference) = (rough(seed, PATCH, (4.3, -6.8)), rough(seed, reference_size(PATCH), (0.0, 0.0)));
        let solution = decided(&patch, &reference);
        let near = |s: &SubPixel| (s.d_col - 4.3).abs() < 0.3 && (s.d_row + 6.8).abs() < 0.3;
        assert!(solution.as_ref().is_ok_and(near), "{solution:?}");
    }
}

#[test]
fn patches_without_texture_are_refused() {
    let reference = rough(62, reference_size(PATCH), (0.0, 0.0));
    assert_eq!(searched(&flat(PATCH), &all_valid(PATCH), &reference), Err(MatchError::Featureless));
    let patch = rough(62, PATCH, (0.0, 0.0));
    assert_eq!(searched(&patch, &[], &reference), Err(MatchError::Featureless), "no valid pixel");
    let one = [Run { row: 3, start: 5, end: 6 }];
    assert_eq!(searched(&patch, &one, &reference), Err(MatchError::Featureless), "one valid pixel");
}

#[test]
fn a_flat_reference_scores_nothing() {
    let patch = rough(63, PATCH, (0.0, 0.0));
    let reference = flat(reference_size(PATCH));
    let (scores, _) = searched(&patch, &all_valid(PATCH), &reference).expect("texture");
    assert!(scores.iter().all(|&score| score == scores[0]));
    // No place is better than the first, in the corner.
    assert_eq!(rejected(&patch, &reference), Some(Rejection::OnBorder));
}

/// A lead of three deviations over the second place happens once in 740 times by chance: once among 100 may be, twice is
/// 1 % likely. (On 5 m orthophotos it was measured at once in 1000.)
#[test]
fn other_ground_is_refused() {
    let mut accepted = 0;
    for seed in 0..100 {
        let (patch, reference) =
            (rough(6400 + seed, PATCH, (0.0, 0.0)), rough(7400 + seed, reference_size(PATCH), (0.0, 0.0)));
        accepted += usize::from(decided(&patch, &reference).is_ok());
    }
    assert!(accepted <= 1, "{accepted} of 100 patches of other ground are accepted");
}

#[test]
fn a_peak_on_the_border_is_refused() {
    let reference = rough(65, reference_size(PATCH), (0.0, 0.0));
    for centre in [(10.4, 0.0), (-11.0, 3.0), (2.0, 11.0), (-1.0, -10.0)] {
        assert_eq!(rejected(&rough(65, PATCH, centre), &reference), Some(Rejection::OnBorder), "{centre:?}");
    }
    // Two pixels beyond the border nothing of the hill is left.
    assert!(decided(&rough(65, PATCH, (-12.0, 3.0)), &reference).is_err());
}

/// Rows of trees, a chequer, a wave both ways, each with noise, so that the best place is any of many.
#[test]
fn a_pattern_that_repeats_is_refused() {
    let rows = |col: usize, _: usize| [60, 80, 150, 200, 150, 80, 60][col % 7];
    let chequer = |col: usize, row: usize| if (col / 3 + row / 3).is_multiple_of(2) { 60 } else { 200 };
    let waves = |col: usize, row: usize| {
        (128.0 + 40.0 * ((col as f64) * 0.9).sin() + 40.0 * ((row as f64) * 0.8).cos()).round() as u8
    };
    let mut random = Random::new(66);
    for _ in 0..40 {
        let mut noisy = |picture: Picture| Picture {
            pixels: picture.pixels.iter().map(|&p| (f64::from(p) + 3.0 * random.normal()).round() as u8).collect(),
            ..picture
        };
        let cases = [
            (noisy(drawn(PATCH, rows)), noisy(drawn(reference_size(PATCH), rows))),
            (noisy(drawn(PATCH, chequer)), noisy(drawn(reference_size(PATCH), chequer))),
            (noisy(drawn(PATCH, waves)), noisy(drawn(reference_size(PATCH), waves))),
        ];
        for (patch, reference) in cases {
            assert!(decided(&patch, &reference).is_err(), "{:?}", decided(&patch, &reference));
        }
    }
}

/// Ground that repeats every nine columns but not along them, under noise as strong as itself, the patch between pixels:
/// whichever copy is best by chance, the others are as good at their own tops.
#[test]
fn ground_that_repeats_is_refused_under_noise() {
    let size = (40, 40);
    for seed in 0..300 {
        let mut random = Random::new(8000 + seed);
        let waves: Vec<(f64, f64, f64)> = (0..24)
            .map(|_| (random.between(0.0, 4.0).round() / 9.0, random.between(-0.4, 0.4), random.between(0.0, 1.0)))
            .collect();
        let off = (random.between(-0.5, 0.5), random.between(-0.5, 0.5));
        let mut picture = |size: (u16, u16), off: (f64, f64)| {
            let cols = usize::from(size.0);
            let half = |side: u16| 0.5 * (f64::from(side) - 1.0);
            let pixels = (0..cols * usize::from(size.1)).map(|i| {
                let (x, y) = ((i % cols) as f64 - half(size.0) + off.0, (i / cols) as f64 - half(size.1) + off.1);
                let wave = |&(u, v, phase): &(f64, f64, f64)| ((u * x + v * y + phase) * std::f64::consts::TAU).cos();
                (128.0 + 3.5 * waves.iter().map(wave).sum::<f64>() + 14.0 * random.normal()).round() as u8
            });
            Picture { pixels: pixels.collect(), size }
        };
        let (patch, reference) = (picture(size, off), picture(reference_size(size), (0.0, 0.0)));
        assert!(decided(&patch, &reference).is_err(), "seed {seed}: {:?}", decided(&patch, &reference));
    }
}

/// Two copies of the patch's ground in the reference, noise apart: which is the right one?
#[test]
fn the_same_ground_twice_is_ambiguous() {
    let (small, mut random) = ((18, 18), Random::new(70));
    for seed in 7000..7040 {
        let patch = rough(seed, small, (0.0, 0.0));
        let mut reference = rough(seed + 1000, reference_size(small), (0.0, 0.0));
        for corner in [1, 19] {
            for (i, &pixel) in patch.pixels.iter().enumerate() {
                let noisy = f64::from(pixel) + 3.0 * random.normal();
                reference.pixels[(corner + i / 18) * 38 + corner + i % 18] = noisy.round() as u8;
            }
        }
        assert_eq!(
            rejected(&patch, &reference),
            Some(Rejection::Ambiguous),
            "seed {seed}: {:?}",
            searched(&patch, &all_valid(small), &reference)
        );
    }
}

#[test]
fn the_rule_names_its_doubt() {
    let rule = AcceptRule::default();
    let good =
        Peak { d_col: 0, d_row: 0, score: 0.8, second: 0.3, second_at: (5, 5), vertex: (0.0, 0.0), on_border: false };
    assert_eq!(rule.peak(&good, 1000), Ok(()));
    assert_eq!(rule.peak(&good, 99), Err(Rejection::FewPixels));
    assert_eq!(rule.peak(&Peak { on_border: true, ..good }, 1000), Err(Rejection::OnBorder));
    assert_eq!(rule.peak(&Peak { score: f32::NAN, ..good }, 1000), Err(Rejection::LowScore));
    // 1000 valid pixels count as 500: a deviation is 1/√500 = 0.0447. 4.5 of them are asked for, 0.2012.
    assert_eq!(rule.peak(&Peak { score: 0.202, second: 0.0, ..good }, 1000), Ok(()));
    assert_eq!(rule.peak(&Peak { score: 0.200, second: 0.0, ..good }, 1000), Err(Rejection::LowScore));
    // A lead of 2 of them: 0.0894.
    assert_eq!(rule.peak(&Peak { second: 0.710, ..good }, 1000), Ok(()));
    assert_eq!(rule.peak(&Peak { second: 0.711, ..good }, 1000), Err(Rejection::Ambiguous));
    // The same lead says less of fewer pixels.
    assert_eq!(rule.peak(&Peak { second: 0.6, ..good }, 1000), Ok(()));
    assert_eq!(rule.peak(&Peak { second: 0.6, ..good }, 150), Err(Rejection::Ambiguous));
}

#[test]
fn texture_in_one_direction_is_refused() {
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
    // The correlation has a ridge along the edge: no place on it leads.
    assert!(matches!(rejected(&patch, &reference), Some(Rejection::Ambiguous | Rejection::OnBorder)));
}

#[test]
fn too_few_pixels_and_far_off_starts_are_refused() {
    // Waves of 10 pixels and more: from three pixels off, the solution still runs to the true place.
    let (ground, mut random) = (Ground::new(68, 40.0, 10.0), Random::new(68));
    let mut picture =
        |size| ground.picture(size, Placement { centre: (0.0, 0.0), ..Placement::default() }, 3.0, &mut random);
    let (patch, reference) = (picture(PATCH), picture(reference_size(PATCH)));
    let start = |d_col, d_row| Peak {
        d_col,
        d_row,
        score: 0.9,
        second: 0.1,
        second_at: (5, 5),
        vertex: (0.0, 0.0),
        on_border: false,
    };
    let few: Vec<Run> = (4..8).map(|row| Run { row, start: 4, end: 10 }).collect();
    let refined = |runs: &[Run], at| refined(&patch, runs, &reference, &at, PRIOR);
    assert_eq!(refined(&few, start(0, 0)), Err(RefineError::TooLittle));
    assert_eq!(refined(&[], start(0, 0)), Err(RefineError::TooLittle));
    assert!(refined(&all_valid(PATCH), start(0, 0)).is_ok());
    assert_eq!(refined(&all_valid(PATCH), start(3, -2)), Err(RefineError::Diverged));
}

#[test]
fn buffers_and_windows_that_do_not_fit_are_refused() {
    let (patch, reference) = (rough(69, PATCH, (0.0, 0.0)), rough(69, reference_size(PATCH), (0.0, 0.0)));
    let runs = footprint(PATCH);
    let search = |radius: u16, scores: usize, bytes: usize| {
        let (mut scores, mut bytes) = (vec![0; scores], vec![0; bytes]);
        search(&view(&patch), &runs, &view(&reference), radius, &mut bytes, &mut scores).map(|_| ())
    };
    let bytes = working_bytes(reference.size);
    assert_eq!(search(RADIUS, 441, bytes), Ok(()));
    assert_eq!(search(RADIUS, 440, bytes), Err(MatchError::Capacity));
    assert_eq!(search(RADIUS, 441, bytes - 4), Err(MatchError::Capacity));
    assert_eq!(search(RADIUS + 1, 23 * 23, bytes), Err(MatchError::OutsideReference));
    for bad in [Run { row: 34, start: 0, end: 4 }, Run { row: 0, start: 30, end: 35 }, Run { row: 0, start: 5, end: 4 }]
    {
        assert_eq!(searched(&patch, &[bad], &reference), Err(MatchError::Capacity), "{bad:?}");
    }
    assert!(View::new(&patch.pixels, (34, 35)).is_none());
    assert!(view(&patch).window(0, 0, PATCH).is_some());
    for (col, row, size) in [(1, 0, PATCH), (0, -1, PATCH), (0, 0, (0, 4)), (i32::MIN, 0, (4, 4)), (33, 33, (2, 1))] {
        assert!(view(&patch).window(col, row, size).is_none(), "{col}, {row}, {size:?}");
    }
    assert!(view(&patch).window(i32::MAX, 0, (4, 4)).is_none());
}

proptest! {
    #![proptest_config(config(71, 300))]

    /// Any pixels, any sorted runs: no panic, scores within 1, and a covariance that is one.
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
            let Ok((_, peak)) = searched(&patch, &runs, &reference) else { continue };
            prop_assert!(peak.score.abs() <= 1.0 + 1e-5 && peak.second <= peak.score, "{peak:?}");
            if let Ok(s) = refined(&patch, &runs, &reference, &peak, PRIOR) {
                let c = s.covariance();
                prop_assert!(c[(0, 0)] > 0.0 && c[(1, 1)] > 0.0 && c[(0, 0)] * c[(1, 1)] > c[(0, 1)] * c[(1, 0)], "{c:?}");
            }
        }
    }
}
