//! Fixes in the messages that autopilots take, with the extension fields that the `mavlink` crate leaves out.
//!
//! ArduPilot takes ODOMETRY and VISION_POSITION_ESTIMATE: metres north, east and down of the origin of its own estimator. Of
//! the covariance it uses one number for each axis, the root of the sum of the three position variances in the diagonal. PX4
//! takes GLOBAL_POSITION_SENSOR, which stamps its transmission.

use super::extensions::extended;
use mavlink::dialects::common::{
    GLOBAL_POSITION_SENSOR_DATA, GlobalPositionFlags, GlobalPositionSrc, MavFrame, MavMessage, ODOMETRY_DATA,
    VISION_POSITION_ESTIMATE_DATA, VISION_SPEED_ESTIMATE_DATA,
};
use mavlink::error::ParserError;
use mavlink::{MavlinkVersion, MessageData};
use plumbline_core::frames::ned_quaternion_from_attitude;
use plumbline_core::math;
use plumbline_core::tile::Geographic;
use plumbline_core::tilt::Attitude;
use plumbline_core::units::Micros;

/// Metres of latitude in 1e-7 degrees, by ArduPilot's sphere (`LOCATION_SCALING_FACTOR`): what it converts its own positions
/// by, so that a fix is where it should be for it and not on the ellipsoid.
const M_PER_E7: f32 = 0.011_131_884;
/// Quality of an accepted match, per cent: the scale is the sender's own, and what is doubtful is not sent.
const QUALITY: u8 = 100;
/// ODOMETRY.estimator_type, MAV_ESTIMATOR_TYPE_VISION: positions by vision.
const ESTIMATOR_VISION: u8 = 2;
/// Elements of the upper right triangle of a covariance of six that are the variances of x, y and z.
const DIAGONAL: [usize; 3] = [0, 6, 11];

/// A fix as it is sent.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SentFix {
    /// Mid-exposure.
    pub at: Micros,
    /// Where.
    pub position: Geographic,
    /// Variances of east and north in metres squared, enlarged for correlation in time.
    pub variance_m2: [f32; 2],
    /// Largest variance along any axis, enlarged likewise.
    pub largest_m2: f32,
    /// Heading from true north, pitch and roll of the vehicle then.
    pub attitude: Attitude,
    /// Velocity to true north and east, m/s.
    pub velocity_m_per_s: [f32; 2],
    /// A number that changes when the autopilot is to begin anew from this fix.
    pub resets: u8,
}

impl SentFix {
    /// Metres north and east of `origin`, as ArduPilot reckons.
    pub fn local(&self, origin: Geographic) -> [f32; 2] {
        let (lat, lon) = (self.position.lat_e7, self.position.lon_e7);
        let middle = 0.5e-7 * (lat as f32 + origin.lat_e7 as f32);
        let (_, cos) = math::sin_cos(middle * (core::f32::consts::PI / 180.0));
        let north = lat.wrapping_sub(origin.lat_e7) as f32 * M_PER_E7;
        // Across the date line the short way.
        let turn = 3_600_000_000i64;
        let east = (lon as i64 - origin.lon_e7 as i64 + turn / 2).rem_euclid(turn) - turn / 2;
        [north, east as f32 * M_PER_E7 * cos]
    }

    /// ArduPilot's one variance for both axes: their mean.
    fn mean_m2(&self) -> f32 {
        0.5 * (self.variance_m2[0] + self.variance_m2[1])
    }

    /// The covariance of x, y, z and of three angles, such that the sum of the three position variances is that of an axis.
    /// The height's is 0, its NaN would become 50 m for the others.
    fn covariance(&self) -> [f32; 21] {
        let mut covariance = [0.0; 21];
        let [x, y, _] = DIAGONAL;
        for index in [x, y] {
            covariance.get_mut(index).into_iter().for_each(|element| *element = 0.5 * self.mean_m2());
        }
        covariance
    }
}

/// ODOMETRY with its extension.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Odometry {
    /// The base fields.
    pub base: ODOMETRY_DATA,
    /// reset_counter.
    pub resets: u8,
    /// estimator_type.
    pub estimator: u8,
    /// quality.
    pub quality: u8,
}

impl Odometry {
    /// A fix `down_m` below the estimator's `origin`.
    pub fn new(fix: &SentFix, origin: Geographic, down_m: f32) -> Self {
        let [x, y] = fix.local(origin);
        let q = ned_quaternion_from_attitude(fix.attitude);
        // To the body's axes: what takes them turns them back by q.
        let [vx, vy, vz] = into_body(q, [fix.velocity_m_per_s[0], fix.velocity_m_per_s[1], 0.0]);
        Odometry {
            base: ODOMETRY_DATA {
                time_usec: fix.at.0,
                x,
                y,
                z: down_m,
                q,
                vx,
                vy,
                vz,
                rollspeed: f32::NAN,
                pitchspeed: f32::NAN,
                yawspeed: f32::NAN,
                pose_covariance: fix.covariance(),
                velocity_covariance: [f32::NAN; 21],
                frame_id: MavFrame::MAV_FRAME_LOCAL_FRD,
                child_frame_id: MavFrame::MAV_FRAME_BODY_FRD,
            },
            resets: fix.resets,
            estimator: ESTIMATOR_VISION,
            quality: QUALITY,
        }
    }
}

/// A vector of the world in the axes of a body whose quaternion turns body into world: v + 2 (w u + u × ...) with −u.
fn into_body([w, x, y, z]: [f32; 4], v: [f32; 3]) -> [f32; 3] {
    let cross =
        |a: [f32; 3], b: [f32; 3]| [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
    let u = [-x, -y, -z];
    let t = cross(u, v).map(|part| 2.0 * part);
    let tt = cross(u, t);
    core::array::from_fn(|i| match (v.get(i), t.get(i), tt.get(i)) {
        (Some(v), Some(t), Some(tt)) => v + w * t + tt,
        _ => 0.0,
    })
}

impl MessageData for Odometry {
    type Message = MavMessage;

    const ID: u32 = ODOMETRY_DATA::ID;
    const NAME: &'static str = ODOMETRY_DATA::NAME;
    const EXTRA_CRC: u8 = ODOMETRY_DATA::EXTRA_CRC;
    const ENCODED_LEN: usize = ODOMETRY_DATA::ENCODED_LEN + 3;

    fn ser(&self, version: MavlinkVersion, payload: &mut [u8]) -> usize {
        let used = self.base.ser(version, payload);
        extended(payload, used, ODOMETRY_DATA::ENCODED_LEN, [self.resets, self.estimator, self.quality])
    }

    fn deser(version: MavlinkVersion, payload: &[u8]) -> Result<Self, ParserError> {
        let byte = |at: usize| payload.get(ODOMETRY_DATA::ENCODED_LEN + at).copied().unwrap_or(0);
        let base = ODOMETRY_DATA::deser(version, payload)?;
        Ok(Odometry { base, resets: byte(0), estimator: byte(1), quality: byte(2) })
    }
}

/// VISION_POSITION_ESTIMATE with its extension.
#[derive(Clone, Debug, PartialEq)]
pub struct VisionPosition {
    /// The base fields.
    pub base: VISION_POSITION_ESTIMATE_DATA,
    /// covariance.
    pub covariance: [f32; 21],
    /// reset_counter.
    pub resets: u8,
}

impl Default for VisionPosition {
    fn default() -> Self {
        VisionPosition { base: VISION_POSITION_ESTIMATE_DATA::DEFAULT, covariance: [0.0; 21], resets: 0 }
    }
}

impl VisionPosition {
    /// A fix `down_m` below the estimator's `origin`.
    pub fn new(fix: &SentFix, origin: Geographic, down_m: f32) -> Self {
        let [x, y] = fix.local(origin);
        let Attitude { heading, pitch, roll } = fix.attitude;
        VisionPosition {
            base: VISION_POSITION_ESTIMATE_DATA {
                usec: fix.at.0,
                x,
                y,
                z: down_m,
                roll: roll.0,
                pitch: pitch.0,
                yaw: heading.0,
            },
            covariance: fix.covariance(),
            resets: fix.resets,
        }
    }
}

impl MessageData for VisionPosition {
    type Message = MavMessage;

    const ID: u32 = VISION_POSITION_ESTIMATE_DATA::ID;
    const NAME: &'static str = VISION_POSITION_ESTIMATE_DATA::NAME;
    const EXTRA_CRC: u8 = VISION_POSITION_ESTIMATE_DATA::EXTRA_CRC;
    const ENCODED_LEN: usize = VISION_POSITION_ESTIMATE_DATA::ENCODED_LEN + 85;

    fn ser(&self, version: MavlinkVersion, payload: &mut [u8]) -> usize {
        let used = self.base.ser(version, payload);
        let covariance = self.covariance.map(f32::to_le_bytes);
        let mut bytes = [0; 85];
        let from = covariance.as_flattened().iter().copied().chain([self.resets]);
        bytes.iter_mut().zip(from).for_each(|(to, from)| *to = from);
        extended(payload, used, VISION_POSITION_ESTIMATE_DATA::ENCODED_LEN, bytes)
    }

    fn deser(version: MavlinkVersion, payload: &[u8]) -> Result<Self, ParserError> {
        let byte = |at: usize| payload.get(VISION_POSITION_ESTIMATE_DATA::ENCODED_LEN + at).copied().unwrap_or(0);
        let float = |at: usize| f32::from_le_bytes([byte(at), byte(at + 1), byte(at + 2), byte(at + 3)]);
        let base = VISION_POSITION_ESTIMATE_DATA::deser(version, payload)?;
        Ok(VisionPosition { base, covariance: core::array::from_fn(|i| float(4 * i)), resets: byte(84) })
    }
}

/// VISION_SPEED_ESTIMATE of the autopilot's own velocity, stamped at its transmission. ArduPilot estimates the smallest
/// latency of a link from the stamps on it, and takes that off all of them: without a message that is new, that of a fix, a
/// hundred milliseconds of age, would be taken for the link's. It ignores the velocity unless it is told to use it.
pub fn reference(now: Micros, [north, east]: [f32; 2]) -> VISION_SPEED_ESTIMATE_DATA {
    VISION_SPEED_ESTIMATE_DATA { usec: now.0, x: north, y: east, z: 0.0 }
}

/// GLOBAL_POSITION_SENSOR: `eph` is one sigma along the worse axis. The message stamps its transmission; the exposure lies
/// `processing_time` before. No altitude is claimed: it is the range finder's business. `id` is at least 1, 0 is dropped.
pub fn global_position_sensor(fix: &SentFix, now: Micros, id: u8) -> GLOBAL_POSITION_SENSOR_DATA {
    GLOBAL_POSITION_SENSOR_DATA {
        time_usec: now.0,
        processing_time: now.since(fix.at).max(0) as u32,
        lat: fix.position.lat_e7,
        lon: fix.position.lon_e7,
        alt_ellipsoid: f32::NAN,
        alt: f32::NAN,
        eph: math::sqrt(fix.largest_m2),
        epv: f32::NAN,
        target_system: 0,
        target_component: 0,
        id,
        source: GlobalPositionSrc::GLOBAL_POSITION_SRC_VISION,
        flags: GlobalPositionFlags::empty(),
    }
}
