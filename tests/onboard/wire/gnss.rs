//! GPS_RAW_INT: its place, and its extension fields.

use super::incoming::SPEAKERS;
use mavlink::dialects::common::{GPS_RAW_INT_DATA, GpsFixType};
use mavlink::{MavlinkVersion, MessageData};
use plumbline_core::tile::Geographic;
use plumbline_firmware::wire::boot_time::BootTime;
use plumbline_firmware::wire::decoder::Packet;
use plumbline_firmware::wire::extensions::GpsRaw;
use plumbline_firmware::wire::incoming::{Gnss, Incoming, Unusable, incoming};
use plumbline_tests::seeded::{Random, config};
use proptest::prelude::{any, prop_assert, proptest};

/// As ArduPilot sends it: 123.456 s, a fix in three dimensions, 48.2 and 16.4 degrees, 300 m; dilutions, speed and course; nine
/// satellites; then the height above the ellipsoid, 345 m, and the accuracies: 1.5 m, 2.5 m, 0.3 m/s; yaw.
fn bytes() -> Vec<u8> {
    let mut bytes = Vec::new();
    bytes.extend(123_456_000u64.to_le_bytes());
    [482_000_000i32, 164_000_000, 300_000].iter().for_each(|field| bytes.extend(field.to_le_bytes()));
    [90u16, 140, 2200, 9000].iter().for_each(|field| bytes.extend(field.to_le_bytes()));
    bytes.extend([3, 9]);
    bytes.extend(345_000i32.to_le_bytes());
    [1500u32, 2500, 300, 0].iter().for_each(|field| bytes.extend(field.to_le_bytes()));
    bytes.extend(0u16.to_le_bytes());
    bytes
}

fn taken(payload: &[u8]) -> Result<Incoming, Unusable> {
    incoming(&Packet { id: GPS_RAW_INT_DATA::ID, system: 1, component: 1, payload, signed: None }, &SPEAKERS)
}

fn place(payload: &[u8]) -> (bool, Option<(Geographic, f32)>) {
    match taken(payload) {
        Ok(Incoming::Gnss(Gnss { is_good, place, .. })) => (is_good, place),
        other => panic!("{other:?}"),
    }
}

const PLACE: Geographic = Geographic { lat_e7: 482_000_000, lon_e7: 164_000_000 };

#[test]
fn a_position_has_its_accuracy_where_the_sender_states_it() {
    let bytes = bytes();
    assert_eq!(bytes.len(), 52);
    let wanted = Gnss { at: BootTime::Micros(123_456_000), is_good: true, place: Some((PLACE, 1.5)) };
    assert_eq!(taken(&bytes), Ok(Incoming::Gnss(wanted)));
    // Without extensions, or with them cut off within the accuracy's bytes: 1500 is 0xDC 0x05.
    assert_eq!(place(&bytes[..30]), (true, Some((PLACE, 5.0))));
    assert_eq!(place(&bytes[..34]), (true, Some((PLACE, 5.0))));
    assert_eq!(place(&bytes[..35]), (true, Some((PLACE, 0.220))));
    let mut most = bytes.clone();
    most[34..38].fill(0xFF);
    assert_eq!(place(&most).1.map(|(_, sigma_m)| sigma_m), Some(4_294_967.3));
}

#[test]
fn what_is_no_position_has_no_place() {
    let with = |at: usize, value: u8| {
        let mut bytes = bytes();
        bytes[at] = value;
        bytes
    };
    const FIX_TYPE: usize = 28;
    for (fix_type, wanted) in [(0, false), (1, false), (2, false), (3, true), (4, true), (6, true), (8, true)] {
        assert_eq!(place(&with(FIX_TYPE, fix_type)), (wanted, wanted.then_some((PLACE, 1.5))), "{fix_type}");
    }
    assert_eq!(taken(&with(FIX_TYPE, 200)), Err(Unusable::Invalid));
    let mut nowhere = bytes();
    nowhere[8..16].fill(0);
    assert_eq!(place(&nowhere), (true, None));
    // As the simulator's other flights send it: a state, and nothing else.
    let state = GPS_RAW_INT_DATA { fix_type: GpsFixType::GPS_FIX_TYPE_3D_FIX, ..GPS_RAW_INT_DATA::DEFAULT };
    let mut payload = [0; 255];
    let length = state.ser(MavlinkVersion::V2, &mut payload);
    assert_eq!(place(&payload[..length]), (true, None));
}

/// Without an accuracy the bytes are those of the base message.
#[test]
fn the_accuracy_is_written_where_it_is_read() {
    let mut base = GPS_RAW_INT_DATA { time_usec: 7, lat: 5, lon: -6, ..GPS_RAW_INT_DATA::DEFAULT };
    for visible in [0, 9] {
        base.satellites_visible = visible;
        for h_acc_mm in [0, 1, 2000, u32::MAX] {
            let (mut plain, mut payload) = ([0xAA; 255], [0xAA; 255]);
            let used = GpsRaw { base: base.clone(), h_acc_mm }.ser(MavlinkVersion::V2, &mut payload);
            let read = GpsRaw::deser(MavlinkVersion::V2, &payload[..used]).expect("it reads");
            assert_eq!((read.h_acc_mm, &read.base), (h_acc_mm, &base));
            if h_acc_mm == 0 {
                let length = base.ser(MavlinkVersion::V2, &mut plain);
                assert_eq!(payload[..used], plain[..length]);
            }
        }
    }
}

proptest! {
    #![proptest_config(config(93, 1000))]

    /// Bytes flipped, cut off or added: a place with a sigma, none, or a refusal.
    #[test]
    fn damaged_positions_are_none_or_have_a_sigma(seed in any::<u64>(), length in 0usize..=255, flips in 0usize..=8) {
        let mut random = Random::new(seed);
        let mut payload = bytes();
        payload.resize(length, 0);
        for _ in 0..flips.min(length) {
            let at = usize::from(random.byte()) % length;
            payload[at] ^= random.byte();
        }
        match taken(&payload) {
            Ok(Incoming::Gnss(gnss)) => {
                prop_assert!(gnss.place.is_none() || gnss.is_good);
                prop_assert!(gnss.place.is_none_or(|(_, sigma_m)| sigma_m > 0.0 && sigma_m.is_finite()));
            }
            other => prop_assert!(other == Err(Unusable::Invalid), "{other:?}"),
        }
    }
}
