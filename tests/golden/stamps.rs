//! Stamps and pose histories of the core: table I of paper 000, and what a timer and its pulses do in the field.

mod mutants;
mod seeded;
mod vectors;

use plumbline_core::pose::{Backwards, History, PoseError};
use plumbline_core::stamp::{Clock, ClockSettings, EXPOSURE_MAX_US, Exposure};
use plumbline_core::tilt::Attitude;
use plumbline_core::units::{Micros, Radians, Ticks};
use proptest::prelude::{any, prop_assert, prop_assert_eq, proptest};
use seeded::config;
use vectors::{list, miss, number, rows, tick, turn_deg};

fn exposure(open: u32, close: u32) -> Exposure {
    Exposure { open: Ticks(open), close: Ticks(close) }
}

/// An ordinary crystal and pulses that jitter by half a tick.
const CLOCK: ClockSettings = ClockSettings {
    pulse_sigma_us: 0.5,
    rate_sigma_ppm: 30.0,
    rate_walk_ppm: 0.01,
    timesync_sigma_us: 100.0,
    sigma_max_us: 5000.0,
};

fn instant(clock: &Clock, tick: Ticks) -> Option<Micros> {
    clock.instant(tick).map(|(at, _)| at)
}

#[test]
fn golden_i_mid_exposure() {
    for row in rows("000", "I_mid_u32") {
        let mid = exposure(tick(&row, "start"), tick(&row, "stop")).mid();
        assert_eq!(mid, Some(Ticks(tick(&row, "mid"))), "{row}");
    }
    for (name, stamp) in mutants::STAMPS {
        let differs = |row: &serde_json::Value| {
            let (open, close) = (tick(row, "start"), tick(row, "stop"));
            exposure(open, close).mid() != Some(Ticks(stamp(open, close)))
        };
        assert!(rows("000", "I_mid_u32").iter().any(differs), "the core gives the same as: {name}");
    }
}

/// Paper 000's t = s1 + (c − c1)/(c1 − c0), through the clock: a coarse tie 0.2 s off at the first pulse, then both. The
/// two pulses outvote it, and theirs is the rate.
#[test]
fn golden_i_pulses() {
    for row in rows("000", "I_pps") {
        let [at, c0, c1] = ["tick", "c0", "c1"].map(|key| tick(&row, key));
        let mut clock = Clock::new(CLOCK);
        let coarse = (number(&row, "s1") - 1.0 + 0.2) * 1e6;
        clock.on_timesync(Ticks(c0.wrapping_sub(500)), Micros(coarse as u64), Ticks(c0.wrapping_add(500)));
        clock.on_pulse(Ticks(c0));
        clock.on_pulse(Ticks(c1));
        let off = instant(&clock, Ticks(at)).expect("after boot").0 as f64 - 1e6 * number(&row, "out");
        assert!(off.abs() <= 1.0, "{off} us off for {row}");
    }
}

fn attitude(degrees: [f64; 3]) -> Attitude {
    let [heading, pitch, roll] = degrees.map(|deg| Radians(deg.to_radians() as f32));
    Attitude { heading, pitch, roll }
}

fn degrees(attitude: Attitude) -> [f64; 3] {
    [attitude.heading, attitude.pitch, attitude.roll].map(|angle| f64::from(angle.0).to_degrees())
}

/// The difference of two attitudes in degrees, the heading's the short way round.
fn miss_attitude(a: [f64; 3], b: [f64; 3]) -> f64 {
    miss([turn_deg(a[0], b[0]), a[1], a[2]], [0.0, b[1], b[2]])
}

#[test]
fn golden_i_attitude() {
    let mut long_way = 0.0f64;
    for row in rows("000", "I_att") {
        let (a0, a1): ([f64; 3], [f64; 3]) = (list(&row, "a0"), list(&row, "a1"));
        let at = 5_000_000 + (5000.0 * number(&row, "u")) as u64;
        let mut history: History<Attitude, 4> = History::new();
        for (stamp, sample) in [(5_000_000, a0), (5_005_000, a1)] {
            history.push(Micros(stamp), attitude(sample)).expect("forwards");
        }
        let ours = degrees(history.at(Micros(at), 5000).expect("between both").value);
        assert!(miss_attitude(ours, list(&row, "linear")) < 1e-4, "{ours:?} for {row}");
        long_way = long_way.max(miss_attitude(mutants::attitude_long_way(a0, a1, number(&row, "u")), ours));
    }
    assert!(long_way > 1.0, "the core goes the long way round");
}

#[test]
fn exposures_that_cannot_be_are_refused() {
    let longest = EXPOSURE_MAX_US as u32;
    for open in [0, 1000, u32::MAX - 10, 1 << 31] {
        assert_eq!(exposure(open, open.wrapping_sub(1)).mid(), None, "closed before it opened");
        assert_eq!(exposure(open, open.wrapping_sub(5000)).mid(), None, "closed before it opened");
        assert!(exposure(open, open.wrapping_add(longest)).mid().is_some());
        assert_eq!(exposure(open, open.wrapping_add(longest + 1)).mid(), None, "too long to be one exposure");
        assert_eq!(exposure(open, open.wrapping_add(1 << 31)).mid(), None, "half a wrap apart");
    }
}

proptest! {
    #![proptest_config(config(1, 2000))]

    /// Wherever the timer stands: the middle lies half the length behind the opening.
    #[test]
    fn mid_exposure_across_any_wrap(open in any::<u32>(), length in 0u32..=500_000) {
        let mid = exposure(open, open.wrapping_add(length)).mid();
        prop_assert_eq!(mid.map(|mid| mid.0.wrapping_sub(open)), Some(length / 2));
    }

    /// A crystal off by up to 50 ppm and edges latched in whole ticks: each latch is up to one tick late, so the rate is
    /// off by one tick a second and the instant within a second after the pulse by at most 2 us and its rounding.
    #[test]
    fn the_clock_follows_the_pulses(start in any::<u32>(), ppm in -50.0f64..50.0, boot_s in 1u64..4_000_000,
                                    phase in 0.0f64..1.0, latency_us in 0u32..40_000, after_us in 0u64..1_000_000) {
        // Tick of the instant `us` microseconds after the second `boot_s`.
        let latch = |us: f64| start.wrapping_add((us * (1.0 + 1e-6 * ppm) + phase).floor() as u32);
        let mut clock = Clock::new(CLOCK);
        prop_assert_eq!(instant(&clock, Ticks(start)), None);
        let sent = latch(300_000.0);
        clock.on_timesync(
            Ticks(sent), Micros(boot_s * 1_000_000 + 300_000 + u64::from(latency_us)), Ticks(sent.wrapping_add(latency_us)),
        );
        for pulse in 1..=3 {
            clock.on_pulse(Ticks(latch(f64::from(pulse) * 1e6)));
        }
        let at = instant(&clock, Ticks(latch((3_000_000 + after_us) as f64))).expect("tied");
        let off = at.0 as i64 - ((boot_s + 3) * 1_000_000 + after_us) as i64;
        prop_assert!(off.abs() <= 2, "{off} us off, {after_us} us after the pulse");
    }

    /// A pulse where none belongs costs nothing but time: before, between and after the true ones.
    #[test]
    fn a_glitch_does_not_spoil_the_clock(start in any::<u32>(), glitch_us in 1_001u32..999_000, from in 0u32..4) {
        let mut clock = Clock::new(CLOCK);
        clock.on_timesync(Ticks(start), Micros(7_000_000), Ticks(start));
        for second in 0..5u32 {
            let tick = start.wrapping_add(second * 1_000_000);
            clock.on_pulse(Ticks(tick));
            if second == from {
                clock.on_pulse(Ticks(tick.wrapping_add(glitch_us)));
            }
            for later in [1, 400_000, 999_999u32] {
                let expected = Micros(7_000_000 + u64::from(second * 1_000_000 + later));
                prop_assert_eq!(instant(&clock, Ticks(tick.wrapping_add(later))), Some(expected));
            }
        }
    }
}

/// When the pulses cease the clock runs on, and TIMESYNC keeps it tied beyond the timer's half range.
#[test]
fn a_clock_without_pulses_falls_back_to_timesync() {
    let mut clock = Clock::new(CLOCK);
    let at = |seconds: u64| Ticks((seconds * 1_000_000) as u32);
    clock.on_timesync(at(0), Micros(0), at(0));
    clock.on_pulse(at(1));
    clock.on_pulse(at(2));
    for seconds in (10..4000).step_by(10) {
        clock.on_timesync(at(seconds), Micros(seconds * 1_000_000), at(seconds));
        let found = instant(&clock, at(seconds));
        let off = found.map(|found| found.0.abs_diff(seconds * 1_000_000));
        assert!(off.is_some_and(|off| off < 1000), "{found:?} {} s after the last pulse", seconds - 2);
    }
}

/// An autopilot that boots anew starts its clock anew; TIMESYNC says so, and the pulses get their new seconds.
#[test]
fn a_clock_follows_an_autopilot_that_boots_anew() {
    let mut clock = Clock::new(CLOCK);
    let at = |seconds: u32| Ticks(seconds * 1_000_000);
    clock.on_timesync(at(0), Micros(500_000_000), at(0));
    for seconds in 1..5 {
        clock.on_pulse(at(seconds));
    }
    for seconds in 5..10 {
        clock.on_timesync(at(seconds), Micros(u64::from(seconds - 4) * 1_000_000), at(seconds));
        clock.on_pulse(at(seconds));
    }
    assert_eq!(instant(&clock, at(10)), Some(Micros(6_000_000)));
}

#[test]
fn a_timesync_that_took_too_long_or_ran_backwards_ties_nothing() {
    let mut clock = Clock::new(CLOCK);
    clock.on_timesync(Ticks(0), Micros(5), Ticks(1_000_000));
    clock.on_timesync(Ticks(100), Micros(5), Ticks(99));
    assert_eq!(instant(&clock, Ticks(100)), None);
    // A pulse without a coarse tie cannot be labelled.
    clock.on_pulse(Ticks(0));
    clock.on_pulse(Ticks(1_000_000));
    assert_eq!(instant(&clock, Ticks(1_000_000)), None);
    clock.on_timesync(Ticks(2_000_000), Micros(1_000_000), Ticks(2_000_000));
    assert_eq!(instant(&clock, Ticks(2_000_000)), Some(Micros(1_000_000)));
    assert_eq!(instant(&clock, Ticks(0)), None, "before boot");
}

fn history(stamps: &[u64]) -> History<f32, 4> {
    let mut history = History::new();
    for &stamp in stamps {
        history.push(Micros(stamp), stamp as f32).expect("forwards");
    }
    history
}

#[test]
fn a_history_never_extrapolates() {
    assert!(History::<f32, 4>::new().at(Micros(5), 100).is_err());
    let history = history(&[1000, 1100, 1200, 1300, 1400]);
    // Five samples in a ring of four: the first is forgotten.
    for (at, expected) in [(1000, PoseError::TooOld), (1099, PoseError::TooOld), (1401, PoseError::NotYet)] {
        assert_eq!(history.at(Micros(at), 100).map(|i| i.value), Err(expected), "at {at}");
    }
    for (at, value, u) in [(1100, 1100.0, 0.0), (1125, 1125.0, 0.25), (1399, 1399.0, 0.99), (1400, 1400.0, 0.0)] {
        let found = history.at(Micros(at), 100).expect("inside");
        assert!((found.value - value).abs() < 1e-3 && (found.u - u).abs() < 1e-6, "{found:?} at {at}");
    }
}

#[test]
fn a_history_does_not_bridge_gaps_nor_run_backwards() {
    let mut history = history(&[1000, 1100, 1301]);
    assert_eq!(history.at(Micros(1200), 200).map(|i| i.value), Err(PoseError::Gap));
    assert!(history.at(Micros(1200), 201).is_ok());
    assert!(history.at(Micros(1050), 100).is_ok(), "the gap is elsewhere");
    for stamp in [0, 1300, 1301] {
        assert_eq!(history.push(Micros(stamp), 9.0), Err(Backwards), "stamp {stamp}");
    }
    assert_eq!(history.newest(), Some((Micros(1301), 1301.0)));
    // Samples hours apart are a gap too, whatever the counter's width.
    history.push(Micros(1301 + (1 << 32) + 50), 1.0).expect("forwards");
    assert_eq!(history.at(Micros(1400), 100).map(|i| i.value), Err(PoseError::Gap));
}

proptest! {
    #![proptest_config(config(2, 2000))]

    /// Linear in each angle, the heading the short way round, at ±180° and everywhere else.
    #[test]
    fn headings_go_the_short_way(from in -180.0f64..360.0, turn in -179.0f64..179.0, u_us in 0u64..=5000,
                                 pitch in -60.0f64..60.0, roll in -60.0f64..60.0) {
        let mut history: History<Attitude, 4> = History::new();
        prop_assert!(history.push(Micros(0), attitude([from, 0.0, roll])).is_ok());
        prop_assert!(history.push(Micros(5000), attitude([(from + turn).rem_euclid(360.0), pitch, -roll])).is_ok());
        let found = history.at(Micros(u_us), 5000);
        prop_assert!(found.is_ok());
        let (ours, u) = (found.map(|i| degrees(i.value)).unwrap_or_default(), u_us as f64 / 5000.0);
        let off = miss_attitude(ours, [from + u * turn, u * pitch, roll * (1.0 - 2.0 * u)]);
        prop_assert!(off < 1e-4, "{ours:?}, {off} degrees off");
    }
}
