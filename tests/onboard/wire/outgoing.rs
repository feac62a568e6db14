//! What we send, read back by the `mavlink` crate, and our own telemetry inside it.

use super::axes::{largest_difference, matrix_of, ned_from_body, product};
use mavlink::dialects::common::{GimbalDeviceFlags, MavMessage, MavType};
use mavlink::{MavlinkVersion, Message, MessageData, calculate_crc};
use plumbline_core::pipeline::{Refusal, Situation};
use plumbline_core::tile::Geographic;
use plumbline_core::tilt::Attitude;
use plumbline_core::units::{Micros, Radians};
use plumbline_firmware::wire::outgoing::{self, CHUNK, COMPONENT, Encoder, SYSTEM};
use plumbline_firmware::wire::telemetry::{
    FixReport, FrameReport, Health, InstantReport, MARK, MatchReport, MotionReport, PlaceReport, PoseReport,
    PositionReport, Risk, SituationReport, StampHealth, StampReport, TUNNEL_BYTES, Telemetry,
};
use plumbline_tests::seeded::{Random, config};
use proptest::prelude::{any, prop_assert, prop_assert_eq, proptest};

/// Encodes, checks the frame by hand, and lets the `mavlink` crate read it.
fn sent<D: MessageData>(encoder: &mut Encoder, sequence: u8, data: &D) -> MavMessage {
    let bytes = encoder.encode(data).to_vec();
    assert_eq!(bytes[..7], [0xFD, (bytes.len() - 12) as u8, 0, 0, sequence, SYSTEM, COMPONENT], "{}", D::NAME);
    let id = u32::from_le_bytes([bytes[7], bytes[8], bytes[9], 0]);
    let end = bytes.len() - 2;
    let crc = calculate_crc(&bytes[1..end], MavMessage::extra_crc(id));
    assert_eq!(bytes[end..], crc.to_le_bytes(), "{}", D::NAME);
    MavMessage::parse(MavlinkVersion::V2, id, &bytes[10..end]).expect("a message of the dialect")
}

fn situation(follow_up: f32) -> Situation {
    Situation::exact(Micros(5_123_456), Attitude::default(), (Radians(follow_up), true), 151.5)
}

const AT: Geographic = Geographic { lat_e7: 481_234_567, lon_e7: -163_000_001 };

#[test]
fn messages_are_what_they_claim() {
    let mut encoder = Encoder::new((SYSTEM, COMPONENT), None);
    let MavMessage::HEARTBEAT(beat) = sent(&mut encoder, 0, &outgoing::heartbeat(true)) else {
        panic!("another message")
    };
    assert_eq!((beat.mavtype, beat.mavlink_version), (MavType::MAV_TYPE_GIMBAL, 3));
    let MavMessage::CAMERA_TRIGGER(trigger) = sent(&mut encoder, 1, &outgoing::camera_trigger(Micros(1 << 40), 7))
    else {
        panic!("another message")
    };
    assert_eq!((trigger.time_usec, trigger.seq), (1 << 40, 7));
    let MavMessage::GIMBAL_DEVICE_SET_ATTITUDE(servo) = sent(&mut encoder, 2, &outgoing::servo(Radians(0.6), SYSTEM))
    else {
        panic!("another message")
    };
    // A follow-up angle to the left is a yaw of -0.6 rad, in the vehicle's frame; the rates are the servo's business.
    assert_eq!(servo.flags, GimbalDeviceFlags::GIMBAL_DEVICE_FLAGS_YAW_IN_VEHICLE_FRAME);
    assert!(largest_difference(&matrix_of(servo.q.map(f64::from)), &ned_from_body(-0.6, 0.0, 0.0)) < 1e-6);
    let rates = [servo.angular_velocity_x, servo.angular_velocity_y, servo.angular_velocity_z];
    assert!(rates.iter().all(|rate| rate.is_nan()), "{rates:?}");
    for (number, message) in
        [(3, outgoing::timesync_request(-5, (1, 1))), (4, outgoing::timesync_answer(1 << 50, 9, (1, 1)))]
    {
        let bytes = encoder.encode(&message).to_vec();
        let long = |at: usize| i64::from_le_bytes(std::array::from_fn(|i| bytes[10 + at + i]));
        let expected = if number == 3 { (0, -5) } else { (1 << 50, 9) };
        assert_eq!((bytes[4], long(0), long(8), &bytes[26..28]), (number, expected.0, expected.1, &[1, 1][..]));
    }
    for number in 5..=255 {
        sent(&mut encoder, number, &outgoing::heartbeat(true));
    }
    sent(&mut encoder, 0, &outgoing::heartbeat(true));
}

#[test]
fn pictures_go_out_in_pieces() {
    let mut encoder = Encoder::new((SYSTEM, COMPONENT), None);
    for (size, packets) in [((34, 34), 5), ((64, 64), 17), ((23, 11), 1), ((22, 23), 2), ((23, 22), 2)] {
        let announcement = outgoing::picture_announcement(size);
        let pixels = u32::from(size.0) * u32::from(size.1);
        assert_eq!(
            (announcement.size, announcement.packets, usize::from(announcement.payload)),
            (pixels, packets, CHUNK)
        );
    }
    let announcement = outgoing::picture_announcement((34, 34));
    let MavMessage::DATA_TRANSMISSION_HANDSHAKE(seen) = sent(&mut encoder, 0, &announcement) else {
        panic!("another message")
    };
    assert_eq!((seen.width, seen.height, seen.jpg_quality), (34, 34, 0));
    for (number, pixels) in [(0u16, vec![7u8; 253]), (4, vec![9; 144]), (5, vec![])] {
        let MavMessage::ENCAPSULATED_DATA(piece) =
            sent(&mut encoder, piece_number(number), &outgoing::picture_piece(number, &pixels))
        else {
            panic!("another message")
        };
        assert_eq!(piece.seqnr, number);
        assert!(piece.data.iter().enumerate().all(|(i, &byte)| byte == pixels.get(i).copied().unwrap_or(0)));
    }
}

/// Sequence of the three pieces above, after the announcement.
fn piece_number(number: u16) -> u8 {
    match number {
        0 => 1,
        4 => 2,
        _ => 3,
    }
}

/// The camera's axes on the ground: the vehicle's attitude, then the gimbal's turn to the right by -β about its down.
#[test]
fn a_picture_is_where_and_how_it_was_taken() {
    let mut random = Random::new(101);
    let mut encoder = Encoder::new((SYSTEM, COMPONENT), None);
    for sequence in 0..50u8 {
        let [heading, pitch, roll, beta] = [3.0, 0.5, 0.5, 3.0].map(|most| random.between(-most, most));
        let [h, p, r] = [heading, pitch, roll].map(|angle| Radians(angle as f32));
        let attitude = Attitude { heading: h, pitch: p, roll: r };
        let message = outgoing::image_captured(&situation(beta as f32), attitude, AT, 40 + u32::from(sequence));
        let MavMessage::CAMERA_IMAGE_CAPTURED(image) = sent(&mut encoder, sequence, &message) else {
            panic!("another message")
        };
        let expected = product(&ned_from_body(heading, pitch, roll), &ned_from_body(-beta, 0.0, 0.0));
        assert!(largest_difference(&matrix_of(image.q.map(f64::from)), &expected) < 2e-6, "{:?}", image.q);
        assert_eq!((image.lat, image.lon, image.relative_alt), (AT.lat_e7, AT.lon_e7, 151_500));
        assert_eq!((image.time_boot_ms, image.image_index), (5123, 40 + i32::from(sequence)));
    }
}

fn match_report(mut float: impl FnMut() -> f32) -> MatchReport {
    let [d_col, d_row, correlation, second_correlation, peak_col, peak_row] = std::array::from_fn(|_| float());
    MatchReport { d_col, d_row, correlation, second_correlation, peak_col, peak_row }
}

fn fix_report(mut float: impl FnMut() -> f32) -> FixReport {
    let [east_m, north_m, variance_east_m2, covariance_m2, variance_north_m2] = std::array::from_fn(|_| float());
    FixReport { east_m, north_m, variance_east_m2, covariance_m2, variance_north_m2 }
}

fn position_report(mut float: impl FnMut() -> f32) -> PositionReport {
    PositionReport { east_m: float(), north_m: float() }
}

fn situation_report(mut float: impl FnMut() -> f32) -> SituationReport {
    let [height_m, heading_rad, pitch_rad, roll_rad, follow_up_rad] = std::array::from_fn(|_| float());
    SituationReport { height_m, heading_rad, pitch_rad, roll_rad, follow_up_rad }
}

/// A report with numbers of all parts, floats taken in the order of the fields.
fn full_report(mut float: impl FnMut() -> f32) -> FrameReport {
    FrameReport {
        matched: Some(match_report(&mut float)),
        fix: Some(fix_report(&mut float)),
        predicted: Some(position_report(&mut float)),
        situation: Some(situation_report(&mut float)),
        ..FrameReport::new(7)
    }
}

/// A report whose every number takes the most bytes.
fn longest_report() -> FrameReport {
    FrameReport {
        sequence: u32::MAX,
        mid_exposure_us: u64::MAX,
        refusal: u8::MAX,
        instructions: [u32::MAX; 6],
        search_px: u8::MAX,
        risk: Risk(u8::MAX),
        ..full_report(|| f32::MIN)
    }
}

/// A ground station that reads the payload by its documented layout: numbers in the order of the fields, floats as their
/// four bytes, little end first.
#[test]
fn a_frame_report_has_its_bytes() {
    let mut next = 0.0;
    let counted = full_report(|| {
        next += 1.0;
        next
    });
    let report = FrameReport {
        mid_exposure_us: 300,
        refusal: 19,
        instructions: [1, 2, 3, 4, 5, 128],
        search_px: 12,
        risk: Risk::new(1e-4),
        ..counted
    };
    let mut expected = vec![b'P', b'L', 0, 7, 0xAC, 0x02, 19];
    let mut first = 1u8;
    // Match, fix, prediction, situation: each behind the byte that says that it is there.
    for floats in [6, 5, 2, 5] {
        expected.push(1);
        expected.extend((first..first + floats).flat_map(|number| f32::from(number).to_le_bytes()));
        first += floats;
    }
    expected.extend([1, 2, 3, 4, 5, 0x80, 0x01, 12, 40]);
    let mut payload = [0; TUNNEL_BYTES];
    let used = Telemetry::Frame(report).encode(&mut payload).expect("it fits");
    assert_eq!(payload[..usize::from(used)], expected);
}

fn longest_health() -> Health {
    const MOST: u32 = u32::MAX;
    Health {
        messages: MOST,
        bad_checksum: MOST,
        unknown_id: MOST,
        incompatible: MOST,
        skipped_bytes: MOST,
        backwards: MOST,
        invalid: MOST,
        foreign: MOST,
        future: MOST,
        overruns: MOST,
        frames_lost: MOST,
        patches_cut: MOST,
        memory: (MOST, MOST),
        delays_us: [MOST; 4],
        stamps: StampHealth {
            edges_bounced: MOST,
            edges_bad: MOST,
            edges_missing: MOST,
            pulses_ignored: MOST,
            ties: MOST,
            free_wheeling_s: MOST,
        },
    }
}

fn longest_instant() -> InstantReport {
    let stamp = StampReport {
        mid_us: u64::MAX,
        halves_us: (u32::MAX, u32::MAX),
        sigma_us: f32::MIN,
        source: u8::MAX,
        by_pulses: true,
        rate_ppm: (f32::MIN, f32::MIN),
        free_wheeling_s: u32::MAX,
    };
    let pose = PoseReport {
        order: 3,
        alpha: f32::MIN,
        samples: [u8::MAX; 3],
        noise: f32::MIN,
        sigma: [f32::MIN; 2],
        rates: [f32::MIN; 3],
        is_position_fitted: true,
        position_sigma_m: f32::MIN,
    };
    let motion =
        MotionReport { max_px: f32::MIN, centre_px: [f32::MIN; 2], exposure_max_us: u32::MAX, warnings: [true; 2] };
    let [east_m, north_m, sigma_east_m, sigma_north_m, protection_m] = [f32::MIN; 5];
    let place = PlaceReport { east_m, north_m, sigma_east_m, sigma_north_m, protection_m };
    InstantReport { sequence: u32::MAX, stamp: Some(stamp), pose: Some(pose), motion: Some(motion), place: Some(place) }
}

#[test]
fn the_longest_telemetry_fits_and_comes_back() {
    let mut encoder = Encoder::new((SYSTEM, COMPONENT), None);
    let longest = [
        Telemetry::Frame(longest_report()),
        Telemetry::Health(longest_health()),
        Telemetry::Instant(longest_instant()),
    ];
    for (sequence, telemetry) in longest.iter().enumerate() {
        let mut payload = [0xEE; TUNNEL_BYTES];
        let used = telemetry.encode(&mut payload).expect("it fits");
        println!("telemetry: {used} of {TUNNEL_BYTES} bytes");
        assert_eq!(payload[..2], MARK);
        assert_eq!(Telemetry::decode(&payload[..usize::from(used)]), Some(*telemetry));
        let MavMessage::TUNNEL(tunnel) = sent(&mut encoder, sequence as u8, &outgoing::tunnel(telemetry)) else {
            panic!("another message")
        };
        assert_eq!(tunnel.payload_length, used);
        assert_eq!(Telemetry::decode(&tunnel.payload[..usize::from(used)]), Some(*telemetry));
        for cut in 0..usize::from(used) {
            assert_eq!(Telemetry::decode(&payload[..cut]), None, "cut after {cut}");
        }
        payload[0] ^= 1;
        assert_eq!(Telemetry::decode(&payload), None, "somebody else's");
    }
}

#[test]
fn every_refusal_has_its_code() {
    for code in 1..=u8::MAX {
        let mut report = FrameReport::new(1);
        report.refusal = code;
        assert_eq!(report.reason().map(Refusal::code), Some(code).filter(|_| report.reason().is_some()));
    }
    assert_eq!(FrameReport::new(1).reason(), None, "an accepted frame");
}

proptest! {
    #![proptest_config(config(103, 1000))]

    /// Bits of floats survive, NaN included; and no payload makes the reader panic.
    #[test]
    fn telemetry_comes_back_bit_for_bit(seed in any::<u64>(), given in any::<[bool; 4]>()) {
        let mut random = Random::new(seed);
        let mut float = || f32::from_bits((random.uniform() * f64::from(u32::MAX)) as u32);
        let mut report = FrameReport::new(seed as u32);
        report.matched = given[0].then(|| match_report(&mut float));
        report.fix = given[1].then(|| fix_report(&mut float));
        report.predicted = given[2].then(|| position_report(&mut float));
        report.situation = given[3].then(|| situation_report(&mut float));
        let mut payload = [0; TUNNEL_BYTES];
        prop_assert!(Telemetry::Frame(report).encode(&mut payload).is_some());
        let Some(Telemetry::Frame(back)) = Telemetry::decode(&payload) else { return Err(proptest::test_runner::TestCaseError::fail("lost")) };
        // The text compares the fields by their names, the bytes the bits of a NaN.
        let mut again = [0; TUNNEL_BYTES];
        prop_assert!(Telemetry::Frame(back).encode(&mut again).is_some());
        prop_assert_eq!(payload, again);
        prop_assert_eq!(format!("{back:?}"), format!("{report:?}"));
        let noise: Vec<u8> = MARK.into_iter().chain((0..126).map(|_| random.byte())).collect();
        let _ = Telemetry::decode(&noise);
    }
}
