//! Motion as somebody else's simulator told it: samples, and what lies between them.

use super::TrueState;
use crate::vehicle::servo::wrapped;

/// Samples further apart than this have nothing between them, microseconds. Chosen: a plane at 25 m/s that changes its
/// acceleration by 5 m/s² within half a second is 0.1 m beside the cubic.
const GAP_MAX_US: f64 = 500_000.0;

/// A state and when it was, microseconds of the autopilot's clock.
pub type Recorded = (f64, TrueState);

/// The state at `at_us` of samples in the order of time; `None` beyond them and in their gaps.
#[must_use]
pub fn recorded(samples: &[Recorded], at_us: f64) -> Option<TrueState> {
    let after = samples.partition_point(|(sample_us, _)| *sample_us < at_us);
    let later = samples.get(after)?;
    if later.0 == at_us {
        return Some(later.1);
    }
    let earlier = samples.get(after.checked_sub(1)?)?;
    (later.0 - earlier.0 <= GAP_MAX_US).then(|| between(earlier, later, at_us))
}

/// The sample nearest in time.
pub(super) fn nearest(samples: &[Recorded], at_us: f64) -> TrueState {
    let off = |sample: &&Recorded| (sample.0 - at_us).abs();
    samples.iter().min_by(|a, b| off(a).total_cmp(&off(b))).map_or_else(TrueState::default, |(_, state)| *state)
}

/// Between two samples: the place on the cubic through both with their velocities, angles and velocities in proportion, which
/// at 50 samples a second of a plane is right to a hundredth of a degree.
fn between((from_us, from): &Recorded, (to_us, to): &Recorded, at_us: f64) -> TrueState {
    let span_s = (to_us - from_us) * 1e-6;
    let part = (at_us - from_us) / (to_us - from_us);
    let mixed = |a: f64, b: f64| a + part * (b - a);
    let turned = |a: f64, b: f64| wrapped(a + part * wrapped(b - a));
    // Hermite's cubic, each end by its place and its velocity.
    let (p2, p3) = (part * part, part * part * part);
    let weights = [2.0 * p3 - 3.0 * p2 + 1.0, p3 - 2.0 * p2 + part, 3.0 * p2 - 2.0 * p3, p3 - p2];
    let place = |a: f64, b: f64, axis: usize| {
        let (va, vb) = (span_s * from.velocity_enu_m_s[axis], span_s * to.velocity_enu_m_s[axis]);
        a * weights[0] + va * weights[1] + b * weights[2] + vb * weights[3]
    };
    TrueState {
        east_m: place(from.east_m, to.east_m, 0),
        north_m: place(from.north_m, to.north_m, 1),
        up_m: place(from.up_m, to.up_m, 2),
        heading_rad: turned(from.heading_rad, to.heading_rad),
        pitch_rad: mixed(from.pitch_rad, to.pitch_rad),
        roll_rad: turned(from.roll_rad, to.roll_rad),
        follow_up_rad: turned(from.follow_up_rad, to.follow_up_rad),
        velocity_enu_m_s: std::array::from_fn(|axis| mixed(from.velocity_enu_m_s[axis], to.velocity_enu_m_s[axis])),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    fn sample(at_s: f64) -> Recorded {
        let state = TrueState {
            east_m: 560_000.0 + 30.0 * at_s.sin(),
            north_m: 25.0 * at_s,
            up_m: 100.0 - at_s * at_s,
            heading_rad: wrapped(3.0 + 0.5 * at_s),
            pitch_rad: 0.1 * at_s.sin(),
            roll_rad: 0.4 * (0.8 * at_s).sin(),
            follow_up_rad: 0.0,
            velocity_enu_m_s: [30.0 * at_s.cos(), 25.0, -2.0 * at_s],
        };
        (at_s * 1e6, state)
    }

    #[test]
    fn between_samples_at_50_hz_it_is_right_to_a_millimetre_and_a_hundredth_of_a_degree() {
        let samples: Vec<Recorded> = (0..200).map(|index| sample(f64::from(index) * 0.02)).collect();
        for at_s in [0.013, 0.31, 1.709, 3.333] {
            let (found, (_, truth)) = (recorded(&samples, at_s * 1e6).unwrap(), sample(at_s));
            let off_m =
                (found.east_m - truth.east_m).hypot(found.north_m - truth.north_m).hypot(found.up_m - truth.up_m);
            assert!(off_m < 1e-3, "{off_m} at {at_s}");
            for (a, b) in [
                (found.heading_rad, truth.heading_rad),
                (found.pitch_rad, truth.pitch_rad),
                (found.roll_rad, truth.roll_rad),
            ] {
                assert!(wrapped(a - b).abs().to_degrees() < 0.01, "{a} {b} at {at_s}");
            }
            assert!(found.heading_rad.abs() <= PI);
        }
    }

    #[test]
    fn beyond_the_samples_and_in_gaps_there_is_nothing() {
        let samples = [sample(1.0), sample(1.1), sample(2.0)];
        assert!(recorded(&samples, 0.9e6).is_none() && recorded(&samples, 2.1e6).is_none());
        assert!(recorded(&samples, 1.5e6).is_none() && recorded(&samples, 1.05e6).is_some());
        assert_eq!(recorded(&samples, 1.1e6), Some(sample(1.1).1));
        assert!(recorded(&[], 1.0).is_none());
    }
}
