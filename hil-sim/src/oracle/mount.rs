//! Paper 001, eq. 4 to 7 in `f64`: where a mounted camera is, where it looks, and the ground point of one of its image
//! points.
//!
//! Axes as in [`super::motion`]: ground X east, Y north, Z up; body and camera x right, y forward, z up; rotations by
//! phi, omega, kappa, ground or body on the left. Lengths are metres.
//!
//! Against the paper: its eq. 5 adds the arm from the antenna to the INS and the one from the antenna to the camera,
//! which counts the first twice; the second must go from the INS to the camera. Its eq. 4 and 7 leave out the scale,
//! which the level ground gives here.

use super::motion::{Exterior, ground_from_image};
use super::rotation::{Matrix3, apply, product};

/// How a camera is mounted.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Mounting {
    /// From the antenna to the INS, along the body's axes.
    pub ins_from_antenna_m: [f64; 3],
    /// From the INS to the projection centre, along the body's axes.
    pub camera_from_ins_m: [f64; 3],
    /// phi, omega, kappa of the camera in the body, radians.
    pub boresight_rad: [f64; 3],
}

impl Mounting {
    /// X_C = X_GPS + R_B^M (r_GPS->INS + r_INS->CAM): the projection centre of a body at phi, omega, kappa whose antenna
    /// is at `antenna_m`.
    pub fn station(&self, antenna_m: [f64; 3], body_rad: [f64; 3]) -> [f64; 3] {
        let arm: [f64; 3] = std::array::from_fn(|axis| self.ins_from_antenna_m[axis] + self.camera_from_ins_m[axis]);
        let turned = apply(&ground_from_image(body_rad), arm);
        std::array::from_fn(|axis| antenna_m[axis] + turned[axis])
    }

    /// R_C^M = R_B^M R_C^B: ground from camera.
    pub fn ground_from_camera(&self, body_rad: [f64; 3]) -> Matrix3 {
        product(&ground_from_image(body_rad), &ground_from_image(self.boresight_rad))
    }

    /// X_P = X_C + lambda R_C^M (x, y, -f): the ground point of an image point on the level plane at height `up_m`, and
    /// lambda; `None` above the horizon.
    pub fn ground(
        &self,
        (antenna_m, body_rad): ([f64; 3], [f64; 3]),
        focal_m: f64,
        [x_m, y_m]: [f64; 2],
        up_m: f64,
    ) -> Option<([f64; 3], f64)> {
        let camera = self.ground_from_camera(body_rad);
        let angles_rad =
            [(-camera[0][2]).atan2(camera[2][2]), (-camera[1][2]).asin(), camera[1][0].atan2(camera[1][1])];
        let exterior = Exterior { station_m: self.station(antenna_m, body_rad), angles_rad };
        let point = exterior.ground(focal_m, [x_m, y_m], up_m)?;
        let ray = apply(&camera, [x_m, y_m, -focal_m]);
        Some((point, (up_m - exterior.station_m[2]) / ray[2]))
    }
}
