//! A vehicle that flies east at 20 m/s, four frames a second with footprints of 100 m over a map of 5 m a pixel: a key frame every 3.75 s.
//! Each frame's scores have a peak at the true shift, and a false one that is as high or nearly so.

use super::*;

extern crate std;
use std::vec::Vec;

const SPEED_M_PER_S: f32 = 20.0;
const PX_M: f32 = 5.0;
const SIDE_M: f32 = 100.0;
const STEP_M: f32 = STEP_PX as f32 * PX_M;
const VALID: u32 = 900;
/// Frames from one key frame to the next.
const FRAMES: u32 = 15;
/// As in flight.
const RISK_MAX: f32 = 1e-3;
/// And for a fix.
const BELIEVED_RISK: f32 = 1e-4;
const UNKNOWN: f32 = 0.0;

/// A peak: offset from the centre (columns, rows), cells, and height.
type Bump = ([f32; 2], f32);

fn scores(bumps: &[Bump]) -> Scores {
    let near = |at: usize, top: f32| (1.0 - 0.5 * (at as f32 - MIDDLE as f32 - top).abs()).max(0.0);
    let at = |row, col| bumps.iter().map(|(top, high)| high * near(col, top[0]) * near(row, top[1])).sum();
    core::array::from_fn(|row| core::array::from_fn(|col| at(row, col)))
}

struct Flight {
    surface: Surface,
    frame: u32,
    speed_m_per_s: f32,
    /// Error of the reported velocity, m/s, and its stated sigma.
    velocity_error_m_per_s: f32,
    sigma_m_per_s: f32,
    /// One sigma of the navigation's position at first, metres.
    expected_m: f32,
}

impl Flight {
    /// Over a map of another year.
    fn new() -> Self {
        Flight {
            surface: Surface::new(),
            frame: 0,
            speed_m_per_s: SPEED_M_PER_S,
            velocity_error_m_per_s: 0.0,
            sigma_m_per_s: 0.1,
            expected_m: UNKNOWN,
        }
    }

    fn east_m(&self, speed_m_per_s: f32) -> f32 {
        0.25 * self.frame as f32 * speed_m_per_s
    }

    fn truth(&self) -> Local {
        Local { east_m: self.east_m(self.speed_m_per_s), north_m: 0.0 }
    }

    /// The next frame, with a search centred a little off the truth. `tops`: peaks, east and south of the truth, cells.
    fn seen(&mut self, tops: &[Bump]) {
        self.frame += 1;
        let reported = self.speed_m_per_s + self.velocity_error_m_per_s;
        let at = Micros(1_000_000 + 250_000 * u64::from(self.frame));
        self.surface.propagate(Moment { at, velocity_m_per_s: [reported, 0.0] }, [0.0; 2], self.sigma_m_per_s);
        let truth = self.truth();
        let centre = truth.moved([3.0, -2.0]);
        let (cols, rows) = self.surface.recentre(centre, (truth, self.expected_m), SIDE_M, PX_M);
        let off = [
            (truth.east_m - centre.east_m) / STEP_M - f32::from(cols) / f32::from(STEP_PX),
            (centre.north_m - truth.north_m) / STEP_M - f32::from(rows) / f32::from(STEP_PX),
        ];
        let tops: Vec<Bump> = tops.iter().map(|([col, row], high)| ([off[0] + col, off[1] + row], *high)).collect();
        self.surface.add(&Frame::new(&scores(&tops), VALID), PX_M);
    }

    /// So many key frames, each with a peak at the truth and a false one.
    fn flown(&mut self, pieces: usize, right: f32, wrong: f32) {
        for piece in 0..pieces {
            let elsewhere = [[-4.0, 1.0], [3.0, -3.0], [-1.0, 4.0], [4.0, 2.0], [-3.0, -4.0]][piece % 5];
            (0..FRAMES).for_each(|_| self.seen(&[([0.0, 0.0], right), (elsewhere, wrong)]));
        }
    }

    fn decision(&self) -> Decision {
        self.surface.decision(PX_M).expect("not on the border")
    }

    fn off_m(&self) -> f32 {
        self.decision().nadir.off_m(self.truth())
    }
}

#[test]
fn several_weak_key_frames_decide() {
    let mut flight = Flight::new();
    flight.flown(1, 0.29, 0.3);
    assert!(flight.decision().risk > 0.1 && flight.off_m() > 2.0 * STEP_M, "{:?}", flight.decision());
    flight.flown(6, 0.29, 0.3);
    assert!(flight.decision().risk < RISK_MAX && flight.off_m() < 0.2 * STEP_M, "{:?}", flight.decision());
}

#[test]
fn the_same_ground_counts_once() {
    let mut flight = Flight { speed_m_per_s: 0.0, ..Flight::new() };
    flight.seen(&[([1.0, 0.0], 0.3), ([-3.0, 0.0], 0.1)]);
    let first = flight.decision();
    (0..100).for_each(|_| flight.seen(&[([1.0, 0.0], 0.3), ([-3.0, 0.0], 0.1)]));
    assert_eq!(flight.decision(), first);
}

/// Until the next key frame, a frame of more texture replaces the newest one; the ground still counts once.
#[test]
fn a_frame_of_more_texture_replaces_the_newest_key_frame() {
    let mut flight = Flight::new();
    flight.seen(&[([3.0, 0.0], 0.2), ([0.0, 0.0], 0.1)]);
    assert!(flight.off_m() > 2.0 * STEP_M);
    flight.seen(&[([0.0, 0.0], 0.9), ([3.0, 0.0], 0.5)]);
    assert!(flight.off_m() < 0.2 * STEP_M, "{:?}", flight.decision());
    // The one before is gone, and one of less texture changes nothing.
    let mut alone = Flight::new();
    alone.frame = 1;
    alone.seen(&[([0.0, 0.0], 0.9), ([3.0, 0.0], 0.5)]);
    let near = |a: f32, b: f32| (a - b).abs() < 0.05 * b;
    assert!(near(flight.decision().risk, alone.decision().risk), "{:?} {:?}", flight.decision(), alone.decision());
    let before = flight.decision().risk;
    flight.seen(&[([-3.0, 0.0], 0.3)]);
    assert_eq!(flight.decision().risk, before);
}

/// The velocity is poorly known, but the position was confirmed a moment ago.
#[test]
fn corrections_bound_the_dead_reckoning_error() {
    let risk = |found: bool| {
        let mut flight = Flight { sigma_m_per_s: 3.0, ..Flight::new() };
        for _ in 0..10 * FRAMES {
            flight.seen(&[([0.0, 0.0], 0.3), ([3.0, 0.0], 0.1)]);
            if found {
                let truth = flight.truth();
                flight.surface.correct(truth, truth, PX_M);
            }
        }
        flight.surface.decision(PX_M).map(|decided| decided.risk)
    };
    let (found, lost) = (risk(true), risk(false));
    assert!(found.is_some_and(|risk| risk < RISK_MAX) && lost.is_none_or(|risk| risk > RISK_MAX), "{found:?} {lost:?}");
}

/// A large residual corrects no more than the limit.
#[test]
fn a_large_residual_is_limited() {
    let moved_m = |aside_px: f32| {
        let mut flight = Flight::new();
        flight.flown(6, 0.3, 0.1);
        let before = flight.decision().nadir;
        flight.surface.correct(before, before.moved([aside_px * PX_M, 0.0]), PX_M);
        flight.decision().nadir.off_m(before)
    };
    assert!((moved_m(0.5) - GAIN * 0.5 * PX_M).abs() < 0.01, "{}", moved_m(0.5));
    assert!((moved_m(3.0) - GAIN * RESIDUAL_MAX_PX * PX_M).abs() < 0.01, "{}", moved_m(3.0));
}

/// However clear its peak is: a fix takes four of them.
#[test]
fn the_evidence_of_a_key_frame_is_limited() {
    let mut flight = Flight::new();
    flight.flown(1, 0.9, 0.0);
    assert!((flight.decision().risk - risk(CAP)).abs() < 1e-4 * risk(CAP), "{:?}", flight.decision());
    flight.flown(2, 0.9, 0.0);
    assert!(flight.decision().risk > BELIEVED_RISK, "{:?}", flight.decision());
    flight.flown(1, 0.9, 0.0);
    assert!(flight.decision().risk < BELIEVED_RISK, "{:?}", flight.decision());
}

/// A false peak that has been there for one key frame only: a shore that moved.
#[test]
fn a_wrong_key_frame_is_outweighed() {
    let mut flight = Flight::new();
    (0..FRAMES).for_each(|_| flight.seen(&[([-4.0, 3.0], 0.9)]));
    flight.flown(5, 0.3, 0.1);
    assert!(flight.off_m() < 0.2 * STEP_M, "{:?}", flight.decision());
}

/// The map's offset changes by place: long evidence delays the change no more than short evidence.
#[test]
fn old_evidence_is_forgotten() {
    let mut flight = Flight::new();
    flight.flown(40, 0.3, 0.1);
    let follows = |flight: &mut Flight| {
        (0..FRAMES).for_each(|_| flight.seen(&[([3.0, 0.0], 0.3), ([0.0, 0.0], 0.1)]));
        flight.off_m() > 2.0 * STEP_M
    };
    let pieces = (1..30).find(|_| follows(&mut flight));
    // By then half of the old evidence has faded.
    assert!(pieces.is_some_and(|pieces| pieces <= 7), "{pieces:?}");
}

#[test]
fn a_frame_contradicts_by_its_evidence_for_another_shift() {
    let mut flight = Flight::new();
    flight.flown(5, 0.3, 0.1);
    let agrees = |tops: &[Bump]| flight.surface.is_consistent(&Frame::new(&scores(tops), VALID));
    assert!(agrees(&[([0.0, 0.0], 0.3)]) && agrees(&[([1.0, 0.0], 0.3)]));
    assert!(agrees(&[([0.0, 0.0], 0.3), ([4.0, 0.0], 0.305)]), "next to nothing");
    assert!(!agrees(&[([0.0, 0.0], 0.2), ([4.0, 0.0], 0.3)]));
}

#[test]
fn a_velocity_error_within_its_sigma_is_followed() {
    let mut flight = Flight { velocity_error_m_per_s: 1.0, sigma_m_per_s: 1.0, ..Flight::new() };
    flight.flown(10, 0.3, 0.2);
    assert!(flight.decision().risk < RISK_MAX && flight.off_m() < STEP_M, "{:?} {}", flight.decision(), flight.off_m());
    // With an understated sigma the evidence is left behind.
    let mut flight = Flight { velocity_error_m_per_s: 1.0, sigma_m_per_s: 0.0, ..Flight::new() };
    flight.flown(10, 0.3, 0.2);
    assert!(flight.off_m() > STEP_M, "{:?}", flight.decision());
}

#[test]
fn corrections_over_one_key_frame_are_limited() {
    let led_px = |key_frame_drift_m: f32, frames: usize| {
        let mut flight = Flight::new();
        flight.flown(6, 0.3, 0.2);
        flight.surface.key_frame_drift_m = key_frame_drift_m;
        let first = flight.surface.centre;
        for _ in 0..frames {
            // Peaks of the frames two pixels north of the decided position.
            let before = flight.surface.centre;
            flight.surface.correct(before, before.moved([0.0, 2.0 * PX_M]), PX_M);
        }
        flight.surface.centre.off_m(first) / PX_M
    };
    assert!((0.2..CORRECTION_MAX_PX).contains(&led_px(0.0, 1)), "{}", led_px(0.0, 1));
    assert!((led_px(0.0, 20) - CORRECTION_MAX_PX).abs() < 0.05, "{}", led_px(0.0, 20));
    // The dead reckoning error since is corrected in addition.
    assert!((led_px(3.0 * PX_M, 100) - 3.0f32.hypot(CORRECTION_MAX_PX)).abs() < 0.05, "{}", led_px(3.0 * PX_M, 100));
}

#[test]
fn there_is_no_decision_after_too_much_dead_reckoning() {
    let mut flight = Flight { sigma_m_per_s: 0.5, ..Flight::new() };
    flight.flown(6, 0.3, 0.2);
    assert!(flight.decision().risk < RISK_MAX);
    // Above the same ground for as long as the dead reckoning limit.
    let carried = |flight: &mut Flight, seconds: f32| {
        let at = Micros(flight.surface.moment.at.0 + (seconds * 1e6) as u64);
        flight.surface.propagate(Moment { at, velocity_m_per_s: [0.0; 2] }, [0.0; 2], 0.5);
    };
    let until_s = DRIFT_SIGMA_MAX_PX * PX_M / 0.5 - 0.25 * FRAMES as f32;
    carried(&mut flight, until_s);
    assert!(flight.surface.decision(PX_M).is_some());
    carried(&mut flight, 4.0);
    assert_eq!(flight.surface.decision(PX_M), None);
    // Frames whose own peaks lie there confirm it.
    let before = flight.surface.centre;
    (0..3).for_each(|_| flight.surface.correct(before, before, PX_M));
    assert!(flight.surface.decision(PX_M).is_some());
}

#[test]
fn a_long_gap_clears_the_surface() {
    let mut flight = Flight::new();
    flight.flown(6, 0.3, 0.2);
    flight.frame += 4 * 10;
    flight.seen(&[([0.0, 0.0], 0.3), ([3.0, 0.0], 0.25)]);
    assert!(flight.decision().risk > 0.1, "{:?}", flight.decision());
}

#[test]
fn evidence_keeps_its_position_when_the_search_moves() {
    let mut flight = Flight::new();
    flight.flown(6, 0.3, 0.1);
    let before = flight.decision();
    let centre = flight.truth().moved([3.2 * STEP_M, -2.0 * STEP_M]);
    let by = flight.surface.recentre(centre, (centre, UNKNOWN), SIDE_M, PX_M);
    assert!(by.0.abs() <= 1 && by.1.abs() <= 1, "{by:?}");
    assert!(flight.decision().nadir.off_m(before.nadir) < 0.01, "{:?}, {before:?}", flight.decision());
    // A search that does not overlap: no evidence there.
    let far = flight.truth().moved([20.0 * STEP_M, 0.0]);
    assert_eq!(flight.surface.recentre(far, (far, UNKNOWN), SIDE_M, PX_M), (0, 0));
    assert_eq!(flight.surface.decision(PX_M), None);
}

#[test]
fn valid_least_squares_outweigh_a_key_frame() {
    let mut flight = Flight::new();
    (0..FRAMES).for_each(|_| flight.seen(&[([3.0, 0.0], 0.9)]));
    flight.frame += 1;
    let at = Micros(1_000_000 + 250_000 * u64::from(flight.frame));
    flight.surface.propagate(Moment { at, velocity_m_per_s: [SPEED_M_PER_S, 0.0] }, [0.0; 2], 0.1);
    let truth = flight.truth();
    flight.surface.recentre(truth, (truth, UNKNOWN), SIDE_M, PX_M);
    flight.surface.add_least_squares(truth, PX_M);
    assert!(flight.off_m() < STEP_M, "{:?}", flight.decision());
}

/// Between two cells of the grid, too, and a key frame that is less than a cell off does not take it to the next one.
#[test]
fn valid_least_squares_locate_the_peak_within_a_cell() {
    let mut flight = Flight::new();
    flight.surface.propagate(Moment { at: Micros(1_000_000), velocity_m_per_s: [0.0; 2] }, [0.0; 2], 0.1);
    let truth = flight.truth();
    let centre = truth.moved([0.45 * STEP_M, -0.3 * STEP_M]);
    flight.surface.recentre(centre, (centre, UNKNOWN), SIDE_M, PX_M);
    flight.surface.add_least_squares(truth, PX_M);
    assert!(flight.off_m() < 0.1 * STEP_M, "{} m", flight.off_m());
    (0..FRAMES).for_each(|_| flight.seen(&[([0.8, 0.0], 0.3)]));
    assert!(flight.off_m() < 0.4 * STEP_M, "{} m", flight.off_m());
}

/// The navigation's position has the weight of one key frame.
#[test]
fn the_prior_has_the_weight_of_one_key_frame() {
    let off_m = |expected_m: f32, pieces: u32| {
        let mut flight = Flight { expected_m, ..Flight::new() };
        (0..pieces * FRAMES).for_each(|_| flight.seen(&[([0.0, 0.0], 0.2), ([4.0, 0.0], 0.25)]));
        flight.off_m()
    };
    assert!(off_m(UNKNOWN, 1) > 3.0 * STEP_M);
    assert!(off_m(STEP_M, 1) < STEP_M);
    assert!(off_m(STEP_M, 20) > 3.0 * STEP_M);
}

/// Nothing on board may panic, whatever the inputs are.
#[test]
fn non_finite_inputs_do_no_harm() {
    for bad in [f32::NAN, f32::INFINITY, f32::MIN, f32::MAX] {
        let mut flight = Flight::new();
        flight.flown(2, 0.3, 0.1);
        flight.seen(&[([0.0, 0.0], bad)]);
        let nowhere = Local { east_m: bad, north_m: bad };
        flight.surface.propagate(Moment { at: Micros(9_000_000), velocity_m_per_s: [bad; 2] }, [bad; 2], bad);
        flight.surface.recentre(nowhere, (nowhere, bad), bad, bad);
        flight.surface.add(&Frame::new(&[[bad; SHIFTS]; SHIFTS], VALID), bad);
        flight.surface.add_least_squares(nowhere, bad);
        flight.surface.correct(nowhere, nowhere, bad);
        let decided = flight.surface.decision(PX_M).is_some_and(|decided| decided.risk <= RISK_MAX);
        assert!(!decided, "{bad}: {:?}", flight.surface.decision(PX_M));
    }
}
