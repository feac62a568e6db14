//! ArduPilot's.

use super::{all, assert_near, rolls};
use crate::logs::Kind;

fn padded(text: &str, length: usize) -> Vec<u8> {
    let mut bytes = text.as_bytes().to_vec();
    bytes.resize(length, 0);
    bytes
}

fn announce(kind: u8, length: u8, name: &str, types: &str, names: &str) -> Vec<u8> {
    [&[0xa3, 0x95, 128, kind, length][..], &padded(name, 4), &padded(types, 16), &padded(names, 64)].concat()
}

fn begin() -> Vec<u8> {
    [
        announce(128, 89, "FMT", "BBnNZ", "Type,Length,Name,Format,Columns"),
        announce(10, 44, "FMTU", "QBNN", "TimeUS,FmtType,UnitIds,MultIds"),
        announce(11, 23, "ATT", "Qccfe", "TimeUS,Roll,Pitch,Yaw,Count"),
        announce(12, 16, "IMU", "QBf", "TimeUS,I,GyrX"),
        [&[0xa3, 0x95, 10][..], &[0; 8], &[12], &padded("s#E", 16), &padded("F-0", 16)].concat(),
    ]
    .concat()
}

/// A record of ATT. A roll of -273.69 degrees has the sync bytes in it.
fn rolled(t_s: u64, roll_cdeg: i16) -> Vec<u8> {
    let t_us = (t_s * 1_000_000).to_le_bytes();
    let [roll, pitch] = [roll_cdeg, 100].map(i16::to_le_bytes);
    [&[0xa3, 0x95, 11][..], &t_us, &roll, &pitch, &90f32.to_le_bytes(), &700i32.to_le_bytes()].concat()
}

fn flight(seconds: std::ops::Range<u64>) -> Vec<u8> {
    seconds.flat_map(|t| rolled(t, 50 * t as i16)).collect()
}

fn wanted(seconds: impl Iterator<Item = u64>) -> Vec<(f64, f64)> {
    seconds.map(|t| (t as f64, 0.5 * t as f64)).collect()
}

#[test]
fn records_instances_and_hundredths() {
    let imu = |i: u8| [&[0xa3, 0x95, 12][..], &1_000_000u64.to_le_bytes(), &[i], &0.25f32.to_le_bytes()].concat();
    let log = all(Kind::DataFlash, &[begin(), flight(0..10), imu(0), imu(1), imu(1)].concat());
    assert_near(&rolls(&log), &wanted(0..10));
    assert_eq!((log.notes.len(), log.messages()), (0, "ATT, FMTU, IMU (:0, :1)".to_owned()));
    let samples = |name: &str| log.series(name).expect(name).1.samples;
    assert_eq!([samples("IMU"), samples("IMU:0"), samples("IMU:1")], [1, 1, 2]);
    let (_, att) = log.series("ATT").expect("there");
    assert_eq!((att.column("Count"), att.column("GyrX")), (Some(vec![7.0; 10]), None));
    assert!(log.series("IMU:2").expect_err("none").to_string().contains("has no message IMU:2, only ATT, "));
}

#[test]
fn bad_bytes_between_records_are_passed_over() {
    let [first, second] = [flight(0..5), flight(5..10)];
    let junk =
        [begin(), first.clone(), vec![0x55; 33], second.clone(), vec![0xa3, 0x95, 11], second[..9].to_vec()].concat();
    let log = all(Kind::DataFlash, &junk);
    assert_near(&rolls(&log), &wanted(0..10));
    assert!(log.notes[0].contains("33 bytes in 1 place") && log.notes[0].contains("12 bytes"), "{:?}", log.notes);
    // A record that lacks bytes in its middle is left out, and not the one behind it.
    let cut = [begin(), first[..4 * 23 + 9].to_vec(), second.clone()].concat();
    assert_near(&rolls(&all(Kind::DataFlash, &cut)), &wanted((0..10).filter(|t| *t != 4)));
    // Sync bytes as a value are no damage, nor is erased flash behind the end.
    let sync = [begin(), first, rolled(5, i16::from_le_bytes([0xa3, 0x95])), flight(6..10), vec![0xff; 900]].concat();
    let log = all(Kind::DataFlash, &sync);
    assert_eq!((rolls(&log).len(), log.notes.len()), (10, 0));
}
