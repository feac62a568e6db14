//! Stamps of the core: table I of paper 000, and what a timer and its pulses do in the field.

use plumbline_core::stamp::{Clock, ClockSettings, EXPOSURE_MAX_US, Exposure};
use plumbline_core::units::{Micros, Ticks};
use plumbline_tests::mutants;
use plumbline_tests::seeded::config;
use plumbline_tests::vectors::{number, rows, tick};
use proptest::prelude::{any, prop_assert, prop_assert_eq, proptest};

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

/// The autopilot's clock makes a step of 20 ms, as that of a simulator does which is short of processor. By TIMESYNC alone, whose
/// answers wait up to 5 ms on the way there, the clock follows within three exchanges, though it was known to a fraction of a
/// millisecond.
#[test]
fn a_clock_by_timesync_follows_a_step() {
    let mut clock = Clock::new(CLOCK);
    let mut exchange = |seconds: u32, step_us: u64| {
        let sent = u64::from(seconds) * 1_000_000;
        let wait_us = [0, 3_700, 1_200, 4_900, 2_400][seconds as usize % 5];
        let (answered, received) = (sent + 500 + wait_us, sent + 1_000 + wait_us);
        clock.on_timesync(Ticks(sent as u32), Micros(answered + step_us), Ticks(received as u32));
        let (found, sigma_us) = clock.instant(Ticks(received as u32)).expect("it is tied");
        (found.since(Micros(received + step_us)), sigma_us)
    };
    for seconds in 1..100 {
        let (off_us, sigma_us) = exchange(seconds, 0);
        let is_good = (off_us as f32).abs() < 3.0 * sigma_us && sigma_us < 500.0;
        assert!(seconds < 5 || is_good, "{off_us} us, sigma {sigma_us}, at {seconds} s");
    }
    for seconds in 100..160 {
        let (off_us, _) = exchange(seconds, 20_000);
        assert!(seconds < 102 || off_us.abs() < 2_500, "{off_us} us at {seconds} s");
        assert!(seconds < 140 || off_us.abs() < 500, "{off_us} us at {seconds} s");
    }
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
