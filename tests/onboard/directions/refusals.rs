//! What the matcher for maps of another year must not believe.

use super::{changed, searched};
use crate::matching::refusals::{drawn, flat, rough};
use crate::matching::{PATCH, PRIOR, RADIUS, reference_size, view};
use plumbline_core::image::Run;
use plumbline_core::matching::directions::evidence::Evidence;
use plumbline_core::matching::directions::risk::{Rule, risk};
use plumbline_core::matching::directions::search::{search, working_bytes};
use plumbline_core::matching::directions::{Located, Peak, locate};
use plumbline_core::matching::{MatchError, Rejection};
use plumbline_tests::seeded::{Random, config};
use plumbline_tests::textures::{Picture, all_valid, footprint};
use proptest::prelude::{any, prop_assert, proptest};

fn found(patch: &Picture, runs: &[Run], reference: &Picture) -> Located {
    let (mut bytes, mut scores) = (vec![0; working_bytes(patch.size, reference.size)], vec![0; 441]);
    let room = (bytes.as_mut_slice(), scores.as_mut_slice());
    locate(&view(patch), runs, &view(reference), RADIUS, (PRIOR, &Rule::default()), room).expect("a patch with texture")
}

/// What the default rule decides about the best place.
fn decided(patch: &Picture, reference: &Picture) -> Result<(), Rejection> {
    found(patch, &all_valid(patch.size), reference).accepted
}

fn rejected(patch: &Picture, reference: &Picture) -> Option<Rejection> {
    decided(patch, reference).err()
}

#[test]
fn a_good_match_is_accepted() {
    for seed in 6100..6150 {
        let (patch, reference) = (rough(seed, PATCH, (4.3, -6.8)), rough(seed, reference_size(PATCH), (0.0, 0.0)));
        let located = found(&patch, &all_valid(PATCH), &reference);
        let solution = located.solution;
        let is_near = (solution.d_col - 4.3).abs() < 0.3 && (solution.d_row + 6.8).abs() < 0.3;
        assert!(located.accepted.is_ok() && located.holds && is_near, "{located:?}");
    }
}

/// Least squares have nothing to hold on to, the directions do, and what they say of themselves is true.
#[test]
fn ground_in_another_state_is_found_by_its_borders() {
    let (mut accepted, mut sum, mut stated) = (0, 0.0, 0.0);
    for seed in 6200..6300 {
        let (patch, reference) = (rough(seed, PATCH, (4.3, -6.8)), rough(seed, reference_size(PATCH), (0.0, 0.0)));
        let located = found(&changed(patch), &all_valid(PATCH), &reference);
        if located.accepted.is_ok() {
            let s = located.solution;
            let off = f64::from(s.d_col - 4.3).hypot(f64::from(s.d_row + 6.8));
            assert!(off < 1.0, "{located:?}");
            accepted += 1;
            sum += off * off;
            stated += f64::from(s.covariance().trace());
        }
    }
    println!("{accepted} of 100 accepted, squared errors {:.3} of what they are said to be", sum / stated);
    assert!(accepted >= 50, "{accepted}");
    assert!(sum < 1.5 * stated, "{sum}, said to be {stated}");
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
    searched(&patch, &all_valid(PATCH), &reference).expect("texture");
    // No place is better than another.
    assert!(matches!(rejected(&patch, &reference), Some(Rejection::OnBorder | Rejection::Ambiguous)));
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
        assert!(
            decided(&patch, &reference).is_err(),
            "seed {seed}: {:?}",
            searched(&patch, &all_valid(size), &reference)
        );
    }
}

/// Two copies of the patch's ground in the reference, noise apart: which is the right one? What counts of the patch lies two pixels within
/// it, so that the copies have the same surroundings.
#[test]
fn the_same_ground_twice_is_ambiguous() {
    let (small, mut random) = ((18, 18), Random::new(70));
    let runs: Vec<Run> = (2..16).map(|row| Run { row, start: 2, end: 16 }).collect();
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
            found(&patch, &runs, &reference).accepted.err(),
            Some(Rejection::Ambiguous),
            "seed {seed}: {:?}",
            searched(&patch, &runs, &reference)
        );
    }
}

#[test]
fn the_rule_names_its_doubt() {
    let rule = Rule::default();
    let evidence = Evidence { score: 0.8, lead: 0.3, steadiness: 1.6, ..Evidence::default() };
    let good = Peak { score: 0.8, second: 0.5, second_at: (5, 5), evidence, ..Peak::default() };
    assert_eq!(rule.accepts(&good, 1000, 1e-4), Ok(()));
    assert_eq!(rule.accepts(&good, 99, 1e-4), Err(Rejection::FewPixels));
    assert_eq!(rule.accepts(&Peak { on_border: true, ..good }, 1000, 1e-4), Err(Rejection::OnBorder));
    assert_eq!(rule.accepts(&good, 1000, 1.1e-4), Err(Rejection::Ambiguous), "the lead is less than half of the score");
    let alone = Evidence { lead: 0.5, ..evidence };
    assert_eq!(rule.accepts(&Peak { evidence: alone, ..good }, 1000, 1.1e-4), Err(Rejection::LowScore));
    let unsteady = Evidence { steadiness: 1.4, ..evidence };
    assert_eq!(rule.accepts(&Peak { evidence: unsteady, ..good }, 1000, 1e-5), Err(Rejection::Ambiguous));
    assert!(rule.accepts(&good, 1000, f32::NAN).is_err());
}

/// The log-odds by their formula, in f64, and what they must do: fall with evidence, rise with the number of shifts.
#[test]
fn the_risk_is_what_it_says() {
    let of = |lead: f32, curvature: f32, valid: u32, shifts: u32, holds: bool| {
        risk(&Evidence { score: 0.6, lead, curvature, ..Evidence::default() }, valid, shifts, holds)
    };
    for (lead, curvature, valid) in [(0.05, 0.1, 400), (0.1, 0.2, 700), (0.15, 0.2, 1225)] {
        let clear = (f64::from(lead) / (0.15 * 0.6)).min(1.0);
        for (shifts, holds) in [(441, false), (16_641, false), (441, true)] {
            let strength = f64::from(valid) * f64::from(lead) * f64::from(curvature) * clear.powi(2);
            let held = if holds { 6.0 * clear } else { 0.0 };
            let log_odds = 0.353 - 0.551 * strength.powf(0.75) + 0.235 * (f64::from(shifts) / 441.0).ln() - held;
            let expected = 1.0 / (1.0 + (-log_odds).exp());
            let found = f64::from(of(lead, curvature, valid, shifts, holds));
            assert!((found / expected.max(1e-5) - 1.0).abs() < 1e-3, "{found}, not {expected}");
        }
    }
    assert_eq!(of(0.9, 0.9, 4000, 441, true), 1e-5, "nothing has shown less");
    for (lead, curvature) in [(0.0, 0.9), (0.9, 0.0), (-0.5, 0.9), (0.9, -0.5)] {
        assert_eq!(of(lead, curvature, 4000, 441, false), 1.0, "no lead or no top is no evidence");
    }
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
fn buffers_and_windows_that_do_not_fit_are_refused() {
    let (patch, reference) = (rough(69, PATCH, (0.0, 0.0)), rough(69, reference_size(PATCH), (0.0, 0.0)));
    let runs = footprint(PATCH);
    let search = |radius: u16, scores: usize, bytes: usize| {
        let (mut scores, mut bytes) = (vec![0; scores], vec![0; bytes]);
        search(&view(&patch), &runs, &view(&reference), radius, &mut bytes, &mut scores).map(|_| ())
    };
    let bytes = working_bytes(PATCH, reference.size);
    assert_eq!(search(RADIUS, 441, bytes), Ok(()));
    assert_eq!(search(RADIUS, 440, bytes), Err(MatchError::Capacity));
    // Whatever the patch's mask is; this one takes less.
    assert_eq!(search(RADIUS, 441, bytes / 2), Err(MatchError::Capacity));
    assert_eq!(search(RADIUS + 1, 23 * 23, bytes), Err(MatchError::OutsideReference));
    for bad in [Run { row: 34, start: 0, end: 4 }, Run { row: 0, start: 30, end: 35 }, Run { row: 0, start: 5, end: 4 }]
    {
        assert_eq!(searched(&patch, &[bad], &reference), Err(MatchError::Capacity), "{bad:?}");
    }
}

proptest! {
    #![proptest_config(config(71, 300))]

    /// Any pixels, any sorted runs: no panic, scores within 1, a risk and a covariance that are such.
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
            if searched(&patch, &runs, &reference).is_err() {
                continue;
            }
            let Located { peak, solution, risk, .. } = found(&patch, &runs, &reference);
            prop_assert!(peak.score.abs() <= 1.0 + 1e-5 && peak.second <= peak.score.max(0.0), "{peak:?}");
            prop_assert!((1e-5..=1.0).contains(&risk), "{risk}");
            let c = solution.covariance();
            prop_assert!(c[(0, 0)] > 0.0 && c[(1, 1)] > 0.0 && c[(0, 0)] * c[(1, 1)] > c[(0, 1)] * c[(1, 0)], "{c:?}");
        }
    }
}
