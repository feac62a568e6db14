//! Lost power, damaged blocks, slow cards: the log is read as far as it goes, and says where that is.

use super::flown::{flown, replayed, scenario};
use plumbline_firmware::log::block::BLOCK;
use plumbline_firmware::log::card::Area;
use plumbline_firmware::log::journal::LogJournal;
use plumbline_firmware::log::writer::write_out;
use plumbline_sim::link::inproc::{Card, InProcess};
use plumbline_sim::link::{Event, Link};
use plumbline_sim::replay::read::{LogError, read};
use plumbline_sim::replay::{End, fixes_csv, replay};
use plumbline_sim::setup::Setup;
use proptest::prelude::{any, proptest};
use std::pin::pin;
use std::sync::OnceLock;
use std::task::{Context, Waker};

fn flight() -> &'static (String, Vec<u8>) {
    static FLIGHT: OnceLock<(String, Vec<u8>)> = OnceLock::new();
    FLIGHT.get_or_init(|| flown(scenario(21, 10)))
}

/// The log's first bytes replay to the flight's first frames; how many.
fn prefix(bytes: &[u8]) -> usize {
    let log = read(bytes, None).expect("a log");
    let tiles = read(&flight().1, None).expect("a log").tiles;
    let replayed = replay(&log, tiles.as_deref()).expect("it can be replayed");
    assert_eq!((replayed.first_difference.as_deref(), replayed.gaps), (None, 0));
    assert_eq!(replayed.replayed, replayed.records);
    let fixes = fixes_csv(&log, None, &replayed).expect("placed");
    if replayed.frames > 0 {
        assert!(flight().0.starts_with(&fixes), "{fixes}");
        assert_eq!(fixes.lines().count(), replayed.frames + 1);
    }
    assert_eq!(replayed.end, if bytes.len() == flight().1.len() { End::Closed } else { End::Cut });
    replayed.frames
}

#[test]
fn power_lost_after_any_block() {
    let whole = &flight().1;
    let blocks = whole.len() / BLOCK;
    let mut last = 0;
    for count in (2..=blocks).step_by(13).chain([blocks]) {
        let frames = prefix(&whole[..count * BLOCK]);
        assert!(frames >= last);
        last = frames;
    }
    assert_eq!(last, 10);
    // In the middle of the last blocks: a started block counts for nothing.
    for cut in (whole.len() - 3 * BLOCK..whole.len()).step_by(97) {
        prefix(&whole[..cut]);
    }
    assert_eq!(read(&whole[..BLOCK - 1], None).expect_err("nothing"), LogError::NoLog);
}

#[test]
fn damaged_blocks_end_what_is_claimed() {
    let (fixes, whole) = flight();
    let blocks = whole.len() / BLOCK;
    for at in [blocks / 2, blocks - 5] {
        let mut bytes = whole.clone();
        bytes[at * BLOCK + 100] ^= 1;
        // Not even its beginning is left of the other.
        bytes[(at + 1) * BLOCK..(at + 2) * BLOCK].fill(0);
        let (log, replayed) = replayed(&bytes);
        assert_eq!((replayed.damaged_blocks, replayed.gaps, replayed.different), (2, 1, 0), "block {at}");
        assert!(replayed.replayed < replayed.records);
        assert_eq!(replayed.same, replayed.frames);
        let told = fixes_csv(&log, None, &replayed).expect("placed");
        assert!(fixes.starts_with(&told), "{told}");
    }
    // Without its beginning nobody knows what the application ran on.
    let mut bytes = whole.clone();
    bytes[100] ^= 1;
    assert_eq!(read(&bytes, None).expect_err("no head"), LogError::NoHead);
    bytes[BLOCK..].fill(0);
    assert_eq!(read(&bytes, None).expect_err("nothing"), LogError::NoLog);
}

#[test]
fn a_slow_card_costs_records_that_are_counted_and_no_frame() {
    let setup = Setup::prepare(scenario(22, 1)).expect("it can be flown");
    let mut link = InProcess::logged(&setup.flash).expect("it boots");
    let mut told = Vec::new();
    let mut card = link.card().expect("a card").clone();
    for step in 0..4000u32 {
        card.set_busy((1000..2000).contains(&step));
        told.extend(link.step(step * 1000, Event::Bytes(&[0x55; 100])).expect("it lives"));
    }
    assert!(!told.is_empty());
    card = link.card().expect("a card").clone();
    card.set_busy(false);
    let (_, replayed) = replayed(&link.close_log());
    // 1000 steps of 100 bytes into 32 blocks of 488: four in five are lost, in one place.
    assert_eq!((replayed.gaps, replayed.different, replayed.damaged_blocks), (1, 0, 0));
    assert!((700..1000).contains(&replayed.lost_records), "{}", replayed.lost_records);
    assert_eq!(replayed.end, End::Closed);
}

/// A card may keep what stood there before where a write was lost, and blocks of an older log are whole.
#[test]
fn a_whole_block_of_another_log_or_place_is_as_good_as_a_damaged_one() {
    let (_, whole) = flight();
    let (_, other) = flown(scenario(23, 1));
    let at = whole.len() / BLOCK / 2;
    for stale in [&other[5 * BLOCK..6 * BLOCK], &whole[(at - 3) * BLOCK..(at - 2) * BLOCK]] {
        let mut bytes = whole.clone();
        bytes[at * BLOCK..(at + 1) * BLOCK].copy_from_slice(stale);
        let (_, replayed) = replayed(&bytes);
        assert_eq!((replayed.damaged_blocks, replayed.gaps, replayed.different), (1, 1, 0));
        assert_eq!(replayed.first_difference, None);
    }
}

/// With the ring of a board, whose half is more than a stall leaves free.
#[test]
fn a_stall_while_tiles_are_written_costs_none_of_them() {
    const RING: usize = 256;
    let tiles: Vec<u8> = (0..600_000u32).map(|n| (n * 7) as u8).collect();
    let blocks = Box::leak(Box::new([[0; BLOCK]; RING]));
    let log = LogJournal::<RING>::new(5, &[1; 200], &tiles, 1000, blocks);
    let mut card = Card::default();
    let shared = card.clone();
    let mut writing = pin!(write_out(&log, &mut card, Area { first: 0, end: u32::MAX }));
    let context = &mut Context::from_waker(Waker::noop());
    for step in 0..4000u32 {
        // Longer than 256 blocks of 488 bytes last.
        shared.set_busy(step < 2000);
        log.annotate(&[step as u8; 100]);
        assert!(writing.as_mut().poll(context).is_pending());
    }
    log.close();
    assert!(writing.as_mut().poll(context).is_pending());
    let read = read(&shared.bytes(), None).expect("a log");
    assert!(read.tiles.as_deref() == Some(&tiles[..]), "tiles are missing");
    // Half of the ring was the flight's: 62 KB of records of 106 bytes, and the rest of 2000 is lost, in one place.
    assert!((1300..1500).contains(&read.lost_records), "{}", read.lost_records);
    assert_eq!((read.gaps, read.is_closed), (1, true));
}

proptest! {
    #[test]
    fn no_bytes_make_the_reader_panic(bytes: Vec<u8>, at in any::<usize>(), change in any::<Vec<u8>>(), cut in any::<usize>()) {
        let _ = read(&bytes, None);
        let mut log = flight().1.clone();
        let at = at % log.len();
        log[at..].iter_mut().zip(&change).for_each(|(byte, other)| *byte ^= other);
        log.truncate(cut % log.len());
        let _ = read(&log, None);
    }
}
