//! The follow-up axis: an angle as the length of a servo's pulse.

use plumbline_core::units::Radians;

/// Pulse of the middle, microseconds.
pub const MIDDLE_US: u16 = 1500;
/// Longest way from the middle, microseconds: a servo's usual travel.
pub const TRAVEL_US: u16 = 500;
/// Angle at the end of the travel, radians: 90 degrees to either side.
pub const TRAVEL_RAD: f32 = core::f32::consts::FRAC_PI_2;
/// Pulses a second.
pub const RATE_HZ: u32 = 50;

/// The pulse for an angle, microseconds. Angles beyond the travel stop at its end; what is no number leaves the middle.
pub fn pulse_us(angle: Radians) -> u16 {
    let part = angle.wrapped().0 / TRAVEL_RAD;
    let part = if part.is_finite() { part.clamp(-1.0, 1.0) } else { 0.0 };
    let off = part * f32::from(TRAVEL_US);
    let rounded = (off + if off < 0.0 { -0.5 } else { 0.5 }) as i16;
    MIDDLE_US.saturating_add_signed(rounded)
}

#[cfg(test)]
mod tests {
    use super::pulse_us;
    use plumbline_core::units::Radians;

    #[test]
    fn angles_become_pulses() {
        let at = |degrees: f32| pulse_us(Radians(degrees.to_radians()));
        assert_eq!((at(0.0), at(90.0), at(-90.0), at(45.0), at(-9.0)), (1500, 2000, 1000, 1750, 1450));
        assert_eq!((at(135.0), at(-170.0)), (2000, 1000));
        assert_eq!(pulse_us(Radians(f32::NAN)), 1500);
    }
}
