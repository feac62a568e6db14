//! Jumps of the tilt and of the position, and what comes back.

use super::{After, UNKNOWN, flown, flown_knowing, known_to};
use crate::navigation::filter::jumps::CALM_US;
use crate::navigation::filter::{Filter, Measurement};
use crate::navigation::reckoning::Moment;
use crate::tile::Local;
use crate::units::Micros;
use std::vec::Vec;

#[test]
fn a_tilt_that_jumps_back_is_known_as_well_as_before() {
    let after = flown(60.0, 24.0, |_| 1.0, |at_s| if (20.0..30.0).contains(&at_s) { [0.05, 0.05] } else { [0.0; 2] });
    let [before, during, end] = [77, 108, 128].map(|frame| after[frame].sigma_rad);
    assert!(during > 2.0 * before && end < 1.1 * before, "{before} {during} {end}");
}

/// Learnt in a turn, then gone: a single match, the first for so many seconds, shows a return. From the first frame
/// after the end on; a quarter of a second each.
fn gone_after(seconds: f32, unseen_s: f32) -> Vec<f32> {
    let heading = |at_s: f32| 0.15 * at_s;
    let tilt = |at_s: f32| match at_s - 40.0 {
        before if before < 0.0 => [0.0; 2],
        seen if seen < seconds - unseen_s => [0.08, 0.05],
        unseen if unseen < seconds => [f32::NAN; 2],
        _ => [0.0; 2],
    };
    let after = flown(52.0 + seconds, 24.0, heading, tilt);
    after[after.len() - 48..].iter().map(|after| after.unexplained_rad).collect()
}

#[test]
fn what_may_swing_has_to_stay_back_for_a_quarter_of_a_period() {
    let unexplained_rad = gone_after(12.0, 1.0);
    assert!(unexplained_rad[..20].iter().all(|rad| *rad > 0.04), "{unexplained_rad:?}");
    assert!(unexplained_rad[21..].iter().all(|rad| *rad < 0.01), "{unexplained_rad:?}");
    // What has stayed for more than a period does not swing, nor does a return from one frame to the next.
    for (seconds, unseen_s) in [(25.0, 1.0), (12.0, 0.0)] {
        let unexplained_rad = gone_after(seconds, unseen_s);
        assert!(unexplained_rad[4..].iter().all(|rad| *rad < 0.01), "{unexplained_rad:?}");
    }
}

/// The first frame sees a part of the return, which could be a swing.
#[test]
fn a_tilt_that_goes_back_within_two_frames_is_known_as_well_as_before() {
    let tilt = |at_s: f32| match at_s {
        before if before < 20.0 => 0.0,
        off if off < 27.0 => 1.0,
        half if half < 27.25 => 0.6,
        _ => 0.0,
    };
    let after = flown_knowing(&known_to(0.6), 60.0, 24.0, |_| 1.0, |at_s| [0.05, 0.06].map(|rad| rad * tilt(at_s)));
    let [before, during, end] = [77, 104, 110].map(|frame| after[frame].unexplained_rad);
    assert!(before < 0.01 && during > 0.02 && end < 0.01, "{before} {during} {end}");
}

/// A late attitude begins like this.
#[test]
fn a_tilt_that_comes_back_at_once_may_swing_on() {
    let tilt = |at_s: f32| if (20.0..20.5).contains(&at_s) { [0.017, 0.0] } else { [0.0; 2] };
    let after = flown_knowing(&known_to(0.3), 90.0, 24.0, |_| 1.0, tilt);
    let [before, behind, end] = [77, 84, 350].map(|frame| after[frame].unexplained_rad);
    assert!(before < 0.002 && behind > 0.006 && end < 0.002, "{before} {behind} {end}");
    // One that is far off and back at once was a wrong match rather than a swing: it costs no more.
    let far = |at_s: f32| if (20.0..20.25).contains(&at_s) { [0.08, 0.0] } else { [0.0; 2] };
    let after = flown_knowing(&known_to(0.3), 40.0, 24.0, |_| 1.0, far);
    let [during, behind] = [78, 84].map(|frame| after[frame].unexplained_rad);
    assert!(during > 0.05 && (0.006..0.0105).contains(&behind), "{during} {behind}");
}

#[test]
fn what_swings_behind_a_jump_is_back_by_chance_where_the_velocity_may_be_anything() {
    let behind = |back_s: f32| {
        let tilt = |at_s: f32| if (20.0..20.0 + back_s).contains(&at_s) { [0.06, 0.05] } else { [0.0; 2] };
        let after = flown_knowing(&known_to(8.0), 60.0, 24.0, |_| 1.0, tilt);
        after[78 + (4.0 * back_s) as usize + 6].unexplained_rad
    };
    assert!(behind(1.5) > 0.05, "{}", behind(1.5));
    assert!(behind(7.0) < 0.01, "{}", behind(7.0));
}

/// The swing before was smaller, and does not hide that this one lasts.
#[test]
fn a_jump_behind_a_swing_is_told_apart_from_it() {
    let tilt = |at_s: f32| match at_s {
        swing if (18.5..19.25).contains(&swing) => [0.006, -0.008],
        before if before < 20.0 => [0.0; 2],
        part if part < 20.25 => [0.010, 0.011],
        _ => [0.0175; 2],
    };
    let after = flown_knowing(&known_to(0.3), 60.0, 22.0, |at_s| 0.4 * libm::sinf(0.3 * at_s), tilt);
    let most = after[100..].iter().map(|after| after.squares).fold(0.0, f32::max);
    assert!(most < 9.2, "{most}");
}

/// In a turn a jump is soon resolved, and a swing would be resolved wrongly.
#[test]
fn what_a_turn_tells_of_a_jump_has_to_hold_for_half_of_a_period() {
    let heading = |at_s: f32| 0.15 * at_s;
    let lasts = |at_s: f32| if at_s < 20.0 { [0.0; 2] } else { [0.05, 0.05] };
    let after = flown(60.0, 24.0, heading, lasts);
    let told = 78 + after[78..].iter().position(|after| after.sigma_rad < 1.3 * UNKNOWN.tilt_rad).expect("it turns");
    let half_period = CALM_US as usize / 250_000;
    let open = |after: &After| after.unexplained_rad > 0.03;
    let is_open: Vec<bool> = after.iter().map(open).collect();
    assert!(is_open[78..told + half_period - 2].iter().all(|is_open| *is_open), "{told} {:?}", &is_open[78..]);
    assert!(!is_open[told + half_period + 8..].iter().any(|is_open| *is_open), "{told} {:?}", &is_open[78..]);
}

/// Another track counts from one frame to the next, further off than a tilt moves a match.
#[test]
fn a_place_that_jumps_has_to_be_seen_for_a_while() {
    let mut filter = Filter::new();
    let micros = |ms: u32| Micros(1_000_000 + 1000 * u64::from(ms));
    let mut unexplained_rad = Vec::new();
    for ms in (0..8000).step_by(200) {
        filter.reported(Moment { at: micros(ms), velocity_m_per_s: [0.0; 2] }, &UNKNOWN);
        filter.propagate(micros(ms), &UNKNOWN);
        let east_m = if ms < 2000 { 0.0 } else { 50.0 };
        let measurement = Measurement::level(Local { east_m, north_m: 0.0 }, 0.01);
        filter.matched(&measurement, (ms == 2000).then_some([50.0, 0.0]), &UNKNOWN);
        unexplained_rad.push(filter.unexplained_rad(&UNKNOWN));
    }
    assert!(unexplained_rad[..10].iter().all(|rad| *rad < 0.01), "{unexplained_rad:?}");
    assert!(unexplained_rad[10..35].iter().all(|rad| *rad > 0.3), "{unexplained_rad:?}");
    assert!(unexplained_rad[35..].iter().all(|rad| *rad < 0.01), "{unexplained_rad:?}");
}
