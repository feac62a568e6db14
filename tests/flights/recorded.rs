//! The bytes of a real autopilot, at the instants at which it sent them: 175 s of ArduPlane 4.8 by TIMESYNC alone.
//!
//! What was recorded cannot answer: our time requests are answered as the recorded ones were, after 1.6 to 13 ms and without a
//! target, and the recorded answers to others are left out. The records' own instants are coarse by 20 ms; a message arrives a
//! millisecond after the newest stamp that was seen, and not before the record.

use mavlink::dialects::common::{
    DISTANCE_SENSOR_DATA, GLOBAL_POSITION_INT_DATA, GPS_RAW_INT_DATA, MavMessage, TIMESYNC_DATA,
};
use mavlink::{Message, MessageData, calculate_crc};
use plumbline_firmware::wire::decoder::Decoder;
use plumbline_firmware::wire::telemetry::{FrameReport, InstantReport};
use plumbline_sim::ground_station::GroundStation;
use plumbline_sim::link::inproc::InProcess;
use plumbline_sim::link::{Event, Flash, FrameEvent, Link};
use plumbline_sim::scenario::Scenario;
use plumbline_sim::setup::Setup;
use plumbline_sim::world::tile::Tile;
use plumbline_survey::crs::Crs;
use plumbline_survey::io::data::for_test;
use plumbline_tests::seeded::Random;
use std::collections::BTreeMap;

use crate::reboot::message;

/// From a message's newest stamp to its arrival, microseconds.
const TRANSPORT_US: u64 = 1_000;
/// The capture timer against the autopilot's clock: its count at 0, and how much faster it runs.
const START_TICKS: u32 = 4_200_000_000;
const DRIFT: f64 = 35e-6;
/// From one frame to the next, and how long the shutter is open.
const FRAME_US: u64 = 500_000;
const EXPOSURE_US: u64 = 2_000;

/// Shifts of the autopilot's clock that have it wrap in mid-flight: none, 32 bits of microseconds, 32 bits of milliseconds.
const SHIFTS_MS: [u64; 3] = [0, (1 << 32) / 1000 - 60_000, (1 << 32) - 60_000];

/// What arrives, and when on the autopilot's clock before the shift.
struct Arrival {
    at_us: u64,
    bytes: Vec<u8>,
}

/// The recording without its TIMESYNC answers, stamps moved by `shift_ms`; and how many of its messages say that they measured
/// nothing, or know no place.
fn recording(file: &[u8], shift_ms: u64) -> (Vec<Arrival>, u32) {
    let (mut decoder, mut arrivals, mut empty) = (Decoder::new(), Vec::new(), 0);
    let (mut rest, mut newest_us) = (file, 0u64);
    while let Some((head, behind)) = rest.split_at_checked(12) {
        let seconds = f64::from_le_bytes(head[..8].try_into().expect("eight bytes"));
        let length = u32::from_le_bytes(head[8..].try_into().expect("four bytes")) as usize;
        let (bytes, after) = behind.split_at_checked(length).expect("a whole record");
        rest = after;
        newest_us = newest_us.max((seconds * 1e6) as u64);
        decoder.take(bytes, |packet| {
            let mut payload = packet.payload.to_vec();
            payload.resize(payload.len().max(18), 0);
            let word = |at: usize| u32::from_le_bytes(std::array::from_fn(|i| payload[at + i]));
            if packet.id == TIMESYNC_DATA::ID && payload[..8] != [0; 8] {
                return;
            }
            // Least, largest and measured distance; on the ground the last is 0.
            let (least, most, measured) = (word(4) & 0xFFFF, word(4) >> 16, word(8) & 0xFFFF);
            let is_measured = measured > 0 && (least..=most).contains(&measured);
            empty += u32::from(packet.id == DISTANCE_SENSOR_DATA::ID && !is_measured);
            empty += u32::from(packet.id == GLOBAL_POSITION_INT_DATA::ID && (word(4), word(8)) == (0, 0));
            if [31, 33].contains(&packet.id) {
                newest_us = newest_us.max(u64::from(word(0)) * 1000);
            }
            let header = (packet.id, packet.system, packet.component);
            arrivals.push(Arrival { at_us: newest_us + TRANSPORT_US, bytes: shifted(header, payload, shift_ms) });
        });
    }
    (arrivals, empty)
}

/// A message with its stamp moved, in whole milliseconds or microseconds as it has it.
fn shifted((id, system, component): (u32, u8, u8), mut payload: Vec<u8>, shift_ms: u64) -> Vec<u8> {
    match id {
        GPS_RAW_INT_DATA::ID => {
            let us = u64::from_le_bytes(payload[..8].try_into().expect("eight bytes")) + shift_ms * 1000;
            payload[..8].copy_from_slice(&us.to_le_bytes());
        }
        30..=33 | 132 => {
            let ms = u32::from_le_bytes(payload[..4].try_into().expect("four bytes")).wrapping_add(shift_ms as u32);
            payload[..4].copy_from_slice(&ms.to_le_bytes());
        }
        _ => {}
    }
    let [a, b, c, _] = id.to_le_bytes();
    let mut bytes = [&[0xFD, payload.len() as u8, 0, 0, 0, system, component, a, b, c][..], &payload].concat();
    let checksum = calculate_crc(&bytes[1..], MavMessage::extra_crc(id));
    bytes.extend(checksum.to_le_bytes());
    bytes
}

/// What the application made of it.
struct Played {
    station: GroundStation,
    /// When each frame was really exposed, on the autopilot's clock before the shift.
    mids_us: Vec<u64>,
}

/// A reference at the place of the recording; its picture does not matter.
fn flash() -> Flash {
    let setup = Setup::prepare(Scenario::of_frames(1)).expect("it can be flown");
    let mut flash = setup.flash;
    let crs = Crs::from_epsg(32_633).expect("UTM 33 north");
    let (east_m, north_m) = crs.from_wgs84(48.185, 16.36).expect("inside");
    let (cols, rows) = (usize::from(flash.head.size.0), usize::from(flash.head.size.1));
    let resolution_m = f64::from(flash.head.resolution_m);
    let half = |count: usize| 0.5 * count as f64 * resolution_m;
    let (west_m, north_m) = (east_m - half(cols), north_m + half(rows));
    let tile = Tile { west_m, north_m, cols, rows, resolution_m, pixels: Vec::new(), unknown: 0 };
    flash.head = tile.head(&crs).expect("it can be georeferenced");
    flash
}

fn play(file: &[u8], shift_ms: u64) -> (Played, u32) {
    let flash = flash();
    let size = flash.configuration.frame;
    let pixels = usize::from(size.0) * usize::from(size.1);
    let mut link = InProcess::new(&flash).expect("it boots");
    let (arrivals, empty) = recording(file, shift_ms);
    let mut random = Random::new(112);
    let tick = |at_us: u64| START_TICKS.wrapping_add((at_us as f64 * (1.0 + DRIFT)).round() as u32);
    let mut played = Played { station: GroundStation::default(), mids_us: Vec::new() };
    // Answers and frames among them, in the order of their instants.
    let mut answers: BTreeMap<u64, Vec<u8>> = BTreeMap::new();
    let mut next_frame_us = 3_000_000;
    let mut queue = arrivals.into_iter().peekable();
    while let Some(message_us) = queue.peek().map(|arrival| arrival.at_us) {
        let answer_us = answers.keys().next().copied().unwrap_or(u64::MAX);
        let now_us = message_us.min(answer_us).min(next_frame_us);
        let sent = if now_us == next_frame_us {
            let (open_us, close_us) = (now_us - 50 - EXPOSURE_US, now_us - 50);
            for (at_us, rising) in [(open_us, true), (close_us, false)] {
                let sent = link.step(tick(now_us), Event::Edge { tick: tick(at_us), rising }).expect("it runs");
                played.station.take(&sent);
            }
            let sequence = played.mids_us.len() as u32;
            played.mids_us.push(open_us + EXPOSURE_US / 2);
            next_frame_us += FRAME_US;
            // Each frame of another grey: two that are the same are a camera that hangs.
            let pixels = vec![sequence as u8; pixels];
            let frame = FrameEvent { sequence, arrival: tick(now_us), size, pixels: &pixels };
            link.step(tick(now_us), Event::Frame(frame))
        } else if now_us == answer_us {
            let bytes = answers.remove(&answer_us).expect("it is there");
            link.step(tick(now_us), Event::Bytes(&bytes))
        } else {
            let arrival = queue.next().expect("it was peeked at");
            link.step(tick(now_us), Event::Bytes(&arrival.bytes))
        };
        played.station.take(&sent.expect("it runs"));
        for ts1 in std::mem::take(&mut played.station.timesync) {
            let [there_us, back_us] = [(); 2].map(|()| random.between(800.0, 6_500.0) as u64);
            let tc1 = ((now_us + there_us) + shift_ms * 1000) as i64 * 1000;
            answers.insert(now_us + there_us + back_us, message(&TIMESYNC_DATA { tc1, ts1 }));
        }
    }
    (played, empty)
}

fn holds(name: &str, shift_ms: u64) -> Option<Vec<(FrameReport, InstantReport)>> {
    let file = for_test("recorded autopilot", &format!("autopilot/{name}/from_autopilot.bin"))?;
    let file = std::fs::read(file).expect("it is read");
    let (Played { station, mids_us }, empty) = play(&file, shift_ms);
    let health = station.health;
    // Nothing but what says that it measured nothing is refused.
    assert_eq!((health.backwards, health.future, health.foreign), (0, 0, 0), "{health:?}");
    assert!(health.invalid <= empty && health.invalid + 25 > empty, "{health:?}, {empty} empty ones");
    let shift_us = shift_ms * 1000;
    let (mut worst_us, mut predicted) = (0.0f64, 0);
    for (frame, mid_us) in mids_us.iter().enumerate().take(mids_us.len() - 2) {
        let instant = station.instants.get(&(frame as u32)).expect("each is reported");
        let stamp = instant.stamp.unwrap_or_else(|| panic!("frame {frame} has no stamp"));
        let off_us = stamp.mid_us.wrapping_sub(shift_us).wrapping_sub(*mid_us) as i64 as f64;
        assert!(off_us.abs() < 4.0 * f64::from(stamp.sigma_us), "frame {frame}: {off_us} us of {}", stamp.sigma_us);
        worst_us = worst_us.max(off_us.abs());
        predicted += u32::from(station.reports.get(&(frame as u32)).is_some_and(|report| report.predicted.is_some()));
    }
    println!("{name}, shifted by {shift_ms} ms: {worst_us:.0} us off at most, {predicted} frames predicted");
    assert!(worst_us < 2_000.0, "{worst_us} us");
    // From take-off on, 21 s into it, nearly each of two frames a second.
    assert!(predicted > 250, "{predicted}");
    let frames = 0..mids_us.len() as u32 - 2;
    Some(frames.map(|frame| (station.reports[&frame], station.instants[&frame])).collect())
}

/// A report whose instants are those before the shift, without what it cost.
fn unshifted((report, instant): &(FrameReport, InstantReport), shift_ms: u64) -> (FrameReport, InstantReport) {
    let mut instant = *instant;
    if let Some(stamp) = &mut instant.stamp {
        stamp.mid_us -= shift_ms * 1000;
    }
    (FrameReport { mid_exposure_us: report.mid_exposure_us - shift_ms * 1000, ..*report }, instant)
}

#[test]
fn a_recorded_autopilot_ties_the_clock_and_loses_no_sample() {
    for name in ["dead_reckoning", "odometry_fixes"] {
        let Some(plain) = holds(name, SHIFTS_MS[0]) else { return };
        for shift_ms in [SHIFTS_MS[1], SHIFTS_MS[2]] {
            let Some(wrapped) = holds(name, shift_ms) else { return };
            let back: Vec<_> = wrapped.iter().map(|frame| unshifted(frame, shift_ms)).collect();
            assert!(back == plain, "shifted by {shift_ms} ms the flight is another");
        }
    }
}
