//! Angles without jumps.

/// Adds whole turns, so that no value is more than half a turn from the one before. Values that are not finite (no
/// sample) stay and are passed over. Degrees.
pub fn unwrap_degrees(values: &mut [f64]) {
    let mut before: Option<f64> = None;
    for value in values.iter_mut().filter(|value| value.is_finite()) {
        if let Some(before) = before {
            // Whole turns are added, never a remainder: the digits of the value stay.
            *value -= 360.0 * ((*value - before) / 360.0).round();
        }
        before = Some(*value);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn turns_are_added_and_gaps_passed_over() {
        let mut values = [350.0, 359.5, 0.25, f64::NAN, 170.0, -170.0, -10.0, 3.0];
        unwrap_degrees(&mut values);
        assert_eq!(values[..3], [350.0, 359.5, 360.25]);
        assert!(values[3].is_nan());
        assert_eq!(values[4..], [530.0, 550.0, 710.0, 723.0]);
        unwrap_degrees(&mut []);
    }
}
