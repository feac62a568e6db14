//! Angles without jumps.

use super::error::{SmoothError, TURN_MAX_DEG};

/// Adds whole turns, so that no value is more than half a turn from the one before. Values that are not finite (no
/// sample) stay and are passed over. Degrees.
///
/// # Errors
/// [`SmoothError::TurnTooFar`]: which way round it went is not certain.
pub fn unwrap_degrees(values: &mut [f64]) -> Result<(), SmoothError> {
    let mut before: Option<f64> = None;
    for (sample, value) in values.iter_mut().enumerate().filter(|(_, value)| value.is_finite()) {
        if let Some(before) = before {
            // Whole turns are added, never a remainder: the digits of the value stay.
            *value -= 360.0 * ((*value - before) / 360.0).round();
            let turn_deg = *value - before;
            if turn_deg.abs() > TURN_MAX_DEG {
                return Err(SmoothError::TurnTooFar { sample, turn_deg });
            }
        }
        before = Some(*value);
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn turns_are_added_and_gaps_passed_over() {
        let mut values = [350.0, 359.5, 0.25, f64::NAN, 100.0, -170.0, -50.0, 3.0];
        assert_eq!(unwrap_degrees(&mut values), Ok(()));
        assert_eq!(values[..3], [350.0, 359.5, 360.25]);
        assert!(values[3].is_nan());
        assert_eq!(values[4..], [460.0, 550.0, 670.0, 723.0]);
        assert_eq!(unwrap_degrees(&mut []), Ok(()));
    }

    #[test]
    fn a_turn_that_may_be_either_way_round_is_refused() {
        for wrong in [132.0, 190.0, 249.0] {
            let refused = unwrap_degrees(&mut [10.0, 11.0, wrong, 13.0]);
            assert!(matches!(refused, Err(SmoothError::TurnTooFar { sample: 2, .. })), "{wrong}: {refused:?}");
        }
        // What is not refused leaves no turns behind.
        for wrong in [130.0, 254.0, 300.0, 0.0] {
            let mut values = [10.0, 11.0, wrong, 13.0];
            assert!(unwrap_degrees(&mut values).is_ok() && values[3] == 13.0, "{wrong}: {values:?}");
        }
    }
}
