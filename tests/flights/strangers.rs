//! Flights on links that carry messages of others, unsigned as the autopilot's own.

use crate::replay::flown::{csv, scenario};
use mavlink::dialects::common::{AUTOPILOT_STATE_FOR_GIMBAL_DEVICE_DATA, MavMessage};
use mavlink::{Message, MessageData, calculate_crc};
use plumbline_sim::link::inproc::InProcess;
use plumbline_sim::link::{Account, Event, Link, LinkError};
use plumbline_sim::run::{Flight, Keep, fly};
use plumbline_sim::score::unrectified::Unrectified;
use plumbline_sim::score::{self, Linked};
use plumbline_sim::setup::Setup;

/// Bytes before the payload, and where the component's id is among them.
const HEADER: usize = 10;
const COMPONENT: usize = 6;
/// Where an attitude's time and quaternion are in its message.
const TIME: usize = HEADER;
const QUATERNION: usize = HEADER + 8;

/// Sends what `forge` makes of each message before it.
struct Stranger<F> {
    link: InProcess,
    forge: F,
}

impl<F: FnMut(&[u8]) -> Option<Vec<u8>>> Link for Stranger<F> {
    fn step(&mut self, timer: u32, event: Event<'_>) -> Result<Vec<u8>, LinkError> {
        let Event::Bytes(bytes) = event else { return self.link.step(timer, event) };
        let all = [(self.forge)(bytes).as_deref().unwrap_or_default(), bytes].concat();
        self.link.step(timer, Event::Bytes(&all))
    }
}

/// The id of a message's kind.
fn id(message: &[u8]) -> u32 {
    u32::from_le_bytes([message[7], message[8], message[9], 0])
}

/// An unsigned message with the checksum of what it now holds.
pub fn sealed(mut message: Vec<u8>) -> Vec<u8> {
    let end = message.len() - 2;
    let checksum = calculate_crc(&message[1..end], MavMessage::extra_crc(id(&message)));
    message[end..].copy_from_slice(&checksum.to_le_bytes());
    message
}

fn flown(setup: &Setup, forge: impl FnMut(&[u8]) -> Option<Vec<u8>>) -> Flight {
    let mut link = Stranger { link: InProcess::new(&setup.flash).expect("it boots"), forge };
    fly(setup, &mut link, Keep::default(), &mut ()).expect("it flies")
}

fn wrong(setup: &Setup, flight: &Flight) -> usize {
    let scored = score::score(setup, flight, &Unrectified::default());
    let linked = Linked { name: "inproc".to_owned(), firmware_sha256: None, account: Account::default() };
    score::summarise(setup, flight, &scored, &linked).wrong_fixes
}

/// Another component of the vehicle repeats all that the autopilot says, attitudes level and to the north, positions and ranges
/// with other figures: nothing comes of it.
#[test]
fn another_component_of_the_vehicle_changes_nothing() {
    for seed in 1..=3 {
        let setup = Setup::prepare(scenario(seed, 50)).expect("it can be flown");
        let alone = flown(&setup, |_| None);
        let flight = flown(&setup, |message| {
            let mut message = message.to_vec();
            message[COMPONENT] = 191;
            if id(&message) == AUTOPILOT_STATE_FOR_GIMBAL_DEVICE_DATA::ID {
                message[QUATERNION..QUATERNION + 16]
                    .copy_from_slice(&[1.0f32, 0.0, 0.0, 0.0].map(f32::to_le_bytes).concat());
            } else if message.len() > HEADER + 10 {
                message[HEADER + 9] ^= 0x40;
            }
            Some(sealed(message))
        });
        assert_eq!(csv(&setup, &flight), csv(&setup, &alone), "seed {seed}");
        assert!(flight.health.foreign > 1000, "{:?}", flight.health);
    }
}

/// Five times a second an attitude of the autopilot's own comes with a stamp 90 ms ahead: what comes behind it counts all the
/// same.
#[test]
fn a_few_stamps_from_the_future_stop_nothing() {
    let setup = Setup::prepare(scenario(4, 50)).expect("it can be flown");
    let alone = flown(&setup, |_| None);
    let mut next_us = 0;
    let flight = flown(&setup, |message| {
        let is_attitude = id(message) == AUTOPILOT_STATE_FOR_GIMBAL_DEVICE_DATA::ID;
        let stamp_us = u64::from_le_bytes(message.get(TIME..TIME + 8)?.try_into().ok()?);
        if !is_attitude || stamp_us < next_us {
            return None;
        }
        next_us = stamp_us + 200_000;
        let mut message = message.to_vec();
        message[TIME..TIME + 8].copy_from_slice(&(stamp_us + 90_000).to_le_bytes());
        Some(sealed(message))
    });
    let fixes = |flight: &Flight| flight.frames.iter().filter(|f| f.report.is_some_and(|r| r.fix.is_some())).count();
    println!("{} fixes, {} alone; {:?}", fixes(&flight), fixes(&alone), flight.health);
    assert!(flight.health.future > 50, "{:?}", flight.health);
    assert!(fixes(&flight) * 100 >= fixes(&alone) * 95 && wrong(&setup, &flight) == 0, "{}", fixes(&flight));
}
