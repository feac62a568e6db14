//! Signed messages against vectors of pymavlink and of Python's hashlib (`tests/signing/vectors.py`), and what no message
//! may do.

use super::{Random, message};
use mavlink::dialects::common::{CAMERA_TRIGGER_DATA, ENCAPSULATED_DATA_DATA, MavMessage};
use mavlink::{MAVLinkV2MessageRaw, MavHeader};
use plumbline_core::units::Micros;
use plumbline_firmware::shared::Shared;
use plumbline_firmware::wire::decoder::Decoder;
use plumbline_firmware::wire::outgoing::{COMPONENT, Encoder, SYSTEM, heartbeat};
use plumbline_firmware::wire::signature::{Key, SIGNATURE, Signature};
use plumbline_firmware::wire::signing::{Signing, Verdict};
use plumbline_sim::vehicle::signing::Signatory;
use plumbline_tests::seeded::config;
use proptest::prelude::{any, prop_assert, prop_assert_eq, proptest};
use serde_json::Value;

const VECTORS: &str = include_str!("../../vectors/signing.json");

fn vectors(name: &str) -> Value {
    let mut all: Value = serde_json::from_str(VECTORS).expect("the vector file is JSON");
    all[name].take()
}

fn bytes(hex: &Value) -> Vec<u8> {
    let hex = hex.as_str().expect("a text");
    (0..hex.len()).step_by(2).map(|at| u8::from_str_radix(&hex[at..at + 2], 16).expect("hexadecimal")).collect()
}

fn key(vectors: &Value) -> Key {
    Key(bytes(&vectors["key"]).try_into().expect("32 bytes"))
}

fn signing(vectors: &Value) -> Signing {
    Signing::new(key(vectors), vectors["stamp"].as_u64().expect("a time"))
}

/// The verdicts on the messages in `stream`.
fn verdicts(signing: &mut Signing, stream: &[u8]) -> Vec<Verdict> {
    let (mut decoder, mut verdicts) = (Decoder::new(), Vec::new());
    decoder.take(stream, |packet| verdicts.push(signing.judge(packet)));
    verdicts
}

#[test]
fn what_is_sent_is_what_pymavlink_signs() {
    let vectors = vectors("sent");
    let signing = Shared::new(signing(&vectors));
    let mut encoder = Encoder::new((SYSTEM, COMPONENT), Some(&signing));
    let data = std::array::from_fn(|n| (n * n) as u8);
    let trigger = CAMERA_TRIGGER_DATA { time_usec: Micros(123_456_789_012).0, seq: 77 };
    let ours = [
        encoder.encode(&heartbeat(false)).to_vec(),
        encoder.encode(&trigger).to_vec(),
        encoder.encode(&ENCAPSULATED_DATA_DATA { seqnr: 7, data }).to_vec(),
    ];
    let theirs: Vec<Vec<u8>> = vectors["messages"].as_array().expect("messages").iter().map(bytes).collect();
    assert_eq!(ours.to_vec(), theirs);
    assert_eq!(signing.with(|signing| signing.stamp()), vectors["stamp"].as_u64().map(|stamp| stamp + 3));
}

#[test]
fn what_is_received_is_judged_as_pymavlink_does_and_counted_by_the_reason() {
    let vectors = vectors("received");
    let mut signing = signing(&vectors);
    let mut counted = [0; 5];
    for (index, message) in vectors["messages"].as_array().expect("messages").iter().enumerate() {
        let [verdict] = verdicts(&mut signing, &bytes(&message["bytes"]))[..] else { panic!("one message") };
        assert_eq!(format!("{verdict:?}"), message["verdict"].as_str().expect("a verdict"), "message {index}");
        assert_eq!(verdict == Verdict::Taken, message["pymavlink_takes"].as_bool().expect("a verdict"));
        if verdict != Verdict::Taken {
            counted[verdict as usize - 1] += 1;
        }
    }
    assert_eq!(signing.refused(), counted);
    assert!(counted[..4].iter().all(|count| *count > 0), "{counted:?} leaves a reason out");
}

#[test]
fn a_message_signed_by_hand_is_taken() {
    let vectors = vectors("by_hand");
    let message = bytes(&vectors["message"]);
    let signature = Signature::of(*message.last_chunk().expect("a signature"));
    assert_eq!((Some(signature.stamp), u64::from(signature.link)), (vectors["stamp"].as_u64(), 2));
    assert_eq!(verdicts(&mut signing(&vectors), &message), [Verdict::Taken]);
}

#[test]
fn no_other_bit_pattern_of_a_signed_message_is_taken() {
    let vectors = vectors("by_hand");
    let message = bytes(&vectors["message"]);
    let mut signing = signing(&vectors);
    for bit in 0..message.len() * 8 {
        let mut changed = message.clone();
        changed[bit / 8] ^= 1 << (bit % 8);
        // With the checksum made right again: what signs is the key.
        for changed in [changed.clone(), checked(changed)].iter().filter(|changed| **changed != message) {
            let verdicts = verdicts(&mut signing, &[&changed[..], &[0; 300]].concat());
            assert!(!verdicts.contains(&Verdict::Taken), "bit {bit}");
        }
    }
    assert_eq!(verdicts(&mut signing, &message), [Verdict::Taken], "nothing forged has moved its stream");
}

/// With the checksum that a changed message should have.
fn checked(mut message: Vec<u8>) -> Vec<u8> {
    let end = message.len() - SIGNATURE - 2;
    let id = u32::from_le_bytes([message[7], message[8], message[9], 0]);
    let checksum = mavlink::calculate_crc(&message[1..end], <MavMessage as mavlink::Message>::extra_crc(id));
    message[end..end + 2].copy_from_slice(&checksum.to_le_bytes());
    message
}

/// The unsigned bytes of a random message of the autopilot's.
fn unsigned(random: &mut Random) -> Vec<u8> {
    let mut raw = MAVLinkV2MessageRaw::new();
    let header = MavHeader { system_id: 1u8.into(), component_id: 1, sequence: random.byte() };
    raw.serialize_message(header, &message(random));
    raw.raw_bytes().to_vec()
}

const KEY: Key = Key([0x5a; 32]);

proptest! {
    #![proptest_config(config(20, 100))]

    #[test]
    fn every_message_is_taken_once_and_no_mutation_of_it(seed in any::<u64>()) {
        let mut random = Random::new(seed);
        let (mut signatory, mut signing) = (Signatory::new(KEY), Signing::new(KEY, 0));
        for step in 0..20 {
            let signed = signatory.signed(&unsigned(&mut random), step);
            let mut mutant = signed.clone();
            for _ in 0..=random.below(3) {
                let at = random.below(mutant.len());
                mutant[at] ^= 1 << random.below(8);
            }
            let mutant = if random.below(2) == 0 { checked(mutant) } else { mutant };
            if mutant != signed {
                let verdicts = verdicts(&mut signing, &[&mutant[..], &[0; 300]].concat());
                prop_assert!(!verdicts.contains(&Verdict::Taken));
            }
            prop_assert_eq!(verdicts(&mut signing, &signed), [Verdict::Taken]);
            prop_assert_eq!(verdicts(&mut signing, &signed), [Verdict::Replayed]);
        }
    }

    #[test]
    fn any_bytes_are_a_signature_and_come_back(raw in any::<[u8; SIGNATURE]>()) {
        prop_assert_eq!(Signature::of(raw).bytes(), raw);
    }
}

#[test]
fn a_key_is_never_told() {
    let signing = Signing::new(KEY, 7);
    for told in [format!("{KEY:?}"), format!("{signing:?}"), format!("{:?}", Shared::new(signing.clone()))] {
        assert!(told.contains("Key(..)") && !told.contains("90, 90"), "{told}");
    }
}
