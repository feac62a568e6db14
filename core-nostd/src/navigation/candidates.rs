//! Rotation and scale that a frame is rectified with while neither is known well enough for a match.
//!
//! A correlation tolerates a rotation or scale error that moves the border of the patch by a pixel and a half. Where the sigmas of heading
//! and height reach further, consecutive frames are rectified with other rotations and scales, likely ones first, until one is matched. A
//! frame is rectified once: a candidate costs a frame, not computing time.

use crate::math::ceil;

/// Tolerated displacement of the patch's border, pixels: 10 degrees over patches of 28 pixels were matched as often as none, and a scale of
/// 8 % three times in four.
const BORDER_PX: f32 = 1.5;
/// Range of the candidates, sigmas, and its limits: radians (10 degrees), and as a share. A compass that is off by more is unusable.
const SIGMAS: f32 = 2.0;
const TURN_MAX_RAD: f32 = 0.175;
const SCALE_MAX: f32 = 0.15;

/// A candidate of an uncertain quantity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Candidate {
    /// Its offset from the most likely value.
    pub off: f32,
    /// One sigma around that.
    pub sigma: f32,
}

/// Number of candidates to each side, and the step between them.
fn steps(sigma: f32, most: f32, tolerance: f32) -> (u8, f32) {
    let reach = (SIGMAS * sigma).min(most);
    if reach <= tolerance {
        return (0, 0.0);
    }
    // Each covers the tolerance to both of its sides.
    let each_side = ceil(0.5 * (reach / tolerance - 1.0));
    (each_side as u8, reach / (each_side + 0.5))
}

/// 0, 1, -1, 2, -2 ...
fn outwards(index: u8) -> f32 {
    let far = index.div_ceil(2) as f32;
    if index % 2 == 1 { far } else { -far }
}

fn candidate((each_side, step): (u8, f32), index: u8, sigma: f32) -> Candidate {
    if each_side == 0 {
        Candidate { off: 0.0, sigma }
    } else {
        Candidate { off: step * outwards(index), sigma: 0.5 * step }
    }
}

/// Rotation (radians) and scale of a frame by their sigmas and the patch's half side in pixels, and whether there are several candidates.
/// `number`: frames since the last match.
pub fn candidates(number: u8, turn_rad: f32, scale: f32, half_px: f32) -> ([Candidate; 2], bool) {
    let tolerance = BORDER_PX / half_px.max(1.0);
    let (turns, scales) = (steps(turn_rad, TURN_MAX_RAD, tolerance), steps(scale, SCALE_MAX, tolerance));
    let of_scale = 2 * scales.0 + 1;
    let number = number % (of_scale * (2 * turns.0 + 1));
    let pair = [candidate(turns, number / of_scale, turn_rad), candidate(scales, number % of_scale, scale)];
    (pair, turns.0 > 0 || scales.0 > 0)
}

#[cfg(test)]
mod tests {
    use super::candidates;

    #[test]
    fn what_is_known_well_has_no_candidates() {
        let ([turn, scale], several) = candidates(7, 0.02, 0.01, 32.0);
        assert_eq!((turn.off, turn.sigma, scale.off, scale.sigma, several), (0.0, 0.02, 0.0, 0.01, false));
    }

    #[test]
    fn candidates_cover_two_sigmas_without_gaps() {
        for (turn_rad, scale, half_px) in
            [(0.08, 0.12, 32.0), (0.02, 0.12, 14.0), (0.09, 0.001, 32.0), (9.0, 9.0, 32.0)]
        {
            let all: std::vec::Vec<_> =
                (0..=254).map(|number| candidates(number, turn_rad, scale, half_px).0).collect();
            for (axis, reach) in [(0, (2.0 * turn_rad).min(0.175f32)), (1, (2.0 * scale).min(0.15f32))] {
                let mut offs: std::vec::Vec<f32> = all.iter().map(|pair| pair[axis].off).collect();
                offs.sort_by(f32::total_cmp);
                offs.dedup();
                let tolerance = 1.5 / half_px;
                if offs.len() > 1 {
                    assert!(offs.windows(2).all(|pair| pair[1] - pair[0] <= 2.0 * tolerance * 1.0001), "{offs:?}");
                    assert!(offs[offs.len() - 1] + tolerance >= 0.9999 * reach, "{offs:?} {reach}");
                } else {
                    assert!(reach <= tolerance);
                }
            }
        }
    }
}
