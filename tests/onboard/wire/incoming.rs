//! From messages to samples, and every trap on the way.

use super::axes::{largest_difference, ned_from_body};
use mavlink::dialects::common::{
    ATTITUDE_QUATERNION_DATA, AUTOPILOT_STATE_FOR_GIMBAL_DEVICE_DATA, COMMAND_ACK_DATA, COMMAND_INT_DATA,
    COMMAND_LONG_DATA, DISTANCE_SENSOR_DATA, GIMBAL_DEVICE_ATTITUDE_STATUS_DATA, GLOBAL_POSITION_INT_DATA,
    GPS_GLOBAL_ORIGIN_DATA, GPS_RAW_INT_DATA, GimbalDeviceFlags, HEARTBEAT_DATA, HIGHRES_IMU_DATA,
    LOCAL_POSITION_NED_DATA, MavAutopilot, MavModeFlag, MavParamType, MavSensorOrientation, PARAM_VALUE_DATA,
    TIMESYNC_DATA,
};
use mavlink::{MavlinkVersion, MessageData};
use plumbline_core::tile::Geographic;
use plumbline_core::units::{Metres, Micros};
use plumbline_firmware::wire::boot_time::BootTime;
use plumbline_firmware::wire::command::{Acknowledgement, Command};
use plumbline_firmware::wire::decoder::Packet;
use plumbline_firmware::wire::incoming::{AutopilotKind, Heartbeat, Incoming, Speakers, Unusable, incoming};
use plumbline_firmware::wire::order::Order;
use plumbline_tests::seeded::{Random, config};
use proptest::prelude::{any, prop_assert, proptest};

const US: (u8, u8) = (1, 154);
const AUTOPILOT: (u8, u8) = (1, 1);
/// All from one sender.
pub(super) const SPEAKERS: Speakers =
    Speakers { us: US, autopilot: AUTOPILOT, range: (AUTOPILOT, None), encoder: AUTOPILOT, ground_station: Some(255) };

/// What the sample of a message with this payload is; trailing zeros are cut off, as on the wire.
fn taken(id: u32, payload: &[u8]) -> Result<Incoming, Unusable> {
    let length = payload.iter().rposition(|&byte| byte != 0).map_or(1, |last| last + 1);
    incoming(&Packet { id, system: 1, component: 1, payload: &payload[..length], signed: None }, &SPEAKERS)
}

fn taken_from<D: MessageData>(data: &D) -> Result<Incoming, Unusable> {
    let mut payload = [0; 255];
    let length = data.ser(MavlinkVersion::V2, &mut payload);
    taken(D::ID, &payload[..length.max(1)])
}

/// Heading 100, pitch -12, roll 7 degrees, north-east-down from forward-right-down, Hamilton, worked out by half angles.
fn quaternion() -> ([f32; 4], [f64; 3]) {
    let angles = [100.0f64, -12.0, 7.0].map(f64::to_radians);
    let [(sy, cy), (sp, cp), (sr, cr)] = angles.map(|angle| (0.5 * angle).sin_cos());
    let q = [
        cr * cp * cy + sr * sp * sy,
        sr * cp * cy - cr * sp * sy,
        cr * sp * cy + sr * cp * sy,
        cr * cp * sy - sr * sp * cy,
    ];
    (q.map(|part| part as f32), angles)
}

#[test]
fn attitudes_come_in_microseconds_or_milliseconds() {
    let (q, angles) = quaternion();
    let fine = AUTOPILOT_STATE_FOR_GIMBAL_DEVICE_DATA { time_boot_us: 5_000_000_123, q, ..Default::default() };
    let [q1, q2, q3, q4] = q;
    let coarse = ATTITUDE_QUATERNION_DATA { time_boot_ms: 4_000_000_001, q1, q2, q3, q4, ..Default::default() };
    let (Ok(Incoming::Attitude(fine_at, a)), Ok(Incoming::Attitude(coarse_at, b))) =
        (taken_from(&fine), taken_from(&coarse))
    else {
        panic!("{:?}, {:?}", taken_from(&fine), taken_from(&coarse))
    };
    assert_eq!((fine_at, coarse_at), (BootTime::Micros(5_000_000_123), BootTime::Millis(4_000_000_001)));
    for attitude in [a, b] {
        let found = ned_from_body(attitude.heading.0.into(), attitude.pitch.0.into(), attitude.roll.0.into());
        assert!(largest_difference(&found, &ned_from_body(angles[0], angles[1], angles[2])) < 1e-6, "{attitude:?}");
    }
}

#[test]
fn attitudes_that_are_no_rotation_are_invalid() {
    for q in [[f32::NAN, 0.0, 0.0, 0.0], [1.0, f32::NAN, 0.0, 0.0], [0.0; 4], [1.0, 1.0, 0.0, 0.0]] {
        let fine = AUTOPILOT_STATE_FOR_GIMBAL_DEVICE_DATA { time_boot_us: 1, q, ..Default::default() };
        let [q1, q2, q3, q4] = q;
        let coarse = ATTITUDE_QUATERNION_DATA { time_boot_ms: 1, q1, q2, q3, q4, ..Default::default() };
        let flags = GimbalDeviceFlags::GIMBAL_DEVICE_FLAGS_YAW_IN_VEHICLE_FRAME;
        let gimbal = GIMBAL_DEVICE_ATTITUDE_STATUS_DATA { time_boot_ms: 1, q, flags, ..Default::default() };
        assert_eq!(taken_from(&fine), Err(Unusable::Invalid), "{q:?}");
        assert_eq!(taken_from(&coarse), Err(Unusable::Invalid), "{q:?}");
        assert_eq!(taken_from(&gimbal), Err(Unusable::Invalid), "{q:?}");
    }
}

/// Only a yaw in the vehicle's frame is the follow-up angle. Senders older than the two frame flags say it by the yaw
/// lock: locked to north, or not.
#[test]
fn a_gimbals_flags_say_what_its_yaw_means() {
    let (vehicle, earth, lock) = (
        GimbalDeviceFlags::GIMBAL_DEVICE_FLAGS_YAW_IN_VEHICLE_FRAME,
        GimbalDeviceFlags::GIMBAL_DEVICE_FLAGS_YAW_IN_EARTH_FRAME,
        GimbalDeviceFlags::GIMBAL_DEVICE_FLAGS_YAW_LOCK,
    );
    // 30 degrees to the right.
    let q = [15f32.to_radians().cos(), 0.0, 0.0, 15f32.to_radians().sin()];
    let with = |flags| {
        taken_from(&GIMBAL_DEVICE_ATTITUDE_STATUS_DATA { time_boot_ms: 70_000, q, flags, ..Default::default() })
    };
    let none = GimbalDeviceFlags::empty();
    for flags in [vehicle, vehicle | lock, none] {
        let Ok(Incoming::FollowUp(at, follow_up)) = with(flags) else { panic!("{:?} for {flags:?}", with(flags)) };
        assert_eq!(at, BootTime::Millis(70_000));
        assert!((follow_up.to_degrees() + 30.0).abs() < 1e-4, "{follow_up:?}");
    }
    for flags in [earth, earth | lock, vehicle | earth, vehicle | earth | lock, lock] {
        assert_eq!(with(flags), Err(Unusable::Invalid), "{flags:?}");
    }
}

/// DISTANCE_SENSOR byte by byte: stamp ms, min, max, current cm, type, id, orientation, covariance; then the extensions
/// horizontal and vertical field, quaternion, quality.
fn distance(limits: (u16, u16), current: u16, orientation: u8, quality: u8) -> Result<Incoming, Unusable> {
    let mut payload = Vec::new();
    payload.extend(123_456u32.to_le_bytes());
    payload.extend([limits.0, limits.1, current].iter().flat_map(|cm| cm.to_le_bytes()));
    payload.extend([0, 3, orientation, 255]);
    payload.extend([0.1f32, 0.1, 1.0, 0.0, 0.0, 0.0].iter().flat_map(|part| part.to_le_bytes()));
    payload.push(quality);
    taken(DISTANCE_SENSOR_DATA::ID, &payload)
}

#[test]
fn distances_and_what_only_looks_like_one() {
    const DOWN: u8 = 25;
    let metres = |cm: f32| Ok(Incoming::Slant(BootTime::Millis(123_456), Metres(cm * 0.01)));
    assert_eq!(distance((20, 20_000), 15_037, DOWN, 0), metres(15_037.0), "quality unknown");
    assert_eq!(distance((20, 20_000), 15_037, DOWN, 100), metres(15_037.0));
    assert_eq!(distance((20, 20_000), 15_037, DOWN, 2), metres(15_037.0));
    assert_eq!(distance((0, 0), 300, DOWN, 50), metres(300.0), "limits not stated");
    assert_eq!(distance((20, 20_000), 20_000, DOWN, 50), metres(20_000.0), "just at the limit");
    let bad = [
        ((20, 20_000), 15_037, 1, "quality 1 is invalid"),
        ((20, 20_000), 0, 50, "nothing measured"),
        ((0, 0), 0, 50, "nothing measured"),
        ((20, u16::MAX), u16::MAX, 50, "65535"),
        ((0, 0), u16::MAX, 50, "65535"),
        ((20, 20_000), 20_001, 50, "beyond the limit"),
        ((20, 20_000), 19, 50, "below the limit"),
    ];
    for (limits, current, quality, why) in bad {
        assert_eq!(distance(limits, current, DOWN, quality), Err(Unusable::Invalid), "{why}");
    }
    // Forward, backward, upwards, to the left; and a number that is no orientation.
    for orientation in [0, 4, 24, 6, 26] {
        assert_eq!(distance((20, 20_000), 15_037, orientation, 50), Err(Unusable::NotOurs), "{orientation}");
    }
    assert!(distance((20, 20_000), 15_037, 99, 50).is_err());
}

#[test]
fn positions_with_their_velocity() {
    let data = GLOBAL_POSITION_INT_DATA {
        time_boot_ms: 90_001,
        lat: 481_234_567,
        lon: -163_000_001,
        vx: 1234,
        vy: -567,
        ..Default::default()
    };
    let Ok(Incoming::Position(at, sample)) = taken_from(&data) else { panic!("{:?}", taken_from(&data)) };
    assert_eq!(at, BootTime::Millis(90_001));
    assert_eq!(sample.position, Geographic { lat_e7: 481_234_567, lon_e7: -163_000_001 });
    assert!((sample.north_m_per_s - 12.34).abs() < 1e-5 && (sample.east_m_per_s + 5.67).abs() < 1e-5, "{sample:?}");
}

/// TIMESYNC byte by byte: tc1, ts1 in ns, then the extensions target system and component.
fn timesync(tc1: i64, ts1: i64, target: (u8, u8)) -> Result<Incoming, Unusable> {
    let payload = [&tc1.to_le_bytes()[..], &ts1.to_le_bytes(), &[target.0, target.1]].concat();
    taken(TIMESYNC_DATA::ID, &payload)
}

#[test]
fn timesync_answers_to_others_are_not_ours() {
    let ours = Ok(Incoming::Timesync { sent_ns: 55, theirs: Micros(7_000_000) });
    assert_eq!(timesync(7_000_000_999, 55, US), ours);
    // ArduPilot's names nobody, and its zeros are cut off.
    assert_eq!(timesync(7_000_000_999, 55, (0, 0)), ours);
    for target in [(1, 1), (2, 154), (255, 190), (154, 1)] {
        assert_eq!(timesync(7_000_000_999, 55, target), Err(Unusable::NotOurs), "{target:?}");
    }
    assert_eq!(timesync(-7_000_000_999, 55, US), Err(Unusable::Invalid), "before boot");
    for target in [US, (0, 0)] {
        assert_eq!(timesync(0, 77, target), Ok(Incoming::TimesyncRequest { theirs_ns: 77 }), "{target:?}");
    }
}

#[test]
fn only_the_autopilots_own_heartbeat_says_whether_it_is_armed() {
    for is_armed in [false, true] {
        let base_mode = if is_armed { MavModeFlag::MAV_MODE_FLAG_SAFETY_ARMED } else { MavModeFlag::empty() };
        let autopilot = MavAutopilot::MAV_AUTOPILOT_ARDUPILOTMEGA;
        let heartbeat = HEARTBEAT_DATA { base_mode, autopilot, ..Default::default() };
        let expected = Heartbeat { kind: AutopilotKind::Ardupilot, is_armed };
        assert_eq!(taken_from(&heartbeat), Ok(Incoming::Heartbeat(expected)));
        let mut payload = [0; 255];
        let length = heartbeat.ser(MavlinkVersion::V2, &mut payload);
        // A ground station's.
        let theirs =
            Packet { id: HEARTBEAT_DATA::ID, system: 1, component: 190, payload: &payload[..length], signed: None };
        assert_eq!(incoming(&theirs, &SPEAKERS), Err(Unusable::NotOurs));
    }
}

/// Each kind of sample has one sender. Any other, of this vehicle or of another, is foreign, whatever it says.
#[test]
fn who_is_not_named_is_not_listened_to() {
    let (laser, encoder) = ((1, 158), (1, 171));
    let speakers = Speakers { us: US, autopilot: AUTOPILOT, range: (laser, Some(3)), encoder, ground_station: None };
    let attitude = ATTITUDE_QUATERNION_DATA { q1: 1.0, ..Default::default() };
    let angle = GIMBAL_DEVICE_ATTITUDE_STATUS_DATA { q: [1.0, 0.0, 0.0, 0.0], ..Default::default() };
    let orientation = MavSensorOrientation::MAV_SENSOR_ROTATION_PITCH_270;
    let distance = |id| DISTANCE_SENSOR_DATA { current_distance: 900, orientation, id, ..Default::default() };
    let position = GLOBAL_POSITION_INT_DATA { lat: 1, lon: 1, ..Default::default() };
    let sync = TIMESYNC_DATA { tc1: 5_000_000, ts1: 9 };
    let is_foreign = |(id, payload): &(u32, Vec<u8>), (system, component): (u8, u8)| {
        let packet = Packet { id: *id, system, component, payload, signed: None };
        incoming(&packet, &speakers).map_or_else(
            |why| {
                assert_eq!(why, Unusable::Foreign);
                true
            },
            |_| false,
        )
    };
    let cases = [
        (payload_of(&attitude), AUTOPILOT),
        (payload_of(&angle), encoder),
        (payload_of(&distance(3)), laser),
        (payload_of(&position), AUTOPILOT),
        (payload_of(&sync), AUTOPILOT),
    ];
    for (message, speaker) in cases {
        for other in [AUTOPILOT, laser, encoder, (1, 190), (2, 1), (255, 190)] {
            assert_eq!(is_foreign(&message, other), other != speaker, "message {} from {other:?}", message.0);
        }
    }
    assert!(is_foreign(&payload_of(&distance(0)), laser), "another sensor of that sender");
}

fn payload_of<D: MessageData>(data: &D) -> (u32, Vec<u8>) {
    let mut payload = [0; 255];
    let length = data.ser(MavlinkVersion::V2, &mut payload);
    (D::ID, payload[..length].to_vec())
}

/// COMMAND_INT: four parameters, latitude, longitude, altitude, command, target, frame.
fn place(sigma_m: f32, (lat_e7, lon_e7): (i32, i32), target: (u8, u8), frame: u8) -> Vec<u8> {
    let mut payload: Vec<u8> = [5.0, 0.1, sigma_m, 0.0].into_iter().flat_map(f32::to_le_bytes).collect();
    payload.extend([lat_e7, lon_e7].into_iter().flat_map(i32::to_le_bytes));
    payload.extend(f32::NAN.to_le_bytes());
    payload.extend(43_003u16.to_le_bytes());
    payload.extend([target.0, target.1, frame]);
    payload
}

#[test]
fn orders_are_a_ground_stations_to_us() {
    let from =
        |id, system, payload: &[u8]| incoming(&Packet { id, system, component: 190, payload, signed: None }, &SPEAKERS);
    let long = |command, first, target| {
        let (id, payload) = payload_of(&Command { command, parameters: [first, 0.0], target });
        (id, payload)
    };
    let (id, two) = long(42_007, 2.0, US);
    assert_eq!(from(id, 255, &two), Ok(Incoming::Ordered(Order::SourceSet(Some(2)), (255, 190))));
    assert_eq!(from(id, 254, &two), Err(Unusable::Foreign));
    for (set, wanted) in [(0.0, None), (1.5, None), (f32::NAN, None), (4.0, None), (3.0, Some(3))] {
        let ordered = from(id, 255, &long(42_007, set, US).1);
        assert_eq!(ordered, Ok(Incoming::Ordered(Order::SourceSet(wanted), (255, 190))), "{set}");
    }
    // The autopilot's and others' commands to a gimbal, and what is for another.
    assert_eq!(from(id, 1, &long(512, 283.0, US).1), Err(Unusable::NotOurs));
    assert_eq!(from(id, 255, &long(42_007, 2.0, AUTOPILOT).1), Err(Unusable::NotOurs));
    let int = COMMAND_INT_DATA::ID;
    let here = (480_000_000, -160_000_000);
    let position = |sigma_m, place: (i32, i32)| {
        let place = Geographic { lat_e7: place.0, lon_e7: place.1 };
        Ok(Incoming::Ordered(Order::Position(Some((place, sigma_m))), (255, 190)))
    };
    assert_eq!(from(int, 255, &place(20.0, here, US, 0)), position(20.0, here));
    assert_eq!(from(int, 255, &place(20.0, here, US, 5)), position(20.0, here));
    let refused = Ok(Incoming::Ordered(Order::Position(None), (255, 190)));
    for bad in [
        place(0.0, here, US, 5),
        place(f32::NAN, here, US, 5),
        place(f32::INFINITY, here, US, 5),
        place(20.0, (0, 0), US, 5),
        place(20.0, (900_000_001, 0), US, 5),
        place(20.0, (1, i32::MIN), US, 5),
        place(20.0, here, US, 3),
    ] {
        assert_eq!(from(int, 255, &bad), refused);
    }
    // In single precision it is a metre coarse.
    assert_eq!(from(id, 255, &place(20.0, here, US, 5)), refused);
}

#[test]
fn acknowledgements_to_others_are_not_ours() {
    let to = |target| taken_from(&Acknowledgement { command: 42_007, result: 2, target });
    assert_eq!((to((0, 0)), to(US)), (Ok(Incoming::Acknowledged(42_007, 2)), Ok(Incoming::Acknowledged(42_007, 2))));
    assert_eq!((to((255, 190)), to((1, 191))), (Err(Unusable::NotOurs), Err(Unusable::NotOurs)));
}

/// PX4 puts an integer's bits into the float, ArduPilot the number.
#[test]
fn parameters_are_numbers_or_bits() {
    let taken = |value, param_type| {
        let name = *b"EKF2_AGP0_CTRL\0\0";
        let data = PARAM_VALUE_DATA { param_value: value, param_id: name.into(), param_type, ..Default::default() };
        let Ok(Incoming::Parameter(parameter)) = taken_from(&data) else { panic!("{:?}", taken_from(&data)) };
        assert!(parameter.is_called("EKF2_AGP0_CTRL") && !parameter.is_called("EKF2_AGP0_CTR"));
        [AutopilotKind::Px4, AutopilotKind::Ardupilot].map(|kind| parameter.number(kind))
    };
    let (int, real) = (MavParamType::MAV_PARAM_TYPE_INT32, MavParamType::MAV_PARAM_TYPE_REAL32);
    assert_eq!(taken(f32::from_bits(7), int)[0], 7.0);
    assert_eq!(taken(f32::from_bits(-7i32 as u32), int)[0], -7.0);
    assert_eq!(taken(6.0, int)[1], 6.0);
    assert_eq!(taken(0.25, real), [0.25, 0.25]);
}

#[test]
fn a_place_that_is_not_known_is_none() {
    assert_eq!(taken_from(&GLOBAL_POSITION_INT_DATA { vx: 5, ..Default::default() }), Err(Unusable::Invalid));
    assert_eq!(taken_from(&GPS_GLOBAL_ORIGIN_DATA { altitude: 5, ..Default::default() }), Err(Unusable::Invalid));
}

#[test]
fn other_messages_are_not_ours() {
    assert_eq!(taken_from(&HIGHRES_IMU_DATA::default()), Err(Unusable::NotOurs));
    assert_eq!(taken(0x00FF_FFFF, &[1, 2, 3]), Err(Unusable::NotOurs));
}

proptest! {
    #![proptest_config(config(92, 1000))]

    /// Any payload of any length under any of our ids: a finite sample or none, never a panic.
    #[test]
    fn any_payload_is_survived(which in 0usize..12, seed in any::<u64>(), length in 0usize..=255) {
        let ids = [
            AUTOPILOT_STATE_FOR_GIMBAL_DEVICE_DATA::ID, ATTITUDE_QUATERNION_DATA::ID, DISTANCE_SENSOR_DATA::ID,
            GIMBAL_DEVICE_ATTITUDE_STATUS_DATA::ID, GLOBAL_POSITION_INT_DATA::ID, TIMESYNC_DATA::ID,
            LOCAL_POSITION_NED_DATA::ID, GPS_GLOBAL_ORIGIN_DATA::ID, GPS_RAW_INT_DATA::ID, COMMAND_ACK_DATA::ID,
            PARAM_VALUE_DATA::ID, HEARTBEAT_DATA::ID,
        ];
        let mut random = Random::new(seed);
        let payload: Vec<u8> = (0..length).map(|_| random.byte()).collect();
        let packet = Packet { id: ids[which], system: 1, component: 1, payload: &payload, signed: None };
        match incoming(&packet, &SPEAKERS) {
            Ok(Incoming::Attitude(_, a)) => {
                prop_assert!([a.heading, a.pitch, a.roll].iter().all(|angle| angle.0.is_finite()));
            }
            Ok(Incoming::FollowUp(_, angle)) => prop_assert!(angle.0.is_finite()),
            Ok(Incoming::Down(_, down_m)) => prop_assert!(down_m.is_finite()),
            Ok(Incoming::Slant(_, slant)) => prop_assert!(slant.0 > 0.0 && slant.0 < 655.35),
            _ => {}
        }
    }

    /// Any order: a set that there is, a place on the earth, or none.
    #[test]
    fn any_order_is_one_that_can_be_meant(is_int in any::<bool>(), is_place in any::<bool>(), seed in any::<u64>(), length in 32usize..=255) {
        let mut random = Random::new(seed);
        let mut payload: Vec<u8> = (0..length).map(|_| random.byte()).collect();
        payload[28..30].copy_from_slice(&if is_place { 43_003u16 } else { 42_007 }.to_le_bytes());
        payload[30..32].copy_from_slice(&[US.0, US.1]);
        if let Some(frame) = payload.get_mut(32) {
            *frame %= 6;
        }
        let id = if is_int { COMMAND_INT_DATA::ID } else { COMMAND_LONG_DATA::ID };
        match incoming(&Packet { id, system: 255, component: 1, payload: &payload, signed: None }, &SPEAKERS) {
            Ok(Incoming::Ordered(Order::SourceSet(set), _)) => prop_assert!(set.is_none_or(|set| (1..=3).contains(&set))),
            Ok(Incoming::Ordered(Order::Position(place), _)) => {
                prop_assert!(is_int || place.is_none());
                if let Some((place, sigma_m)) = place {
                    prop_assert!(sigma_m > 0.0 && sigma_m.is_finite());
                    prop_assert!(place.lat_e7.abs() <= 900_000_000 && place.lon_e7.unsigned_abs() <= 1_800_000_000);
                }
            }
            other => prop_assert!(false, "{other:?}"),
        }
    }
}
