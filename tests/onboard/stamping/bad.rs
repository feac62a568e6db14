//! What is refused, by name.

use super::world::SETTINGS;
use plumbline_core::pipeline::Refusal;
use plumbline_core::stamp::{
    ClockSettings, Edge, EdgeError, ExposureLimits, KnownExposure, Polarity, SettingsError, ShutterSettings,
    StampError, StampSettings, Stamper, Wired,
};
use plumbline_core::units::{Micros, Ticks};

/// No delays, the rising edge opens, the exposure known or not; the clock tied by an exchange and two pulses at ticks of a
/// million and two.
fn stamper(exposure: Option<KnownExposure>) -> Stamper {
    let mut stamper = untied(exposure);
    stamper.clock.on_timesync(Ticks(500_000), Micros(500_000), Ticks(500_000));
    stamper.clock.on_pulse(Ticks(1_000_000));
    stamper.clock.on_pulse(Ticks(2_000_000));
    stamper
}

const KNOWN: Option<KnownExposure> = Some(KnownExposure { us: 5000, sigma_us: 20.0 });

fn untied(exposure: Option<KnownExposure>) -> Stamper {
    Stamper::new(&settings(exposure))
}

fn settings(exposure: Option<KnownExposure>) -> StampSettings {
    let shutter = ShutterSettings {
        opens_on: Polarity::Rising,
        open_delay_us: 0,
        close_delay_us: 0,
        exposure,
        ..SETTINGS.shutter
    };
    StampSettings { shutter, ..SETTINGS }
}

fn edge(at: u32, rising: bool) -> Edge {
    Edge { at: Ticks(at), polarity: if rising { Polarity::Rising } else { Polarity::Falling } }
}

/// Edges at ticks, rising where positive, then the frame's arrival; `None` where it is stamped.
fn refused(stamper: &mut Stamper, edges: &[i64], arrival: u32) -> Option<StampError> {
    for &at in edges {
        let _ = stamper.on_edge(edge(at.unsigned_abs() as u32, at > 0));
    }
    stamper.frame(Ticks(arrival)).err()
}

#[test]
fn frames_without_a_good_stamp_are_refused_by_name() {
    let pair: [i64; 2] = [2_100_000, -2_105_000];
    assert_eq!(refused(&mut stamper(KNOWN), &pair, 2_105_800), None);
    assert_eq!(refused(&mut stamper(None), &pair, 2_105_800), None);
    assert_eq!(refused(&mut untied(KNOWN), &pair, 2_105_800), Some(StampError::NoClock));
    // Another exposure than is known, whatever edge is where it should be.
    let long: [i64; 2] = [2_100_000, -2_107_000];
    assert_eq!(refused(&mut stamper(KNOWN), &long, 2_107_800), Some(StampError::Contradiction));
    assert_eq!(refused(&mut stamper(KNOWN), &long[..1], 2_105_800), None, "the opening one stands for both");
    assert_eq!(refused(&mut stamper(KNOWN), &[2_100_000, -2_103_000], 2_105_800), Some(StampError::Contradiction));
    assert_eq!(refused(&mut stamper(None), &long, 2_107_800), None);
    // A latency that is not what it was: the pair is good, but not the frame's.
    assert_eq!(refused(&mut stamper(KNOWN), &pair, 2_125_800), Some(StampError::Contradiction));
    // Exposures of unknown length.
    assert_eq!(refused(&mut stamper(None), &[2_100_000, -2_600_001], 2_600_801), Some(StampError::BadExposure));
    assert_eq!(refused(&mut stamper(None), &pair[1..], 2_105_800), Some(StampError::NoExposure));
    assert_eq!(refused(&mut stamper(None), &pair[..1], 2_105_800), Some(StampError::NoExposure));
    assert_eq!(refused(&mut stamper(None), &[], 2_105_800), Some(StampError::NoExposure));
    let twice: [i64; 3] = [2_100_000, 2_102_000, -2_105_000];
    assert_eq!(refused(&mut stamper(None), &twice, 2_105_800), Some(StampError::Contradiction));
    assert_eq!(refused(&mut stamper(KNOWN), &twice, 2_105_800), None, "the known length decides");
    // Closed before it opened: with one edge where it should be, and with none.
    assert_eq!(refused(&mut stamper(None), &[-2_105_000, 2_105_500], 2_105_800), Some(StampError::NoExposure));
}

#[test]
fn frames_that_run_backwards_or_come_twice_are_refused() {
    let mut stamper = stamper(KNOWN);
    assert_eq!(refused(&mut stamper, &[2_100_000, -2_105_000], 2_105_800), None);
    for arrival in [2_105_800, 2_105_799, 1_000_000] {
        assert_eq!(stamper.frame(Ticks(arrival)).err(), Some(StampError::Backwards), "{arrival}");
    }
    assert_eq!(refused(&mut stamper, &[2_350_000, -2_355_000], 2_355_800), None);
}

#[test]
fn a_clock_that_has_run_free_for_too_long_is_refused() {
    let mut stamper = stamper(KNOWN);
    let mut tick = 2_000_000u32;
    // An hour without pulses and TIMESYNC, and a wrap of the timer in it.
    for _ in 0..3600 * 4 {
        tick = tick.wrapping_add(1_000_000);
        stamper.keep(Ticks(tick));
    }
    let at = stamper.clock.instant(Ticks(tick)).expect("tied");
    assert_eq!(at.0, Micros(14_402_000_000), "{at:?}");
    let edges = [tick.wrapping_add(100), tick.wrapping_add(5100)];
    assert_eq!(stamper.on_edge(edge(edges[0], true)), Ok(()));
    assert_eq!(stamper.on_edge(edge(edges[1], false)), Ok(()));
    assert_eq!(stamper.frame(Ticks(tick.wrapping_add(5900))).err(), Some(StampError::UncertainClock));
}

#[test]
fn edges_that_run_backwards_or_come_twice_are_refused() {
    let mut stamper = stamper(KNOWN);
    assert_eq!(stamper.on_edge(edge(2_100_000, true)), Ok(()));
    assert_eq!(stamper.on_edge(edge(2_100_000, true)), Err(EdgeError::Repeated));
    assert_eq!(stamper.on_edge(edge(2_099_999, false)), Err(EdgeError::Backwards));
    assert_eq!(stamper.on_edge(edge(2_100_030, true)), Err(EdgeError::Bounce));
    assert_eq!(stamper.on_edge(edge(2_105_000, false)), Ok(()));
    assert_eq!(stamper.frame(Ticks(2_105_800)).map(|stamp| stamp.mid), Ok(Micros(2_102_500)));
    let counters = stamper.counters();
    assert_eq!((counters.edges_bad, counters.edges_bounced, counters.edges_missing), (2, 1, 0));
}

#[test]
fn every_error_is_a_refusal_of_its_own() {
    let errors = [
        (StampError::NoClock, 1),
        (StampError::BadExposure, 2),
        (StampError::Contradiction, 21),
        (StampError::NoExposure, 22),
        (StampError::UncertainClock, 23),
        (StampError::Backwards, 24),
    ];
    for (error, code) in errors {
        let refusal = Refusal::from(error);
        assert_eq!((refusal.code(), Refusal::from_code(code)), (code, Some(refusal)));
    }
}

#[test]
fn settings_that_cannot_be_are_refused_by_name() {
    let shutter = |change: fn(&mut ShutterSettings)| {
        let mut settings = SETTINGS;
        change(&mut settings.shutter);
        settings.check()
    };
    let clock = |change: fn(&mut ClockSettings)| {
        let mut settings = SETTINGS;
        change(&mut settings.clock);
        settings.check()
    };
    assert_eq!(SETTINGS.check(), Ok(()));
    assert_eq!(shutter(|s| s.edge_sigma_us = f32::NAN), Err(SettingsError::Sigma));
    assert_eq!(shutter(|s| s.arrival_sigma_us = -1.0), Err(SettingsError::Sigma));
    assert_eq!(shutter(|s| s.open_delay_us = i32::MIN), Err(SettingsError::Delay));
    assert_eq!(shutter(|s| s.readout_us = u32::MAX), Err(SettingsError::Delay));
    assert_eq!(shutter(|s| s.exposure = Some(KnownExposure { us: 0, sigma_us: 0.0 })), Err(SettingsError::Exposure));
    assert_eq!(shutter(|s| s.hold_off_us = 5000), Err(SettingsError::HoldOff));
    assert_eq!(shutter(|s| s.open_delay_us = 5000), Err(SettingsError::HoldOff));
    for wired in [Wired::Opening, Wired::Closing, Wired::None] {
        let mut settings = SETTINGS;
        (settings.shutter.wired, settings.shutter.exposure) = (wired, None);
        assert_eq!(settings.check(), Err(SettingsError::NoExposure), "{wired:?}");
    }
    assert_eq!(shutter(|s| s.exposure = None), Ok(()));
    // Where the exposure is controlled, stamps must be able to go by any that may come.
    let controlled = |known: Option<u32>, (least_us, longest_us)| {
        let mut settings = SETTINGS;
        settings.shutter.exposure = known.map(|us| KnownExposure { us, sigma_us: 1.0 });
        settings.exposure = Some(ExposureLimits { least_us, longest_us });
        settings.check()
    };
    assert_eq!(controlled(Some(5000), (500, 8000)), Ok(()));
    assert_eq!(controlled(None, (500, 8000)), Err(SettingsError::NoExposure));
    assert_eq!(controlled(Some(5000), (500, 4000)), Err(SettingsError::Exposure));
    assert_eq!(controlled(Some(5000), (8000, 500)), Err(SettingsError::Exposure));
    assert_eq!(controlled(Some(5000), (500, u32::MAX)), Err(SettingsError::Exposure));
    assert_eq!(controlled(Some(5000), (50, 8000)), Err(SettingsError::HoldOff));
    assert_eq!(clock(|c| c.pulse_sigma_us = f32::INFINITY), Err(SettingsError::Sigma));
    assert_eq!(clock(|c| c.sigma_max_us = 0.0), Err(SettingsError::Sigma));
    assert_eq!(clock(|c| c.rate_sigma_ppm = 0.0), Err(SettingsError::Rate));
    assert_eq!(clock(|c| c.rate_walk_ppm = f32::NAN), Err(SettingsError::Rate));
}
