//! Heading, pitch, roll and the follow-up angle: the rotation of eq. 1, the servo's command, and the equivalent pitch
//! and roll of eq. 5 in exact form.

use crate::math;
use crate::units::Radians;
use core::f32::consts::FRAC_PI_2;
use nalgebra::Matrix3;

/// Attitude of the vehicle relative to the local north-up-east frame.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Attitude {
    /// φ, clockwise from north.
    pub heading: Radians,
    /// θ, nose up.
    pub pitch: Radians,
    /// γ, right wing down.
    pub roll: Radians,
}

/// Residual tilt of a camera that follows: eq. 5's θ1 and γ1.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct EquivalentTilt {
    /// θ1.
    pub pitch: Radians,
    /// γ1.
    pub roll: Radians,
}

impl Attitude {
    /// Whether every angle is a finite number and the optical axis points below the horizon.
    pub fn looks_down(&self) -> bool {
        let finite = self.heading.0.is_finite() && self.pitch.0.is_finite() && self.roll.0.is_finite();
        // a22 > 0 alone would accept a vehicle that is upside down twice over.
        finite && self.pitch.wrapped().0.abs() < FRAC_PI_2 && self.roll.wrapped().0.abs() < FRAC_PI_2
    }

    /// a22 = cos θ cos γ, the cosine of the angle between the optical axis and the plumb line, whatever heading and
    /// follow-up. A strapped-down range finder's slant times a22 is the height above ground.
    pub fn cos_tilt(&self) -> f32 {
        math::sin_cos(self.pitch.0).1 * math::sin_cos(self.roll.0).1
    }

    /// With known errors of heading, pitch and roll subtracted, radians.
    #[must_use]
    pub fn corrected_by(self, [heading, pitch, roll]: [f32; 3]) -> Self {
        Attitude {
            heading: Radians(self.heading.0 - heading).wrapped(),
            pitch: Radians(self.pitch.0 - pitch),
            roll: Radians(self.roll.0 - roll),
        }
    }

    /// Direction of the optical axis, whatever the follow-up: the components of its unit vector to the east and to the
    /// north, −a23 and −a21. The third, downwards, is [`Attitude::cos_tilt`].
    pub fn axis(&self) -> [f32; 2] {
        let (sg, cg) = math::sin_cos(self.roll.0);
        let (st, _) = math::sin_cos(self.pitch.0);
        let (sp, cp) = math::sin_cos(self.heading.0);
        [cg * st * sp - sg * cp, cg * st * cp + sg * sp]
    }
}

/// A = RY(β) RX(γ) RZ(θ) RY'(φ), `camera_from_local`, rows and columns north/forward, up, east/right (eq. 1).
///
/// The paper prints the second matrix with θ; it must be γ, or roll would not occur. φ turns clockwise and β
/// counter-clockwise about the same axis, so their opposite signs in eq. 1 are right.
pub fn camera_from_local(attitude: Attitude, follow_up: Radians) -> Matrix3<f32> {
    let (sb, cb) = math::sin_cos(follow_up.0);
    let (sg, cg) = math::sin_cos(attitude.roll.0);
    let (st, ct) = math::sin_cos(attitude.pitch.0);
    let (sp, cp) = math::sin_cos(attitude.heading.0);
    let (mut forward, mut up, mut right) = ([cp, 0.0, sp], [0.0, 1.0, 0.0], [-sp, 0.0, cp]);
    turn(&mut forward, &mut up, (st, ct));
    turn(&mut up, &mut right, (sg, cg));
    turn(&mut forward, &mut right, (-sb, cb));
    let ([a11, a12, a13], [a21, a22, a23], [a31, a32, a33]) = (forward, up, right);
    Matrix3::new(a11, a12, a13, a21, a22, a23, a31, a32, a33)
}

/// An elementary rotation from the left: rows (a, b) become (c a + s b, c b - s a).
#[inline(never)]
fn turn(a: &mut [f32; 3], b: &mut [f32; 3], (s, c): (f32, f32)) {
    for (a, b) in a.iter_mut().zip(b) {
        (*a, *b) = (c * *a + s * *b, c * *b - s * *a);
    }
}

/// The follow-up angle that makes a13 = 0 with a11 > 0: the servo's exact command, β = atan2(cos θ sin φ,
/// cos γ cos φ + sin γ sin θ sin φ). β ≈ φ is off by up to 1.7° at ±10° of tilt, 17 px at the corner of a frame.
pub fn follow_up_command(attitude: Attitude) -> Radians {
    let (sg, cg) = math::sin_cos(attitude.roll.0);
    let (st, ct) = math::sin_cos(attitude.pitch.0);
    let (sp, cp) = math::sin_cos(attitude.heading.0);
    Radians(math::atan2(ct * sp, cg * cp + sg * st * sp))
}

/// [`follow_up_command`] to half a hundredth of a radian, for a servo whose encoder is read: the true angle is
/// measured, so the error does not enter the rectification.
pub fn approximate_follow_up_command(attitude: Attitude) -> Radians {
    let (sg, cg) = math::approximate_sin_cos(attitude.roll.0);
    let (st, ct) = math::approximate_sin_cos(attitude.pitch.0);
    let (sp, cp) = math::approximate_sin_cos(attitude.heading.0);
    Radians(math::approximate_atan2(ct * sp, cg * cp + sg * st * sp))
}

/// Equivalent pitch and roll of a camera that follows with `follow_up` (eq. 5), exact:
/// sin θ1 = sin θ cos β + cos θ sin γ sin β, γ1 = atan2(sin γ cos φ − cos γ sin θ sin φ, cos θ cos γ / cos θ1).
///
/// The usual θ1 ≈ θ cos φ + γ sin φ costs 2.75 px at ±10°, for a saving of nothing: it runs once a frame.
pub fn equivalent_tilt(attitude: Attitude, follow_up: Radians) -> EquivalentTilt {
    let (sb, cb) = math::sin_cos(follow_up.0);
    let (sg, cg) = math::sin_cos(attitude.roll.0);
    let (st, ct) = math::sin_cos(attitude.pitch.0);
    let (sp, cp) = math::sin_cos(attitude.heading.0);
    let pitch = math::asin(st * cb + ct * sg * sb);
    let (_, ct1) = math::sin_cos(pitch);
    let roll = math::atan2(sg * cp - cg * st * sp, ct * cg / ct1);
    EquivalentTilt { pitch: Radians(pitch), roll: Radians(roll) }
}
