//! The frame receivers of the simulator's line: a board's and the simulator's.

use super::Target;
use plumbline_firmware::serial::FRAME_MAX;
use plumbline_firmware::serial::frame::encode;
use plumbline_firmware::serial::message::{Answer, Counts, Envelope, Event, Next, Refused, Request, Store, Welcome};
use plumbline_firmware::stores::framing::checksum;
use plumbline_sim::link::mutants::{NEXT_ID, device_bytes, host_bytes, step_bytes};

/// What a board receives.
pub struct Device;
/// What the simulator receives.
pub struct Host;

impl Target for Device {
    fn name(&self) -> &'static str {
        "line_device"
    }

    fn seeds(&self) -> Vec<Vec<u8>> {
        let step = |event| Request::Step { timer: 123_456, event };
        let mut messages: Vec<Vec<u8>> = [
            Request::Hello { version: 1 },
            Request::Open,
            Request::Announce { store: Store::Tile, bytes: 70_000, crc: 0x1234_5678 },
            Request::Piece { store: Store::Configuration, offset: 0, bytes: &[0, 1, 2, 0, 255] },
            Request::Start,
            step(Event::Nothing),
            step(Event::Bytes(&[0xfd; 300])),
            step(Event::Pulse(7)),
            step(Event::Edge { tick: 99, rising: true }),
            step(Event::Frame { sequence: 3, arrival: 123_456, size: (64, 64) }),
            Request::Rows { sequence: 3, offset: 0, bytes: &[0; 256] },
            Request::Continue,
            Request::Reset { boot: 3 },
            Request::Bye,
        ]
        .into_iter()
        .map(|request| step_bytes(NEXT_ID, request))
        .collect();
        messages.push(messages.concat());
        messages
    }

    fn seal(&self, input: &mut Vec<u8>) {
        seal(input);
    }

    fn read(&mut self, input: &[u8]) -> Result<(), String> {
        device_bytes(input);
        Ok(())
    }
}

impl Target for Host {
    fn name(&self) -> &'static str {
        "line_host"
    }

    fn seeds(&self) -> Vec<Vec<u8>> {
        let welcome = Welcome {
            version: 2,
            boot: 3,
            core_clock_hz: 480_000_000,
            counts: Counts::Cycles,
            piece_max: 2048,
            configuration_capacity: 1024,
            tile_capacity: 400_000,
            plan_capacity: 16_384,
            key_capacity: 128,
            board: "board",
            firmware: "0.1.0",
        };
        let sent = [0xfd; 280];
        let mut messages: Vec<Vec<u8>> = [
            Answer::Welcome(welcome),
            Answer::Done,
            Answer::Refused(Refused::Boot(["configuration: ", "impossible sigma"])),
            Answer::Refused(Refused::TooLarge { capacity: 400_000 }),
            Answer::Stepped { cost: 1_000_000, next: Next::More, is_at_work: true, sent: &sent },
            Answer::Stepped { cost: 0, next: Next::Rows { sequence: 3, offset: 64 }, is_at_work: false, sent: &[] },
            Answer::Stranger { boot: 4 },
        ]
        .into_iter()
        .map(|message| {
            let mut buffer = [0; FRAME_MAX];
            encode(&Envelope { session: 7, id: 5, message }, &mut buffer).unwrap_or_default().to_vec()
        })
        .collect();
        messages.push(messages.concat());
        messages
    }

    fn seal(&self, input: &mut Vec<u8>) {
        seal(input);
    }

    fn read(&mut self, input: &[u8]) -> Result<(), String> {
        host_bytes(input);
        Ok(())
    }
}

/// Gives what stands between zeros the CRC that it should have.
fn seal(input: &mut Vec<u8>) {
    let mut sealed = Vec::with_capacity(input.len() + 8);
    for chunk in input.split(|&byte| byte == 0) {
        if let Some(mut body) = unstuffed(chunk)
            && let Some((message, crc)) = body.split_last_chunk_mut::<4>()
        {
            *crc = checksum(message).to_le_bytes();
            sealed.extend(stuffed(&body));
        } else {
            sealed.extend_from_slice(chunk);
        }
        sealed.push(0);
    }
    *input = sealed;
}

/// COBS undone (Cheshire and Baker): each code says how far the next zero is.
fn unstuffed(chunk: &[u8]) -> Option<Vec<u8>> {
    let (mut body, mut rest) = (Vec::new(), chunk);
    while let Some((&code, after)) = rest.split_first() {
        let (run, after) = after.split_at_checked(usize::from(code).checked_sub(1)?)?;
        body.extend_from_slice(run);
        rest = after;
        if code < 0xff && !rest.is_empty() {
            body.push(0);
        }
    }
    Some(body)
}

/// COBS done.
fn stuffed(body: &[u8]) -> Vec<u8> {
    let mut out = Vec::new();
    for run in body.split(|&byte| byte == 0) {
        for piece in run.chunks(254) {
            out.push(piece.len() as u8 + 1);
            out.extend_from_slice(piece);
        }
        // A run that ends with a whole block, and an empty one, say by themselves that a zero follows.
        if run.len() % 254 == 0 {
            out.push(1);
        }
    }
    out
}
