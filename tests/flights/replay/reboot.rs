//! The autopilot boots anew in flight, its clock begins at zero, and the log has that too.

use super::flown::{replayed, scenario};
use crate::reboot::{autopilot_with_attitude, message};
use mavlink::dialects::common::TIMESYNC_DATA;
use plumbline_sim::ground_station::GroundStation;
use plumbline_sim::link::inproc::InProcess;
use plumbline_sim::link::{Event, FrameEvent, Link};
use plumbline_sim::setup::Setup;
use plumbline_sim::vehicle::sensors::{Reading, Sample};

#[test]
fn a_reboot_of_the_autopilot_replays() {
    let setup = Setup::prepare(scenario(31, 1)).expect("it can be flown");
    let mut link = InProcess::logged(&setup.flash).expect("it boots");
    let (mut station, mut tick) = (GroundStation::default(), 0u32);
    let pixels = vec![90; 128 * 128];
    for boot_us in [100_000_000u64, 1_000_000] {
        let mut autopilot = autopilot_with_attitude();
        for sample in 0..600u64 {
            let at_us = boot_us + 5_000 * sample;
            tick += 5_000;
            let reading = match sample % 3 {
                0 => Reading::Range { slant_m: Some(120.0) },
                _ => Reading::Attitude {
                    heading_true_rad: 0.1,
                    pitch_rad: 0.01,
                    roll_rad: 0.0,
                    velocity_ned_m_s: [0.0; 3],
                },
            };
            let taken = Sample { sampled_at_us: at_us, arrived_at_us: at_us, reading };
            let bytes = autopilot.messages(&taken, &setup.crs).expect("messages").concat();
            station.take(&link.step(tick, Event::Bytes(&bytes)).expect("it runs"));
            for ts1 in std::mem::take(&mut station.timesync) {
                let answer = TIMESYNC_DATA { tc1: at_us as i64 * 1000, ts1 };
                link.step(tick, Event::Bytes(&message(&answer))).expect("it runs");
            }
            if sample % 50 == 49 {
                let sequence = (tick / 250_000) - 1;
                link.step(tick, Event::Edge { tick: tick - 3000, rising: true }).expect("it runs");
                link.step(tick, Event::Edge { tick: tick - 1000, rising: false }).expect("it runs");
                let frame = FrameEvent { sequence, arrival: tick - 950, size: (128, 128), pixels: &pixels };
                link.step(tick, Event::Frame(frame)).expect("it runs");
            }
        }
    }
    let (_, replayed) = replayed(&link.close_log());
    assert_eq!(replayed.first_difference, None);
    assert_eq!(replayed.replayed, replayed.records);
    // All had stamps on either clock, though a grey field without a position gives no fix.
    let stamped = |from_us: u64| replayed.reports.iter().filter(|r| r.mid_exposure_us / 50_000_000 == from_us).count();
    assert!(stamped(2) > 5 && stamped(0) > 5, "{:?}", replayed.reports);
}
