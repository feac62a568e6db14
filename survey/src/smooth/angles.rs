//! Angles without jumps.

use super::error::{SmoothError, TURN_MAX_DEG};
use std::f64::consts::TAU;

/// Adds whole turns, so that no value is more than half a turn from the one before. Values that are not finite (no
/// sample) stay and are passed over. `turn`: a whole one in the unit of the values, 360 for degrees ([`turn_of`]).
///
/// # Errors
/// [`SmoothError::TurnTooFar`]: which way round it went is not certain.
pub fn unwrap_turns(values: &mut [f64], turn: f64) -> Result<(), SmoothError> {
    let mut before: Option<f64> = None;
    for (sample, value) in values.iter_mut().enumerate().filter(|(_, value)| value.is_finite()) {
        if let Some(before) = before {
            // Whole turns are added, never a remainder: the digits of the value stay.
            *value -= turn * ((*value - before) / turn).round();
            let turn_deg = 360.0 * ((*value - before) / turn);
            if turn_deg.abs() > TURN_MAX_DEG {
                return Err(SmoothError::TurnTooFar { sample, turn_deg });
            }
        }
        before = Some(*value);
    }
    Ok(())
}

/// From one sample to the next an angle that is counted over its end changes by a whole turn but for what it really turned:
/// less than this share of one. Chosen, 60 degrees: two samples of a vehicle's log are nearer.
const REAL_TURN: f64 = 60.0 / 360.0;
/// What rounding may add to the end of a range, as a share of a turn: a hundredth of a degree has five digits of radians.
const ROUNDED: f64 = 1e-4;

/// A whole turn in the unit of these values: 2π where they are counted over as radians are, else 360.
#[must_use]
pub fn turn_of(values: &[f64]) -> f64 {
    if over(values, TAU).is_some() { TAU } else { 360.0 }
}

/// The first place where values look like an angle that is counted over its end, as from 179 to -179 degrees or from 3.1 to -3.1 radians: all of
/// them lie within half a turn of 0, or from 0 to a whole one, and two that follow each other are nearly a whole turn apart.
#[must_use]
pub fn turned_over(values: &[f64]) -> Option<SmoothError> {
    over(values, TAU).or_else(|| over(values, 360.0))
}

fn over(values: &[f64], turn: f64) -> Option<SmoothError> {
    let known = || values.iter().enumerate().filter(|(_, value)| value.is_finite());
    let rounded = ROUNDED * turn;
    let within = |low: f64, high: f64| known().all(|(_, value)| (low - rounded..=high + rounded).contains(value));
    if !within(-0.5 * turn, 0.5 * turn) && !within(0.0, turn) {
        return None;
    }
    known().zip(known().skip(1)).find_map(|((_, before), (sample, value))| {
        let jump = value - before;
        (jump.abs() > turn - REAL_TURN * turn).then_some(SmoothError::TurnedOver { sample, jump, turn })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn turns_are_added_and_gaps_passed_over() {
        let mut values = [350.0, 359.5, 0.25, f64::NAN, 100.0, -170.0, -50.0, 3.0];
        assert_eq!(unwrap_turns(&mut values, 360.0), Ok(()));
        assert_eq!(values[..3], [350.0, 359.5, 360.25]);
        assert!(values[3].is_nan());
        assert_eq!(values[4..], [460.0, 550.0, 670.0, 723.0]);
        assert_eq!(unwrap_turns(&mut [], 360.0), Ok(()));
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
    fn radians_are_known_by_their_own_turn() {
        let mut values = [3.0, 3.1, -3.1, -3.0, -0.5, 0.5, 3.1, -3.1];
        assert!(matches!(turned_over(&values), Some(SmoothError::TurnedOver { sample: 2, turn, .. }) if turn == TAU));
        assert_eq!(turn_of(&values), TAU);
        // Half a turn from the third value on is too far.
        assert!(unwrap_turns(&mut values, TAU).is_err());
        let mut values = [3.0, 3.1, -3.1, -2.0, -0.5, 0.5, 2.0, 3.1, -3.1];
        assert_eq!(unwrap_turns(&mut values, TAU), Ok(()));
        assert!(values.windows(2).all(|pair| (0.0..1.6).contains(&(pair[1] - pair[0]))), "{values:?}");
        assert!((values[8] - (2.0 * TAU - 3.1)).abs() < 1e-12, "{values:?}");
        // Degrees near 0, and degrees that are counted over.
        assert_eq!((turn_of(&[-3.0, 2.0, -1.0]), turn_of(&[170.0, -170.0])), (360.0, 360.0));
        assert_eq!(turned_over(&[-3.0, 2.0, -1.0]), None);
    }

    #[test]
    fn a_turn_that_may_be_either_way_round_is_refused() {
        for wrong in [132.0, 190.0, 249.0] {
            let refused = unwrap_turns(&mut [10.0, 11.0, wrong, 13.0], 360.0);
            assert!(matches!(refused, Err(SmoothError::TurnTooFar { sample: 2, .. })), "{wrong}: {refused:?}");
        }
        // What is not refused leaves no turns behind.
        for wrong in [130.0, 254.0, 300.0, 0.0] {
            let mut values = [10.0, 11.0, wrong, 13.0];
            assert!(unwrap_turns(&mut values, 360.0).is_ok() && values[3] == 13.0, "{wrong}: {values:?}");
        }
    }
}
