//! Whether a distortion is one that a lens may have.

use super::Distortion;
use super::keys::Keys;
use crate::error::InputError;

/// How many times nearer or farther the nearest border may be from the middle than without distortion. Chosen: lenses that see 120 degrees, the
/// widest that are described so, bring it to a half.
const FACTOR: f64 = 3.0;
/// Steps of the way out to that: a fold is missed that is narrower.
const STEPS: u32 = 300;
/// Most that the tangential part may move the nearest border, of its distance from the middle. Chosen: decentred lenses do by a hundredth.
const TANGENTIAL: f64 = 0.5;

/// Refuses a distortion that leaves less than a picture: `nearest` is the tangent of the angle at which the nearest border is seen.
///
/// Beyond the nearest border it may fold back, as polynomials do where no point was measured: the board takes nothing from there.
pub(super) fn check(keys: &Keys<'_>, distortion: Option<&Distortion>, nearest: f64) -> Result<(), InputError> {
    let Some(distortion) = distortion else { return Ok(()) };
    let Some(why) = implausible(distortion, nearest) else { return Ok(()) };
    let Distortion { k1, k2, k3, p1, p2 } = distortion;
    Err(InputError::new(format!(
        "camera file {}: {}distortion of k1 = {k1}, k2 = {k2}, k3 = {k3}, p1 = {p1}, p2 = {p2} {why}, which no lens does: they are \
         coefficients of lengths in focal lengths, not in pixels or mm, in OpenCV's order k1, k2, p1, p2, k3",
        keys.name, keys.prefix
    )))
}

/// What a distortion does that none does.
fn implausible(distortion: &Distortion, nearest: f64) -> Option<&'static str> {
    let Distortion { k1, k2, k3, p1, p2 } = distortion;
    let radius = |r: f64| {
        let r2 = r * r;
        r * (1.0 + r2 * (k1 + r2 * (k2 + r2 * k3)))
    };
    if 3.0 * (p1.abs() + p2.abs()) * nearest > TANGENTIAL {
        return Some("moves its border aside by half a picture");
    }
    let mut before = 0.0;
    for step in 1..=STEPS {
        let ideal = FACTOR * nearest * f64::from(step) / f64::from(STEPS);
        let found = radius(ideal);
        if found <= before {
            return Some("folds the picture back before its nearest border");
        }
        if found >= nearest {
            return (ideal * FACTOR < nearest).then_some("makes the middle of the picture several times as large");
        }
        before = found;
    }
    Some("makes the picture several times smaller")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lenses_are_told_from_numbers_that_are_none() {
        let of = |[k1, k2, k3, p1, p2]: [f64; 5], nearest| implausible(&Distortion { k1, k2, k3, p1, p2 }, nearest);
        // None; a barrel; a wide action camera; a pincushion; a barrel that folds back in the corners alone, at 0.82 of 0.58 x 1.41 = 0.82.
        for (coefficients, nearest) in [
            ([0.0; 5], 2.0),
            ([-0.12, 0.02, 0.0, 0.001, -0.0006], 0.6),
            ([-0.27, 0.11, -0.02, 0.0, 0.0], 0.9),
            ([0.3, 0.1, 0.0, 0.0, 0.01], 0.5),
            ([-0.33, 0.0, 0.0, 0.0, 0.0], 0.58),
        ] {
            assert_eq!(of(coefficients, nearest), None, "{coefficients:?}");
        }
        for (coefficients, what) in [
            ([-0.5, 0.0, 0.0, 0.0, 0.0], "folds"),
            ([-1e-8, -1e9, 0.0, 0.0, 0.0], "folds"),
            ([200.0, 0.0, 0.0, 0.0, 0.0], "as large"),
            ([0.0, 0.0, 0.0, 0.0, -5.0], "aside"),
            ([f64::MAX, -f64::MAX, 0.0, 0.0, 0.0], "as large"),
        ] {
            assert!(
                of(coefficients, 0.9).is_some_and(|why| why.contains(what)),
                "{coefficients:?} {:?}",
                of(coefficients, 0.9)
            );
        }
    }
}
