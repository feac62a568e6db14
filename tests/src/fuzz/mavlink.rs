//! The MAVLink receiver: the decoder, whose books must balance, and the application behind it, which lives through all
//! inputs one after the other.

use super::Target;
use mavlink::dialects::common::MavMessage;
use mavlink::{MAV_STX_V2, Message, calculate_crc};
use plumbline_firmware::wire::decoder::Decoder;
use plumbline_sim::link::inproc::InProcess;
use plumbline_sim::link::{Event, Link};
use plumbline_sim::scenario::Scenario;
use plumbline_sim::setup::Setup;
use plumbline_sim::vehicle::autopilot::Autopilot;
use plumbline_sim::vehicle::sensors::Streams;

/// Most bytes that the application may answer to a byte: a request of 12 bytes is answered by 30.
const ANSWER_MAX: usize = 64;
/// Bytes that it sends of itself in the time that an input takes.
const BEAT_BYTES: usize = 4096;
/// How far the capture timer goes on with each input.
const STEP_TICKS: u32 = 1000;

pub struct Mavlink {
    seeds: Vec<Vec<u8>>,
    application: InProcess,
    timer: u32,
}

impl Mavlink {
    pub fn new() -> Self {
        let scenario = Scenario::default();
        let setup = Setup::prepare(scenario).expect("the default scene is sound");
        let mut streams = Streams::new(&setup.scenario, setup.payload.mount, setup.convergence_rad);
        let mut autopilot = Autopilot::default();
        let slant = |_: &_| Some(500.0);
        let mut messages: Vec<Vec<u8>> = Vec::new();
        while let Some(sample) = streams.next_before(1_200_000, &setup.motion, &slant) {
            messages.extend(autopilot.message(&sample, &setup.crs).expect("inside the system"));
        }
        messages.push(autopilot.timesync_answer(5_000, 1_000_000, (1, 154)));
        // One of each kind is enough, and each in company.
        messages.sort_by_key(|message| message[7..10].to_vec());
        messages.dedup_by_key(|message| message[7..10].to_vec());
        let all = messages.concat();
        messages.push(all);
        let application = InProcess::new(&setup.flash).expect("the default configuration is sound");
        Mavlink { seeds: messages, application, timer: 0 }
    }
}

impl Target for Mavlink {
    fn name(&self) -> &'static str {
        "mavlink"
    }

    fn seeds(&self) -> Vec<Vec<u8>> {
        self.seeds.clone()
    }

    /// Wherever a message seems to begin.
    fn seal(&self, input: &mut Vec<u8>) {
        let mut at = 0;
        while let Some(start) = input.get(at..).and_then(|rest| rest.iter().position(|&byte| byte == MAV_STX_V2)) {
            let start = at + start;
            at = start + 1;
            let Some(head) = input.get(start..start + 10) else { return };
            let id = u32::from_le_bytes([head[7], head[8], head[9], 0]);
            let end = start + 10 + usize::from(head[1]);
            let Some(body) = input.get(start + 1..end) else { continue };
            let checksum = calculate_crc(body, MavMessage::extra_crc(id)).to_le_bytes();
            if let Some(place) = input.get_mut(end..end + 2) {
                place.copy_from_slice(&checksum);
                at = end + 2;
            }
        }
    }

    fn read(&mut self, input: &[u8]) -> Result<(), String> {
        let mut decoder = Decoder::new();
        let (mut rest, mut used) = (input, 0);
        while !rest.is_empty() {
            let room = decoder.free();
            let count = room.len().min(rest.len());
            if count == 0 {
                return Err("the decoder has no room left".to_owned());
            }
            room[..count].copy_from_slice(&rest[..count]);
            decoder.filled(count);
            rest = &rest[count..];
            while let Some(packet) = decoder.next() {
                let length = packet.payload.len() + 12;
                used += if packet.is_signed { length + 13 } else { length };
            }
        }
        let waiting = decoder.waiting();
        let skipped = decoder.counters().skipped_bytes as usize;
        if used + skipped + waiting != input.len() {
            return Err(format!(
                "of {} bytes {used} were used, {skipped} skipped and {waiting} are waiting",
                input.len()
            ));
        }
        self.timer = self.timer.wrapping_add(STEP_TICKS);
        let sent = self.application.step(self.timer, Event::Bytes(input)).map_err(|error| error.to_string())?;
        if sent.len() > BEAT_BYTES + ANSWER_MAX * input.len() {
            return Err(format!("{} bytes were answered by {}", input.len(), sent.len()));
        }
        Ok(())
    }
}
