//! PX4's.

use super::{all, assert_near, rolls};
use crate::logs::attitude::Attitude;
use crate::logs::{Kind, Log};

fn record(kind: u8, payload: &[u8]) -> Vec<u8> {
    let size = u16::try_from(payload.len()).expect("short").to_le_bytes();
    [&size[..], &[kind], payload].concat()
}

const QUATERNION: &str = "vehicle_attitude:uint64_t timestamp;float[4] q;uint8_t[4] _padding0;";

/// Header, flags, a format, a subscription.
fn begin(format: &str) -> Vec<u8> {
    let name = format.split(':').next().expect("a name");
    let header = [b"ULog\x01\x12\x35\x01".as_slice(), &5_000_000u64.to_le_bytes()].concat();
    let subscription = [&[0, 7, 0][..], name.as_bytes()].concat();
    [header, record(b'B', &[0; 40]), record(b'F', format.as_bytes()), record(b'A', &subscription)].concat()
}

/// A roll at an instant, as a quaternion.
fn rolled(t_us: u64, roll_deg: f32) -> Vec<u8> {
    let half = roll_deg.to_radians() / 2.0;
    let q = [half.cos(), half.sin(), 0.0, 0.0].map(f32::to_le_bytes).concat();
    record(b'D', &[&7u16.to_le_bytes()[..], &t_us.to_le_bytes(), &q].concat())
}

fn flight(seconds: std::ops::Range<u64>) -> Vec<u8> {
    seconds.flat_map(|t| rolled(6_000_000 + 1_000_000 * t, t as f32)).collect()
}

fn wanted(seconds: impl Iterator<Item = u64>) -> Vec<(f64, f64)> {
    seconds.map(|t| (6.0 + t as f64, t as f64)).collect()
}

#[test]
fn quaternions_and_angles() {
    let whole = [begin(QUATERNION), flight(0..20)].concat();
    let log = all(Kind::ULog, &whole);
    assert_near(&rolls(&log), &wanted(0..20));
    assert_eq!(log.notes, Vec::<String>::new());
    assert_eq!(log.messages(), "vehicle_attitude");
    // Logs of 2016: angles, no record of flags; what is logged of them is 24 bytes.
    let old = begin(
        "vehicle_attitude:uint64_t timestamp;float roll;float pitch;float yaw;float yawspeed;uint8_t[4] _padding0;",
    );
    let old = [&old[..16], &old[16 + 43..]].concat();
    let angles = [0.5f32, 0.1, 3.0, 0.0].map(f32::to_le_bytes).concat();
    let data = record(b'D', &[&7u16.to_le_bytes()[..], &1_000_000u64.to_le_bytes(), &angles].concat());
    assert_near(&rolls(&all(Kind::ULog, &[old, data].concat())), &[(1.0, 0.5f64.to_degrees())]);
}

#[test]
fn damage_is_passed_over_and_told() {
    let whole = [begin(QUATERNION), flight(0..40)].concat();
    let size = rolled(0, 0.0).len();
    let at = begin(QUATERNION).len() + 10 * size;
    // Bytes that are no records; a record whose size is wrong; the end cut off.
    let junk = [&whole[..at], &[0xee; 50], &whole[at..]].concat();
    let log = all(Kind::ULog, &junk);
    assert_near(&rolls(&log), &wanted(0..40));
    assert!(log.notes[0].contains("50 bytes in 1 place are damaged"), "{:?}", log.notes);
    let mut wrong = whole.clone();
    wrong[at + 1] = 0x40;
    let log = all(Kind::ULog, &wrong);
    assert_near(&rolls(&log), &wanted((0..40).filter(|t| *t != 10)));
    // Damage that looks like flags.
    let flags = [&whole[..at], &record(b'B', &[0xee; 45]), &whole[at..]].concat();
    assert_near(&rolls(&all(Kind::ULog, &flags)), &wanted(0..40));
    let log = all(Kind::ULog, &whole[..whole.len() - 5]);
    assert_near(&rolls(&log), &wanted(0..39));
    assert!(log.notes[0].contains("ends within a record"), "{:?}", log.notes);
    // Sixteen bytes, and a log that ends before the first message.
    for end in [10, 16, at - 10 * size] {
        let error = Log::read("a.log", Kind::ULog, &whole[..end], &|_| true).expect_err("nothing");
        assert!(error.to_string().starts_with("a.log: "), "{error}");
    }
}

#[test]
fn dropouts_are_told_and_appended_data_are_read() {
    let mut whole = [begin(QUATERNION), flight(0..20), record(b'O', &[44, 1])].concat();
    // Cut off within a record, with what was rescued behind it.
    whole.extend(&flight(20..21)[..9]);
    let offset = whole.len() as u64;
    whole.extend(flight(30..50));
    whole[16 + 3 + 8] = 1;
    whole[16 + 3 + 16..][..8].copy_from_slice(&offset.to_le_bytes());
    let log = all(Kind::ULog, &whole);
    assert_near(&rolls(&log), &wanted((0..20).chain(30..50)));
    assert!(log.notes[0].contains("dropped 0.300 s"), "{:?}", log.notes);
}

#[test]
fn a_reboot_is_refused_and_what_is_no_attitude_left_out() {
    let none = record(b'D', &[&7u16.to_le_bytes()[..], &7_500_000u64.to_le_bytes(), &[0; 16]].concat());
    let log = all(Kind::ULog, &[begin(QUATERNION), flight(0..2), none, flight(2..3), flight(2..4)].concat());
    assert_near(&rolls(&log), &wanted(0..4));
    let note = Attitude::of_log(&log).expect("attitudes").notes.pop().expect("a note");
    assert!(note.contains("1 left out that are none, 1 left out that are not later"), "{note}");
    let log = all(Kind::ULog, &[begin(QUATERNION), flight(0..10), flight(0..10)].concat());
    let error = Attitude::of_log(&log).expect_err("a reboot").to_string();
    assert!(error.contains("time goes back from 15.000 s to 6.000 s"), "{error}");
    let other = begin("vehicle_status:uint64_t timestamp;float[4] q;");
    let error = Attitude::of_log(&all(Kind::ULog, &[other, flight(0..2)].concat())).expect_err("none").to_string();
    assert!(error.contains("has no attitude (vehicle_attitude, ") && error.ends_with("only vehicle_status"), "{error}");
}
