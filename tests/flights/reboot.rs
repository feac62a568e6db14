//! The application when the autopilot boots anew in flight: its clock begins at zero again.

use mavlink::dialects::common::{ATTITUDE_QUATERNION_DATA, TIMESYNC_DATA};
use mavlink::{MAVLinkV2MessageRaw, MavHeader, MessageData};
use plumbline_firmware::wire::command::{Command, SET_MESSAGE_INTERVAL};
use plumbline_sim::ground_station::GroundStation;
use plumbline_sim::link::inproc::InProcess;
use plumbline_sim::link::{Event, Link};
use plumbline_sim::scenario::Scenario;
use plumbline_sim::setup::Setup;
use plumbline_sim::vehicle::autopilot::Autopilot;
use plumbline_sim::vehicle::sensors::{Reading, Sample};

/// An attitude that only its stamp tells from the others.
fn attitude(at_us: u64) -> Sample {
    let reading =
        Reading::Attitude { heading_true_rad: 0.1, pitch_rad: 0.0, roll_rad: 0.0, velocity_ned_m_s: [0.0; 3] };
    Sample { sampled_at_us: at_us, arrived_at_us: at_us, reading }
}

/// A message of the autopilot.
pub fn message(data: &impl MessageData) -> Vec<u8> {
    let mut raw = MAVLinkV2MessageRaw::new();
    raw.serialize_message_data(MavHeader { system_id: 1, component_id: 1, sequence: 0 }, data);
    raw.raw_bytes().to_vec()
}

/// An autopilot that sends attitudes stamped in microseconds.
pub fn autopilot_with_attitude() -> Autopilot {
    let mut autopilot = Autopilot::new(1_000, 0);
    let asked = Command { command: SET_MESSAGE_INTERVAL, parameters: [286.0, 5_000.0], target: (1, 1) };
    autopilot.commanded(&asked, 0);
    autopilot
}

/// Servo commands in the second after an autopilot that had been up for a hundred boots anew, and sends fine or coarse
/// attitudes then.
fn servo_commands_after(is_coarse: bool) -> usize {
    let scenario = Scenario::of_frames(1);
    let setup = Setup::prepare(scenario).expect("it can be flown");
    let mut link = InProcess::new(&setup.flash).expect("it boots");
    let (mut station, mut tick) = (GroundStation::default(), 0);
    for (boot_us, is_coarse) in [(100_000_000, false), (1_000_000, is_coarse)] {
        station.servo.clear();
        let mut autopilot = autopilot_with_attitude();
        for sample in 0..200 {
            let at_us = boot_us + 5_000 * sample;
            let fine = autopilot.messages(&attitude(at_us), &setup.crs).expect("a message").concat();
            let coarse =
                ATTITUDE_QUATERNION_DATA { time_boot_ms: (at_us / 1000) as u32, q1: 1.0, ..Default::default() };
            let bytes = if is_coarse { message(&coarse) } else { fine };
            tick += 5_000;
            station.take(&link.step(tick, Event::Bytes(&bytes)).expect("it runs"));
            for ts1 in std::mem::take(&mut station.timesync) {
                let answer = TIMESYNC_DATA { tc1: at_us as i64 * 1000, ts1 };
                link.step(tick, Event::Bytes(&message(&answer))).expect("it runs");
            }
        }
    }
    station.servo.len()
}

#[test]
fn the_servo_is_commanded_on() {
    // 50 a second, less those of the attitudes that had to show first that the clock began anew.
    for is_coarse in [false, true] {
        let commands = servo_commands_after(is_coarse);
        assert!((35..=50).contains(&commands), "coarse {is_coarse}: {commands}");
    }
}
