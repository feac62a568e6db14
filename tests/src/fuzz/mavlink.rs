//! The MAVLink receiver: the decoder, whose books must balance, and the application behind it, which lives through all
//! inputs one after the other.

use super::Target;
use mavlink::dialects::common::MavMessage;
use mavlink::{MAV_STX_V2, Message, calculate_crc};
use plumbline_firmware::wire::command::{Command, REQUEST_MESSAGE, SET_MESSAGE_INTERVAL};
use plumbline_firmware::wire::decoder::Decoder;
use plumbline_sim::ground_station::GroundStation;
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
        let mut autopilot = Autopilot::new(setup.scenario.world.autopilot.loop_rate_hz, 0);
        let slant = |_: &_| Some(500.0);
        let mut messages: Vec<Vec<u8>> = vec![autopilot.heartbeat()];
        let origin = Command { command: REQUEST_MESSAGE, parameters: [49.0, 0.0], target: (1, 1) };
        for message in [31.0, 286.0] {
            let asked = Command { command: SET_MESSAGE_INTERVAL, parameters: [message, 5000.0], target: (1, 1) };
            messages.push(autopilot.commanded(&asked, 0).1);
        }
        while let Some(sample) = streams.next_before(1_200_000, &setup.motion, &slant) {
            messages.extend(autopilot.messages(&sample, &setup.crs).expect("inside the system"));
        }
        let (_, answered) = autopilot.commanded(&origin, 0);
        messages.extend(each(&answered).map(<[u8]>::to_vec));
        messages.push(autopilot.timesync_answer(5_000, 1_000_000).1);
        messages.extend(autopilot.parameter("EK3_SRC2_POSXY", 0).map(|(_, answer)| answer));
        messages.extend([76, 75].map(order));
        // One of each kind is enough, and each in company.
        messages.sort_by_key(|message| message[7..10].to_vec());
        messages.dedup_by_key(|message| message[7..10].to_vec());
        let all = messages.concat();
        messages.push(all);
        let mut application = InProcess::new(&setup.flash).expect("the default configuration is sound");
        let timer = tied(&mut application, &mut autopilot);
        Mavlink { seeds: messages, application, timer }
    }
}

/// A ground station's order to us: a set of sources by COMMAND_LONG (76), a place by COMMAND_INT (75). Both have parameters, the
/// command, and the target at the same places.
fn order(id: u8) -> Vec<u8> {
    let (command, words) = match id {
        75 => (43_003u16, [0, 0, 20f32.to_bits(), 0, 480_000_000, 160_000_000, 0]),
        _ => (42_007, [2f32.to_bits(), 0, 0, 0, 0, 0, 0]),
    };
    let mut payload: Vec<u8> = words.into_iter().flat_map(u32::to_le_bytes).collect();
    payload.extend(command.to_le_bytes());
    payload.extend([1, 154, 5]);
    let mut bytes = [&[MAV_STX_V2, payload.len() as u8, 0, 0, 0, 255, 190, id, 0, 0][..], &payload].concat();
    let checksum = calculate_crc(&bytes[1..], MavMessage::extra_crc(id.into()));
    bytes.extend(checksum.to_le_bytes());
    bytes
}

/// Has the clock of the application tied, without which it takes no sample; its capture timer then.
fn tied(application: &mut InProcess, autopilot: &mut Autopilot) -> u32 {
    let mut station = GroundStation::default();
    let mut timer = 0;
    for _ in 0..10 {
        timer += 100_000;
        station.take(&application.step(timer, Event::Nothing).expect("a host's firmware"));
        for stamp in std::mem::take(&mut station.timesync) {
            let (at_us, answer) = autopilot.timesync_answer(stamp, timer.into());
            station.take(&application.step(at_us as u32, Event::Bytes(&answer)).expect("a host's firmware"));
        }
    }
    timer
}

/// The messages that follow each other in `bytes`.
fn each(bytes: &[u8]) -> impl Iterator<Item = &[u8]> {
    let mut rest = bytes;
    std::iter::from_fn(move || {
        let length = 12 + usize::from(*rest.get(1)?);
        let (message, behind) = rest.split_at_checked(length)?;
        rest = behind;
        Some(message)
    })
}

impl Target for Mavlink {
    fn name(&self) -> &'static str {
        "mavlink"
    }

    fn seeds(&self) -> Vec<Vec<u8>> {
        self.seeds.clone()
    }

    fn seal(&self, input: &mut Vec<u8>) {
        checksums(input);
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
                used += if packet.signed.is_some() { length + 13 } else { length };
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

/// Makes checksums right wherever a message seems to begin.
pub fn checksums(input: &mut [u8]) {
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
