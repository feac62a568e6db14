//! A log that says something else than what was flown is found out.

use super::flown::{flown, scenario};
use plumbline_firmware::log::record::Record;
use plumbline_sim::replay::read::{Item, Log, read};
use plumbline_sim::replay::{Replayed, replay};

fn log() -> Log {
    let (_, bytes) = flown(scenario(11, 12));
    read(&bytes, None).expect("a log")
}

fn run(log: &Log, items: Vec<Item>) -> Replayed {
    replay(&Log { items, ..log.clone() }, None).expect("it can be replayed")
}

/// The record, changed where `change` gives another.
fn changed(item: &Item, change: impl Fn(Record<'_>) -> Option<Record<'_>>) -> Option<Item> {
    let Item::Record(bytes) = item else { return None };
    let mut buffer = [0; 8192];
    let other = change(Record::decode(bytes)?)?;
    Some(Item::Record(other.encode(&mut buffer)?.to_vec()))
}

#[test]
fn a_tick_a_bit_or_the_order() {
    let log = log();
    assert_eq!(run(&log, log.items.clone()).different, 0);
    let is = |item: &Item, wanted: fn(&Record<'_>) -> bool| match item {
        Item::Record(bytes) => Record::decode(bytes).is_some_and(|record| wanted(&record)),
        Item::Hole => false,
    };
    // Behind the first fix, before the last frame.
    let place = |wanted: fn(&Record<'_>) -> bool| {
        let fix = log
            .items
            .iter()
            .position(|item| is(item, |r| matches!(r, Record::Frame(report, ..) if report.fix.is_some())));
        let from = fix.expect("a fix") + 1;
        from + log.items[from..].iter().position(|item| is(item, wanted)).expect("one of them")
    };
    let with = |at: usize, item: Item| {
        let mut items = log.items.clone();
        items[at] = item;
        run(&log, items)
    };
    // A closing edge a hundred ticks late: another exposure, another stamp.
    let at = place(|r| matches!(r, Record::Edge(_, false)));
    let late =
        changed(
            &log.items[at],
            |r| if let Record::Edge(tick, up) = r { Some(Record::Edge(tick + 100, up)) } else { None },
        );
    assert!(with(at, late.expect("an edge")).different > 0);
    // A bit of a pixel in the middle of a patch.
    let at = place(|r| matches!(r, Record::Patch(..)));
    let Item::Record(mut bytes) = log.items[at].clone() else { unreachable!() };
    let middle = bytes.len() / 2;
    bytes[middle] ^= 0x40;
    let found = with(at, Item::Record(bytes));
    assert!(found.different > 0 && found.first_difference.expect("told").contains("frame"));
    // A run that is not what the pose says.
    let shorter = changed(&log.items[at], |r| match r {
        Record::Patch(size, runs, pixels) => Some(Record::Patch((size.0 - 1, size.1), runs, pixels)),
        _ => None,
    });
    assert!(with(at, shorter.expect("a patch")).different > 0);
    // A fix one bit off.
    let at = place(|r| matches!(r, Record::Frame(report, ..) if report.fix.is_some()));
    let off = changed(&log.items[at], |r| match r {
        Record::Frame(mut report, instant, fix) => {
            let east = &mut report.fix.as_mut()?.east_m;
            *east = f32::from_bits(east.to_bits() ^ 1);
            Some(Record::Frame(report, instant, fix))
        }
        _ => None,
    });
    let found = with(at, off.expect("a fix"));
    assert_eq!((found.different, found.same), (1, found.frames - 1));
    // The pose before the samples that it waited for.
    let at = place(|r| matches!(r, Record::Pose(_)));
    let mut items = log.items.clone();
    items.swap(at - 1, at);
    assert!(run(&log, items).different > 0);
    // Bytes that are not there.
    let at = place(|r| matches!(r, Record::Bytes(..)));
    let mut items = log.items.clone();
    items.drain(at..at + 60);
    assert!(run(&log, items).different > 0);
}
