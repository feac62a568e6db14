mod correlated;
mod jumps;
mod misalignment;
mod resection;

use super::{Filter, Measurement, PriorSigmas};
use crate::navigation::reckoning::Moment;
use crate::tile::Local;
use crate::units::Micros;
use nalgebra::Vector2;

const HEIGHT_M: f32 = 120.0;
const UNKNOWN: PriorSigmas = PriorSigmas { velocity_m_per_s: 0.3, tilt_rad: 0.02, extra_wander_rad: 0.0 };
const NOISE_M: f32 = 0.2;

/// Estimates after a frame, and the tilt that was inconsistent at it.
#[derive(Clone, Copy, Debug)]
struct After {
    tilt_rad: [f32; 2],
    sigma_rad: f32,
    unexpected_rad: f32,
    unexplained_rad: f32,
    /// Normalised squared error of the position.
    squares: f32,
}

/// Noise of sigma [`NOISE_M`]: the sum of four uniform numbers.
fn noise(state: &mut u32) -> f32 {
    let uniform = |_| {
        *state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (*state >> 8) as f32 / 16_777_216.0 - 0.5
    };
    (0..4).map(uniform).sum::<f32>() * NOISE_M * 1.732
}

fn flown(
    seconds: f32,
    speed: f32,
    heading: impl Fn(f32) -> f32,
    tilt: impl Fn(f32) -> [f32; 2],
) -> std::vec::Vec<After> {
    flown_knowing(&UNKNOWN, seconds, speed, heading, tilt)
}

/// A flight at a speed, m/s, four frames a second; heading and errors of pitch and roll are functions of time, and
/// there is no match where the latter are NaN. The velocity is reported five times a second, each time 0.15 s late.
fn flown_knowing(
    prior: &PriorSigmas,
    seconds: f32,
    speed: f32,
    heading: impl Fn(f32) -> f32,
    tilt: impl Fn(f32) -> [f32; 2],
) -> std::vec::Vec<After> {
    flown_by(&mut Filter::new(), prior, seconds, speed, heading, tilt)
}

fn flown_by(
    filter: &mut Filter,
    prior: &PriorSigmas,
    seconds: f32,
    speed: f32,
    heading: impl Fn(f32) -> f32,
    tilt: impl Fn(f32) -> [f32; 2],
) -> std::vec::Vec<After> {
    const STEP_MS: u32 = 10;
    let (mut position, mut state) = ([0.0f32; 2], 1u32);
    let micros = |ms: u32| Micros(1_000_000 + 1000 * u64::from(ms));
    let velocity = |ms: u32| {
        let heading = heading(1e-3 * ms as f32);
        [speed * libm::sinf(heading), speed * libm::cosf(heading)]
    };
    let mut after = std::vec::Vec::new();
    for ms in (0..(1e3 * seconds) as u32).step_by(STEP_MS as usize) {
        if let Some(sampled) = ms.checked_sub(150).filter(|sampled| sampled % 200 == 0) {
            filter.reported(Moment { at: micros(sampled), velocity_m_per_s: velocity(sampled) }, prior);
        }
        let at_s = 1e-3 * ms as f32;
        if ms % 250 == 0 && ms >= 500 && tilt(at_s)[0].is_finite() {
            let (sin, cos) = (libm::sinf(heading(at_s)), libm::cosf(heading(at_s)));
            filter.propagate(micros(ms), prior);
            let known = filter.tilt_rad();
            let left = [tilt(at_s)[0] - known[0], tilt(at_s)[1] - known[1]];
            // With a reported nose too high the picture is taken to lie too far ahead, so the nadir is found behind.
            let (ahead, right) = (-HEIGHT_M * left[0], HEIGHT_M * left[1]);
            let nadir = Local {
                east_m: position[0] + ahead * sin + right * cos + noise(&mut state),
                north_m: position[1] + ahead * cos - right * sin + noise(&mut state),
            };
            let measurement = Measurement {
                corrected_tilt_rad: known,
                heading_rad: heading(at_s),
                ..Measurement::level(nadir, NOISE_M * NOISE_M)
            };
            let unexpected_rad = filter.matched(&measurement, None, prior);
            let (tilt_rad, sigma_rad) = (filter.tilt_rad(), filter.tilt_sigma_rad(prior));
            let unexplained_rad = filter.unexplained_rad(prior);
            let (local, covariance) = filter.position().expect("it was found");
            let off = Vector2::new(local.east_m - position[0], local.north_m - position[1]);
            let squares = (off.transpose() * covariance.try_inverse().expect("sound") * off)[(0, 0)];
            after.push(After { tilt_rad, sigma_rad, unexpected_rad, unexplained_rad, squares });
        }
        let [before, next] = [velocity(ms), velocity(ms + STEP_MS)];
        (0..2).for_each(|axis| position[axis] += 0.5e-3 * STEP_MS as f32 * (before[axis] + next[axis]));
    }
    after
}

#[test]
fn a_turn_tells_the_tilt_and_a_straight_leg_does_not() {
    let tilt = [0.017, -0.012];
    let straight = flown(60.0, 5.0, |_| 0.5, |_| tilt);
    let end = straight[straight.len() - 1];
    assert!(end.sigma_rad > 0.018, "{end:?}");
    assert!(end.tilt_rad[0].abs() < 0.008 && end.tilt_rad[1].abs() < 0.008, "{end:?}");
    let turning = flown(60.0, 5.0, |at_s| if at_s < 20.0 { 0.5 } else { 0.5 + 0.15 * (at_s - 20.0) }, |_| tilt);
    let end = turning[turning.len() - 1];
    assert!(end.sigma_rad < 0.7 * UNKNOWN.tilt_rad, "{end:?}");
    assert!(tilt.iter().zip(end.tilt_rad).all(|(is, said)| (said - is).abs() < 3.0 * end.sigma_rad), "{end:?}");
    // At five times the speed as well, though the velocities are late.
    let fast = flown(60.0, 24.0, |at_s| 0.15 * at_s, |_| tilt);
    let end = fast[fast.len() - 1];
    assert!(end.sigma_rad < 0.7 * UNKNOWN.tilt_rad, "{end:?}");
    assert!(tilt.iter().zip(end.tilt_rad).all(|(is, said)| (said - is).abs() < 3.0 * end.sigma_rad), "{end:?}");
    assert!(turning.iter().chain(&straight).chain(&fast).all(|after| after.unexpected_rad == 0.0));
}

#[test]
fn a_tilt_that_jumps_is_told_and_stays_in_what_is_not_known() {
    let after = flown(40.0, 24.0, |_| 1.0, |at_s| if at_s < 20.0 { [0.0; 2] } else { [0.05, 0.05] });
    let first = after[78];
    assert!(first.unexpected_rad > 0.03, "{first:?}");
    assert!(after[79..].iter().all(|after| after.unexpected_rad < 0.02 && after.sigma_rad > 0.035), "{:?}", after[98]);
}

#[test]
fn a_tilt_that_swings_is_seen_in_what_is_not_known() {
    // As of an attitude with latency: 0.02 at 0.2 Hz.
    let after = flown(60.0, 24.0, |_| 1.0, |at_s| [0.02 * libm::sinf(1.26 * at_s), 0.0]);
    let late: f32 = after[78..].iter().map(|after| after.sigma_rad).fold(f32::MAX, f32::min);
    assert!(late > 0.012, "{late}");
}

/// Prior sigmas of consumer sensors.
const CONSUMER: PriorSigmas = PriorSigmas { velocity_m_per_s: 0.05, tilt_rad: 0.005, extra_wander_rad: 0.0 };

/// A transient may turn out constant, which a straight leg does not show.
#[test]
fn a_small_tilt_that_begins_and_stays_is_not_forgotten() {
    let after = flown_knowing(&CONSUMER, 60.0, 24.0, |_| 1.0, |at_s| if at_s < 20.0 { [0.0; 2] } else { [0.0, 0.008] });
    assert!(after[77].sigma_rad < 0.0055, "{:?}", after[77]);
    assert!((0.006..0.008).contains(&after[78].unexpected_rad), "{:?}", after[78]);
    assert!(after[79..].iter().all(|after| after.sigma_rad > 0.0058), "{:?}", after[237]);
}

/// An attitude whose error is 0.005, three quarters of the variance wandering in the ground's axes within 10 s and the
/// rest constant in the vehicle's: over flights in circles the position's error matches its covariance.
#[test]
fn an_attitude_that_wanders_is_what_is_expected() {
    let mut state = 7;
    let mut normal = |sigma: f32| noise(&mut state) / NOISE_M * sigma;
    let flights = (0..40).map(|_| {
        let lasting = [normal(0.0025), normal(0.0025)];
        let mut wander = [normal(0.0043), normal(0.0043)];
        let wanders: std::vec::Vec<[f32; 2]> = (0..480)
            .map(|_| {
                let keeps = libm::expf(-0.025);
                wander = wander.map(|axis| axis * keeps + normal(0.0043 * libm::sqrtf(1.0 - keeps * keeps)));
                wander
            })
            .collect();
        let heading = |at_s: f32| 0.15 * at_s;
        let tilt = |at_s: f32| {
            let ([east, north], (sin, cos)) =
                (wanders[(4.0 * at_s) as usize], (libm::sinf(heading(at_s)), libm::cosf(heading(at_s))));
            [lasting[0] - east * sin - north * cos, lasting[1] + east * cos - north * sin]
        };
        let after = flown_knowing(&CONSUMER, 120.0, 24.0, heading, tilt);
        after[120..].iter().map(|after| after.squares).sum::<f32>() / (after.len() - 120) as f32
    });
    let mean = flights.sum::<f32>() / 40.0;
    // Two degrees of freedom.
    assert!((1.0..2.3).contains(&mean), "{mean}");
}

#[test]
fn a_filter_that_begins_knows_as_much_as_was_said() {
    let filter = Filter::new();
    assert_eq!(
        (filter.tilt_rad(), filter.tilt_sigma_rad(&PriorSigmas { tilt_rad: 0.004, ..UNKNOWN })),
        ([0.0; 2], 0.004)
    );
}

#[test]
fn a_tilt_that_was_learnt_and_is_gone_is_not_taken_out_any_more() {
    let tilt = |at_s: f32| if (10.0..50.0).contains(&at_s) { [0.08, 0.05] } else { [0.0; 2] };
    let after = flown(60.0, 24.0, |at_s| 0.15 * at_s, tilt);
    let [learnt, first, end] = [190, 198, 199].map(|frame| after[frame]);
    assert!((learnt.tilt_rad[0] - 0.08).abs() < 0.01 && (learnt.tilt_rad[1] - 0.05).abs() < 0.01, "{learnt:?}");
    // The first frame without it was still corrected for it.
    assert!(first.unexpected_rad > 0.08, "{first:?}");
    assert!(end.tilt_rad.iter().all(|tilt| tilt.abs() < 0.01) && end.sigma_rad < 0.025, "{end:?}");
}

/// The attitude of an autopilot, and a velocity of this sigma.
fn known_to(velocity_m_per_s: f32) -> PriorSigmas {
    PriorSigmas { velocity_m_per_s, tilt_rad: 0.0035, extra_wander_rad: 0.0 }
}

/// Without a reported velocity it could vanish unnoticed.
#[test]
fn a_tilt_that_was_learnt_counts_as_unexplained_where_the_velocity_may_be_anything() {
    let known = known_to(0.3);
    let learnt = |seconds: f32| {
        let tilt = |at_s: f32| if at_s < 20.0 { [0.0; 2] } else { [0.05, 0.06] };
        flown_knowing(&known, seconds, 24.0, |at_s| 0.15 * at_s, tilt).last().expect("frames").unexplained_rad
    };
    assert!(learnt(80.0) < 0.01, "{}", learnt(80.0));
    let mut filter = Filter::new();
    let measurement = Measurement { corrected_tilt_rad: [0.05, 0.06], ..Measurement::level(Local::default(), 0.01) };
    let mut unexplained_rad = |prior: &PriorSigmas| {
        filter.reset(Moment { at: Micros(1_000_000), velocity_m_per_s: [0.0; 2] });
        filter.matched(&measurement, None, prior);
        filter.unexplained_rad(prior)
    };
    assert!(unexplained_rad(&known) < 0.01 && unexplained_rad(&known_to(8.0)) > 0.07);
}

/// Matches of a vehicle that flies east, two a second with as many velocities, and displaced to the side by `tilt_rad` of roll.
fn straight(filter: &mut Filter, seconds: core::ops::Range<u64>, prior: &PriorSigmas, tilt_rad: f32) {
    for at_s in seconds.flat_map(|second| [second as f32, second as f32 + 0.5]) {
        let at = Micros((1e6 * (1.0 + at_s)) as u64);
        filter.reported(Moment { at, velocity_m_per_s: [24.0, 0.0] }, prior);
        filter.propagate(at, prior);
        let known = filter.tilt_rad();
        let nadir = Local { east_m: 24.0 * at_s, north_m: -HEIGHT_M * (tilt_rad - known[1]) };
        let measurement = Measurement {
            corrected_tilt_rad: known,
            heading_rad: core::f32::consts::FRAC_PI_2,
            ..Measurement::level(nadir, NOISE_M * NOISE_M)
        };
        filter.matched(&measurement, None, prior);
    }
}

/// Velocities stop for longer than they are propagated over, are taken to be frozen, or begin anew with their clock.
#[test]
fn a_jump_is_not_forgotten_where_velocities_are_interrupted() {
    let prior = known_to(0.3);
    for again_s in [50, 21, 0] {
        let mut filter = Filter::new();
        straight(&mut filter, 0..10, &prior, 0.0);
        assert!(filter.unexplained_rad(&prior) < 0.01);
        straight(&mut filter, 10..20, &prior, 0.05);
        assert!(filter.unexplained_rad(&prior) > 0.03);
        filter.forget();
        assert!(filter.unexplained_rad(&prior) > 0.03);
        straight(&mut filter, again_s..again_s + 10, &prior, 0.05);
        assert!(filter.unexplained_rad(&prior) > 0.03, "{again_s}");
        // It ends all the same.
        straight(&mut filter, again_s + 10..again_s + 40, &prior, 0.0);
        assert!(filter.unexplained_rad(&prior) < 0.01, "{again_s}: {}", filter.unexplained_rad(&prior));
    }
}

#[test]
fn a_tilt_that_was_learnt_is_not_forgotten_where_velocities_are_interrupted() {
    let (mut filter, tilt) = (Filter::new(), [0.08, 0.05]);
    flown_by(&mut filter, &UNKNOWN, 60.0, 24.0, |at_s| 0.15 * at_s, |_| tilt);
    let (learnt, sigma_rad) = (filter.tilt_rad(), filter.tilt_sigma_rad(&UNKNOWN));
    assert!((0..2).all(|axis| (learnt[axis] - tilt[axis]).abs() < 0.01), "{learnt:?}");
    filter.forget();
    assert_eq!(filter.tilt_rad(), learnt);
    assert!(filter.tilt_sigma_rad(&UNKNOWN) >= sigma_rad);
    filter.reported(Moment { at: Micros(90_000_000), velocity_m_per_s: [24.0, 0.0] }, &UNKNOWN);
    let measurement = Measurement { corrected_tilt_rad: learnt, ..Measurement::level(Local::default(), 0.01) };
    filter.matched(&measurement, None, &UNKNOWN);
    assert_eq!(filter.tilt_rad(), learnt);
}

#[test]
fn a_velocity_that_is_thrown_over_is_not_taken_for_an_acceleration() {
    let mut filter = Filter::new();
    let at = |ms: u64| Micros(1_000_000 + 1000 * ms);
    for (ms, east) in [(0, 20.0), (200, 20.0), (400, 28.0)] {
        filter.reported(Moment { at: at(ms), velocity_m_per_s: [east, 0.0] }, &UNKNOWN);
        if ms == 0 {
            let measurement = Measurement::level(Local::default(), 0.01);
            assert_eq!(filter.matched(&measurement, None, &UNKNOWN), 0.0);
        }
    }
    filter.propagate(at(900), &UNKNOWN);
    let (place, covariance) = filter.position().expect("it was found");
    // By the mean over the step and the newest velocity; by an acceleration of 40 m/s2 it would be 5 m more.
    assert!((place.east_m - (4.0 + 4.8 + 14.0)).abs() < 0.1, "{place:?}");
    // Its error may be as large as the velocity's change.
    assert!(covariance[(0, 0)].sqrt() > 3.0, "{covariance}");
}

#[test]
fn time_alone_tells_no_jump() {
    let after = flown(300.0, 24.0, |_| 1.0, |at_s| if at_s < 20.0 { [0.0; 2] } else { [0.08, 0.0] });
    let end = after[after.len() - 1];
    assert!(after[79..].iter().all(|after| after.sigma_rad > 0.05), "{end:?}");
}

#[test]
fn on_one_heading_the_tilt_does_not_walk_away() {
    let after = flown(1200.0, 24.0, |_| 1.0, |_| [0.0; 2]);
    let norm = |after: &After| libm::hypotf(after.tilt_rad[0], after.tilt_rad[1]);
    let largest = after.iter().map(norm).fold(0.0f32, f32::max);
    assert!(largest < 2.0 * UNKNOWN.tilt_rad, "{largest}");
}
