//! Image motion during the exposure: blur, and the longest exposure that keeps it small (paper 000).
//!
//! A ground point is seen at q = (Y, −1, X) along (forward, up, right) of the camera: X = m kH across, Y = n kV along.
//! With ω the angular rate of the camera and v its velocity, both on the camera's axes, and d the depth of the point
//! along the optical axis, the point moves past the camera by −ω × d q − v, so that exactly, at any attitude,
//!
//! X' = ωf + ωu Y + X (ωf X − ωr Y) − (vr + X vu)/d
//! Y' = −ωu X − ωr + Y (ωf X − ωr Y) − (vf + Y vu)/d,  1/d = (a22 − a12 Y − a32 X)/H on level ground H below.
//!
//! This is the derivative of the collinearity equations themselves; [`first_order`] is the paper's eq. 21, which is it
//! to first order in the residual angles. Taken at mid-exposure, times the exposure T, it gives the displacement up to
//! T³ x'''/24: below 1e-5 px at 20°/s, 40 m/s, 100 m and 5 ms. The mean of the track, its smear centroid, lies at the
//! point of mid-exposure up to T² x''/24, since the linear part averages to nothing: so an exposure is stamped by its
//! middle.
//!
//! Over a frame the longest displacement lies on the border. Its component along any direction is a quadratic in (X, Y)
//! whose second-order part is (c X + s Y)(α X + β Y), with α = ωf + vu a32/H and β = −ωr + vu a12/H: a product of two
//! linear forms, whose Hessian is never definite. So through every point goes a line along which the component is
//! convex, and on the border that the line meets it is as large. Along a side one of the two components is a parabola;
//! between points that are δ apart in tangents it can rise above them by δ² |α|/4 or δ² |β|/4, and eight points a side
//! leave 0.004 px of 20°/s at 5 ms and 60°.
//!
//! The lens's distortion is left out: the local scale at the border, by which the figure is off, differs from one by
//! 3 k1 r².

pub mod first_order;

use crate::camera::Camera;
use crate::math;
use crate::tilt::{Attitude, camera_from_local};
use crate::units::Radians;
use nalgebra::{Matrix3, Vector3};

/// Blur above this is reported: half a pixel.
pub const BLUR_WARNING_PX: f32 = 0.5;
/// Largest blur by GB/T 27920.1-2011 (Specifications for digital aerial photography, part 1: frame digital aerial
/// photography).
///
/// Paper 000 does not print the figure: it says that its largest image motion, 1.475 px, "meets the standard on frame
/// digital aerial photography of the national specification" (section 1.4, conclusion 3, reference 16). 1.5 px is the
/// bound in use with which that sentence is true; the standard's own text was not at hand, so no decision rests on it.
pub const BLUR_STANDARD_PX: f32 = 1.5;
/// Points on each side of the frame at which the motion is computed, one corner included.
const PER_SIDE: u8 = 8;

/// Why there is no result.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum MotionError {
    /// An angle, a rate or a velocity that is not a finite number.
    NotFinite,
    /// A height that is not above zero.
    Height,
    /// The optical axis is at or above the horizon.
    Tilt,
}

/// Angular rates, radians a second, each of the angle of that name.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Rates {
    /// Of the heading, clockwise.
    pub heading: f32,
    /// Of the pitch, nose up.
    pub pitch: f32,
    /// Of the roll, right wing down.
    pub roll: f32,
    /// Of the camera against the body, counter-clockwise from above.
    pub follow_up: f32,
}

/// Velocity of the vehicle on the grid, metres a second.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Velocity {
    /// To grid north.
    pub north: f32,
    /// Upwards.
    pub up: f32,
    /// To grid east.
    pub east: f32,
}

/// State that determines the image motion, at mid-exposure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moving {
    /// Heading from grid north, pitch, roll.
    pub attitude: Attitude,
    /// Follow-up angle β.
    pub follow_up: Radians,
    /// Their rates.
    pub rates: Rates,
    /// Velocity of the vehicle.
    pub velocity: Velocity,
    /// Height above ground, metres.
    pub height_m: f32,
}

/// Image motion during one exposure.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ImageMotion {
    /// Longest displacement in the frame, pixels: the blur.
    pub max_px: f32,
    /// Its position: (m right, n forward) from the frame's centre, pixels.
    pub at: (f32, f32),
    /// Displacement at the frame's centre, (right, forward) pixels.
    pub centre_px: (f32, f32),
    /// Longest exposure that keeps the blur at half a pixel, microseconds; `u32::MAX` without motion.
    pub exposure_max_us: u32,
}

impl ImageMotion {
    /// Whether the blur is above half a pixel.
    pub fn is_blurred(&self) -> bool {
        self.max_px > BLUR_WARNING_PX
    }

    /// Whether the blur is above [`BLUR_STANDARD_PX`].
    pub fn exceeds_standard(&self) -> bool {
        self.max_px > BLUR_STANDARD_PX
    }
}

/// Velocity of the picture at every point of the image plane.
#[derive(Clone, Copy, Debug)]
pub struct Flow {
    /// Angular rate on the camera's axes (forward, up, right), radians a second.
    rate: Vector3<f32>,
    /// Velocity on the same axes, heights a second.
    velocity: Vector3<f32>,
    /// The local up axis on the camera's: a12, a22, a32.
    up: Vector3<f32>,
    /// Tangents a pixel, across and along, and pixels a tangent.
    k: (f32, f32),
    focal: (f32, f32),
}

impl Flow {
    /// # Errors
    /// [`MotionError`].
    pub fn new(camera: &Camera, moving: &Moving) -> Result<Self, MotionError> {
        let Moving { attitude, follow_up, rates, velocity, height_m } = *moving;
        let numbers = [rates.heading, rates.pitch, rates.roll, rates.follow_up, follow_up.0];
        let speeds = [velocity.north, velocity.up, velocity.east];
        if !numbers.iter().chain(&speeds).all(|number| number.is_finite()) {
            return Err(MotionError::NotFinite);
        }
        if !(height_m > 0.0 && height_m.is_finite()) {
            return Err(MotionError::Height);
        }
        if !attitude.looks_down() {
            return Err(MotionError::Tilt);
        }
        let a = camera_from_local(attitude, follow_up);
        let (k_h, k_v) = camera.tangent_per_px();
        Ok(Flow {
            rate: angular_rate(attitude, follow_up, rates),
            velocity: a * Vector3::new(velocity.north, velocity.up, velocity.east) / height_m,
            up: a * Vector3::new(0.0, 1.0, 0.0),
            k: (k_h, k_v),
            focal: (1.0 / k_h, 1.0 / k_v),
        })
    }

    /// Velocity of the picture at ideal frame position (`m` right, `n` forward of the principal point), pixels a
    /// second.
    ///
    /// Beyond the horizon there is no ground; only the rotation moves the picture there, as the translation's part
    /// vanishes at the horizon.
    pub fn at(&self, m: f32, n: f32) -> (f32, f32) {
        let (x, y) = (m * self.k.0, n * self.k.1);
        let (rate, velocity) = (&self.rate, &self.velocity);
        let nearness = self.up.y - self.up.x * y - self.up.z * x;
        let nearness = if nearness > 0.0 { nearness } else { 0.0 };
        let bend = rate.x * x - rate.z * y;
        let across = rate.x + rate.y * y + x * bend - (velocity.z + x * velocity.y) * nearness;
        let along = -rate.y * x - rate.z + y * bend - (velocity.x + y * velocity.y) * nearness;
        (across * self.focal.0, along * self.focal.1)
    }
}

/// Angular rate of the camera on its own axes (forward, up, right). Each elementary rotation of eq. 1 adds its rate
/// about its axis, rotated by those that follow it: ω = β' eu + RY(β) (γ' ef + RX(γ) (θ' er − φ' RZ(θ) eu)).
pub(crate) fn angular_rate(attitude: Attitude, follow_up: Radians, rates: Rates) -> Vector3<f32> {
    let (sb, cb) = math::sin_cos(follow_up.0);
    let (sg, cg) = math::sin_cos(attitude.roll.0);
    let (st, ct) = math::sin_cos(attitude.pitch.0);
    let turned = Vector3::new(-rates.heading * st, -rates.heading * ct, rates.pitch);
    let by_roll = Matrix3::new(1.0, 0.0, 0.0, 0.0, cg, sg, 0.0, -sg, cg);
    let by_follow_up = Matrix3::new(cb, 0.0, -sb, 0.0, 1.0, 0.0, sb, 0.0, cb);
    let turned = by_follow_up * (by_roll * turned + Vector3::new(rates.roll, 0.0, 0.0));
    turned + Vector3::new(0.0, rates.follow_up, 0.0)
}

/// Blur of an exposure of `exposure_us`: the longest displacement over corners and sides of the frame, which is the
/// longest of all.
///
/// Cost: 32 points of some 40 operations, once a frame; nothing waits for it, so it runs after the fix.
///
/// # Errors
/// [`MotionError`].
pub fn image_motion(camera: &Camera, moving: &Moving, exposure_us: u32) -> Result<ImageMotion, MotionError> {
    let flow = Flow::new(camera, moving)?;
    let (half_cols, half_rows) = (0.5 * camera.cols() as f32, 0.5 * camera.rows() as f32);
    let (offset_m, offset_n) = camera.offset_px();
    let (mut most, mut at) = (0.0f32, (0.0, 0.0));
    for point in 0..4 * PER_SIDE {
        let along = -1.0 + 2.0 * (point / 4) as f32 / PER_SIDE as f32;
        let (right, forward) = match point % 4 {
            0 => (along, 1.0),
            1 => (1.0, -along),
            2 => (-along, -1.0),
            _ => (-1.0, along),
        };
        let (m, n) = (right * half_cols, forward * half_rows);
        let (across, ahead) = flow.at(m - offset_m, n - offset_n);
        let speed2 = across * across + ahead * ahead;
        // A NaN must not be lost.
        if speed2 > most || speed2.is_nan() {
            (most, at) = (speed2, (m, n));
        }
    }
    let (seconds, speed) = (exposure_us as f32 * 1e-6, math::sqrt(most));
    let centre = flow.at(-offset_m, -offset_n);
    if !speed.is_finite() {
        return Err(MotionError::NotFinite);
    }
    Ok(ImageMotion {
        max_px: speed * seconds,
        at,
        centre_px: (centre.0 * seconds, centre.1 * seconds),
        // A cast saturates, of an infinite quotient too.
        exposure_max_us: (BLUR_WARNING_PX * 1e6 / speed) as u32,
    })
}
