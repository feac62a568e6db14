//! Bad lines: each request is done once all the same, or the gap is counted.

use super::{Flown, flown, in_process, open, quick, setup, small, socket};
use plumbline_core::pipeline::Refusal;
use plumbline_sim::fault::line::{FaultyLine, LineFaultCounts, LineFaults};
use plumbline_sim::link::device::Device;
use plumbline_sim::scenario::Scenario;
use plumbline_sim::setup::Setup;
use std::time::Duration;

/// Every kind that leaves line and board in place.
fn bad(percent: f64) -> LineFaults {
    LineFaults {
        lost: percent,
        doubled: percent,
        reordered: percent,
        corrupted: percent,
        stalled: percent,
        stall: Duration::from_millis(20),
        absence: Duration::from_millis(30),
        ..LineFaults::default()
    }
}

fn fly(setup: &Setup, faults: LineFaults, seed: u64) -> (Flown, LineFaultCounts) {
    let device = Device::socket(&socket("board")).expect("a socket");
    let line = FaultyLine::new(&socket("line"), device.path(), faults, seed, device.reset_button()).expect("a proxy");
    let flown = flown(setup, &mut open(setup, line.path(), quick()));
    let counts = line.counts();
    println!("seed {seed}: {counts:?}; {}", flown.account.trouble.expect("it is counted"));
    (flown, counts)
}

/// One message in a hundred is hit by each kind of fault.
#[test]
#[ignore = "long: a thousand frames; everyday runs fly forty over a line that is cut as well"]
fn a_bad_line_changes_no_fix_of_a_thousand() {
    let frames = 1000;
    let setup = setup(small(5, frames));
    let expected = in_process(&setup);
    let (flown, counts) = fly(&setup, bad(1.0), 6);
    assert!(flown.csv == expected.csv, "{}\n{}", flown.csv, expected.csv);
    assert_eq!(flown.flight.health, expected.flight.health);
    assert!(flown.accepted() * 10 >= frames as usize * 9, "{} accepted", flown.accepted());
    flown.has_no_wrong_fix(setup.scenario.vehicle.resolution_m);
    let trouble = flown.account.trouble.expect("it is counted");
    assert_eq!((trouble.reboots, trouble.frames_abandoned), (0, 0));
    // Each kind has struck, and what the line did shows in what the link counted.
    let each = [counts.lost, counts.doubled, counts.reordered, counts.corrupted, counts.stalled];
    let least = counts.messages / 200;
    assert!(each.iter().all(|&count| count >= least), "{counts:?}");
    assert!(trouble.timeouts >= counts.lost && trouble.resends >= counts.lost, "{trouble} of {counts:?}");
    assert!(trouble.bad_checksum > 0 && trouble.stale > 0, "{trouble}");
}

/// The session outlives the line: a request that was under way is sent again, and done once.
#[test]
fn a_line_that_is_unplugged_and_plugged_in_changes_no_fix() {
    let setup = setup(small(7, 40));
    let expected = in_process(&setup);
    let (flown, counts) = fly(&setup, LineFaults { cut: 0.5, ..bad(0.2) }, 8);
    assert!(counts.cut >= 3, "{counts:?}");
    assert!(flown.csv == expected.csv, "{}\n{}", flown.csv, expected.csv);
    let trouble = flown.account.trouble.expect("it is counted");
    assert!(trouble.reconnects >= 3 && trouble.reboots == 0, "{trouble}");
}

/// The power fails in mid-flight, the line with it: frames around it are refused or lost and counted, the others have
/// the fixes that they should have, within what the firmware itself says of them.
#[test]
fn a_board_that_reboots_leaves_a_gap_that_is_counted() {
    let setup = with_pulses(small(9, 60));
    rebooted(&setup, &in_process(&setup), 10);
}

/// At other moments.
#[test]
#[ignore = "long: boards that reboot again and again"]
fn boards_that_reboot_leave_gaps_that_are_counted() {
    let setup = with_pulses(small(9, 120));
    let expected = in_process(&setup);
    for seed in 20..28 {
        rebooted(&setup, &expected, seed);
    }
}

/// With pulses: by TIMESYNC alone every boot has a clock of its own.
fn with_pulses(mut scenario: Scenario) -> Setup {
    scenario.world.timer.pps = true;
    setup(scenario)
}

fn rebooted(setup: &Setup, expected: &Flown, seed: u64) {
    let (flown, counts) = fly(setup, LineFaults { rebooted: 0.15, cut: 0.05, ..bad(0.3) }, seed);
    let trouble = flown.account.trouble.expect("it is counted");
    assert!(counts.rebooted >= 1 && trouble.reboots >= 1 && trouble.reboots <= counts.rebooted, "{trouble} {counts:?}");
    flown.has_no_wrong_fix(setup.scenario.vehicle.resolution_m);
    let (mut equal, mut gap, mut lost, mut most) = (0, 0, Vec::new(), 0.0f64);
    for (ours, theirs) in flown.flight.frames.iter().zip(&expected.flight.frames) {
        let frame = ours.exposure.frame;
        // In a flight's first seconds the board that has booted anew says itself that a frame was lost.
        let report = ours.report.as_ref().filter(|report| report.reason() != Some(Refusal::Busy));
        let Some(report) = report else {
            lost.push((frame, ours.report.as_ref().and_then(|report| report.reason())));
            continue;
        };
        let (Some(fix), Some(other)) = (report.fix, theirs.report.and_then(|report| report.fix)) else {
            gap += u64::from(report.fix.is_none());
            assert!(report.fix.is_some() || report.reason().is_some(), "frame {frame}: neither fix nor reason");
            continue;
        };
        // Tied to other pulses the stamps differ by microseconds; both fixes are of the same place. Sigmas of a fix are
        // those of one axis, and most of what they say both fixes share.
        let apart_m = f64::from(fix.east_m - other.east_m).hypot(f64::from(fix.north_m - other.north_m));
        let variance_m2 =
            fix.variance_east_m2 + fix.variance_north_m2 + other.variance_east_m2 + other.variance_north_m2;
        let sigma_m = f64::from(variance_m2).sqrt();
        assert!(apart_m <= sigma_m, "frame {frame}: {apart_m} m apart, sigma {sigma_m} m");
        most = most.max(apart_m / sigma_m);
        equal += u64::from(fix == other);
    }
    println!("{equal} fixes equal bit by bit, the others {most:.3} sigma apart at most; {gap} refused, {lost:?} lost");
    // What was lost is what the link counted.
    assert_eq!(lost.len() as u64, trouble.frames_abandoned, "{lost:?}, {trouble}");
    assert!(equal > 0 && flown.accepted() * 6 >= flown.scored.len(), "{} accepted", flown.accepted());
}
