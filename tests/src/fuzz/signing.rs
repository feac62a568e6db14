//! The key store, and a receiver with a key: whatever comes, it takes nothing but what was signed, each once.

use super::Target;
use super::mavlink::checksums;
use super::stores::seal;
use mavlink::dialects::common::{ATTITUDE_QUATERNION_DATA, HEARTBEAT_DATA};
use mavlink::{MAVLinkV2MessageRaw, MavHeader, MessageData};
use plumbline_firmware::stores::framing::HEADER_BYTES;
use plumbline_firmware::stores::key::{self, STORE_BYTES, Stored};
use plumbline_firmware::wire::decoder::Decoder;
use plumbline_firmware::wire::signature::Key;
use plumbline_firmware::wire::signing::{Signing, Verdict};
use plumbline_sim::vehicle::signing::Signatory;

const KEY: Key = Key([0xc3; 32]);
/// Messages of each kind in the seeds.
const EACH: u8 = 3;

/// The key store.
pub struct KeyStore;
/// Signed messages.
pub struct Signed {
    signed: Vec<Vec<u8>>,
}

impl Target for KeyStore {
    fn name(&self) -> &'static str {
        "key"
    }

    fn seeds(&self) -> Vec<Vec<u8>> {
        let store = |first: u64| key::store(&Stored { key: KEY, first }).to_vec();
        vec![store(0), store(34_715_520_000_000), store((1 << 48) - 1)]
    }

    fn seal(&self, input: &mut Vec<u8>) {
        seal(input);
    }

    /// A key that was taken is the one that the store holds, and comes back.
    fn read(&mut self, input: &[u8]) -> Result<(), String> {
        match key::read(input) {
            Ok(Some(stored)) if input.get(HEADER_BYTES..STORE_BYTES) != key::store(&stored).get(HEADER_BYTES..) => {
                Err("another key than is stored".to_owned())
            }
            _ => Ok(()),
        }
    }
}

impl Signed {
    pub fn new() -> Self {
        let mut signatory = Signatory::new(KEY);
        let mut signed = Vec::new();
        for number in 0..EACH {
            let attitude = ATTITUDE_QUATERNION_DATA { time_boot_ms: number.into(), q1: 1.0, ..Default::default() };
            for message in [unsigned(&HEARTBEAT_DATA::default(), number), unsigned(&attitude, number)] {
                signed.push(signatory.signed(&message, number.into()));
            }
        }
        Signed { signed }
    }
}

fn unsigned<D: MessageData>(data: &D, sequence: u8) -> Vec<u8> {
    let mut raw = MAVLinkV2MessageRaw::new();
    raw.serialize_message_data(MavHeader { system_id: 1u8.into(), component_id: 1, sequence }, data);
    raw.raw_bytes().to_vec()
}

impl Target for Signed {
    fn name(&self) -> &'static str {
        "signing"
    }

    fn seeds(&self) -> Vec<Vec<u8>> {
        let mut seeds = self.signed.clone();
        seeds.push(self.signed.concat());
        seeds
    }

    /// The checksums alone: who has no key can do no more.
    fn seal(&self, input: &mut Vec<u8>) {
        checksums(input);
    }

    fn read(&mut self, input: &[u8]) -> Result<(), String> {
        let (mut decoder, mut signing, mut taken) = (Decoder::new(), Signing::new(KEY, 0), Vec::new());
        decoder.take(input, |packet| {
            if signing.judge(packet) == Verdict::Taken {
                let bytes = packet.signed.map(|signed| [signed.message, signed.signature].concat());
                taken.push(bytes.unwrap_or_default());
            }
        });
        match taken.iter().find(|bytes| !self.signed.contains(bytes)) {
            Some(bytes) => Err(format!("{bytes:02x?} was not signed, and was taken")),
            None if (1..taken.len()).any(|n| taken[..n].contains(&taken[n])) => Err("one was taken twice".to_owned()),
            None => Ok(()),
        }
    }
}
