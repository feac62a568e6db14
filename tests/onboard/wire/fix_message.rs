//! Fixes in the messages that autopilots take, read back byte by byte, and placed by ArduPilot's own reckoning in `f64`.

use super::axes::{matrix_of, ned_from_body};
use mavlink::dialects::common::{GLOBAL_POSITION_SENSOR_DATA, MavMessage};
use mavlink::{MavlinkVersion, Message, MessageData};
use plumbline_core::tile::Geographic;
use plumbline_core::tilt::Attitude;
use plumbline_core::units::{Micros, Radians};
use plumbline_firmware::wire::fix_message::{Odometry, SentFix, VisionPosition, global_position_sensor, reference};
use plumbline_tests::seeded::Random;

const ORIGIN: Geographic = Geographic { lat_e7: 481_850_000, lon_e7: 163_600_000 };

fn fix(position: Geographic) -> SentFix {
    let [heading, pitch, roll] = [1.9, -0.1, 0.35].map(Radians);
    SentFix {
        at: Micros(78_123_456),
        position,
        variance_m2: [0.4, 1.2],
        largest_m2: 1.5,
        attitude: Attitude { heading, pitch, roll },
        velocity_m_per_s: [21.0, -7.0],
        resets: 3,
    }
}

fn payload<D: MessageData>(message: &D) -> Vec<u8> {
    let mut payload = [0xEE; 255];
    let length = message.ser(MavlinkVersion::V2, &mut payload);
    payload[..length].to_vec()
}

fn float(bytes: &[u8], at: usize) -> f64 {
    f32::from_le_bytes(std::array::from_fn(|i| bytes[at + i])).into()
}

/// `Location::get_distance_NE` of ArduPilot: 0.011131884502145034 m in 1e-7 degrees, east by the cosine of the mean latitude.
fn ardupilot_metres(position: Geographic) -> [f64; 2] {
    let scale = 0.011131884502145034;
    let middle = (0.5e-7 * (f64::from(position.lat_e7) + f64::from(ORIGIN.lat_e7))).to_radians();
    let north = (f64::from(position.lat_e7) - f64::from(ORIGIN.lat_e7)) * scale;
    [north, (f64::from(position.lon_e7) - f64::from(ORIGIN.lon_e7)) * scale * middle.cos()]
}

/// Up to 20 km from the origin a fix lies where ArduPilot would put it, to a centimetre.
#[test]
fn fixes_lie_where_ardupilot_reckons() {
    let mut random = Random::new(111);
    for _ in 0..2000 {
        let [north, east] = [(); 2].map(|()| random.between(-1.8e6, 1.8e6) as i32);
        let position = Geographic { lat_e7: ORIGIN.lat_e7 + north, lon_e7: ORIGIN.lon_e7 + east };
        let found = fix(position).local(ORIGIN).map(f64::from);
        let expected = ardupilot_metres(position);
        let off_m = (found[0] - expected[0]).hypot(found[1] - expected[1]);
        assert!(off_m < 0.01, "{found:?}, {expected:?}");
    }
    // Across the date line, 222.6 m at the equator.
    let (west, east) =
        (Geographic { lat_e7: 0, lon_e7: -1_799_990_000 }, Geographic { lat_e7: 0, lon_e7: 1_799_990_000 });
    assert!((fix(west).local(east)[1] - 222.638).abs() < 0.01, "{:?}", fix(west).local(east));
}

/// What ArduPilot reads of it: frames, quality, and one sigma for each axis, the root of three elements' sum.
#[test]
fn odometry_has_its_bytes() {
    let position = Geographic { lat_e7: ORIGIN.lat_e7 + 9_000, lon_e7: ORIGIN.lon_e7 - 5_000 };
    let bytes = payload(&Odometry::new(&fix(position), ORIGIN, -101.5));
    assert_eq!(bytes.len(), 233);
    assert_eq!(u64::from_le_bytes(std::array::from_fn(|i| bytes[i])), 78_123_456);
    let expected = ardupilot_metres(position);
    assert!((float(&bytes, 8) - expected[0]).abs() < 0.01 && (float(&bytes, 12) - expected[1]).abs() < 0.01);
    assert_eq!(float(&bytes, 16), -101.5, "the autopilot's own height");
    // Attitude; and velocity in the body's axes, which turned back is that of the world.
    let q = std::array::from_fn(|i| float(&bytes, 20 + 4 * i));
    let rotation = matrix_of(q);
    let wanted = ned_from_body(1.9, -0.1, 0.35);
    let v: [f64; 3] = std::array::from_fn(|i| float(&bytes, 36 + 4 * i));
    for (row, (turned, world)) in rotation.iter().zip([21.0, -7.0, 0.0]).enumerate() {
        assert!(turned.iter().zip(&wanted[row]).all(|(a, b)| (a - b).abs() < 1e-6));
        let back: f64 = turned.iter().zip(&v).map(|(r, v)| r * v).sum();
        assert!((back - world).abs() < 1e-4, "{back} for {world}");
    }
    let covariance: Vec<f64> = (0..21).map(|i| float(&bytes, 60 + 4 * i)).collect();
    let used = covariance[0] + covariance[6] + covariance[11];
    assert!((used - 0.8).abs() < 1e-6 && covariance[11] == 0.0, "the mean variance of an axis: {used}");
    assert!((covariance[0] - 0.25 * 1.6).abs() < 1e-6, "a quarter of the trace");
    // MAV_FRAME_LOCAL_FRD, MAV_FRAME_BODY_FRD, reset counter, MAV_ESTIMATOR_TYPE_VISION, quality.
    assert_eq!(bytes[228..], [20, 12, 3, 2, 100]);
    assert_eq!(payload(&Odometry::deser(MavlinkVersion::V2, &bytes).expect("it is read")), bytes);
}

#[test]
fn vision_position_estimate_has_its_bytes() {
    let bytes = payload(&VisionPosition::new(&fix(ORIGIN), ORIGIN, -9.0));
    assert_eq!(bytes.len(), 117);
    assert_eq!([8, 12, 16, 20, 24, 28].map(|at| float(&bytes, at) as f32), [0.0, 0.0, -9.0, 0.35, -0.1, 1.9]);
    let covariance: Vec<f64> = (0..21).map(|i| float(&bytes, 32 + 4 * i)).collect();
    assert!((covariance[0] + covariance[6] + covariance[11] - 0.8).abs() < 1e-6);
    assert_eq!(bytes[116], 3);
    // Without resets the counter is a zero that is cut off, and all before it stands.
    let calm = SentFix { resets: 0, variance_m2: [0.0; 2], ..fix(ORIGIN) };
    assert_eq!(payload(&VisionPosition::new(&calm, ORIGIN, -9.0)).len(), 32);
}

#[test]
fn global_position_sensor_states_its_worse_axis_and_its_age() {
    let position = Geographic { lat_e7: 5, lon_e7: -7 };
    let bytes = payload(&global_position_sensor(&fix(position), Micros(78_158_023), 4));
    let Ok(MavMessage::GLOBAL_POSITION_SENSOR(seen)) =
        MavMessage::parse(MavlinkVersion::V2, GLOBAL_POSITION_SENSOR_DATA::ID, &bytes)
    else {
        panic!("another message")
    };
    assert_eq!((seen.time_usec, seen.processing_time, seen.id), (78_158_023, 34_567, 4));
    assert_eq!((seen.lat, seen.lon), (5, -7));
    assert!((f64::from(seen.eph) - 1.5f64.sqrt()).abs() < 1e-6);
    assert!(seen.alt.is_nan() && seen.alt_ellipsoid.is_nan() && seen.epv.is_nan());
}

#[test]
fn the_reference_is_stamped_when_it_is_sent() {
    let message = reference(Micros(5_000_000_000), [3.0, -4.0]);
    assert_eq!((message.usec, message.x, message.y, message.z), (5_000_000_000, 3.0, -4.0, 0.0));
}
