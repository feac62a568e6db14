//! A log that says something else than what was flown is found out.

use super::flown::{flown, scenario};
use plumbline_firmware::log::record::Record;
use plumbline_sim::replay::read::{Item, Log, read};
use plumbline_sim::replay::{Replayed, replay};
use std::sync::LazyLock;

static LOG: LazyLock<Log> = LazyLock::new(|| {
    let (_, bytes) = flown(scenario(11, 12));
    read(&bytes, None).expect("a log")
});

/// The flight replayed with other items in its log.
fn with_items(items: Vec<Item>) -> Replayed {
    replay(&Log { items, ..LOG.clone() }, None).expect("it can be replayed")
}

/// The flight replayed with another item in one place.
fn with(at: usize, item: Item) -> Replayed {
    let mut items = LOG.items.clone();
    items[at] = item;
    with_items(items)
}

/// The first such record behind the first fix.
fn find(wanted: fn(&Record<'_>) -> bool) -> usize {
    let is = |item: &Item, wanted: fn(&Record<'_>) -> bool| match item {
        Item::Record(bytes) => Record::decode(bytes).is_some_and(|record| wanted(&record)),
        Item::Hole => false,
    };
    let from = LOG.items.iter().position(|item| is(item, is_fix)).expect("a fix") + 1;
    from + LOG.items[from..].iter().position(|item| is(item, wanted)).expect("one of them")
}

fn is_fix(record: &Record<'_>) -> bool {
    matches!(record, Record::Frame(report, ..) if report.fix.is_some())
}

/// The record at a place, changed as `change` says.
fn changed(at: usize, change: impl Fn(Record<'_>) -> Option<Record<'_>>) -> Item {
    let Item::Record(bytes) = &LOG.items[at] else { panic!("a hole") };
    let mut buffer = [0; 8192];
    let other = Record::decode(bytes).and_then(change).expect("a record of the kind");
    Item::Record(other.encode(&mut buffer).expect("encoded").to_vec())
}

#[test]
fn an_unchanged_log_replays_without_a_difference() {
    assert_eq!(with_items(LOG.items.clone()).different, 0);
}

/// A closing edge a hundred ticks late: another exposure, another stamp.
#[test]
fn a_late_edge() {
    let at = find(|r| matches!(r, Record::Edge(_, false)));
    let late = changed(at, |r| if let Record::Edge(tick, up) = r { Some(Record::Edge(tick + 100, up)) } else { None });
    assert!(with(at, late).different > 0);
}

#[test]
fn a_bit_in_the_middle_of_a_patch_or_a_shorter_run() {
    let at = find(|r| matches!(r, Record::Patch(..)));
    let Item::Record(mut bytes) = LOG.items[at].clone() else { unreachable!() };
    let middle = bytes.len() / 2;
    bytes[middle] ^= 0x40;
    let found = with(at, Item::Record(bytes));
    assert!(found.different > 0 && found.first_difference.expect("reported").contains("frame"));
    // Runs that are not what the pose says.
    let shorter = changed(at, |r| match r {
        Record::Patch(size, runs, pixels) => Some(Record::Patch((size.0 - 1, size.1), runs, pixels)),
        _ => None,
    });
    assert!(with(at, shorter).different > 0);
}

#[test]
fn a_fix_one_bit_off() {
    let at = find(is_fix);
    let off = changed(at, |r| match r {
        Record::Frame(mut report, instant, fix) => {
            let east = &mut report.fix.as_mut()?.east_m;
            *east = f32::from_bits(east.to_bits() ^ 1);
            Some(Record::Frame(report, instant, fix))
        }
        _ => None,
    });
    let found = with(at, off);
    assert_eq!((found.different, found.same), (1, found.frames - 1));
}

#[test]
fn a_pose_before_its_samples_or_bytes_that_are_missing() {
    // The pose before the samples that it waited for.
    let at = find(|r| matches!(r, Record::Pose(_)));
    let mut items = LOG.items.clone();
    items.swap(at - 1, at);
    assert!(with_items(items).different > 0);
    let at = find(|r| matches!(r, Record::Bytes(..)));
    let mut items = LOG.items.clone();
    items.drain(at..at + 60);
    assert!(with_items(items).different > 0);
}
