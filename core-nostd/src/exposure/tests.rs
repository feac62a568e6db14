//! Expected instants are those of the uniform motion that is flown: where a point lies `x` metres behind the start of a
//! flight at speed v, it is passed after x / v.

use super::*;
use std::vec::Vec;

/// Points of strips, with the course of each.
struct Plan(Vec<(f32, Vec<[f32; 2]>)>);

impl Planned for Plan {
    fn strip(&self, number: u16) -> Option<Strip> {
        let (course, points) = self.0.get(usize::from(number))?;
        let before: usize = self.0.iter().take(number.into()).map(|(_, points)| points.len()).sum();
        Some(Strip { first: before as u32, end: (before + points.len()) as u32, course: Radians(*course) })
    }

    fn point(&self, number: u32) -> Option<Local> {
        let [east_m, north_m] = *self.0.iter().flat_map(|(_, points)| points).nth(number as usize)?;
        Some(Local { east_m, north_m })
    }
}

const LIMITS: Limits = Limits { interval_us: 1_000_000, across_m: 10.0 };
const SPEED: f32 = 40.0;
const START_US: u64 = 5_000_000;

/// Three strips of five points 100 m apart: east, 200 m further north back west, and east again.
fn plan() -> Plan {
    let strip = |north: f32, eastwards: bool| {
        let easts = (0..5).map(|n| 100.0 * if eastwards { n as f32 } else { 4.0 - n as f32 });
        (0.0, easts.map(|east| [east, north]).collect())
    };
    Plan([strip(0.0, true), strip(200.0, false), strip(400.0, true)].into())
}

/// Looks every 100 ms at a camera that flies straight on for `seconds`; what was committed to.
fn fly(exposures: &mut Exposures, plan: &Plan, from: [f32; 2], velocity: [f32; 2], seconds: f32) -> Vec<Exposure> {
    fly_at(START_US, exposures, plan, (from, velocity), seconds)
}

fn fly_at(
    start_us: u64,
    exposures: &mut Exposures,
    plan: &Plan,
    (from, velocity): ([f32; 2], [f32; 2]),
    seconds: f32,
) -> Vec<Exposure> {
    let commit = |count: u32| {
        let t_s = 0.1 * count as f32;
        let state = PositionState {
            east_m: from[0] + velocity[0] * t_s,
            north_m: from[1] + velocity[1] * t_s,
            east_m_per_s: velocity[0],
            north_m_per_s: velocity[1],
        };
        let now = Micros(start_us + u64::from(count) * 100_000);
        let exposure = exposures.commit(plan, &state, now);
        if let Some(exposure) = exposure {
            let ahead_us = exposure.mid.since(now);
            assert!((LEAST_US as i32..=COMMIT_US as i32).contains(&ahead_us), "{ahead_us}");
        }
        exposure
    };
    (0..(10.0 * seconds) as u32).filter_map(commit).collect()
}

fn photos(exposures: &[Exposure]) -> Vec<u32> {
    exposures.iter().map(|exposure| exposure.photo).collect()
}

#[test]
fn points_are_exposed_when_they_are_crossed() {
    let mut exposures = Exposures::new(LIMITS);
    // Drifting aside by 1 m/s, within the limit: the coordinate along the strip decides.
    let taken = fly(&mut exposures, &plan(), [-150.0, -8.0], [SPEED, 1.0], 15.0);
    assert_eq!(photos(&taken), [0, 1, 2, 3, 4]);
    for exposure in &taken {
        let crossed_s = f64::from(150 + 100 * exposure.photo) / f64::from(SPEED);
        let off_us = exposure.mid.0 as f64 - START_US as f64 - 1e6 * crossed_s;
        // A few units in the last place of 550 m, 6e-5 m, at 40 m/s; and what is cut off of a microsecond.
        assert!((-6.0..5.0).contains(&off_us), "{off_us} us");
    }
    assert_eq!(exposures.counts(), Counts { exposed: 5, ..Counts::default() });
    assert_eq!(exposures.next(), 5);
}

#[test]
fn strips_are_flown_both_ways_and_what_is_told_is_found_again() {
    let mut exposures = Exposures::new(LIMITS);
    let plan = plan();
    // A minute from one strip to the next.
    let mut strip = |number: u64, from: [f32; 2], speed: f32| {
        let start_us = START_US + number * 60_000_000;
        let taken = fly_at(start_us, &mut exposures, &plan, (from, [speed, 0.0]), 15.0);
        let found: Vec<Option<u32>> = taken.iter().map(|exposure| exposures.photo_at(exposure.mid)).collect();
        assert_eq!(found, taken.iter().map(|exposure| Some(exposure.photo)).collect::<Vec<_>>());
        assert_eq!(exposures.photo_at(Micros(taken[4].mid.0 - 3)), Some(taken[4].photo));
        assert_eq!(exposures.photo_at(Micros(taken[4].mid.0 + 50_000)), None);
        taken
    };
    let there = strip(0, [-100.0, 0.0], SPEED);
    let back = strip(1, [500.0, 200.0], -SPEED);
    let again = strip(2, [-100.0, 400.0], SPEED);
    assert_eq!(photos(&there), [0, 1, 2, 3, 4]);
    assert_eq!(photos(&back), [5, 6, 7, 8, 9]);
    assert_eq!(photos(&again), [10, 11, 12, 13, 14]);
    // Eight are remembered.
    assert_eq!(exposures.photo_at(back[2].mid), Some(7));
    assert_eq!(exposures.photo_at(back[1].mid), None);
    assert_eq!(exposures.counts(), Counts { exposed: 15, ..Counts::default() });
    // Behind the last there is nothing left.
    assert!(fly(&mut exposures, &plan, [-100.0, 400.0], [SPEED, 0.0], 15.0).is_empty());
}

#[test]
fn a_strip_that_is_entered_late_goes_on_with_its_next_point() {
    let mut exposures = Exposures::new(LIMITS);
    let taken = fly(&mut exposures, &plan(), [150.0, 2.0], [SPEED, 0.0], 10.0);
    assert_eq!(photos(&taken), [2, 3, 4]);
    assert_eq!(exposures.counts(), Counts { exposed: 3, passed: 2, ..Counts::default() });
}

#[test]
fn off_the_line_nothing_is_exposed_and_the_reason_counted() {
    let mut exposures = Exposures::new(LIMITS);
    assert!(fly(&mut exposures, &plan(), [-100.0, 20.0], [SPEED, 0.0], 15.0).is_empty());
    assert_eq!(exposures.counts(), Counts { off_line: 5, ..Counts::default() });
    // Within the limit now, and beyond it when the point comes.
    let mut exposures = Exposures::new(LIMITS);
    assert!(fly(&mut exposures, &plan(), [-8.0, 9.9], [SPEED, 1.0], 0.5).is_empty());
    assert_eq!(exposures.counts(), Counts { off_line: 1, ..Counts::default() });
    // So far away it is another flight: nothing is given up.
    let mut exposures = Exposures::new(LIMITS);
    assert!(fly(&mut exposures, &plan(), [-100.0, -100.0], [SPEED, 0.0], 15.0).is_empty());
    assert_eq!((exposures.counts(), exposures.next()), (Counts::default(), 0));
}

#[test]
fn against_the_strip_across_it_and_in_turns_nothing_happens() {
    let plan = plan();
    let mut exposures = Exposures::new(LIMITS);
    assert!(fly(&mut exposures, &plan, [500.0, 0.0], [-SPEED, 0.0], 15.0).is_empty());
    assert!(fly(&mut exposures, &plan, [100.0, -300.0], [0.0, SPEED], 20.0).is_empty());
    assert_eq!((exposures.counts(), exposures.next()), (Counts::default(), 0));
    // From the end of strip 0 to the beginning of strip 1: half a circle of 100 m, beyond its points.
    fly(&mut exposures, &plan, [-100.0, 0.0], [SPEED, 0.0], 15.0);
    for step in 0..80 {
        let (s, c) = math::sin_cos(core::f32::consts::PI * step as f32 / 80.0);
        let (east_m, north_m) = (450.0 + 100.0 * s, 100.0 - 100.0 * c);
        let state = PositionState { east_m, north_m, east_m_per_s: SPEED * c, north_m_per_s: SPEED * s };
        let now = Micros(20_000_000 + 98_000 * step);
        assert_eq!(exposures.commit(&plan, &state, now), None, "{step}");
    }
    assert_eq!(exposures.counts(), Counts { exposed: 5, ..Counts::default() });
}

#[test]
fn strips_before_the_one_that_is_flown_are_passed_by() {
    let mut exposures = Exposures::new(LIMITS);
    let taken = fly(&mut exposures, &plan(), [150.0, 400.0], [SPEED, 0.0], 10.0);
    assert_eq!(photos(&taken), [12, 13, 14]);
    assert_eq!(exposures.counts(), Counts { exposed: 3, passed: 12, ..Counts::default() });
    // Nor is one entered that is crossed in a turn, 30 degrees off its direction.
    let mut exposures = Exposures::new(LIMITS);
    assert!(fly(&mut exposures, &plan(), [150.0, 390.0], [34.6, 20.0], 2.0).is_empty());
    assert_eq!((exposures.counts(), exposures.next()), (Counts::default(), 0));
    // One of the other direction is not entered by who flies over it the wrong way.
    let mut exposures = Exposures::new(LIMITS);
    assert!(fly(&mut exposures, &plan(), [-100.0, 200.0], [SPEED, 0.0], 15.0).is_empty());
    assert_eq!(exposures.counts(), Counts::default());
}

#[test]
fn points_that_follow_too_soon_are_left_out() {
    // 20 m at 40 m/s: every second one is less than a second behind.
    let points = (0..8).map(|n| [20.0 * n as f32, 0.0]).collect();
    let plan = Plan([(0.0, points)].into());
    let limits = Limits { interval_us: 900_000, ..LIMITS };
    let mut exposures = Exposures::new(limits);
    let taken = fly(&mut exposures, &plan, [-100.0, 0.0], [SPEED, 0.0], 10.0);
    assert_eq!(photos(&taken), [0, 2, 4, 6]);
    assert_eq!(exposures.counts(), Counts { exposed: 4, too_soon: 4, ..Counts::default() });
}

#[test]
fn an_autopilot_that_boots_anew_is_not_waited_for() {
    let mut exposures = Exposures::new(LIMITS);
    let state = |east_m: f32| PositionState { east_m, north_m: 0.0, east_m_per_s: SPEED, north_m_per_s: 0.0 };
    let first = exposures.commit(&plan(), &state(-5.0), Micros(500_000_000));
    assert_eq!(first.map(|first| first.photo), Some(0));
    let second = exposures.commit(&plan(), &state(95.0), Micros(300_000));
    assert_eq!(second, Some(Exposure { photo: 1, mid: Micros(425_000) }));
}

#[test]
fn a_single_point_has_the_strips_course() {
    let course = Radians::from_degrees(30.0).0;
    let plan = Plan([(course, [[0.0, 0.0]].into())].into());
    let (s, c) = math::sin_cos(course);
    let flown = |turn: f32| {
        let mut exposures = Exposures::new(LIMITS);
        let velocity = [turn * SPEED * s, turn * SPEED * c];
        fly(&mut exposures, &plan, [-3.0 * velocity[0], -3.0 * velocity[1]], velocity, 6.0).len()
    };
    assert_eq!((flown(1.0), flown(-1.0)), (1, 0));
}

#[test]
fn no_place_no_speed_and_no_plan_expose_nothing() {
    let values = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 0.0, SPEED, f32::MAX];
    let (plan, nothing) = (plan(), Plan(Vec::new()));
    for number in 0..6usize.pow(4) {
        let value = |digit: u32| values[number / 6usize.pow(digit) % 6];
        let state =
            PositionState { east_m: value(0), north_m: value(1), east_m_per_s: value(2), north_m_per_s: value(3) };
        let mut exposures = Exposures::new(LIMITS);
        let exposure = exposures.commit(&plan, &state, Micros(START_US));
        // The one good state among them is at the first point itself: too late for it.
        assert_eq!(exposure, None, "{state:?}");
        assert_eq!(Exposures::new(LIMITS).commit(&nothing, &state, Micros(START_US)), None);
    }
    // Limits that are no numbers let nothing through.
    let limits = Limits { across_m: f32::NAN, ..LIMITS };
    assert!(fly(&mut Exposures::new(limits), &plan, [-100.0, 0.0], [SPEED, 0.0], 15.0).is_empty());
}
