//! Stamps from raw edges, pulses and arrivals: what they are worth against a simulated shutter, and what is refused.

mod bad;
mod clocks;
mod edges;
mod world;

use plumbline_core::stamp::StampSource;
use world::{Flown, World, nees, rms};

/// Flights of a thousand frames each that every figure is taken over.
const SEEDS: std::ops::Range<u64> = 1..5;
/// Σ(error/sigma)² of n independent errors has a standard deviation of √(2/n): 0.022 over 4,000 frames, so that the
/// limits are four and a half of them.
const NEES: std::ops::Range<f64> = 0.9..1.1;

fn flights(world: &World) -> Vec<Vec<Flown>> {
    SEEDS.map(|seed| world.fly(seed, 1000)).collect()
}

/// Every flight within `limit_us`, and the sigmas right over all.
fn holds(name: &str, flights: &[Vec<Flown>], limit_us: f64) -> bool {
    let each: Vec<f64> = flights.iter().map(|flown| rms(flown)).collect();
    let all: Vec<Flown> = flights.iter().flatten().copied().collect();
    println!("{name}: RMS {each:.2?} us, NEES {:.3} over {} frames", nees(&all), all.len());
    each.iter().all(|rms| *rms <= limit_us) && NEES.contains(&nees(&all))
}

/// Flights stamped at another instant of the exposure.
fn moved(flights: &[Vec<Flown>], by: fn(&Flown) -> f64) -> Vec<Vec<Flown>> {
    let moved = |f: &Flown| Flown { error_us: f.error_us + by(f), ..*f };
    flights.iter().map(|flown| flown.iter().map(moved).collect()).collect()
}

fn share(flights: &[Vec<Flown>], source: StampSource) -> f64 {
    let all = flights.iter().flatten();
    all.clone().filter(|f| f.source == source).count() as f64 / all.count() as f64
}

/// 20 ppm with a walk, 2 % of the edges lost, 2 % extra, 2 % of the frames lost, and the timer's wrap in each flight.
#[test]
fn both_edges_are_good_to_ten_microseconds() {
    let flights = flights(&World::default());
    assert!(holds("both edges", &flights, 10.0));
    assert!(share(&flights, StampSource::BothEdges) > 0.95);
    // About two in a hundred of each edge are lost.
    assert!((0.03..0.05).contains(&share(&flights, StampSource::OneEdge)));
    for (name, by) in [("start", start as fn(&Flown) -> f64), ("end", |f| -start(f))] {
        assert!(!holds(name, &moved(&flights, by), 10.0), "stamps at the {name} of the exposure pass");
    }
}

#[test]
fn one_edge_is_good_to_a_hundred_microseconds() {
    for world in [World::opening(), World::closing()] {
        let flights = flights(&world);
        assert!(holds("one edge", &flights, 100.0));
        assert!(share(&flights, StampSource::OneEdge) > 0.97);
        assert!(!holds("start", &moved(&flights, start), 100.0), "stamps at the start of the exposure pass");
    }
}

#[test]
fn arrival_is_as_good_as_its_latency() {
    let flights = flights(&World::arrival());
    assert!(holds("arrival", &flights, 100.0));
    assert!(share(&flights, StampSource::Arrival) == 1.0);
    assert!(!holds("start", &moved(&flights, start), 100.0), "stamps at the start of the exposure pass");
}

/// Half of the exposure before the middle.
fn start(flown: &Flown) -> f64 {
    -0.5 * flown.length_us
}

/// One frame a flight, since all frames of one outage share the error of the clock's rate: 2,000 flights, with TIMESYNC
/// going on and without.
#[test]
fn sixty_seconds_without_pulses_cost_less_than_a_hundred_microseconds() {
    for timesync in [true, false] {
        let world = World { pulses_until_s: 40, timesync, ..World::default() };
        let flights: Vec<Flown> = (0..2000).flat_map(|seed| world.one_at(1000 + seed, 100.0)).collect();
        assert!(flights.len() > 1900, "{} of 2000", flights.len());
        // A single flight of all of them.
        let flights = [flights];
        assert!(holds("after 60 s without pulses", &flights, 100.0));
        assert!(!holds("start", &moved(&flights, start), 100.0), "stamps at the start of the exposure pass");
        // 20 ppm for a minute.
        assert!(!holds("without rate", &moved(&flights, |_| 1200.0), 100.0));
    }
}

/// A frame never has another's edges, whatever is lost or put in, and no stamp is off by more than its sigma allows. One
/// thing cannot be told: a stray edge of the same polarity within the hold-off before the true one makes a bounce of it.
/// That happens to one edge in 7,500 where every second has a stray beside it, and costs less than half the hold-off.
#[test]
fn no_frame_has_the_edges_of_another() {
    let hold_off_us = f64::from(world::SETTINGS.shutter.hold_off_us);
    for (lost, extra, frames) in [(0.02, 0.02, 0.02), (0.3, 0.0, 0.0), (0.0, 0.5, 0.0), (0.1, 0.1, 0.3)] {
        let world = World { lost_edges: lost, extra_edges: extra, lost_frames: frames, ..World::default() };
        let mut strays = 0;
        for seed in SEEDS {
            let flown = world.fly(seed, 1000);
            // Five and a half sigmas are passed by one in twenty-six million.
            let off = flown.iter().filter(|f| f.error_us.abs() > 5.5 * f.sigma_us);
            strays += off.clone().count();
            assert!(off.clone().all(|f| f.error_us.abs() < 0.5 * hold_off_us), "{lost} lost, {extra} extra edges");
            let expected = 1000.0 * (1.0 - frames);
            assert!(flown.len() as f64 > 0.9 * expected, "{} stamps", flown.len());
        }
        assert!(strays <= if extra > 0.2 { 4 } else { 0 }, "{strays} with {lost} lost, {extra} extra edges");
    }
}
