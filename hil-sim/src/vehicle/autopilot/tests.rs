use super::{Autopilot, UNASKED_US};
use crate::scenario::FaultList;
use crate::vehicle::sensors::{Reading, Sample};
use mavlink::dialects::common::{DISTANCE_SENSOR_DATA, GLOBAL_POSITION_INT_DATA};
use mavlink::{MavlinkVersion, MessageData};
use plumbline_firmware::wire::command::{Command, SET_MESSAGE_INTERVAL};
use plumbline_survey::crs::Crs;

fn failing(word: &str) -> Autopilot {
    let faults: FaultList = [word.parse().expect(word)].into_iter().collect();
    Autopilot::new(300, 1).failing(faults, 1)
}

/// What TIMESYNC tells for a request sent at `at_us`, microseconds, and when the answer arrives.
fn answer(autopilot: &mut Autopilot, at_us: u64) -> (i64, u64) {
    assert!(autopilot.is_awake(at_us));
    let (arrives_us, bytes) = autopilot.timesync_answer(77, at_us);
    let told_ns = i64::from_le_bytes(bytes[10..18].try_into().expect("eight bytes"));
    (told_ns / 1000, arrives_us)
}

/// An exchange at 1, 5 and 9 s, of which the fault has the middle one: what it tells and when it arrives beside the good one.
fn off(word: &str) -> [(i64, i64); 3] {
    let (mut good, mut bad) = (Autopilot::new(300, 1), failing(&format!("{word}@4..6")));
    [1_000_000, 5_000_000, 9_000_000].map(|at_us| {
        let (good, bad) = (answer(&mut good, at_us), answer(&mut bad, at_us));
        (bad.0 - good.0, bad.1 as i64 - good.1 as i64)
    })
}

#[test]
fn timesync_tells_another_time() {
    assert_eq!(off("clock.offset=-250"), [(0, 0), (-250_000, 0), (0, 0)]);
    assert_eq!(off("clock.asymmetry=20"), [(0, 0), (0, 20_000), (0, 0)]);
    let [before, (told, late), after] = off("clock.jitter=20");
    assert_eq!((before, told, after), ((0, 0), 0, (0, 0)));
    assert!((1..20_000).contains(&late), "{late}");
}

/// Its clock begins at 0, and what was asked for is forgotten.
#[test]
fn an_autopilot_boots_at_the_end_of_its_silence() {
    let crs = Crs::from_epsg(32633).expect("known");
    let mut autopilot = failing("clock.reboot@4..6");
    let asked = Command {
        command: SET_MESSAGE_INTERVAL,
        parameters: [DISTANCE_SENSOR_DATA::ID as f32, 50_000.0],
        ..Command::default()
    };
    autopilot.commanded(&asked, 0);
    // Twenty samples a second.
    let mut stamps_ms = |from_s: u64| -> Vec<u32> {
        let samples = (from_s * 20..(from_s + 2) * 20).map(|index| Sample {
            sampled_at_us: index * 50_000,
            arrived_at_us: index * 50_000 + 10_000,
            reading: Reading::Range { slant_m: Some(100.0) },
        });
        let mut messages = Vec::new();
        for sample in samples {
            if autopilot.is_awake(sample.arrived_at_us) {
                messages.extend(autopilot.messages(&sample, &crs).expect("sent"));
            }
        }
        messages.iter().map(|bytes| u32::from_le_bytes(bytes[10..14].try_into().expect("four bytes"))).collect()
    };
    let before = stamps_ms(2);
    assert_eq!((before.len(), before[0]), (40, 2000));
    assert!(stamps_ms(4).len() < 2, "silent");
    let after = stamps_ms(6);
    assert_eq!(after.len() as u64, 2_000_000 / UNASKED_US, "{after:?}");
    assert!(after[0] < 60, "{after:?}");
    assert_eq!(answer(&mut autopilot, 7_000_000).0 / 100_000, 10, "a second after its boot");
}

/// From true north, 0 to 359.99 degrees, as the last attitude had it.
#[test]
fn a_position_tells_the_heading_once_there_is_one() {
    let crs = Crs::from_epsg(32633).expect("known");
    let mut autopilot = Autopilot::new(300, 1);
    let mut heading_after = |second: u64, heading_deg: Option<f64>| {
        let at = |reading| Sample { sampled_at_us: second * 1_000_000, arrived_at_us: second * 1_000_000, reading };
        let velocity_ned_m_s = [0.0; 3];
        if let Some(heading_true_rad) = heading_deg.map(f64::to_radians) {
            let attitude = Reading::Attitude { heading_true_rad, pitch_rad: 0.1, roll_rad: 0.2, velocity_ned_m_s };
            autopilot.messages(&at(attitude), &crs).expect("taken");
        }
        let position = Reading::Position { east_m: 500_000.0, north_m: 5e6, up_m: 100.0, velocity_ned_m_s };
        let sent = autopilot.messages(&at(position), &crs).expect("sent");
        let position =
            sent.iter().find(|bytes| u32::from(bytes[7]) == GLOBAL_POSITION_INT_DATA::ID).expect("a position");
        let payload = &position[10..10 + usize::from(position[1])];
        GLOBAL_POSITION_INT_DATA::deser(MavlinkVersion::V2, payload).expect("whole").hdg
    };
    let headings_deg = [None, Some(-90.0), Some(45.5), Some(-0.001), None];
    let told: Vec<u16> = (1..).zip(headings_deg).map(|(second, deg)| heading_after(second, deg)).collect();
    assert_eq!(told, [u16::MAX, 27_000, 4_550, 0, 0]);
}
