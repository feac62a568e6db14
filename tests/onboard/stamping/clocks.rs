//! The clock under pulses that are late, wrong, gone and back.

use super::world::SETTINGS;
use plumbline_core::stamp::Clock;
use plumbline_core::units::{Micros, Ticks};
use plumbline_tests::seeded::Random;

/// Tick of an instant in microseconds: 20 ppm fast, started at `start`, an edge `jitter_us` late.
fn latch(start: u32, at_us: f64, jitter_us: f64) -> Ticks {
    Ticks(start.wrapping_add((at_us * (1.0 + 20e-6) + jitter_us).floor() as u64 as u32))
}

/// A clock with pulses in the seconds from 1 to `pulses`.
fn disciplined(start: u32, pulses: u32, random: &mut Random) -> Clock {
    let mut clock = Clock::new(SETTINGS.clock);
    let sent = latch(start, 0.0, 0.0);
    clock.on_timesync(sent, Micros(700), Ticks(sent.0.wrapping_add(1400)));
    for second in 1..=pulses {
        clock.on_pulse(latch(start, f64::from(second) * 1e6, 0.5 * random.normal()));
    }
    clock
}

/// Error at an instant, and its sigma, microseconds.
fn off(clock: &Clock, start: u32, at_us: f64) -> (f64, f64) {
    let (found, sigma) = clock.instant(latch(start, at_us, 0.5)).expect("tied");
    (found.0 as f64 - at_us, sigma.into())
}

#[test]
fn the_rate_and_its_sigma_are_found() {
    for seed in 0..50 {
        let mut random = Random::new(seed);
        let start = (random.uniform() * f64::from(u32::MAX)) as u32;
        let clock = disciplined(start, 60, &mut random);
        let state = clock.state(latch(start, 60.2e6, 0.0));
        let off = f64::from(state.rate_ppm) + 20.0;
        assert!(off.abs() < 5.0 * f64::from(state.rate_sigma_ppm), "{state:?}");
        assert!(state.rate_sigma_ppm < 0.2 && state.by_pulses && state.free_wheeling_s == 0, "{state:?}");
    }
}

/// A pulse where none belongs changes nothing: the clock says what it said, to the bit.
#[test]
fn a_glitch_is_ignored_and_counted() {
    let mut random = Random::new(3);
    let mut clock = disciplined(5, 20, &mut random);
    for (count, late_us) in [20e3, 400e3, 300.0, -50.0, 8.0].into_iter().enumerate() {
        let second = 21.0 + count as f64;
        let before = clock.instant(latch(5, second * 1e6 + 7e5, 0.0));
        clock.on_pulse(latch(5, second * 1e6 + late_us, 0.0));
        assert_eq!(clock.counted().0, count as u32 + 1, "{late_us} us late");
        assert_eq!(clock.instant(latch(5, second * 1e6 + 7e5, 0.0)), before, "{late_us} us late");
        clock.on_pulse(latch(5, second * 1e6, 0.0));
    }
    assert_eq!(clock.counted(), (5, 1));
}

/// The autopilot steps its seconds by 3 ms: three pulses are taken for glitches, the fourth ties the clock anew.
#[test]
fn pulses_that_go_on_disagreeing_are_right() {
    let mut random = Random::new(4);
    let mut clock = disciplined(9, 20, &mut random);
    for second in 21..=24 {
        let (error, _) = off(&clock, 9, f64::from(second) * 1e6);
        assert!(error.abs() < 5.0, "{error} us before the tie");
        assert_eq!(clock.counted().1, 1);
        clock.on_pulse(latch(9, f64::from(second) * 1e6 + 3000.0, 0.0));
    }
    assert_eq!(clock.counted(), (4, 2));
    let (error, _) = off(&clock, 9, 24.5e6);
    assert!((error + 3000.0).abs() < 5.0, "{error}");
}

/// Pulses stop for a minute: sigma grows, the rate stays, and when they return the clock moves by no more than it said.
#[test]
fn the_clock_runs_free_and_does_not_jump() {
    for seed in 0..20 {
        let mut random = Random::new(seed);
        let start = 0u32.wrapping_sub((random.uniform() * 100e6) as u32);
        let mut clock = disciplined(start, 40, &mut random);
        let (mut before, rate) = (0.0, clock.state(latch(start, 40e6, 0.0)).rate_ppm);
        for second in 41..100 {
            let at_us = f64::from(second) * 1e6 + 0.4e6;
            // What TIMESYNC says is 700 us wrong, as on a link with unequal ways; it knows less than the clock.
            let sent = latch(start, at_us, 0.0);
            let theirs = Micros((at_us + 1400.0 + 700.0) as u64);
            clock.on_timesync(sent, theirs, Ticks(sent.0.wrapping_add(2800)));
            let (error, sigma) = off(&clock, start, at_us);
            assert!(sigma > before && sigma < 100.0, "{sigma} after {before}");
            assert!(error.abs() < 5.0 * sigma, "{error} us off, sigma {sigma}");
            before = sigma;
            let state = clock.state(sent);
            assert_eq!((state.rate_ppm, state.free_wheeling_s, state.by_pulses), (rate, second - 40, true));
        }
        let soon = latch(start, 100e6 + 1.0, 0.5);
        let (then, sigma) = clock.instant(soon).expect("tied");
        clock.on_pulse(latch(start, 100e6, 0.0));
        let (now, after) = clock.instant(soon).expect("tied");
        assert!(f64::from(now.since(then).abs()) < 5.0 * f64::from(sigma), "a jump from {then:?} to {now:?}");
        assert!(after < 1.5 && clock.counted() == (0, 1), "{after}");
    }
}

/// Pulses of a receiver whose seconds are not the autopilot's, or the wrong edge of a pulse: no sigma holds them, so there is
/// none, until the two agree again or the pulses are gone and TIMESYNC serves alone.
#[test]
fn pulses_off_the_autopilots_seconds_are_not_believed() {
    for late_us in [3e3, 100e3, -100e3, 400e3] {
        let mut clock = Clock::new(SETTINGS.clock);
        let exchange = |clock: &mut Clock, at_us: f64| {
            clock.on_timesync(latch(7, at_us, 0.0), Micros(at_us as u64 + 2000), latch(7, at_us + 4000.0, 0.0));
        };
        for second in 1..10 {
            let at_us = f64::from(second) * 1e6;
            clock.on_pulse(latch(7, at_us + late_us, 0.0));
            exchange(&mut clock, at_us + 0.45e6);
            let (error, sigma) = off(&clock, 7, at_us + 0.48e6);
            assert!(error.abs() < 5.0 * sigma, "{late_us} us late: {error} us off, sigma {sigma} in second {second}");
        }
        assert_eq!(off(&clock, 7, 9.5e6).1, f64::INFINITY, "{late_us}");
        let mut gone = clock;
        for second in 10..22 {
            exchange(&mut gone, f64::from(second) * 1e6);
        }
        let (error, sigma) = off(&gone, 7, 21.1e6);
        assert!(error.abs() < 200.0 && sigma < 2000.0, "{late_us} us late, gone: {error} us off, sigma {sigma}");
    }
    // The line is mended in flight: once enough pulses agree with each other, an exchange agrees with them.
    let mut clock = Clock::new(SETTINGS.clock);
    for second in 1..20 {
        let at_us = f64::from(second) * 1e6;
        clock.on_pulse(latch(7, at_us + if second < 10 { 50e3 } else { 0.0 }, 0.0));
        clock.on_timesync(latch(7, at_us + 0.4e6, 0.0), Micros(at_us as u64 + 402_000), latch(7, at_us + 0.404e6, 0.0));
    }
    let (error, sigma) = off(&clock, 7, 19.5e6);
    assert!(error.abs() < 5.0 * sigma && sigma < 5.0, "{error} us off, sigma {sigma}");
}

/// No pulses ever: half a round trip is all that is sure, and slow exchanges do not spoil quick ones.
#[test]
fn timesync_alone_is_as_good_as_its_quickest_exchanges() {
    let mut random = Random::new(8);
    let mut clock = Clock::new(SETTINGS.clock);
    let (mut worst, mut squares) = (0.0f64, 0.0);
    for second in 0..600 {
        let at_us = f64::from(second) * 1e6;
        let slow = if second % 3 == 0 { 0.0 } else { 60e3 * random.uniform() };
        let there = 1500.0 + slow;
        clock.on_timesync(
            latch(77, at_us, 0.0),
            Micros((at_us + there) as u64),
            latch(77, at_us + there + 1500.0, 0.0),
        );
        let (error, sigma) = off(&clock, 77, at_us + 0.5e6);
        if second > 60 {
            worst = worst.max((error / sigma).abs());
            squares += error * error / 540.0;
        }
        assert!(sigma < 1200.0 && !clock.state(latch(77, at_us, 0.0)).by_pulses);
    }
    println!("TIMESYNC alone: RMS {} us", squares.sqrt());
    assert!(worst < 3.0, "{worst} sigmas");
    assert!(squares.sqrt() < 100.0, "{} us", squares.sqrt());
}

/// Where every exchange takes all of its time one way, none of them says so: sigma has to, however many there are.
#[test]
fn timesync_knows_that_its_ways_may_be_unequal() {
    for (there, back) in [(3000.0, 0.0), (0.0, 3000.0)] {
        let mut clock = Clock::new(SETTINGS.clock);
        for second in 0..300 {
            let at_us = f64::from(second) * 1e6;
            clock.on_timesync(
                latch(3, at_us, 0.0),
                Micros((at_us + there) as u64),
                latch(3, at_us + there + back, 0.0),
            );
        }
        let (error, sigma) = off(&clock, 3, 299.5e6);
        assert!((error.abs() - 1500.0).abs() < 20.0, "{error}");
        assert!((1.5..2.0).contains(&(error / sigma).abs()), "{error} us, sigma {sigma}");
    }
}

#[test]
fn ticks_far_from_any_tie_do_not_panic() {
    let mut random = Random::new(9);
    for _ in 0..2000 {
        let mut word = || (random.uniform() * 4_294_967_296.0) as u32;
        let mut clock = Clock::new(SETTINGS.clock);
        for _ in 0..20 {
            let (a, b, c) = (word(), word(), word());
            match a % 4 {
                0 => clock.on_timesync(Ticks(b), Micros(u64::from(c) << (a >> 27)), Ticks(b.wrapping_add(c >> 13))),
                1 => clock.on_pulse(Ticks(b)),
                2 => clock.keep(Ticks(b)),
                _ => assert!(clock.instant(Ticks(b)).is_none_or(|(_, sigma)| sigma >= 0.0)),
            }
        }
    }
}
