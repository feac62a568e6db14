//! What flies of the directions: a second opinion on least squares, scores at half the resolution, and a patch's own top near a place.

use super::{changed, directions};
use crate::matching::refusals::rough;
use crate::matching::{PATCH, PRIOR, RADIUS, matched, reference_size, view};
use plumbline_core::image::Run;
use plumbline_core::matching::MatchError;
use plumbline_core::matching::directions::aboard::{FramePeak, WORKING_BYTES, confirms, frame_peak};
use plumbline_core::matching::directions::half::{MIDDLE, SHIFTS, Scores};
use plumbline_tests::seeded::Random;
use plumbline_tests::textures::{Ground, Picture, Placement, all_valid, footprint};

const TRUTH: (f64, f64) = (4.3, -6.8);

fn looked(patch: &Picture, reference: &Picture, may_hold: bool, at: Option<(i16, i16)>) -> Option<FramePeak> {
    let (mut bytes, runs) = (vec![0; WORKING_BYTES], all_valid(patch.size));
    let (middle, prior) = ((RADIUS, (0, 0)), (PRIOR, may_hold));
    frame_peak(&view(patch), &runs, &view(reference), middle, prior, &mut bytes, |_, _| at).expect("texture")
}

fn scored(patch: &Picture, runs: &[Run], reference: &Picture, middle: (i16, i16)) -> (Scores, u32) {
    let (mut bytes, mut seen) = (vec![0x55; WORKING_BYTES], None);
    let (middle, prior) = ((RADIUS, middle), (PRIOR, false));
    let own = frame_peak(&view(patch), runs, &view(reference), middle, prior, &mut bytes, |scores, valid| {
        seen = Some((*scores, valid));
        None
    });
    assert_eq!(own, Ok(None), "nothing was asked for");
    seen.expect("scores")
}

/// Means of boxes of 2 x 2 from a pixel on, both channels, 0 where a run does not reach.
fn boxes(channels: &[Picture; 2], runs: &[Run], from: (usize, usize)) -> (Vec<[f64; 2]>, (usize, usize)) {
    let (cols, rows) = (usize::from(channels[0].size.0), usize::from(channels[0].size.1));
    let is_valid = |col: usize, row: usize| {
        runs.iter().any(|run| usize::from(run.row) == row && (run.start..run.end).contains(&(col as u16)))
    };
    let value = |channel: usize, col: usize, row: usize| {
        if is_valid(col, row) { f64::from(channels[channel].pixels[row * cols + col]) - 128.0 } else { 0.0 }
    };
    let size = ((cols - from.0) / 2, (rows - from.1) / 2);
    let mean = |at: usize| {
        let (col, row) = (from.0 + 2 * (at % size.0), from.1 + 2 * (at / size.0));
        [0, 1].map(|channel| {
            let sum: f64 =
                [(0, 0), (1, 0), (0, 1), (1, 1)].iter().map(|by| value(channel, col + by.0, row + by.1)).sum();
            sum / 4.0
        })
    };
    ((0..size.0 * size.1).map(mean).collect(), size)
}

/// By f64 arithmetic of its own. The core's boxes are rounded to a digit.
#[test]
fn scores_are_the_correlation_of_boxes() {
    let mut random = Random::new(31);
    let ground = Ground::new(11, 40.0, 5.0);
    for (runs, middle) in [(all_valid(PATCH), (0i16, 0i16)), (footprint(PATCH), (0, 0)), (footprint(PATCH), (1, -3))] {
        let placement = Placement { centre: (3.6, -5.2), ..Placement::default() };
        let patch = ground.picture(PATCH, placement, 3.0, &mut random);
        let reference = ground.picture(reference_size(PATCH), Placement::default(), 3.0, &mut random);
        let (scores, valid) = scored(&patch, &runs, &reference, middle);
        let pixels: usize = runs.iter().map(|run| usize::from(run.end - run.start)).sum();
        assert_eq!(valid as usize, pixels);
        let (own, size) = boxes(&directions(&patch, &runs), &runs, (0, 0));
        let first = [middle.0, middle.1].map(|middle| RADIUS as i16 + middle - 2 * MIDDLE as i16);
        let phase = first.map(|first| first.rem_euclid(2) as usize);
        let all = all_valid(reference.size);
        let (others, other_size) = boxes(&directions(&reference, &all), &all, (phase[0], phase[1]));
        let share = pixels as f64 / (f64::from(PATCH.0) * f64::from(PATCH.1));
        for (row, col) in (0..SHIFTS).flat_map(|row| (0..SHIFTS).map(move |col| (row, col))) {
            let at = [(first[0], col), (first[1], row)].map(|(first, at)| i32::from(first.div_euclid(2)) + at as i32);
            let is_in = |at: i32, own: usize, other: usize| at >= 0 && at as usize + own <= other;
            let score = f64::from(scores[row][col]);
            if !is_in(at[0], size.0, other_size.0) || !is_in(at[1], size.1, other_size.1) {
                assert_eq!(score, 0.0, "beyond the search");
                continue;
            }
            let pairs = own.iter().enumerate().map(|(i, own)| {
                let (x, y) = (i % size.0 + at[0] as usize, i / size.0 + at[1] as usize);
                (own, others[y * other_size.0 + x])
            });
            let (mut products, mut energies) = (0.0, [0.0, 0.0]);
            for (own, other) in pairs {
                products += own[0] * other[0] + own[1] * other[1];
                energies[0] += own[0] * own[0] + own[1] * own[1];
                energies[1] += other[0] * other[0] + other[1] * other[1];
            }
            let exact = products / (energies[0] * share * energies[1]).sqrt();
            assert!((score - exact).abs() < 0.01, "{middle:?} {col} {row}: {score}, exactly {exact}");
        }
    }
}

#[test]
fn the_highest_score_is_where_the_patch_lies() {
    for seed in 6300..6330 {
        let (patch, reference) = (rough(seed, PATCH, (4.0, -6.0)), rough(seed, reference_size(PATCH), (0.0, 0.0)));
        let (scores, _) = scored(&changed(patch), &all_valid(PATCH), &reference, (0, 0));
        let places = (0..SHIFTS).flat_map(|row| (0..SHIFTS).map(move |col| (row, col)));
        let best = places.max_by(|a, b| scores[a.0][a.1].total_cmp(&scores[b.0][b.1]));
        assert_eq!(best, Some((MIDDLE - 3, MIDDLE + 2)), "{seed}");
    }
}

/// The patch's own top, from a place two pixels beside it, with a covariance that is true.
#[test]
fn ground_in_another_state_has_its_own_top() {
    let (mut found, mut sum, mut stated) = (0, 0.0, 0.0);
    for seed in 6400..6500 {
        let (patch, reference) = (rough(seed, PATCH, TRUTH), rough(seed, reference_size(PATCH), (0.0, 0.0)));
        let Some(own) = looked(&changed(patch), &reference, true, Some((6, -5))) else { continue };
        let off = f64::from(own.solution.d_col) - TRUTH.0;
        let off = off.hypot(f64::from(own.solution.d_row) - TRUTH.1);
        assert!(off < 1.5, "{seed}: {own:?}");
        found += 1;
        sum += off * off;
        stated += f64::from(own.solution.covariance().trace());
    }
    println!("{found} of 100 found, squared errors {:.3} of what they are said to be", sum / stated);
    assert!(found >= 90, "{found}");
    assert!(sum < 1.5 * stated, "{sum}, said to be {stated}");
}

#[test]
fn ground_in_the_same_state_is_found_by_least_squares_where_they_may_be_tried() {
    for seed in 6500..6520 {
        let (patch, reference) = (rough(seed, PATCH, TRUTH), rough(seed, reference_size(PATCH), (0.0, 0.0)));
        let tried = looked(&patch, &reference, true, Some((4, -7))).expect("a top");
        let off = (f64::from(tried.solution.d_col) - TRUTH.0).hypot(f64::from(tried.solution.d_row) - TRUTH.1);
        assert!(tried.holds && off < 0.2, "{seed}: {tried:?}");
        assert!(!looked(&patch, &reference, false, Some((4, -7))).expect("a top").holds);
        assert_eq!(looked(&patch, &reference, true, None), None);
    }
}

/// A place far from where the patch lies has no top that leads there.
#[test]
fn a_top_is_never_far_from_where_it_is_looked_for() {
    for seed in 6520..6560 {
        let (patch, reference) = (rough(seed, PATCH, TRUTH), rough(seed, reference_size(PATCH), (0.0, 0.0)));
        for at in [(-5, 5), (0, 0), (8, 8), (-9, -9), (127, -127), (i16::MAX, i16::MIN)] {
            if let Some(own) = looked(&patch, &reference, true, Some(at)) {
                let off = own.peak.0.abs_diff(at.0).max(own.peak.1.abs_diff(at.1));
                assert!(off <= 3, "{at:?}: {own:?}");
            }
        }
    }
}

#[test]
fn directions_confirm_what_is_right_and_nothing_else() {
    let (runs, mut bytes) = (all_valid(PATCH), vec![0; WORKING_BYTES]);
    let mut confirmed = |patch: &Picture, reference: &Picture, at: (i16, i16), solution: &_| {
        let corner = (i32::from(RADIUS), i32::from(RADIUS));
        confirms(&view(patch), &runs, (&view(reference), corner), (at, solution), &mut bytes)
    };
    let mut by_chance = 0;
    for seed in 6600..6640 {
        let (patch, reference) = (rough(seed, PATCH, TRUTH), rough(seed, reference_size(PATCH), (0.0, 0.0)));
        let (peak, solution) = matched(&patch, &runs, &reference, PRIOR);
        let at = (peak.d_col, peak.d_row);
        assert_eq!(confirmed(&patch, &reference, at, &solution), Ok(true), "{seed}");
        // Two pixels beside, in both senses.
        let mut beside = solution;
        beside.d_col += 2.0;
        assert_eq!(confirmed(&patch, &reference, at, &beside), Ok(false), "{seed}");
        assert_eq!(confirmed(&patch, &reference, (at.0 - 2, at.1), &solution), Ok(false), "{seed}");
        // Over other ground a top may lie there by chance.
        let elsewhere = rough(seed + 1000, reference_size(PATCH), (0.0, 0.0));
        by_chance += u32::from(confirmed(&patch, &elsewhere, at, &solution) == Ok(true));
        // On the tile's border there is nothing to look at.
        assert_eq!(confirmed(&patch, &reference, (10, -10), &solution), Ok(false), "{seed}");
    }
    assert!(by_chance <= 4, "{by_chance} of 40");
}

#[test]
fn what_cannot_be_looked_at_is_refused() {
    let (patch, reference) = (rough(67, PATCH, TRUTH), rough(67, reference_size(PATCH), (0.0, 0.0)));
    let (middle, prior) = ((RADIUS, (0, 0)), (PRIOR, true));
    let mut bytes = vec![0; WORKING_BYTES];
    let flat = Picture { pixels: vec![90; patch.pixels.len()], size: PATCH };
    let runs = all_valid(PATCH);
    let asked = |_: &Scores, _| Some((0, 0));
    let found = frame_peak(&view(&flat), &runs, &view(&reference), middle, prior, &mut bytes, asked);
    assert_eq!(found, Err(MatchError::Featureless));
    let found = frame_peak(&view(&patch), &[], &view(&reference), middle, prior, &mut bytes, asked);
    assert_eq!(found, Err(MatchError::Featureless));
    for room in [0, 1, 1000, 7000] {
        let found = frame_peak(&view(&patch), &runs, &view(&reference), middle, prior, &mut bytes[..room], asked);
        assert_eq!(found, Err(MatchError::Capacity), "{room}");
    }
}
