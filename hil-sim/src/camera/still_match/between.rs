//! Where two orthophotos have the same ground, and how well that is known.
//!
//! Of greys that have not changed least squares know the place to hundredths of a pixel, and where they have changed a little they say so
//! all the same: between years those few that hold, one in 25 of what is accepted, were off by 0.3 pixels on each axis where they stated 0.08.
//! What tells the two apart is the patch itself: its quarters, each located by itself, are at odds.

use super::quarters::odds;
use nalgebra::Matrix2;
use plumbline_core::image::{Run, View};
use plumbline_core::matching::Prior;
use plumbline_core::matching::directions::Located;
use plumbline_core::matching::refine::SubPixel;

/// By how much the variance of a top is larger than its nine parts say, and one sigma on each axis of where two orthophotos of other years
/// have the same ground, pixels, beside it.
///
/// Learnt from 3,700 accepted patches of 27 to 65 pixels, in four years of farmland and lakes (5 m a pixel) and the western half of the area, judged by displacement
/// fields of another program: as much as leaves the mean square over the variances, 2 where they are true, at 1.2. Normal errors would need
/// 1 and 0.2 (1.8), but of the other half and the other years 2.0 % were then beyond 9.21 and 1.3 of 1,000 beyond 25; so it is 0.7 %
/// and 0.4 of 1,000. What is left there are places where one orthophoto lies off by more than a pixel, which no patch can know: the map's sigma is for them.
const OVER_PARTS: f32 = 1.3;
const BETWEEN_PX: f32 = 0.25;

/// Least squares are taken at their word where all four quarters were located and this is below the limit: ln(sigma) and a part of
/// ln(scatter of the quarters), both in pixels.
///
/// The part by logistic regression over 11,400 solutions in the patches' own year (27 to 65 pixels, noise of two and five grey levels) and those between
/// four years in the western half of the area that had all quarters; the limit chosen, below all of the latter. Between the
/// other years and in the other half two of 1,540 pass, which is one in 20,000 accepted matches. In their own year 92 % of 65 pixels pass, of
/// 35 pixels 62 % (of two grey levels more): the others have that of a top beside their own.
const PER_SCATTER: f32 = 0.3;
const UNCHANGED: f32 = -3.8;

/// The place and its covariance. `reference`: what was searched within ±`radius`; `map_px`: one sigma on each axis of where the map has its ground.
#[must_use]
pub fn solution(
    patch: &View<'_>,
    runs: &[Run],
    (reference, radius): (&View<'_>, u16),
    located: &Located,
    prior: Prior,
    map_px: f32,
) -> SubPixel {
    let mut solution = located.solution;
    let between = located.peak.covariance * OVER_PARTS + Matrix2::identity() * (BETWEEN_PX * BETWEEN_PX);
    let mut shift = solution.joint.fixed_view_mut::<2, 2>(0, 0);
    if !located.holds {
        shift.copy_from(&between);
    } else if !is_unchanged(patch, runs, (reference, radius), &located.solution, prior) {
        shift += between;
    }
    shift += Matrix2::identity() * (map_px * map_px);
    solution
}

/// Whether the ground is as the reference has it, so that what least squares say of their error is true.
fn is_unchanged(patch: &View<'_>, runs: &[Run], searched: (&View<'_>, u16), solution: &SubPixel, prior: Prior) -> bool {
    let odds = odds(patch, runs, searched, solution, prior);
    let sigma = (0.5 * (solution.joint[(0, 0)] + solution.joint[(1, 1)])).sqrt();
    // A NaN is no agreement.
    odds.count == 4 && sigma.ln() + PER_SCATTER * odds.scatter_px().ln() < UNCHANGED
}

#[cfg(test)]
mod tests {
    use super::solution;
    use crate::camera::still_match::quarters::odds;
    use plumbline_core::image::{Run, View};
    use plumbline_core::matching::Prior;
    use plumbline_core::matching::directions::{self, Located, risk::Rule};

    const SIDE: u16 = 48;
    const RADIUS: u16 = 6;
    const PRIOR: Prior = Prior { turn_rad: 0.0087, scale: 0.005 };

    /// A texture of waves that do not repeat within the pictures.
    fn grey(x: f64, y: f64) -> u8 {
        let waves = [(0.31, 0.17), (-0.23, 0.37), (0.11, -0.29), (0.43, 0.05), (0.07, 0.47), (-0.19, -0.13)];
        let sum: f64 = waves.iter().zip(1..).map(|((a, b), k)| (a * x + b * y + f64::from(k * k)).sin()).sum();
        (128.0 + 18.0 * sum).round() as u8
    }

    /// What is found of a patch whose right half lies `apart` further to the right, and how far its quarters are at odds; with the sigma.
    fn found(apart: f64, map_px: f32) -> (Located, f32, f32) {
        let window = SIDE + 2 * RADIUS;
        let (side, all) = (usize::from(SIDE), usize::from(window));
        let reference: Vec<u8> = (0..all * all).map(|at| grey((at % all) as f64, (at / all) as f64)).collect();
        let by = f64::from(RADIUS) + 0.3;
        let moved = |col: usize| if col >= side / 2 { 0.5 * apart } else { -0.5 * apart };
        let patch: Vec<u8> = (0..side * side)
            .map(|at| grey((at % side) as f64 + by + moved(at % side), (at / side) as f64 + by))
            .collect();
        let views =
            (View::new(&patch, (SIDE, SIDE)).expect("a patch"), View::new(&reference, (window, window)).expect("one"));
        let runs: Vec<Run> = (0..SIDE).map(|row| Run { row, start: 0, end: SIDE }).collect();
        let mut bytes = vec![0; directions::search::working_bytes(views.0.size(), views.1.size())];
        let mut scores = vec![0; (2 * usize::from(RADIUS) + 1).pow(2)];
        let rule = (PRIOR, &Rule::default());
        let located =
            directions::locate(&views.0, &runs, &views.1, RADIUS, rule, (&mut bytes, &mut scores)).expect("texture");
        let scatter = odds(&views.0, &runs, (&views.1, RADIUS), &located.solution, PRIOR).scatter_px();
        let sigma = solution(&views.0, &runs, (&views.1, RADIUS), &located, PRIOR, map_px).joint[(0, 0)].sqrt();
        (located, scatter, sigma)
    }

    #[test]
    fn quarters_that_are_at_odds_widen_the_sigma_and_others_do_not() {
        let (located, scatter, sigma) = found(0.0, 0.0);
        assert!(located.holds && scatter < 0.05, "{scatter}: {located:?}");
        assert_eq!(sigma, located.solution.joint[(0, 0)].sqrt());
        let (_, scatter, sigma) = found(2.0, 0.0);
        assert!(scatter > 0.2 && sigma >= super::BETWEEN_PX, "{scatter} {sigma}");
    }

    #[test]
    fn the_maps_sigma_is_beside_the_patch_own() {
        let [own, wider] = [0.0, 0.5].map(|map_px| found(0.0, map_px).2);
        assert!((wider - own.hypot(0.5)).abs() < 1e-6, "{own} {wider}");
    }
}
