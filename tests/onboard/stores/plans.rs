//! The plan store.

use super::{flash, framed, stores};
use plumbline_core::exposure::{Limits, Planned};
use plumbline_core::tile::Local;
use plumbline_firmware::boot::{self, BootError};
use plumbline_firmware::stores::framing::HEADER_BYTES;
use plumbline_firmware::stores::plan::{before, entry, read};
use plumbline_firmware::stores::{StoreError, configuration};
use plumbline_sim::link::inproc::InProcess;
use plumbline_sim::link::{Event, Link};

const LIMITS: Limits = Limits { interval_us: 1_500_000, across_m: 12.5 };

/// The store of strips (first photo, course) and photos (latitude, longitude, 1e-7 degrees).
fn store(limits: Limits, strips: &[(u32, f32)], photos: &[(i32, i32)]) -> Vec<u8> {
    let strips: Vec<u8> = strips.iter().flat_map(|&(first, course)| entry(first, course.to_bits())).collect();
    let photos: Vec<u8> = photos.iter().flat_map(|&(lat, lon)| entry(lat as u32, lon as u32)).collect();
    [&before(limits, &strips, &photos)[..], &strips, &photos].concat()
}

/// Five photos in two strips about the tile of the default scene, 100 units of 1e-7 degrees apart.
fn photos() -> Vec<(i32, i32)> {
    let centre = flash().head.georeference.centre;
    (0..5).map(|n| (centre.lat_e7 + 100 * n, centre.lon_e7 - 100 * n)).collect()
}

fn good() -> Vec<u8> {
    store(LIMITS, &[(0, 1.5), (3, -1.5)], &photos())
}

/// What a boot says to a plan beside good stores.
fn booted(plan: &[u8]) -> Result<bool, BootError> {
    let stores = stores();
    boot::read(&stores.configuration, &stores.tiles, plan).map(|flight| flight.plan.is_some())
}

#[test]
fn a_plan_store_is_these_bytes() {
    // Written down by hand from the table in `stores::plan`.
    let store = store(LIMITS, &[(0, 1.5), (1, -1.5)], &[(481_850_000, -5), (-1, 163_690_000)]);
    let mut payload = vec![0x60, 0xe3, 0x16, 0, 0, 0, 0x48, 0x41, 2, 0, 0, 0, 2, 0, 0, 0];
    payload.extend([0, 0, 0, 0, 0, 0, 0xc0, 0x3f, 1, 0, 0, 0, 0, 0, 0xc0, 0xbf]);
    payload.extend([0x90, 0x72, 0xb8, 0x1c, 0xfb, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0x10, 0xb6, 0xc1, 0x09]);
    assert_eq!(store[HEADER_BYTES..], payload);
    assert_eq!(store, framed(b"PLBP", 1, &payload));
}

#[test]
fn what_was_written_is_read() {
    let region = [good(), vec![0xff; 50]].concat();
    let plan = read(&region).expect("it is read").expect("a plan");
    assert_eq!((plan.limits(), plan.photos()), (LIMITS, 5));
    let georeference = flash().head.georeference;
    let on_grid = plan.on(&georeference);
    let strips = [0, 1].map(|number| on_grid.strip(number).expect("a strip"));
    assert_eq!(strips.map(|strip| (strip.first, strip.end)), [(0, 3), (3, 5)]);
    assert!((strips[0].course.0 - 1.5 + georeference.convergence.0).abs() < 1e-6);
    assert_eq!((on_grid.strip(2), on_grid.point(5)), (None, None));
    // The first lies at the tile's centre, the others a metre north and 0.7 m west of each other.
    assert_eq!(on_grid.point(0), Some(Local { east_m: 0.0, north_m: 0.0 }));
    let last = on_grid.point(4).expect("a place");
    assert!((last.north_m - 4.0 * 1.112).abs() < 0.1 && (last.east_m + 4.0 * 0.743).abs() < 0.1, "{last:?}");
}

#[test]
fn nothing_is_no_plan_and_all_else_is_refused_for_what_it_is() {
    assert_eq!(booted(&good()), Ok(true));
    for nothing in [vec![], vec![0xff; 4096], vec![0; 4096]] {
        assert_eq!(booted(&nothing), Ok(false));
    }
    let refused = |plan: &[u8]| match booted(plan) {
        Err(BootError::Plan(why)) => why,
        other => panic!("{other:?}"),
    };
    let plan = good();
    assert_eq!(refused(&plan[..20]), StoreError::Nothing);
    assert_eq!(refused(&plan[..plan.len() - 1]), StoreError::Length);
    assert_eq!(refused(&stores().configuration), StoreError::Magic);
    assert_eq!(refused(&framed(b"PLBP", 2, &plan[HEADER_BYTES..])), StoreError::Version);
    for bit in 0..8 * plan.len() {
        let mut bad = plan.clone();
        bad[bit / 8] ^= 1 << (bit % 8);
        let why = match bit / 8 {
            0..4 => StoreError::Magic,
            4..HEADER_BYTES => StoreError::Header,
            _ => StoreError::Payload,
        };
        assert_eq!(refused(&bad), why, "bit {bit}");
    }
    // Whole, and of another length than its counts say.
    let payload = &plan[HEADER_BYTES..];
    for bad in [&payload[..10], &payload[..payload.len() - 8], &[payload, &[0; 8]].concat(), &[payload, &[0]].concat()]
    {
        assert_eq!(refused(&framed(b"PLBP", 1, bad)), StoreError::Encoding);
    }
    // And with content that cannot be flown.
    let all = photos();
    let bad = [
        store(LIMITS, &[], &all),
        store(LIMITS, &[(0, 0.0)], &[]),
        store(LIMITS, &[(1, 0.0)], &all),
        store(LIMITS, &[(0, 0.0), (0, 0.0)], &all),
        store(LIMITS, &[(0, 0.0), (3, 0.0), (2, 0.0)], &all),
        store(LIMITS, &[(0, 0.0), (5, 0.0)], &all),
        store(LIMITS, &[(0, f32::NAN)], &all),
        store(LIMITS, &[(0, 10.0)], &all),
        store(Limits { across_m: f32::NAN, ..LIMITS }, &[(0, 0.0)], &all),
        store(Limits { across_m: -1.0, ..LIMITS }, &[(0, 0.0)], &all),
        store(Limits { interval_us: u32::MAX, ..LIMITS }, &[(0, 0.0)], &all),
        store(LIMITS, &[(0, 0.0)], &[(900_000_001, 0)]),
        store(LIMITS, &[(0, 0.0)], &[(0, i32::MIN)]),
    ];
    for (number, bad) in bad.iter().enumerate() {
        assert_eq!(refused(bad), StoreError::Plan, "{number}");
    }
    // Good, and on the other side of the country.
    let far = [(all[0].0, all[0].1), (all[0].0 + 6_000_000, all[0].1)];
    assert_eq!(booted(&store(LIMITS, &[(0, 0.0)], &far)), Err(BootError::Astray));
}

#[test]
fn a_vehicle_whose_plan_was_refused_stays_on_the_ground_and_says_why() {
    let mut bad = stores();
    bad.plan = good();
    bad.plan[HEADER_BYTES + 3] ^= 1;
    let mut link = InProcess::boot(&bad, false);
    let sent = link.step(1_000_000, Event::Nothing).expect("it lives");
    let reason = b"no fixes: plan store: content damaged";
    assert!(sent.windows(reason.len()).any(|window| window == reason));
    // The configuration alone is what it was.
    assert!(configuration::read(&bad.configuration).is_ok());
}
