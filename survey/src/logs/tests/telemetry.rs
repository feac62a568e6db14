//! What a ground station logged.

use super::{all, assert_near, rolls};
use crate::logs::Kind;
use mavlink::dialects::ardupilotmega::{ATTITUDE_DATA, ATTITUDE_QUATERNION_DATA, HEARTBEAT_DATA, MavMessage};
use mavlink::{MAVLinkV1MessageRaw, MAVLinkV2MessageRaw, MavHeader};

const STAMP_US: u64 = 1_790_000_000_000_000;

fn stamped(frame: &[u8]) -> Vec<u8> {
    [&STAMP_US.to_be_bytes()[..], frame].concat()
}

fn sent(system_id: u32, message: &MavMessage) -> Vec<u8> {
    let mut raw = MAVLinkV2MessageRaw::new();
    raw.serialize_message(MavHeader { system_id, component_id: 1, sequence: 0 }, message);
    stamped(raw.raw_bytes())
}

fn rolled(t_ms: u32, roll_deg: f32) -> MavMessage {
    // The last field is not 0, so that each frame has its whole length.
    let roll = roll_deg.to_radians();
    MavMessage::ATTITUDE(ATTITUDE_DATA { time_boot_ms: t_ms, roll, yawspeed: 0.5, ..ATTITUDE_DATA::DEFAULT })
}

fn flight(seconds: std::ops::Range<u32>) -> Vec<u8> {
    seconds.flat_map(|t| sent(1, &rolled(1000 * t, t as f32))).collect()
}

fn wanted(seconds: impl Iterator<Item = u32>) -> Vec<(f64, f64)> {
    seconds.map(|t| (t.into(), t.into())).collect()
}

#[test]
fn both_versions_and_several_senders() {
    let mut raw = MAVLinkV1MessageRaw::new();
    raw.serialize_message(MavHeader { system_id: 1, component_id: 1, sequence: 0 }, &rolled(10_000, 10.0));
    let ground_station = sent(255, &MavMessage::HEARTBEAT(HEARTBEAT_DATA::DEFAULT));
    let other = sent(2, &rolled(500, 90.0));
    let log = all(Kind::Telemetry, &[ground_station, other, flight(0..10), stamped(raw.raw_bytes())].concat());
    assert_near(&rolls(&log), &wanted(0..11));
    assert_eq!(log.messages(), "ATTITUDE (:1.1, :2.1), HEARTBEAT");
    assert_eq!(log.series("ATTITUDE:2.1").expect("there").1.t_s, [0.5]);
    assert_eq!(log.notes, Vec::<String>::new());
}

#[test]
fn what_was_sent_more_often_is_taken() {
    let half = 0.25f32.to_radians();
    let quaternion = |t_ms| {
        let q = ATTITUDE_QUATERNION_DATA {
            time_boot_ms: t_ms,
            q1: half.cos(),
            q2: half.sin(),
            ..ATTITUDE_QUATERNION_DATA::DEFAULT
        };
        sent(1, &MavMessage::ATTITUDE_QUATERNION(q))
    };
    let often: Vec<u8> = (0..3).flat_map(|t| quaternion(100 * t)).collect();
    let found = rolls(&all(Kind::Telemetry, &[flight(0..2), often].concat()));
    assert_near(&found, &[(0.0, 0.5), (0.1, 0.5), (0.2, 0.5)]);
}

#[test]
fn damage_is_passed_over_and_unknown_messages_are_counted() {
    let one = flight(0..1).len();
    let mut whole = flight(0..10);
    // A bit of the fourth's payload is wrong; bytes between the fifth and the sixth; the last is cut.
    whole[3 * one + 30] ^= 1;
    let cut = [&whole[..5 * one], &[0xfd; 20], &whole[5 * one..], &flight(10..11)[..one - 3]].concat();
    let log = all(Kind::Telemetry, &cut);
    assert_near(&rolls(&log), &wanted((0..10).filter(|t| *t != 3)));
    let note = &log.notes[0];
    assert!(note.contains(&format!("{} bytes in 2 places", one + 20)) && note.contains("ends within"), "{note}");
    let unknown = stamped(&[&[0xfd, 4, 0, 0, 0, 1, 1, 0x39, 0x30, 0][..], &[1, 2, 3, 4, 0, 0]].concat());
    let log = all(Kind::Telemetry, &[flight(0..2), unknown, flight(2..3)].concat());
    assert_eq!((log.messages(), rolls(&log).len()), ("ATTITUDE, MESSAGE_12345".to_owned(), 3));
}
