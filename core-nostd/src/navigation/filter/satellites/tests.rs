use super::SatellitePosition;
use crate::navigation::filter::{Filter, Measurement, PriorSigmas};
use crate::navigation::reckoning::Moment;
use crate::tile::Local;
use crate::units::Micros;
use nalgebra::Matrix2;

extern crate std;
use std::vec::Vec;

const HEIGHT_M: f32 = 120.0;
const NOISE_M: f32 = 0.2;
const SPEED_M_PER_S: f32 = 22.0;
/// Sigmas of the receiver's white noise, as it states it, and of the map.
const SIGMA_M: f32 = 2.0;
const MAP_M: f32 = 1.0;

/// A flight: heading, error of pitch and roll, and offset of the satellites' positions from the map, as functions of
/// time.
struct Flight<'f> {
    seconds: f32,
    heading: &'f dyn Fn(f32) -> f32,
    tilt_rad: [f32; 2],
    tilt_sigma_rad: f32,
    beside_m: &'f dyn Fn(f32) -> Option<[f32; 2]>,
    /// Age of positions at their stamps.
    late_s: f32,
    /// Whether frames are corrected for the estimated tilt.
    corrects: bool,
}

const STRAIGHT: Flight<'static> = Flight {
    seconds: 60.0,
    heading: &|_| 0.0,
    tilt_rad: [0.0; 2],
    tilt_sigma_rad: 0.02,
    beside_m: &|_| Some([0.0; 2]),
    late_s: 0.1,
    corrects: true,
};

/// North for half a minute, a turn of 15 s, then west.
fn to_the_west(at_s: f32) -> f32 {
    -core::f32::consts::FRAC_PI_2 * ((at_s - 30.0) / 15.0).clamp(0.0, 1.0)
}

/// Estimates after a frame.
#[derive(Clone, Debug)]
struct After {
    at_s: f32,
    tilt_rad: [f32; 2],
    disagreement_m: Option<f32>,
    offset_m: [f32; 2],
    offset_sigma_m: f32,
    /// Estimates by matches alone: position, covariance, tilt's sigma.
    alone: [u32; 5],
    /// Error of the position, and its sigma.
    error_m: f32,
    sigma_m: f32,
}

impl After {
    fn of(filter: &Filter, at_s: f32, position: [f32; 2], prior: &PriorSigmas) -> Self {
        let (place, covariance) = filter.position().expect("it was found");
        let sigma_rad = filter.tilt_sigma_rad(prior);
        let alone = [place.east_m, place.north_m, covariance[(0, 0)], covariance[(1, 1)], sigma_rad];
        let (offset_m, offset_sigma_m) = filter.satellites.offset();
        After {
            at_s,
            tilt_rad: filter.tilt_rad(),
            disagreement_m: filter.disagreement_m(),
            offset_m,
            offset_sigma_m,
            alone: alone.map(f32::to_bits),
            error_m: libm::hypotf(place.east_m - position[0], place.north_m - position[1]),
            sigma_m: libm::sqrtf(covariance[(0, 0)].max(covariance[(1, 1)])),
        }
    }
}

fn noise(state: &mut u32, sigma: f32) -> f32 {
    let uniform = |_| {
        *state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (*state >> 8) as f32 / 16_777_216.0 - 0.5
    };
    (0..4).map(uniform).sum::<f32>() * sigma * 1.732
}

impl Flight<'_> {
    /// Four frames a second, velocities and positions of satellites five times a second, the velocities 0.15 s late.
    fn flown(&self, seed: u32) -> Vec<After> {
        const STEP_MS: u32 = 10;
        let prior = PriorSigmas { velocity_m_per_s: 0.3, tilt_rad: self.tilt_sigma_rad, extra_wander_rad: 0.0 };
        let mut filter = Filter::new();
        let (mut state, mut of_satellites) = (seed, seed.wrapping_mul(77));
        let mut places = Vec::new();
        let (mut position, mut after) = ([0.0f32; 2], Vec::new());
        let micros = |ms: u32| Micros(1_000_000 + 1000 * u64::from(ms));
        let velocity = |ms: u32| {
            let heading = (self.heading)(1e-3 * ms as f32);
            [SPEED_M_PER_S * libm::sinf(heading), SPEED_M_PER_S * libm::cosf(heading)]
        };
        for ms in (0..(1e3 * self.seconds) as u32).step_by(STEP_MS as usize) {
            places.push(position);
            let at_s = 1e-3 * ms as f32;
            if let Some(sampled) = ms.checked_sub(150).filter(|sampled| sampled % 200 == 0) {
                filter.reported(Moment { at: micros(sampled), velocity_m_per_s: velocity(sampled) }, &prior);
            }
            let old = places.len().checked_sub(1 + (100.0 * self.late_s) as usize).map(|index| places[index]);
            if let (0, Some(old), Some(beside_m)) = (ms % 200, old, (self.beside_m)(at_s)) {
                let local = Local {
                    east_m: old[0] + beside_m[0] + noise(&mut of_satellites, SIGMA_M),
                    north_m: old[1] + beside_m[1] + noise(&mut of_satellites, SIGMA_M),
                };
                filter.satellites(SatellitePosition { at: micros(ms), local, sigma_m: SIGMA_M, map_sigma_m: MAP_M });
            }
            if ms % 250 == 0 && ms >= 500 {
                let (sin, cos) = (libm::sinf((self.heading)(at_s)), libm::cosf((self.heading)(at_s)));
                filter.propagate(micros(ms), &prior);
                let known = if self.corrects { filter.tilt_rad() } else { [0.0; 2] };
                let left = [self.tilt_rad[0] - known[0], self.tilt_rad[1] - known[1]];
                let (ahead, right) = (-HEIGHT_M * left[0], HEIGHT_M * left[1]);
                let nadir = Local {
                    east_m: position[0] + ahead * sin + right * cos + noise(&mut state, NOISE_M),
                    north_m: position[1] + ahead * cos - right * sin + noise(&mut state, NOISE_M),
                };
                let measurement = Measurement {
                    nadir,
                    covariance: Matrix2::identity() * (NOISE_M * NOISE_M),
                    map_variance_m2: 0.0,
                    inflation_m2: 0.0,
                    transient_rad: 0.0,
                    corrected_tilt_rad: known,
                    height_m: HEIGHT_M,
                    heading_rad: (self.heading)(at_s),
                };
                filter.matched(&measurement, None, &prior);
                after.push(After::of(&filter, at_s, position, &prior));
            }
            let [before, next] = [velocity(ms), velocity(ms + STEP_MS)];
            (0..2).for_each(|axis| position[axis] += 0.5e-3 * STEP_MS as f32 * (before[axis] + next[axis]));
        }
        after
    }

    /// The mean of several flights' last tilt and offset.
    fn means(&self) -> [f32; 4] {
        let ends = (1..=8).map(|seed| self.flown(seed).pop().expect("it has frames"));
        ends.fold([0.0; 4], |mean, end| {
            let all = [end.tilt_rad[0], end.tilt_rad[1], end.offset_m[0], end.offset_m[1]];
            core::array::from_fn(|index| mean[index] + all[index] / 8.0)
        })
    }
}

fn first_told(after: &[After]) -> Option<f32> {
    after.iter().find(|after| after.disagreement_m.is_some()).map(|after| after.at_s)
}

/// Satellites are 3 m east and 2 m south of the map's position, for whatever reason; the camera is level and known to
/// be.
#[test]
fn the_offset_of_the_map_is_found() {
    let flight = Flight { tilt_sigma_rad: 0.001, beside_m: &|_| Some([3.0, -2.0]), ..STRAIGHT };
    for seed in 1..=8 {
        let end = flight.flown(seed).pop().expect("it has frames");
        // North is along the track, where the receiver's latency error is an offset as well, of 0.06 s times 22 m/s.
        let within = [(end.offset_m[0] + 3.0).abs() < 1.0, (end.offset_m[1] - 2.0).abs() < 1.5];
        assert!(within == [true; 2] && end.offset_sigma_m < 1.3 && end.disagreement_m.is_none(), "{seed}: {end:?}");
    }
}

/// Roll off by 1.5 sigmas, 2.4 m times 1.5 = 3.6 m to the right, and the map by 2.5 m to the left of it, one sigma being 2.24 m: on one
/// heading the sum, 1.1 m, is shared by the squares of the sigmas; two headings tell them apart.
#[test]
fn one_heading_shares_by_the_sigmas_and_two_tell_apart() {
    let flight = Flight { tilt_rad: [0.0, 0.03], beside_m: &|_| Some([2.5, 0.0]), ..STRAIGHT };
    let [_, roll, east, _] = flight.means();
    let (by_tilt, all) = (2.4f32 * 2.4, 2.4f32 * 2.4 + 5.0);
    assert!((roll * HEIGHT_M - 1.1 * by_tilt / all).abs() < 0.4, "{roll} {east}");
    assert!((east - 1.1 * (1.0 - by_tilt / all)).abs() < 0.4, "{roll} {east}");
    let [pitch, roll, east, north] = Flight { heading: &to_the_west, seconds: 90.0, ..flight }.means();
    // A tilt is taken to last 25 s: of what two headings tell a third fades in the turn of 15 s between them.
    assert!((roll - 0.03).abs() < 0.015 && pitch.abs() < 0.01, "{pitch} {roll} {east} {north}");
    assert!((-3.5..-0.8).contains(&east) && north.abs() < 1.5, "{pitch} {roll} {east} {north}");
}

/// Without satellites a turn determines a tilt by the velocities alone, and less accurately.
#[test]
fn satellites_tell_more_of_the_tilt_than_matches_alone() {
    let flight = Flight { tilt_rad: [0.0, 0.03], ..STRAIGHT };
    let off = |flight: &Flight<'_>| (flight.means()[1] - 0.03).abs();
    let (with, alone) = (off(&flight), off(&Flight { beside_m: &|_| None, ..flight }));
    assert!(with < 0.75 * alone, "{with} {alone}");
}

/// A camera that leans 9 degrees where 1.1 are expected is 18.9 m off at 120 m, 5.7 sigmas.
#[test]
fn a_lean_beyond_what_may_be_is_told() {
    let flight = Flight { tilt_rad: [0.0, 0.157], ..STRAIGHT };
    for seed in 1..=8 {
        let after = flight.flown(seed);
        let told = first_told(&after).expect("it is told");
        assert!(told < 5.0, "{seed}: {told}");
        let end = after.last().and_then(|after| after.disagreement_m).expect("it still is");
        assert!((end - 18.9).abs() < 2.0, "{seed}: {end}");
        // The tilt was not corrected for it.
        assert!(after.iter().all(|after| after.tilt_rad[1].abs() < 0.06), "{seed}");
    }
}

/// Satellites that walk off by 0.5 m/s to the side from 20 s on: the difference is 4.8 times the root of 4 + 1 (offset) + 0.0004 h² (tilt)
/// + 0.4 / 10 (white) or 15.8 m after 31.6 s. The average of ten is a second late, and off by 0.6 m at 3 sigmas.
#[test]
fn satellites_that_are_dragged_off_are_told_and_do_no_harm() {
    let drag = |at_s: f32| Some([0.5 * (at_s - 20.0).max(0.0), 0.0]);
    let flight = Flight { seconds: 120.0, beside_m: &drag, ..STRAIGHT };
    for seed in 1..=8 {
        let after = flight.flown(seed);
        let told = first_told(&after).expect("it is told");
        assert!((48.0..57.0).contains(&told), "{seed}: {told}");
        // Within three sigmas of the estimate by matches alone.
        assert!(after.iter().all(|after| after.tilt_rad[1].abs() <= 3.04 * 0.02), "{seed}");
        let end = after.last().expect("it has frames");
        assert!((end.disagreement_m.unwrap_or(0.0) - 49.0).abs() < 1.5 && end.tilt_rad[1].abs() < 0.01, "{end:?}");
    }
}

#[test]
fn satellites_that_jump_and_come_back_are_told_at_once_and_believed_again() {
    let jump = |at_s: f32| Some([if (20.0..40.0).contains(&at_s) { 100.0 } else { 0.0 }, 0.0]);
    for seed in 1..=8 {
        let after = Flight { beside_m: &jump, ..STRAIGHT }.flown(seed);
        let told: Vec<f32> =
            after.iter().filter(|after| after.disagreement_m.is_some()).map(|after| after.at_s).collect();
        // Two of ten of the average are enough; it is back within 7 m, three sigmas, when it has forgotten 93 %.
        assert!((20.0..21.5).contains(&told[0]) && (44.0..47.5).contains(&told[told.len() - 1]), "{seed}: {told:?}");
    }
}

#[test]
fn satellites_that_are_right_are_never_said_to_disagree() {
    for seed in 1..=20 {
        for late_s in [0.0, 0.1, 0.2] {
            let flight = Flight { seconds: 300.0, heading: &|at_s| 0.1 * at_s, late_s, ..STRAIGHT };
            let after = flight.flown(seed);
            assert_eq!(first_told(&after), None, "{seed}");
            // Nor is a latency error of 0.1 s taken for the pitch that it resembles, 2.2 m or 0.018.
            assert!(after[400..].iter().all(|after| after.tilt_rad[0].abs() < 0.018), "{seed} {late_s}");
        }
    }
}

/// The offset is kept without satellites and decays.
#[test]
fn an_offset_drifts_to_its_prior_when_satellites_are_lost() {
    let until = |at_s: f32| (at_s < 60.0).then_some([4.0, 0.0]);
    let after = Flight { seconds: 360.0, tilt_sigma_rad: 0.001, beside_m: &until, ..STRAIGHT }.flown(1);
    let [then, end] = [&after[235], &after[after.len() - 1]];
    // 300 of 600 s in steps of 0.2 s.
    assert!((end.offset_m[0] / then.offset_m[0] - 0.607).abs() < 0.01, "{then:?} {end:?}");
    assert!(end.offset_sigma_m > 1.5 && end.offset_sigma_m < 2.3 && then.offset_sigma_m < 1.3, "{then:?} {end:?}");
}

/// The estimates by matches alone, to the last bit: position, its covariance and the tilt's sigma, of protection and
/// fixes.
#[test]
fn satellites_change_nothing_of_what_matches_alone_know() {
    let flight = Flight { corrects: false, tilt_rad: [0.01, 0.02], heading: &to_the_west, seconds: 90.0, ..STRAIGHT };
    let without = Flight { beside_m: &|_| None, ..flight }.flown(3);
    for beside_m in [[0.0; 2], [3.0, -4.0], [500.0, 0.0], [f32::NAN, 0.0]] {
        let with = Flight { beside_m: &|_| Some(beside_m), ..flight }.flown(3);
        assert!(without.iter().zip(&with).all(|(without, with)| without.alone == with.alone), "{beside_m:?}");
    }
    assert!(without.iter().all(|after| after.error_m < 4.8 * after.sigma_m));
}

/// Each position is repeated a second later, after a newer one, as on a link that repeats; one in two has no valid
/// sigma.
#[test]
fn old_positions_and_those_without_a_sigma_are_left_out() {
    let mut satellites = super::Satellites::new();
    let at = |tenth: u64| Micros(10_000_000 + 100_000 * tenth);
    let local = Local { east_m: 1.0, north_m: 2.0 };
    let position = |tenth, sigma_m| SatellitePosition { at: at(tenth), local, sigma_m, map_sigma_m: 0.0 };
    for tenth in 10..30 {
        satellites.receive(position(tenth, 2.0));
        for sigma_m in [f32::NAN, f32::INFINITY, 100.1] {
            satellites.receive(position(tenth + 1, sigma_m));
        }
        satellites.receive(position(tenth - 10, 2.0));
        assert_eq!(satellites.due(at(tenth)), Some(position(tenth, 2.0)), "{tenth}");
        assert_eq!(satellites.due(at(tenth)), None);
        satellites.averaged += 1.0;
    }
    // The first has nothing before it.
    assert_eq!(satellites.averaged, 20.0);
    // A clock that restarted, and a pause.
    for tenth in [0, 21] {
        satellites.averaged = 5.0;
        satellites.receive(position(tenth, 2.0));
        assert_eq!((satellites.due(at(tenth)), satellites.averaged), (Some(position(tenth, 2.0)), 0.0));
    }
    // A position that waited too long is not used.
    satellites.receive(position(22, 2.0));
    assert_eq!((satellites.due(at(21)), satellites.due(at(43))), (None, None));
}

/// After a jump of the tilt the offset is kept, so that satellites determine the tilt when matches alone do not any
/// more.
#[test]
fn an_estimate_that_begins_anew_keeps_the_offset() {
    let mut filter = Filter::new();
    let prior = PriorSigmas { velocity_m_per_s: 0.3, tilt_rad: 0.005, extra_wander_rad: 0.0 };
    let at = |tenth: u64| Micros(1_000_000 + 100_000 * tenth);
    let mut state = 5;
    for tenth in 0..600u64 {
        let east_m = 2.0 * tenth as f32;
        filter.reported(Moment { at: at(tenth), velocity_m_per_s: [20.0, 0.0] }, &prior);
        let local = Local { east_m: east_m - 2.0 - 2.0, north_m: noise(&mut state, SIGMA_M) };
        filter.satellites(SatellitePosition { at: at(tenth), local, sigma_m: SIGMA_M, map_sigma_m: MAP_M });
        filter.propagate(at(tenth), &prior);
        // East is ahead: a roll puts the nadir to the south.
        let roll = if tenth < 300 { 0.0 } else { 0.05 };
        let known = filter.tilt_rad();
        let measurement = Measurement {
            nadir: Local { east_m, north_m: -HEIGHT_M * (roll - known[1]) },
            covariance: Matrix2::identity() * 0.04,
            map_variance_m2: 0.0,
            inflation_m2: 0.0,
            transient_rad: 0.0,
            corrected_tilt_rad: known,
            height_m: HEIGHT_M,
            heading_rad: core::f32::consts::FRAC_PI_2,
        };
        filter.matched(&measurement, None, &prior);
    }
    let (offset_m, sigma_m) = filter.satellites.offset();
    assert!((offset_m[0] - 2.0).abs() < 1.3 && offset_m[1].abs() < 1.0 && sigma_m < 1.6, "{offset_m:?} {sigma_m}");
    let [pitch, roll] = filter.tilt_rad();
    assert!((roll - 0.05).abs() < 0.012 && pitch.abs() < 0.012, "{pitch} {roll}");
    assert!(filter.tilt_sigma_rad(&prior) > 0.03, "it is that of matches alone");
}
