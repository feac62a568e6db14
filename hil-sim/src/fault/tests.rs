//! Shares are binomial: 4 standard errors, √(p(1 − p)/n), are allowed.

use super::{FaultCounts, FaultInjector};
use crate::scenario::LinkFaults;

const MESSAGES: u64 = 5000;

/// A message of 40 bytes that tells where it belongs.
fn message(index: u64) -> [u8; 40] {
    std::array::from_fn(|byte| (index as u8).wrapping_mul(31).wrapping_add(byte as u8))
}

/// What arrives of each message, and what was counted.
fn flown(link_faults: LinkFaults, seed: u64) -> (Vec<Vec<u8>>, FaultCounts) {
    let mut injector = FaultInjector::new(link_faults, seed, "down");
    let arrived = (0..MESSAGES).map(|index| {
        let mut link = Vec::new();
        injector.pass(&message(index), &mut link);
        link
    });
    (arrived.collect(), injector.counts())
}

fn assert_share(count: u64, of: f64, percent: f64) {
    let p = percent / 100.0;
    let share = count as f64 / of;
    assert!((share - p).abs() < 4.0 * (p * (1.0 - p) / of).sqrt(), "{share} instead of {p}");
}

#[test]
fn a_good_link_changes_nothing() {
    let (arrived, counts) = flown(LinkFaults::default(), 1);
    assert!(arrived.iter().zip(0..).all(|(bytes, index)| *bytes == message(index)));
    assert_eq!(counts, FaultCounts { messages: MESSAGES, ..FaultCounts::default() });
}

#[test]
fn bits_flip_at_their_rate_and_are_counted() {
    let (arrived, counts) = flown(LinkFaults { bit_error_percent: 0.5, ..LinkFaults::default() }, 1);
    assert_share(counts.flipped_bits, MESSAGES as f64 * 320.0, 0.5);
    let flipped = |(bytes, index): (&Vec<u8>, u64)| -> u64 {
        bytes.iter().zip(message(index)).map(|(byte, good)| u64::from((byte ^ good).count_ones())).sum()
    };
    let flips: Vec<u64> = arrived.iter().zip(0..).map(flipped).collect();
    assert_eq!(flips.iter().sum::<u64>(), counts.flipped_bits);
    assert_eq!(flips.iter().filter(|flips| **flips > 0).count() as u64, counts.damaged);
    // Independent bits: a message stays whole with 0.995^320.
    assert_share(MESSAGES - counts.damaged, MESSAGES as f64, 100.0 * 0.995_f64.powi(320));
    assert!(arrived.iter().all(|bytes| bytes.len() == 40));
}

#[test]
fn messages_are_cut_anywhere() {
    let (arrived, counts) = flown(LinkFaults { cut_percent: 30.0, ..LinkFaults::default() }, 1);
    assert_share(counts.cut, MESSAGES as f64, 30.0);
    assert!(arrived.iter().zip(0..).all(|(bytes, index)| message(index).starts_with(bytes)));
    assert_eq!(arrived.iter().filter(|bytes| bytes.len() < 40).count() as u64, counts.cut);
    assert!((0..40).all(|length| arrived.iter().any(|bytes| bytes.len() == length)));
}

/// Header 10, payload as stated, checksum 2; then the good message, untouched.
#[test]
fn unknown_messages_come_whole_and_in_between() {
    let (arrived, counts) = flown(LinkFaults { unknown_percent: 20.0, ..LinkFaults::default() }, 1);
    assert_share(counts.unknown, MESSAGES as f64, 20.0);
    for (bytes, index) in arrived.iter().zip(0..).filter(|(bytes, _)| bytes.len() > 40) {
        assert_eq!((bytes[0], bytes[2], bytes[9]), (0xFD, 0, 0xF0));
        let (unknown, good) = bytes.split_at(10 + usize::from(bytes[1]) + 2);
        assert!(usize::from(unknown[1]) < 64);
        assert_eq!(good, message(index));
    }
}

#[test]
fn the_seed_decides() {
    let faults = LinkFaults { bit_error_percent: 0.01, cut_percent: 3.0, unknown_percent: 3.0 };
    assert_eq!(flown(faults, 1), flown(faults, 1));
    assert_ne!(flown(faults, 1).0, flown(faults, 2).0);
}
