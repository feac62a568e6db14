//! A doubted attitude, and pictures that show the tilt.

use super::{CONSUMER, HEIGHT_M, NOISE_M, noise};
use crate::navigation::filter::resection::Resection;
use crate::navigation::filter::{Filter, JUMP_GATE, Measurement, Resected};
use crate::navigation::reckoning::Moment;
use crate::tile::Local;
use crate::units::Micros;
use nalgebra::{Matrix2, Vector2};
use std::vec::Vec;

/// Sigma of the tilt that a picture shows, and with which frames have fixes, radians.
const SHOWN_RAD: f32 = 0.015;
const KNOWN_RAD: f32 = 0.025;
/// A tilt of three degrees, which begins at this time and ends at that, seconds.
const JUMP_RAD: f32 = 0.052;
const JUMPS_S: (f32, f32) = (10.0, 20.0);

/// Whether frames of a flight on one heading have fixes, four a second, with their times and by how much the tilt moves them.
/// `tilt`: the error of the pitch at a time. `shows`: whether pictures show it. `slope`: of the ground, which they show as
/// well.
fn flown_over(slope: f32, tilt: impl Fn(f32) -> f32, shows: bool) -> Vec<(f32, bool, f32)> {
    let (mut filter, mut state) = (Filter::new(), 7u32);
    let at = |ms: u64| Micros(1_000_000 + 1000 * ms);
    let speed = 20.0;
    let mut frames = Vec::new();
    for ms in (0..40_000u64).step_by(50) {
        let at_s = 1e-3 * ms as f32;
        if ms % 200 == 0 {
            filter.reported(Moment { at: at(ms), velocity_m_per_s: [0.0, speed] }, &CONSUMER);
        }
        if ms % 250 != 0 || ms < 500 {
            continue;
        }
        filter.propagate(at(ms), &CONSUMER);
        filter.try_other_tilt(false, &CONSUMER);
        let corrected = filter.tilt_rad();
        // With a nose taken too high the nadir is found behind.
        let left_rad = tilt(at_s) - corrected[0];
        let measurement = Measurement {
            corrected_tilt_rad: corrected,
            ..Measurement::level(
                Local { east_m: noise(&mut state), north_m: speed * at_s - HEIGHT_M * left_rad + noise(&mut state) },
                NOISE_M * NOISE_M,
            )
        };
        let in_doubt = filter.innovation_beyond(JUMP_GATE, &measurement).is_some()
            || filter.is_other_tilt_tried()
            || filter.unexplained_rad(&CONSUMER) > KNOWN_RAD;
        if shows && (in_doubt || filter.is_attitude_checked(&CONSUMER)) {
            let off = |state: &mut u32| noise(state) * (SHOWN_RAD / NOISE_M);
            let by_m = Vector2::new(off(&mut state), left_rad - slope + off(&mut state)) * HEIGHT_M;
            let covariance = Matrix2::identity() * (SHOWN_RAD * SHOWN_RAD * HEIGHT_M * HEIGHT_M);
            let resected = Resected { by_m, covariance, common_variance: 0.0 };
            filter.resect(Some(&resected), !in_doubt, &measurement, &CONSUMER);
        } else {
            filter.clear_resections();
        }
        let unexplained_rad = filter.matched(&measurement, None, &CONSUMER);
        let is_doubted = |filter: &Filter| filter.unexplained_rad(&CONSUMER).max(unexplained_rad) > KNOWN_RAD;
        let doubted = is_doubted(&filter) || filter.is_other_tilt_tried();
        let shown_rad = filter.conclude((doubted, KNOWN_RAD), &measurement, &CONSUMER);
        let remains_doubted = shows && filter.was_attitude_in_doubt() && shown_rad.is_none();
        frames.push((at_s, !doubted && !remains_doubted && !is_doubted(&filter), HEIGHT_M * left_rad.abs()));
    }
    frames
}

fn flown(tilt: impl Fn(f32) -> f32, shows: bool) -> Vec<(f32, bool, f32)> {
    flown_over(0.0, tilt, shows)
}

/// The first frame with a fix from a time on, after it.
fn again_s(frames: &[(f32, bool, f32)], from_s: f32) -> f32 {
    frames.iter().find(|(at_s, is_fixed, _)| *at_s >= from_s && *is_fixed).map_or(f32::MAX, |frame| frame.0 - from_s)
}

#[test]
fn pictures_show_when_an_attitude_is_right_again() {
    // It goes up at once, and down slowly: no match shows where it ends.
    let fades = |at_s: f32| if at_s < JUMPS_S.0 { 0.0 } else { JUMP_RAD * ((25.0 - at_s) / 5.0).clamp(0.0, 1.0) };
    let end = |frames: &[(f32, bool, f32)]| {
        let fixed = frames.iter().filter(|(at_s, is_fixed, _)| *at_s > 27.0 && *is_fixed);
        fixed.map(|(_, _, off_m)| *off_m).fold(0.0, f32::max)
    };
    let frames = flown(fades, true);
    assert!(again_s(&frames, 25.0) < 2.0, "{}", again_s(&frames, 25.0));
    assert!(end(&frames) < 0.5, "{}", end(&frames));
    // As many sigmas of their mean as it takes to be noticed.
    assert!(frames.iter().all(|(_, is_fixed, off_m)| !is_fixed || *off_m < 4.5), "{frames:?}");
    let without = flown(fades, false);
    assert!(again_s(&without, 25.0) > 2.0 || end(&without) > 2.0, "{} {}", again_s(&without, 25.0), end(&without));
}

#[test]
fn a_tilt_that_lasts_is_not_taken_for_the_one_before() {
    let frames = flown(|at_s| if at_s < JUMPS_S.0 { 0.0 } else { JUMP_RAD }, true);
    let lasting = &frames[38..];
    assert!(lasting.iter().all(|(_, is_fixed, _)| !is_fixed), "{lasting:?}");
    // Frames are corrected for it as pictures show it, to a sigma of theirs.
    assert!(lasting[10..].iter().all(|(_, _, off_m)| *off_m < HEIGHT_M * SHOWN_RAD), "{lasting:?}");
}

/// Ground that is taken to be level shows a tilt that is none: it moves fixes by less than as much.
#[test]
fn a_slope_that_is_not_known_moves_fixes_by_less_than_its_tilt() {
    let jumps = |at_s: f32| if (JUMPS_S.0..JUMPS_S.1).contains(&at_s) { JUMP_RAD } else { 0.0 };
    for slope in [-0.04f32, -0.02, 0.02, 0.04] {
        let frames = flown_over(slope, jumps, true);
        let behind = frames.iter().filter(|(at_s, is_fixed, _)| *at_s > JUMPS_S.1 + 0.5 && *is_fixed);
        let largest_m = behind.map(|(_, _, off_m)| *off_m).fold(0.0, f32::max);
        assert!(largest_m < HEIGHT_M * slope.abs(), "{slope}: {largest_m}");
    }
}

#[test]
fn a_swing_is_not_correct_as_it_passes_zero() {
    // Five degrees every six seconds; each crossing lasts half a second within the sigma of a picture.
    let swings = |at_s: f32| {
        let is_late = (JUMPS_S.0..JUMPS_S.1).contains(&at_s);
        if is_late { 0.087 * libm::cosf(core::f32::consts::TAU * (at_s - JUMPS_S.0) / 6.0) } else { 0.0 }
    };
    let frames = flown(swings, true);
    assert!(frames.iter().all(|(_, is_fixed, off_m)| !is_fixed || *off_m < 3.0), "{frames:?}");
    assert!(again_s(&frames, JUMPS_S.1) < 2.0, "{}", again_s(&frames, JUMPS_S.1));
}

#[test]
fn a_picture_that_shows_nothing_changes_nothing() {
    let mut filter = Filter::new();
    let at = Micros(1_000_000);
    filter.reported(Moment { at, velocity_m_per_s: [0.0; 2] }, &CONSUMER);
    let measurement = Measurement::level(Local::default(), 1.0);
    filter.propagate(at, &CONSUMER);
    filter.matched(&measurement, None, &CONSUMER);
    let before = (filter.tilt_rad(), filter.tilt_sigma_rad(&CONSUMER));
    for (along, variance) in [(f32::NAN, 1.0), (1.0, f32::NAN), (1.0, 0.0), (1.0, -1.0), (1.0, f32::INFINITY)] {
        let (by_m, covariance) = (Vector2::new(along, 0.0), Matrix2::identity() * variance);
        let resected = Resected { by_m, covariance, common_variance: 0.0 };
        assert_eq!(filter.resect(Some(&resected), true, &measurement, &CONSUMER), None, "{along} {variance}");
        filter.conclude((true, KNOWN_RAD), &measurement, &CONSUMER);
        assert_eq!((filter.tilt_rad(), filter.tilt_sigma_rad(&CONSUMER)), before, "{along} {variance}");
    }
}

/// A filter that has been matched for ten seconds at rest, propagated over so many without a match.
fn unmatched_for(seconds: u64) -> (Filter, Measurement) {
    let (mut filter, measurement) = (Filter::new(), Measurement::level(Local::default(), NOISE_M * NOISE_M));
    for second in 1..=10 + seconds {
        let at = Micros(1_000_000 * second);
        filter.reported(Moment { at, velocity_m_per_s: [0.0; 2] }, &CONSUMER);
        filter.propagate(at, &CONSUMER);
        if second <= 10 {
            filter.matched(&measurement, None, &CONSUMER);
        }
    }
    (filter, measurement)
}

/// A jump may hide in what dead reckoning leaves unknown.
#[test]
fn what_may_hide_grows_without_matches() {
    let hides = |seconds: u64, displacement_m: f32| unmatched_for(seconds).0.may_hide(true, displacement_m);
    assert!(!hides(0, 3.0) && !hides(1, 6.0) && hides(4, 6.0) && !hides(4, 60.0));
    assert!(!unmatched_for(4).0.may_hide(false, 6.0) && !Filter::new().may_hide(true, 0.0));
    // What a reset leaves of the tilt may have ended as well.
    let (mut filter, _) = unmatched_for(0);
    filter.forget();
    assert!(filter.may_hide(false, 60.0));
}

/// Such a filter with pictures of this tilt, one a second for twenty, each as uncertain as of a small patch, and the sigma that each adds.
fn asked(tilt_rad: f32) -> (Filter, Vec<f32>) {
    let (mut filter, measurement) = unmatched_for(4);
    assert!(!filter.is_attitude_checked(&CONSUMER));
    filter.ask_pictures();
    let by_m = Vector2::new(0.0, tilt_rad) * HEIGHT_M;
    let covariance = Matrix2::identity() * (9.0 * SHOWN_RAD * SHOWN_RAD * HEIGHT_M * HEIGHT_M);
    let resected = Resected { by_m, covariance, common_variance: 0.0 };
    let mut shown = |second: u64| {
        let at = Micros(1_000_000 * second);
        filter.reported(Moment { at, velocity_m_per_s: [0.0; 2] }, &CONSUMER);
        filter.propagate(at, &CONSUMER);
        assert!(filter.is_attitude_checked(&CONSUMER), "{second}");
        filter.resect(Some(&resected), true, &measurement, &CONSUMER);
        filter.matched(&measurement, None, &CONSUMER);
        filter.conclude((false, KNOWN_RAD), &measurement, &CONSUMER).expect("not in doubt")
    };
    let shown = (14..34).map(&mut shown).collect();
    (filter, shown)
}

#[test]
fn pictures_that_are_asked_count_as_long_as_they_show_a_tilt() {
    let (mut filter, of_none) = asked(0.0);
    // One alone cannot tell: frames have fixes, with most of the sigma that they may have.
    assert!((0.5..1.0).contains(&(of_none[0] / KNOWN_RAD)), "{of_none:?}");
    assert_eq!(of_none[10..], [0.0; 10]);
    filter.propagate(Micros(filter.moment.at.0 + 2_000_000), &CONSUMER);
    assert!(!filter.is_attitude_checked(&CONSUMER));
    let (mut filter, of_one) = asked(2.0 * JUMP_RAD);
    assert!(of_one[3..].iter().all(|shown_rad| *shown_rad > KNOWN_RAD), "{of_one:?}");
    // The position may be off by it too, and the question is open as long as they show it.
    assert!(filter.pictured_rad() > KNOWN_RAD);
    filter.propagate(Micros(filter.moment.at.0 + 19_000_000), &CONSUMER);
    assert!(filter.is_attitude_checked(&CONSUMER));
    // No match has shown it.
    assert_eq!(filter.unexplained_rad(&CONSUMER), 0.0);
}

/// A picture that shows less than a wrong fix's error is no answer.
#[test]
fn a_picture_that_is_asked_and_knows_little_leaves_the_doubt() {
    let answers = |sigma_rad: f32| {
        let (mut filter, measurement) = unmatched_for(4);
        filter.ask_pictures();
        let covariance = Matrix2::identity() * (sigma_rad * sigma_rad * HEIGHT_M * HEIGHT_M);
        let resected = Resected { by_m: Vector2::zeros(), covariance, common_variance: 0.0 };
        filter.resect(Some(&resected), true, &measurement, &CONSUMER);
        filter.matched(&measurement, None, &CONSUMER);
        filter.conclude((false, KNOWN_RAD), &measurement, &CONSUMER).is_some()
    };
    assert!(answers(KNOWN_RAD) && answers(3.0 * KNOWN_RAD) && !answers(8.0 * KNOWN_RAD));
}

const START: Moment = Moment { at: Micros(1_000_000), velocity_m_per_s: [0.0; 2] };

/// A second estimate at rest, with this many pictures that show no tilt, four a second, and its moment.
fn rested(pictures: u64) -> (Resection, Moment) {
    let measurement = Measurement::level(Local::default(), NOISE_M * NOISE_M);
    let mut moment = START;
    let mut resection = Resection::begin(START, &measurement, &CONSUMER);
    for picture in 1..=pictures {
        moment.at = Micros(START.at.0 + 250_000 * picture);
        let propagated = resection.propagated(moment, &CONSUMER).expect("no gap");
        resection = propagated.matched(&measurement).resected(&shown(0.0), &measurement).expect("they agree");
    }
    (resection, moment)
}

/// A picture that shows this tilt, radians.
fn shown(rad: f32) -> Resected {
    let covariance = Matrix2::identity() * (SHOWN_RAD * SHOWN_RAD * HEIGHT_M * HEIGHT_M);
    Resected { by_m: Vector2::new(0.0, HEIGHT_M * rad), covariance, common_variance: 0.0 }
}

#[test]
fn pictures_that_contradict_in_a_row_end_it() {
    let (resection, _) = rested(12);
    let measurement = Measurement::level(Local::default(), NOISE_M * NOISE_M);
    let (known_rad, off) = (resection.tilt_rad(), shown(0.2));
    let first = resection.resected(&off, &measurement).expect("one may be wrong");
    assert_eq!(first.tilt_rad(), known_rad);
    let second = first.resected(&off, &measurement).expect("so may two");
    assert!(second.resected(&off, &measurement).is_none());
    // One that agrees between them begins the count anew.
    let agreed = second.resected(&shown(0.0), &measurement).expect("it agrees");
    let again = agreed.resected(&off, &measurement).and_then(|resection| resection.resected(&off, &measurement));
    assert!(again.is_some_and(|again| again.resected(&off, &measurement).is_none()));
}

#[test]
fn a_gap_makes_the_tilt_unknown_and_a_long_one_ends_it() {
    let (resection, moment) = rested(12);
    let known = resection.tilt_variance();
    let after = |seconds: f32| {
        let at = Micros(moment.at.0 + (1e6 * seconds) as u64);
        resection.propagated(Moment { at, ..moment }, &CONSUMER)
    };
    let unknown = 0.1;
    assert!(known < SHOWN_RAD * SHOWN_RAD, "{known}");
    let [short, gap] = [0.9, 1.1].map(|seconds| after(seconds).expect("short").tilt_variance());
    assert!(short < 4.0 * known && gap > unknown * unknown, "{known} {short} {gap}");
    assert!(after(20.0).is_none());
}
