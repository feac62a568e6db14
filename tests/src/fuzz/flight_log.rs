//! The readers of flight logs: ULog, DataFlash, telemetry.

use super::Target;
use mavlink::dialects::common::{ATTITUDE_DATA, HEARTBEAT_DATA, MavMessage};
use mavlink::{MAVLinkV2MessageRaw, MavHeader, Message, calculate_crc};
use plumbline_survey::logs::attitude::Attitude;
use plumbline_survey::logs::{Kind, Log};

/// When telemetry is received, microseconds since 1970.
const STAMP_US: u64 = 1_790_000_000_000_000;
/// Bytes of the stamp and of the head behind it.
const STAMP: usize = 8;
const HEAD: usize = 10;

pub struct FlightLog;

fn ulog() -> Vec<u8> {
    let record = |kind: u8, payload: &[u8]| [&(payload.len() as u16).to_le_bytes()[..], &[kind], payload].concat();
    let mut log = [&b"ULog\x01\x12\x35\x01"[..], &[0; 8], &record(b'B', &[0; 40])].concat();
    log.extend(record(b'F', b"part:float[2] x;uint8_t[3] y;"));
    log.extend(record(b'F', b"vehicle_attitude:uint64_t timestamp;float[4] q;part[2] parts;uint8_t[2] _padding0;"));
    log.extend(record(b'A', b"\0\x05\0vehicle_attitude"));
    for t in 1..12u64 {
        let q = [1f32, 0.0, 0.0, 0.0].map(f32::to_le_bytes).concat();
        log.extend(record(b'D', &[&[5, 0][..], &(100_000 * t).to_le_bytes(), &q, &[3; 22]].concat()));
        log.extend(record(b'S', b"\x2f\x73\x13\x20\x25\x0c\xbb\x12"));
    }
    log
}

fn dataflash() -> Vec<u8> {
    let padded = |text: &str, length: usize| {
        let mut bytes = text.as_bytes().to_vec();
        bytes.resize(length, 0);
        bytes
    };
    let announce = |kind: u8, length: u8, name: &str, types: &str, names: &str| {
        [&[0xa3, 0x95, 128, kind, length][..], &padded(name, 4), &padded(types, 16), &padded(names, 64)].concat()
    };
    let mut log = announce(128, 89, "FMT", "BBnNZ", "Type,Length,Name,Format,Columns");
    log.extend(announce(10, 44, "FMTU", "QBNN", "TimeUS,FmtType,UnitIds,MultIds"));
    log.extend(announce(11, 20, "ATT", "Qcchgb", "TimeUS,Roll,Pitch,Yaw,Half,I"));
    log.extend([&[0xa3, 0x95, 10][..], &[0; 8], &[11], &padded("sddd-#", 16), &[0; 16]].concat());
    for t in 1..20u64 {
        log.extend([&[0xa3, 0x95, 11][..], &(100_000 * t).to_le_bytes(), &[9; 8], &[0]].concat());
    }
    log
}

fn telemetry() -> Vec<u8> {
    let mut log = Vec::new();
    for t in 1..12 {
        let attitude = ATTITUDE_DATA { time_boot_ms: 100 * t, yawspeed: 0.5, ..ATTITUDE_DATA::DEFAULT };
        for message in [MavMessage::ATTITUDE(attitude), MavMessage::HEARTBEAT(HEARTBEAT_DATA::DEFAULT)] {
            let mut raw = MAVLinkV2MessageRaw::new();
            raw.serialize_message(MavHeader { system_id: 1, component_id: 1, sequence: 0 }, &message);
            log.extend(STAMP_US.to_be_bytes());
            log.extend(raw.raw_bytes());
        }
    }
    log
}

impl Target for FlightLog {
    fn name(&self) -> &'static str {
        "flight_log"
    }

    fn seeds(&self) -> Vec<Vec<u8>> {
        vec![ulog(), dataflash(), telemetry()]
    }

    /// The checksums of telemetry, whose frames follow each other; the other formats have none.
    fn seal(&self, input: &mut Vec<u8>) {
        let mut rest = input.as_mut_slice();
        while rest.get(STAMP) == Some(&0xfd) && rest.len() >= STAMP + HEAD + 2 {
            let end = STAMP + HEAD + usize::from(rest[STAMP + 1]);
            if rest.len() < end + 2 {
                return;
            }
            let id = u32::from_le_bytes([rest[STAMP + 7], rest[STAMP + 8], rest[STAMP + 9], 0]);
            let sum = calculate_crc(&rest[STAMP + 1..end], <MavMessage as Message>::extra_crc(id));
            rest[end..end + 2].copy_from_slice(&sum.to_le_bytes());
            rest = &mut rest[end + 2..];
        }
    }

    fn read(&mut self, input: &[u8]) -> Result<(), String> {
        let Some(kind) = Kind::of(input) else { return Ok(()) };
        let Ok(log) = Log::read("input", kind, input, &|_| true) else { return Ok(()) };
        let Ok(attitude) = Attitude::of_log(&log) else { return Ok(()) };
        let is_forward = attitude.samples.windows(2).all(|pair| pair[0].t_s < pair[1].t_s);
        let is_finite = attitude.samples.iter().all(|s| (s.t_s + s.roll_rad + s.pitch_rad + s.yaw_rad).is_finite());
        if is_forward && is_finite { Ok(()) } else { Err(format!("{:?}", attitude.samples)) }
    }
}
