//! Mount of the camera in the vehicle: lever arm and boresight (paper 001, eq. 4 to 7, corrected).
//!
//! X_C = X_GPS + R_B^M (r_GPS→INS + r_INS→CAM) and R_C^M = R_B^M R_C^B. The paper prints GPS→CAM for the second arm,
//! which would count the first one twice, and omits the scale in its (4) and (7), which the ground plane gives here.

use crate::tilt::{Attitude, camera_from_local};
use crate::units::Radians;
use nalgebra::{Matrix3, Vector3};

/// From the point that positions refer to, usually the antenna, to the camera's projection centre, along the body's
/// axes: the sum of both of the paper's arms. Metres.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct LeverArm {
    /// Towards the nose.
    pub forward_m: f32,
    /// Towards the right wing.
    pub right_m: f32,
    /// Towards the belly.
    pub down_m: f32,
}

/// Pitch or roll of a boresight above which the camera is an oblique head (paper 002) rather than one meant to look
/// along its mount's axis: 11.5 degrees.
const LEAN_RAD: f32 = 0.2;

/// Position and rotation of the camera in the vehicle. A head of a combined camera is mounted as any camera is: its
/// rotation and the platform's boresight are one rotation, applied in the homography once a frame.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Mount {
    /// Its position.
    pub lever_arm: LeverArm,
    /// Its rotation against the mount's axes, in the same three angles as an attitude.
    pub boresight: Attitude,
}

impl Mount {
    /// Whether the camera has no boresight rotation.
    pub(crate) fn is_aligned(&self) -> bool {
        self.boresight == Attitude::default()
    }

    /// Whether the camera is oblique, so that its footprint lies off the nadir.
    pub(crate) fn looks_aside(&self) -> bool {
        self.boresight.pitch.0.abs() > LEAN_RAD || self.boresight.roll.0.abs() > LEAN_RAD
    }

    /// The rotation of eq. 1 with the boresight on the camera's side: camera from mount, times mount from local.
    pub fn camera_from_local(&self, attitude: Attitude, follow_up: Radians) -> Matrix3<f32> {
        let mount_from_local = camera_from_local(attitude, follow_up);
        if self.is_aligned() {
            return mount_from_local;
        }
        camera_from_local(self.boresight, Radians(0.0)) * mount_from_local
    }

    /// The camera's position relative to the point that positions refer to, `[north, up, east]` metres.
    pub fn camera_offset(&self, attitude: Attitude) -> [f32; 3] {
        let LeverArm { forward_m, right_m, down_m } = self.lever_arm;
        if self.lever_arm == LeverArm::default() {
            return [0.0; 3];
        }
        let local_from_body = camera_from_local(attitude, Radians(0.0)).transpose();
        (local_from_body * Vector3::new(forward_m, -down_m, right_m)).into()
    }
}
