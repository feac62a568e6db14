use super::{Altitude, AltitudePrior, Height, Heights};
use crate::navigation::observed::Observed;
use crate::units::Micros;

const EXPECTED: AltitudePrior = AltitudePrior { bias_m: 15.0, scale: 0.04, has_elevation: true, has_ranges: true };
const GROUND_M: f32 = 400.0;

/// A flight 120 m up whose altitude is off by a bias and a scale: the height that each of its frames is rectified with, less the
/// true one. `range`: the laser's reading of a height at a frame; `sees`: whether matches find the scale.
fn flown(
    frames: u32,
    offset: (f32, f32),
    expected: &AltitudePrior,
    range: impl Fn(u32, f32) -> Option<f32>,
    sees: bool,
) -> std::vec::Vec<Option<(f32, f32)>> {
    flown_as_seen(frames, offset, expected, range, |_| sees)
}

/// `sees`: whether the match of a frame finds the scale.
fn flown_as_seen(
    frames: u32,
    (bias_m, scale): (f32, f32),
    expected: &AltitudePrior,
    range: impl Fn(u32, f32) -> Option<f32>,
    sees: impl Fn(u32) -> bool,
) -> std::vec::Vec<Option<(f32, f32)>> {
    let mut heights = Heights::new();
    let mut off = std::vec::Vec::new();
    for frame in 0..frames {
        let at = Micros(250_000 * u64::from(frame));
        // It climbs and sinks by 20 m.
        let true_m = 120.0 + 20.0 * libm::sinf(0.02 * frame as f32);
        let metres = GROUND_M + (true_m - bias_m) / (1.0 + scale);
        heights.reported(Altitude { at, metres, climb_m_per_s: 0.0, home_m: None });
        let range = range(frame, true_m).map(|metres| Height { metres, sigma_m: 0.05 });
        let used = heights.best(at, range, GROUND_M, expected);
        heights.frame(at, range, (GROUND_M, 24.0), expected);
        off.push(used.map(|used| (used.metres - true_m, used.sigma_m)));
        if let Some(used) = used
            && sees(frame)
        {
            let scale = Observed { off: true_m / used.metres - 1.0, variance: 1e-5 };
            if heights.is_plausible(at, used, scale, GROUND_M, expected) {
                heights.update_scale(at, used, scale, GROUND_M, expected);
            }
        }
    }
    off
}

#[test]
fn without_a_laser_the_scale_of_matches_finds_bias_and_scale() {
    let off = flown(120, (-15.0, 0.04), &EXPECTED, |_, _| None, true);
    let (first, sigma_m) = off[0].unwrap();
    assert!((9.0..11.0).contains(&first.abs()) && (15.0..17.0).contains(&sigma_m), "{first} {sigma_m}");
    for (late, sigma_m) in off[60..].iter().flatten() {
        assert!(late.abs() < 0.5 && *sigma_m < 1.0, "{late} of {sigma_m}");
    }
}

#[test]
fn neither_an_elevation_model_nor_a_laser_is_no_height() {
    let level = AltitudePrior { has_elevation: false, ..EXPECTED };
    assert!(flown(10, (0.0, 0.0), &level, |_, _| None, true).iter().all(Option::is_none));
    // A laser that was there once is enough, as long as matches go on.
    let off = flown(200, (3.0, 0.02), &level, |frame, true_m| (frame < 8).then_some(true_m), true);
    assert!(off.iter().flatten().all(|(off, sigma_m)| off.abs() < 1.5 && off.abs() < 4.0 * sigma_m.max(0.1)));
    assert!(off.iter().all(Option::is_some));
}

#[test]
fn a_laser_is_taken_as_it_is_over_ground_that_is_not_known() {
    let level = AltitudePrior { has_elevation: false, ..EXPECTED };
    let off = flown(100, (3.0, 0.02), &level, |_, true_m| Some(true_m), true);
    assert!(off.iter().all(|off| off.is_some_and(|(off, sigma_m)| (off, sigma_m) == (0.0, 0.05))));
}

#[test]
fn a_laser_that_fails_is_found_out_by_the_pictures_scale() {
    for expected in [EXPECTED, AltitudePrior { has_elevation: false, ..EXPECTED }] {
        let failing: [fn(f32) -> f32; 4] = [|m| 1.1 * m, |m| m - 10.0, |_| 120.0, |m| 1.05 * m];
        for fails in failing {
            let range = |frame: u32, true_m: f32| Some(if frame < 40 { true_m } else { fails(true_m) });
            let off = flown(160, (3.0, 0.02), &expected, range, true);
            let largest = off.iter().flatten().map(|(off, _)| off.abs()).fold(0.0, f32::max);
            assert!(largest < 3.5, "{largest} m off, elevation {}", expected.has_elevation);
        }
    }
}

/// Without matches nothing tells that it has come right, and with the first of them it counts again.
#[test]
fn a_laser_that_was_found_out_stays_so_without_matches() {
    for expected in [EXPECTED, AltitudePrior { has_elevation: false, ..EXPECTED }] {
        let mut heights = Heights::new();
        let mut frame = |second: u64, range: Option<f32>, is_matched: bool| {
            let at = Micros(1_000_000 * second);
            let range = range.map(|metres| Height { metres, sigma_m: 0.05 });
            heights.reported(Altitude { at, metres: GROUND_M + 120.0, climb_m_per_s: 0.0, home_m: None });
            let used = heights.best(at, range, GROUND_M, &expected).expect("a range");
            heights.frame(at, range, (GROUND_M, 10.0), &expected);
            if is_matched {
                let scale = Observed { off: 120.0 / used.metres - 1.0, variance: 1e-5 };
                heights.update_scale(at, used, scale, GROUND_M, &expected);
            }
            used.metres
        };
        for second in 1..10 {
            frame(second, Some(120.0), true);
        }
        for second in 10..14 {
            frame(second, Some(140.0), true);
        }
        // A match without a range says nothing of it.
        frame(14, None, true);
        for second in 15..30 {
            let used = frame(second, (second > 18).then_some(140.0), false);
            assert!((used - 120.0).abs() < 3.0, "{used} at {second} s, elevation {}", expected.has_elevation);
        }
        frame(30, Some(120.5), true);
        assert!((frame(31, Some(120.5), false) - 120.5).abs() < 0.4, "elevation {}", expected.has_elevation);
    }
}

/// Two echoes of something in between, with the last matches there are, are not a laser that fails; three are.
#[test]
fn a_laser_is_found_out_by_three_ranges_in_a_row() {
    for expected in [EXPECTED, AltitudePrior { has_elevation: false, ..EXPECTED }] {
        let off_m = |echoes: u32| -> std::vec::Vec<f32> {
            let range =
                |frame: u32, true_m: f32| Some(if (40 - echoes..40).contains(&frame) { 0.5 * true_m } else { true_m });
            let off = flown_as_seen(200, (3.0, 0.02), &expected, range, |frame| frame < 40);
            off.into_iter().map(|off| off.unwrap().0.abs()).collect()
        };
        let [none, two, three] = [0, 2, 3].map(off_m);
        assert!(three[37..40].iter().all(|off_m| *off_m < 1.0), "{:?} m at the echoes", &three[37..40]);
        // Beyond three seconds, as if there had been none; the third takes the laser away, and nothing makes good what the barometer drifts.
        let as_without = |off_m: &[f32]| (60..200).all(|frame| (off_m[frame] - none[frame]).abs() < 0.05);
        assert!(as_without(&two) && !as_without(&three), "elevation {}", expected.has_elevation);
    }
}

/// Where the height is not known any more the laser that was found out is all there is, and counts.
#[test]
fn a_laser_that_was_found_out_counts_where_nothing_else_says_how_high() {
    let mut heights = Heights::new();
    let mut frame = |second: u64, altitude_m: f32, range_m: f32, is_matched: bool| {
        let at = Micros(1_000_000 * second);
        let range = Some(Height { metres: range_m, sigma_m: 0.05 });
        heights.reported(Altitude { at, metres: GROUND_M + altitude_m, climb_m_per_s: 0.0, home_m: None });
        let used = heights.best(at, range, GROUND_M, &EXPECTED).expect("a range");
        heights.frame(at, range, (GROUND_M, 10.0), &EXPECTED);
        if is_matched {
            let scale = Observed { off: altitude_m / used.metres - 1.0, variance: 1e-5 };
            heights.update_scale(at, used, scale, GROUND_M, &EXPECTED);
        }
        used.metres
    };
    for second in 1..10 {
        frame(second, 120.0, if second < 5 { 120.0 } else { 90.0 }, true);
    }
    assert!((frame(10, 120.0, 90.0, false) - 120.0).abs() < 2.0, "it was found out");
    // So near the ground the altitude says next to nothing.
    for second in 11..15 {
        frame(second, 4.0, 5.0, false);
    }
    let climbed_m = (15..40)
        .map(|second| frame(second, 2.0 * (second - 13) as f32, 2.0 * (second - 13) as f32 + 6.0, false))
        .last();
    assert!(climbed_m.is_some_and(|climbed_m| (climbed_m - 58.0).abs() < 1.0), "{climbed_m:?}");
}

#[test]
fn without_matches_a_laser_counts() {
    let range = |frame: u32, true_m: f32| Some(if frame < 40 { true_m } else { true_m - 30.0 });
    let level = AltitudePrior { has_elevation: false, ..EXPECTED };
    let off = flown(80, (0.0, 0.0), &level, range, false);
    assert!((off[79].unwrap().0 + 30.0).abs() < 0.1, "{:?}", off[79]);
}

#[test]
fn the_place_that_it_took_off_from_serves_until_there_is_a_range() {
    let level = AltitudePrior { has_elevation: false, has_ranges: false, ..EXPECTED };
    let mut heights = Heights::new();
    let at = Micros(0);
    heights.reported(Altitude { at, metres: GROUND_M + 120.0, climb_m_per_s: 0.0, home_m: Some(GROUND_M) });
    let known = heights.known(at, 0.0, &level).expect("it is");
    // 15 m, and 4 % of 120 m.
    assert!((known.metres - 120.0).abs() < 1e-3 && (known.sigma_m - 15.75).abs() < 0.1, "{known:?}");
    assert_eq!(heights.known(at, 0.0, &AltitudePrior { has_ranges: true, ..level }), None);
    // Of ground that nobody knows it is known less and less, until a match tells.
    for frame in 1..40 {
        heights.frame(Micros(250_000 * frame), None, (0.0, 24.0), &level);
    }
    heights.reported(Altitude { at: Micros(9_750_000), metres: 520.0, climb_m_per_s: 0.0, home_m: Some(GROUND_M) });
    let later = heights.known(Micros(9_750_000), 0.0, &level).expect("it is");
    assert!(later.sigma_m > known.sigma_m + 1.0, "{later:?}");
    let scale = Observed { off: 0.1, variance: 1e-5 };
    assert!(heights.is_plausible(Micros(9_750_000), later, scale, 0.0, &level));
    heights.update_scale(Micros(9_750_000), later, scale, 0.0, &level);
    let told = heights.known(Micros(9_750_000), 0.0, &level).expect("it is");
    assert!((told.metres - 1.1 * later.metres).abs() < 1.0 && told.sigma_m < 1.5, "{told:?}");
}

/// Nothing was seen for two minutes: what is known of the height is less, and enough to look for it.
#[test]
fn the_height_is_known_behind_a_long_time_without_frames() {
    for expected in [EXPECTED, AltitudePrior { has_elevation: false, ..EXPECTED }] {
        let mut heights = Heights::new();
        let mut frame = |at: u64, range: Option<f32>| {
            heights.reported(Altitude { at: Micros(at), metres: 520.0, climb_m_per_s: 0.0, home_m: None });
            heights.frame(
                Micros(at),
                range.map(|metres| Height { metres, sigma_m: 0.05 }),
                (GROUND_M, 24.0),
                &expected,
            );
            heights.known(Micros(at), GROUND_M, &expected)
        };
        let before = frame(1_000_000, Some(118.0)).expect("a range");
        let after = frame(121_000_000, None).expect("an altitude");
        assert!(before.sigma_m < 6.0 && (10.0..19.0).contains(&after.sigma_m), "{before:?} {after:?}");
    }
}

#[test]
fn an_old_altitude_is_none() {
    let mut heights = Heights::new();
    heights.reported(Altitude { at: Micros(0), metres: 520.0, climb_m_per_s: 1.0, home_m: None });
    let known = |at| heights.known(Micros(at), GROUND_M, &EXPECTED).map(|height| height.metres);
    assert_eq!(known(1_000_000), Some(121.0));
    assert_eq!(known(3_000_000), None);
}
