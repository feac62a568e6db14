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

/// From one sample to the next an angle that is counted over its end changes by a whole turn but for what it really turned:
/// less than this, degrees. Chosen: two samples of a vehicle's log are nearer.
const REAL_TURN_DEG: f64 = 60.0;

/// The first place where values look like an angle in degrees that is counted over its end, as from 179 to -179: all of them lie
/// within half a turn of 0, or from 0 to a whole one, and two that follow each other are nearly a whole turn apart.
#[must_use]
pub fn turned_over(values: &[f64]) -> Option<SmoothError> {
    let known = || values.iter().enumerate().filter(|(_, value)| value.is_finite());
    let within = |low: f64, high: f64| known().all(|(_, value)| (low..=high).contains(value));
    if !within(-180.0, 180.0) && !within(0.0, 360.0) {
        return None;
    }
    known().zip(known().skip(1)).find_map(|((_, before), (sample, value))| {
        let turn_deg = value - before;
        (turn_deg.abs() > 360.0 - REAL_TURN_DEG).then_some(SmoothError::TurnedOver { sample, turn_deg })
    })
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
    fn an_angle_that_is_counted_over_its_end_is_known_by_its_jump() {
        let of = |values: &[f64]| {
            turned_over(values).map(|error| matches!(error, SmoothError::TurnedOver { sample: 2, .. }))
        };
        assert_eq!(of(&[170.0, 178.0, -175.0]), Some(true));
        assert_eq!(of(&[359.0, f64::NAN, 2.0, 3.0]), Some(true));
        // A jump of another size, metres beyond a turn, a slow change.
        assert_eq!((of(&[0.0, 170.0, -100.0]), of(&[0.0, 400.0, 10.0]), of(&[10.0, 100.0, 180.0])), (None, None, None));
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
