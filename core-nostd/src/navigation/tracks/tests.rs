//! A vehicle that flies east at 20 m/s, seen four times a second with footprints of 100 m: other ground comes every 3.75 s.

use super::*;
use crate::units::Micros;

extern crate std;
use std::vec::Vec as List;

const SPEED_M_PER_S: f32 = 20.0;

struct Flight {
    tracks: Tracks,
    speed_m_per_s: f32,
    frame: u32,
    /// What the reported velocity is off, m/s.
    velocity_error_m_per_s: f32,
}

impl Flight {
    fn new() -> Self {
        Flight { tracks: Tracks::new(), speed_m_per_s: SPEED_M_PER_S, frame: 0, velocity_error_m_per_s: 0.0 }
    }

    /// The next frame, with a match so far off, or none. Whether it is believed.
    fn seen(&mut self, off: Option<[f32; 2]>) -> bool {
        self.frame += 1;
        let at_s = 0.25 * self.frame as f32;
        let moment = Moment {
            at: Micros(1_000_000 + 250_000 * u64::from(self.frame)),
            velocity_m_per_s: [self.speed_m_per_s + self.velocity_error_m_per_s, 0.0],
        };
        self.tracks.propagate(moment, 0.5, 50.0);
        let Some([east_m, north_m]) = off else { return false };
        let truth = Local { east_m: self.speed_m_per_s * at_s, north_m: 0.0 };
        let nadir = Local { east_m: truth.east_m + east_m, north_m };
        let sighting = Sighting {
            nadir,
            covariance: Matrix2::identity() * 0.25,
            white: Matrix2::zeros(),
            side_m: 100.0,
            heading_rad: 0.0,
        };
        if self.tracks.is_empty() {
            self.tracks.begin(&sighting);
            return true;
        }
        self.tracks.matched(&sighting)
    }

    /// Of so many frames, which are believed.
    fn all(&mut self, frames: usize, off: [f32; 2]) -> List<bool> {
        (0..frames).map(|_| self.seen(Some(off))).collect()
    }
}

const RIGHT: [f32; 2] = [0.0, 0.0];
/// The next parcel.
const WRONG: [f32; 2] = [0.0, 40.0];

#[test]
fn matches_that_agree_are_believed_from_the_first_on() {
    assert!(Flight::new().all(200, RIGHT).into_iter().all(|is_believed| is_believed));
    // Off by up to four sigmas of a match, to and fro.
    let mut flight = Flight::new();
    assert!((0..200).all(|i| flight.seen(Some([if i % 2 == 0 { 1.0 } else { -1.0 }, 0.0]))));
}

#[test]
fn one_that_lies_elsewhere_is_not_and_does_no_harm() {
    let mut flight = Flight::new();
    flight.all(40, RIGHT);
    for off in [WRONG, [24.0, 0.0], [-6.0, -6.0]] {
        assert!(!flight.seen(Some(off)), "{off:?}");
        assert!(flight.seen(Some(RIGHT)), "after {off:?}");
    }
}

/// Parcels side by side agree with each other over one piece of ground for as long as it is seen.
#[test]
fn wrong_matches_over_one_ground_never_overrule_the_right_ones() {
    let mut flight = Flight::new();
    flight.all(40, RIGHT);
    // Half a footprint, 2.5 s.
    assert!(flight.all(10, WRONG).into_iter().all(|is_believed| !is_believed));
    assert!(flight.all(40, RIGHT).into_iter().all(|is_believed| is_believed));
}

/// Where the matches themselves were wrong at first, other ground overrules them: until that is clear nothing is believed.
#[test]
fn other_ground_overrules_what_was_wrong() {
    let mut flight = Flight::new();
    flight.all(8, [0.0, 24.0]);
    let believed = flight.all(80, RIGHT);
    let first = believed.iter().position(|is_believed| *is_believed).expect("they come through");
    // Two pieces of ground at least, and no more than the four that the others could have had.
    assert!((10..60).contains(&first), "{first}");
    assert!(believed[first..].iter().all(|is_believed| *is_believed));
}

#[test]
fn a_wrong_velocity_is_no_contradiction() {
    let mut flight = Flight { velocity_error_m_per_s: 5.0, ..Flight::new() };
    assert!(flight.all(100, RIGHT).into_iter().all(|is_believed| is_believed));
    // Two seconds without a match, in which it comes to 10 m.
    (0..8).for_each(|_| assert!(!flight.seen(None)));
    assert!(flight.seen(Some(RIGHT)));
}

#[test]
fn a_place_is_known_until_it_may_be_anywhere() {
    let mut flight = Flight::new();
    assert_eq!(flight.tracks.place(), None);
    flight.all(4, RIGHT);
    // 1.5 m/s over 50 m: 33 s.
    (0..130).for_each(|_| assert!(!flight.seen(None)));
    let place = flight.tracks.place().expect("known");
    assert!((place.east_m - 0.25 * 134.0 * SPEED_M_PER_S).abs() < 0.1, "{place:?}");
    (0..10).for_each(|_| assert!(!flight.seen(None)));
    assert_eq!(flight.tracks.place(), None);
}

/// A vehicle that stands: no ground is other ground. A match or many beside the place change nothing, and the place of the wrong
/// ones never takes right ones in.
#[test]
fn over_one_ground_nothing_is_overruled() {
    let hovering = || Flight { speed_m_per_s: 0.0, ..Flight::new() };
    let mut flight = hovering();
    flight.all(40, RIGHT);
    assert!(!flight.seen(Some(WRONG)));
    assert!(flight.all(800, RIGHT).into_iter().all(|is_believed| is_believed));
    let mut flight = hovering();
    flight.all(40, RIGHT);
    assert!(!flight.all(2400, WRONG).into_iter().any(|is_believed| is_believed));
    // Scattered ones either.
    let mut flight = hovering();
    flight.all(40, RIGHT);
    for off in [[45.0, 0.0], [-45.0, 0.0], [0.0, 45.0], [0.0, -45.0], [110.0, 0.0], [0.0, 110.0]] {
        assert!(!flight.seen(Some(off)));
    }
    assert!(flight.all(400, RIGHT).into_iter().all(|is_believed| is_believed));
}

#[test]
fn after_a_while_a_match_that_lies_aside_is_to_be_found_again() {
    let doubtful = |flight: &Flight| {
        let place = flight.tracks.place().unwrap_or_default();
        [0.0, 12.0, 13.0, 40.0].map(|north_m| flight.tracks.is_doubtful(Local { north_m, ..place }, 50.0))
    };
    let mut flight = Flight::new();
    assert_eq!(doubtful(&flight), [false; 4], "nothing was ever known");
    flight.all(4, RIGHT);
    assert_eq!(doubtful(&flight), [false; 4]);
    // 4.8 times 1.5 m/s is half of the search after 3.5 s.
    (0..13).for_each(|_| assert!(!flight.seen(None)));
    assert_eq!(doubtful(&flight), [false; 4]);
    (0..2).for_each(|_| assert!(!flight.seen(None)));
    assert_eq!(doubtful(&flight), [false, false, true, true]);
    (0..150).for_each(|_| assert!(!flight.seen(None)));
    assert_eq!(doubtful(&flight), [true; 4], "it has been forgotten");
}

#[test]
fn what_is_no_number_is_not_believed() {
    for (nadir, sigma) in [(f32::NAN, 1.0), (0.0, f32::NAN), (f32::INFINITY, 1.0), (0.0, f32::INFINITY)] {
        let mut flight = Flight::new();
        flight.all(8, RIGHT);
        let nadir = Local { east_m: nadir, north_m: 0.0 };
        let sighting = Sighting {
            nadir,
            covariance: Matrix2::identity() * sigma,
            white: Matrix2::zeros(),
            side_m: 100.0,
            heading_rad: 0.0,
        };
        for _ in 0..9 {
            assert!(!flight.tracks.matched(&sighting), "{nadir:?} {sigma}");
        }
        assert!(flight.seen(Some(RIGHT)));
    }
}

#[test]
fn what_a_tilt_puts_aside_turns_with_the_vehicle() {
    // 10 m ahead of a vehicle that flew north, and flies east now.
    let aside = super::Displacement { by_m: [0.0, 10.0], heading_rad: 0.0 };
    let [east_m, north_m] = aside.turned_to(core::f32::consts::FRAC_PI_2);
    assert!((east_m - 10.0).abs() < 1e-5 && north_m.abs() < 1e-5, "{east_m} {north_m}");
}

/// After a while without a match a place may be anywhere, and what lies far from it belongs to it.
#[test]
fn a_place_that_takes_in_what_lies_far_off_is_told_to_have_moved_so_far() {
    let mut flight = Flight::new();
    flight.all(60, RIGHT);
    // As much is worth another one; nothing tells which counts.
    while flight.tracks.place().is_some() {
        flight.seen(Some([0.0, 27.0]));
    }
    (0..12).for_each(|_| _ = flight.seen(None));
    assert!(flight.seen(Some([0.0, -25.0])), "{:?}", flight.tracks);
    let aside = flight.tracks.overruled().expect("none counted");
    assert!((hypot(aside.by_m[0], aside.by_m[1]) - 25.0).abs() < 0.1, "{aside:?}");
}

/// The way since explains it, where nothing says otherwise.
#[test]
fn a_place_that_was_contradicted_and_takes_in_what_lies_far_off_has_moved() {
    let moved = |is_contradicted: bool| {
        let mut flight = Flight::new();
        flight.all(60, RIGHT);
        (0..20).for_each(|_| _ = flight.seen(None));
        if is_contradicted {
            flight.tracks.contradicted();
        }
        assert!(flight.seen(Some([0.0, -11.0])), "{:?}", flight.tracks);
        flight.tracks.overruled().map(|aside| hypot(aside.by_m[0], aside.by_m[1]))
    };
    assert_eq!(moved(false), None);
    assert!(moved(true).is_some_and(|by_m| (by_m - 11.0).abs() < 0.1), "{:?}", moved(true));
}
