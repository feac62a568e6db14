//! Axes, and the only places where they are swapped.
//!
//! | frame | axes | used by |
//! |---|---|---|
//! | ground of the paper | north, up, east | [`crate::tilt`], [`crate::homography`] |
//! | camera of the paper | forward, up, right; the optical axis points down, −up | the same |
//! | MAVLink | body forward-right-down, world north-east-down | the link |
//! | images | col to the right, row downwards, row 0 forward (frame) or north (patch, tile), pixel centres at integers | all |
//!
//! Heading is clockwise from north, pitch nose up, roll right wing down, all positive. The paper turns heading, then
//! pitch, then roll, which is MAVLink's yaw-pitch-roll sequence: the three angles are the same numbers. The follow-up
//! angle β turns the camera about the body's up axis counter-clockwise seen from above, MAVLink's gimbal yaw turns
//! clockwise: β = −yaw.

use crate::math;
use crate::tilt::Attitude;
use crate::units::Radians;

/// Metres of the tile's grid from its centre.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Local {
    /// Grid east.
    pub east_m: f32,
    /// Grid north.
    pub north_m: f32,
}

impl Local {
    /// How far another place is, metres.
    pub fn off_m(self, other: Local) -> f32 {
        let [east_m, north_m] = self.to(other);
        math::hypot(east_m, north_m)
    }

    /// Displacement to another place, east and north, metres.
    pub fn to(self, other: Local) -> [f32; 2] {
        [other.east_m - self.east_m, other.north_m - self.north_m]
    }

    /// The place so many metres east and north of it.
    pub fn moved(self, [east_m, north_m]: [f32; 2]) -> Local {
        Local { east_m: self.east_m + east_m, north_m: self.north_m + north_m }
    }
}

/// Attitude of the body from a MAVLink quaternion `[w, x, y, z]` (world north-east-down from body
/// forward-right-down, Hamilton). The norm may be off by 10 %; `None` for a NaN, an infinity or a norm further off,
/// the zero quaternion included.
pub fn attitude_from_ned_quaternion(q: [f32; 4]) -> Option<Attitude> {
    let [w, x, y, z] = normalised(q)?;
    // Third row and first column of the direction cosine matrix are all that the three angles need.
    let heading = math::atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z));
    let pitch = math::asin(2.0 * (w * y - z * x));
    let roll = math::atan2(2.0 * (w * x + y * z), 1.0 - 2.0 * (x * x + y * y));
    Some(Attitude { heading: Radians(heading), pitch: Radians(pitch), roll: Radians(roll) })
}

/// MAVLink quaternion `[w, x, y, z]` of an attitude; the inverse of [`attitude_from_ned_quaternion`].
pub fn ned_quaternion_from_attitude(attitude: Attitude) -> [f32; 4] {
    let (sy, cy) = math::sin_cos(0.5 * attitude.heading.0);
    let (sp, cp) = math::sin_cos(0.5 * attitude.pitch.0);
    let (sr, cr) = math::sin_cos(0.5 * attitude.roll.0);
    [cr * cp * cy + sr * sp * sy, sr * cp * cy - cr * sp * sy, cr * sp * cy + sr * cp * sy, cr * cp * sy - sr * sp * cy]
}

/// Follow-up angle β from a gimbal quaternion given in the vehicle frame: minus its yaw.
pub fn follow_up_from_gimbal_quaternion(q: [f32; 4]) -> Option<Radians> {
    let [w, x, y, z] = normalised(q)?;
    Some(Radians(-math::atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))))
}

/// Gimbal quaternion in the vehicle frame that commands the follow-up angle β.
pub fn gimbal_quaternion_from_follow_up(follow_up: Radians) -> [f32; 4] {
    let (s, c) = math::sin_cos(-0.5 * follow_up.0);
    [c, 0.0, 0.0, s]
}

fn normalised(q: [f32; 4]) -> Option<[f32; 4]> {
    let norm2 = q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3];
    if !(0.81..=1.21).contains(&norm2) {
        return None;
    }
    let scale = 1.0 / math::sqrt(norm2);
    Some([q[0] * scale, q[1] * scale, q[2] * scale, q[3] * scale])
}

/// Position of pixel (`col`, `row`) relative to the centre of a picture of `cols` x `rows`: (`m` right, `n` forward
/// or north).
pub fn centred(col: f32, row: f32, cols: u16, rows: u16) -> (f32, f32) {
    (col - 0.5 * (cols as f32 - 1.0), 0.5 * (rows as f32 - 1.0) - row)
}

/// Pixel (`col`, `row`) of the centred position (`m` right, `n` forward or north); the inverse of [`centred`].
pub fn pixel(m: f32, n: f32, cols: u16, rows: u16) -> (f32, f32) {
    (m + 0.5 * (cols as f32 - 1.0), 0.5 * (rows as f32 - 1.0) - n)
}
