//! Edges one by one: polarity, bounces, delays, and the frames they belong to.

use plumbline_core::stamp::{
    Association, Edge, EdgeError, Edges, Exposure, KnownExposure, Polarity, ShutterSettings, StampError, Wired,
};
use plumbline_core::units::Ticks;

const KNOWN: KnownExposure = KnownExposure { us: 5000, sigma_us: 5.0 };
const SHUTTER: ShutterSettings = ShutterSettings {
    wired: Wired::Both,
    opens_on: Polarity::Rising,
    open_delay_us: 30,
    close_delay_us: 10,
    hold_off_us: 100,
    edge_sigma_us: 1.0,
    exposure: Some(KNOWN),
    readout_us: 800,
    arrival_sigma_us: 40.0,
};
/// Just before the timer wraps.
const ORIGIN: u32 = u32::MAX - 100_000;

fn at(us: u32) -> Ticks {
    Ticks(ORIGIN.wrapping_add(us))
}

/// Edges at ticks after the origin, rising where positive; how many were bounces.
fn push(edges: &mut Edges, shutter: &ShutterSettings, list: &[i32]) -> usize {
    let polarity = |us: i32| if us > 0 { Polarity::Rising } else { Polarity::Falling };
    list.iter()
        .filter(|&&us| {
            let edge = Edge { at: at(us.unsigned_abs()), polarity: polarity(us) };
            edges.push(edge, shutter) == Err(EdgeError::Bounce)
        })
        .count()
}

fn both(open: u32, close: u32) -> Result<Association, StampError> {
    Ok(Association::Both(Exposure { open: at(open), close: at(close) }))
}

/// The claim of a frame that arrives 800 us after its shutter closed at `close`.
fn claim(edges: &mut Edges, shutter: &ShutterSettings, close: u32) -> Result<Association, StampError> {
    edges.associate(at(close + 800), shutter)
}

#[test]
fn delays_are_taken_off_and_polarity_decides() {
    let mut edges = Edges::new();
    push(&mut edges, &SHUTTER, &[50_030, -55_010, 300_030, -305_010]);
    assert_eq!(claim(&mut edges, &SHUTTER, 55_000), both(50_000, 55_000));
    assert_eq!(claim(&mut edges, &SHUTTER, 305_000), both(300_000, 305_000), "across the wrap");
    // The same edges by another polarity are no exposures of 5 ms.
    let upside_down = ShutterSettings { opens_on: Polarity::Falling, exposure: None, ..SHUTTER };
    let mut edges = Edges::new();
    push(&mut edges, &upside_down, &[50_030, -55_010, 300_030]);
    assert_ne!(claim(&mut edges, &upside_down, 55_000), both(50_000, 55_000));
}

/// The edge before would be half a frame interval off: what is lost is replaced by the known exposure, or by nothing.
#[test]
fn one_lost_edge_costs_one_edge() {
    for (list, expected) in [
        (&[50_030][..], Association::Opening(at(50_000))),
        (&[-55_010][..], Association::Closing(at(55_000))),
        (&[][..], Association::Neither(at(55_000))),
    ] {
        let mut edges = Edges::new();
        push(&mut edges, &SHUTTER, list);
        assert_eq!(claim(&mut edges, &SHUTTER, 55_000), Ok(expected));
        assert_eq!(expected.exposure(&SHUTTER), Ok(Exposure { open: at(50_000), close: at(55_000) }));
        // The next has its own again.
        push(&mut edges, &SHUTTER, &[300_030, -305_010]);
        assert_eq!(claim(&mut edges, &SHUTTER, 305_000), both(300_000, 305_000));
    }
}

#[test]
fn the_first_of_an_edge_and_its_bounces_counts() {
    let mut edges = Edges::new();
    let bouncing = [50_030, -50_040, 50_055, -50_070, 50_090, -55_010, 55_020, -55_030];
    assert_eq!(push(&mut edges, &SHUTTER, &bouncing), 6);
    assert_eq!(claim(&mut edges, &SHUTTER, 55_000), both(50_000, 55_000));
}

#[test]
fn a_short_pulse_is_no_exposure_and_opens_nothing() {
    let mut edges = Edges::new();
    // Where the opening edge should be, 15 us late, and it is lost; so is the closing one.
    push(&mut edges, &SHUTTER, &[50_045, -50_075]);
    assert_eq!(claim(&mut edges, &SHUTTER, 55_000), Ok(Association::Neither(at(55_000))));
    // Elsewhere, around good edges.
    push(&mut edges, &SHUTTER, &[250_000, -250_050, 300_030, -305_010, 305_200, -305_250]);
    assert_eq!(claim(&mut edges, &SHUTTER, 305_000), both(300_000, 305_000));
}

#[test]
fn strays_within_the_exposure_do_not_count() {
    for stray in [52_000, -52_000, 54_000, -51_000] {
        let mut list: Vec<i32> = vec![50_030, stray, -55_010];
        list.sort_by_key(|us| us.abs());
        let mut edges = Edges::new();
        push(&mut edges, &SHUTTER, &list);
        assert_eq!(claim(&mut edges, &SHUTTER, 55_000), both(50_000, 55_000), "{stray}");
    }
}

/// Frames are lost, edges are not: no frame takes those of one before it, and none is given twice.
#[test]
fn an_exposure_is_given_once_and_to_its_own_frame() {
    let mut edges = Edges::new();
    for frame in 1..=3 {
        push(&mut edges, &SHUTTER, &[frame * 250_000 + 30, -(frame * 250_000 + 5010)]);
    }
    assert_eq!(claim(&mut edges, &SHUTTER, 755_000), both(750_000, 755_000));
    assert_eq!(edges.associate(at(755_900), &SHUTTER), Ok(Association::Neither(at(755_100))), "its edges are gone");
    // Order is kept: an arrival before the last one is none.
    assert_eq!(claim(&mut edges, &SHUTTER, 505_000), Err(StampError::Backwards));
}

/// Two edges of a kind within the gate may both be strays: arrival decides, with its larger sigma.
#[test]
fn what_is_ambiguous_goes_by_arrival() {
    let shutter = ShutterSettings { wired: Wired::Closing, ..SHUTTER };
    let mut edges = Edges::new();
    push(&mut edges, &shutter, &[-54_860, -55_060]);
    let found = claim(&mut edges, &shutter, 55_000).expect("by arrival");
    assert_eq!(found, Association::Neither(at(55_000)));
    assert!(found.variance(&shutter) > Association::Closing(at(55_050)).variance(&shutter));
}

/// More edges than are kept, and edges of long ago, across a wrap.
#[test]
fn old_edges_make_room_and_are_forgotten() {
    let mut edges = Edges::new();
    for frame in 1..=20 {
        push(&mut edges, &SHUTTER, &[frame * 20_000 + 30, -(frame * 20_000 + 5010)]);
    }
    assert_eq!(claim(&mut edges, &SHUTTER, 405_000), both(400_000, 405_000));
    // An edge without a frame, then half an hour and more of silence: the next edge would look older than the last.
    push(&mut edges, &SHUTTER, &[410_030]);
    let later = 405_000u32.wrapping_add(1 << 31);
    assert_eq!(
        edges.push(Edge { at: at(later + 6000), polarity: Polarity::Rising }, &SHUTTER),
        Err(EdgeError::Backwards)
    );
    edges.forget(at(410_030 + 3_000_000));
    assert_eq!(edges.push(Edge { at: at(later + 10_030), polarity: Polarity::Rising }, &SHUTTER), Ok(()));
    assert_eq!(edges.push(Edge { at: at(later + 15_010), polarity: Polarity::Falling }, &SHUTTER), Ok(()));
    assert_eq!(claim(&mut edges, &SHUTTER, later + 15_000), both(later + 10_000, later + 15_000));
}
