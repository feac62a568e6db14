//! Decides over several key frames: adds each frame to the log-likelihood surface, and gives it a fix at the surface's peak.
//!
//! A match of the high-pass images is accepted alone if its least-squares solution is valid by the gradient directions as well: the map is
//! of the ground's own year, or the ground has not changed. Otherwise the frame's direction scores are added to the surface. Once that has
//! decided for a position, a frame whose own peak lies within a gate around it has its fix there.

use super::register::Matched;
use super::{Buffers, Pipeline, Prediction, Refusal, Situation};
use crate::budget::SEARCH_MAX_PX;
use crate::homography::Placement;
use crate::image::View;
use crate::matching::directions::aboard::{FramePeak, confirms, frame_peak};
use crate::matching::{Match, Prior, Rejection, Shift, grey_correlation};
use crate::math::{hypot, round, sqrt, squared};
use crate::navigation::surface::{Decision, Frame};
use crate::tile::Local;
use nalgebra::Matrix2;

/// Largest risk of the surface's decision for frames' own peaks to be looked for there and to correct the surface.
const RISK_MAX: f32 = 1e-3;
/// Largest risk of the decision for a fix. Of 131,000 fixes at and below it in 500 flights between years none was more than 1.9 pixels off,
/// of 11,800 between it and twice that 2.6 pixels.
pub const BELIEVED_RISK: f32 = 1e-4;
/// The navigation's sigma is scaled by this for the prior of an empty surface. Chosen: an error of three sigmas then costs as much as one
/// of two.
const PRIOR_SIGMA_SCALE: f32 = 1.5;
/// A match, or a frame's own peak, further from the decided position than this does not support it, pixels: as far as what is called a
/// wrong match.
pub(super) const WRONG_PX: f32 = 3.0;
/// The gate around the decided position shrinks by this for each pixel of dead reckoning error over a footprint, one sigma: after the loss
/// of satellites velocities were off by three to six of their sigmas. With 0 in its place 44 of 761 fixes were wrong there, with 3, 4 and 6
/// alike none or one of 2,400.
const GATE_PER_DRIFT: f32 = 4.0;
/// Least radius of the gate, pixels: the scatter of frames' own peaks around the right position.
const GATE_MIN_PX: f32 = 0.8;
/// One sigma, each axis, of the local offset of a map of another year, pixels, for a frame that is matched alone: neighbouring frames share
/// it, and no part of a patch shows it. With 0.37 in its place 21 of 601 such matches between years were off by more than five of their
/// sigmas.
pub(super) const MAP_SIGMA_PX: f32 = 0.6;
/// One sigma of the decided position, which averages several key frames, each axis, pixels: in 84 flights between eight years it was off by
/// 0.33 pixels where the frame's own peak was near it and the last residuals unbiased; a fifth is added. With a tenth more than 0.33 eight
/// of 13,600 fixes of patches of 35 pixels, in one flight, were off by five of their sigmas.
const DECISION_SIGMA_PX: f32 = 0.4;
/// Its sigma grows by these shares of the frame's residual, of the dead reckoning error over a footprint, and of the mean residual of the
/// last frames, each in pixels and added as squares: with the first, errors are as stated up to 3 pixels; of the second, frames' own peaks
/// take off half; with the third, errors are as stated where velocities are off by five of their sigmas.
const RESIDUAL_SHARE: f32 = 0.2;
const DRIFT_SHARE: f32 = 0.5;
const BIAS_SHARE: f32 = 0.5;
/// Largest sigma of a frame's own peak along both axes, pixels, for it to correct the surface: a worse one hardly says more than where it
/// was looked for, and pulls the surface away. With all of them, at a gain that falls with their variance, 27 % of frames of 35 pixels were
/// fixed instead of 22, and ten times as many wrong.
const CORRECTING_SIGMA_MAX_PX: f32 = 0.55;
/// Probability that a least-squares solution that the directions confirm is at a wrong position. One of 23,000 wrong peaks between years
/// had such a solution, which is one in 4,800 at most with 95 % confidence, and a quarter of what the high-pass images alone accept between
/// years is wrong: 0.5e-4. Doubled, for grounds where more of it is wrong.
const CONFIRMED_RISK: f32 = 1e-4;
/// Probability that the decided position is wrong although the frame's own peak is near it: one of 5,800 within one pixel was, one in 1,200
/// at most with 95 % confidence.
const GATED_RISK: f32 = 5e-4;

/// All constants behind the risk of a fix besides those of the decision, for a record of which ones were in use.
pub const COEFFICIENTS: [f32; 8] = [
    RISK_MAX,
    BELIEVED_RISK,
    PRIOR_SIGMA_SCALE,
    GATE_PER_DRIFT,
    GATE_MIN_PX,
    CORRECTING_SIGMA_MAX_PX,
    CONFIRMED_RISK,
    GATED_RISK,
];

/// The search of the match, for the surface.
struct SearchWindow<'a> {
    window: View<'a>,
    radius: u16,
    prior: Prior,
    /// Centre of the surface less that of the search, pixels (columns, rows).
    middle: (i16, i16),
    px_m: f32,
    /// Dead reckoning error over a footprint, one sigma, pixels.
    drift_px: f32,
}

impl<'t> Pipeline<'t> {
    /// Confirms the match of a small search that was accepted alone, or replaces it by a fix at the surface's decision.
    #[inline(never)]
    pub(super) fn together(&mut self, situation: &Situation, matched: &mut Matched) {
        let accepted = matched.found.accepted;
        matched.found.accepted = accepted.and(Err(Rejection::Undecided));
        if matched.search_px as usize > SEARCH_MAX_PX {
            return self.alone(situation, accepted, matched);
        }
        let Some(sought) = self.sought(situation, matched) else {
            return self.navigation.surface.agreement.gap();
        };
        let decided = self.decided(sought.px_m);
        if let Ok(shift) = accepted
            && self.confirmed(matched) == Ok(true)
        {
            let nadir = self.tile.local(matched.centre.0 + shift.d_col, matched.centre.1 + shift.d_row);
            self.held(nadir, decided, sought.px_m);
            self.count_least_squares(situation, true);
            let believed = decided.filter(Decision::is_believed);
            matched.is_decided = believed.is_some();
            matched.is_elsewhere = believed.is_some_and(|decided| !sought.is_near(nadir, &decided));
            (matched.found.accepted, matched.risk) = (Ok(self.with_map_error(shift)), CONFIRMED_RISK);
            return;
        }
        self.count_least_squares(situation, false);
        let Ok((Some(decided), own)) = self.frame_match(matched, accepted.is_err(), &sought) else {
            return self.navigation.surface.agreement.gap();
        };
        (matched.is_decided, matched.by_decision) = (decided.is_believed(), true);
        let at = |found: &Match| self.tile.local(matched.centre.0 + found.shift.0, matched.centre.1 + found.shift.1);
        // Over repetitive ground least squares is valid at many shifts.
        if let Some(found) = own.filter(|own| decided.is_believed() && own.refined.is_some())
            && sought.is_near(at(&found), &decided)
        {
            self.held(at(&found), Some(decided), sought.px_m);
            let accepted = found.accepted.map(|shift| self.with_map_error(shift));
            (matched.found, matched.risk) = (Match { accepted, ..found }, CONFIRMED_RISK);
            return;
        }
        // A least-squares match confirms the position as well as a directions' peak.
        let by_itself = accepted.ok().map(|shift| Match { accepted: Ok(shift), ..matched.found });
        let (col, row) = self.tile.pixel(decided.nadir);
        let together = (col - matched.centre.0, row - matched.centre.1);
        // While the last residuals are biased to one side, peaks belong to another position.
        if let Some(found) = own.filter(|own| may_correct(own) && !self.navigation.surface.agreement.is_astray()) {
            self.navigation.surface.correct(decided.nadir, at(&found), sought.px_m);
        }
        let own = own.or(by_itself);
        let off_px = own.and_then(|own| self.residual_px(at(&own), &decided));
        let (agree, astray_px) = self.agreed(off_px, sought.drift_px);
        let counts = decided.is_believed() && agree;
        let own = own.and_then(|own| at_decision(own, together, sought.drift_px, astray_px));
        if let Some(found) = own.filter(|_| counts) {
            (matched.found, matched.risk) = (found, decided.risk + GATED_RISK);
        }
    }

    /// Confirms the match of a search that a surface does not reach, or takes it back.
    fn alone(&mut self, situation: &Situation, accepted: Result<Shift, Rejection>, matched: &mut Matched) {
        self.navigation.surface.agreement.gap();
        let held = accepted.ok().filter(|_| self.confirmed(matched) == Ok(true));
        // After a loss the last frames say more of the map than the search for the position.
        if matched.search_px == self.settings.search_px {
            self.count_least_squares(situation, held.is_some());
        }
        if let Some(shift) = held {
            (matched.found.accepted, matched.risk) = (Ok(self.with_map_error(shift)), CONFIRMED_RISK);
        }
    }

    /// Whether the last frames, this one included, agree with the decision; and their mean residual, pixels.
    fn agreed(&mut self, off_px: Option<(f32, f32)>, drift_px: f32) -> (bool, f32) {
        let agreement = &mut self.navigation.surface.agreement;
        agreement.frame(off_px, gate_px(drift_px));
        (agreement.is_enough(is_adrift(drift_px)), agreement.off_px())
    }

    /// A valid least-squares match at a nadir, with the decision if there is one.
    fn held(&mut self, nadir: Local, decided: Option<Decision>, px_m: f32) {
        if let Some(decided) = decided {
            let off_px = self.residual_px(nadir, &decided);
            self.navigation.surface.agreement.frame(off_px, WRONG_PX);
        }
        self.navigation.surface.add_least_squares(nadir, px_m);
    }

    /// Residual of a nadir against the decision, pixels to the right and downwards; none beyond [`WRONG_PX`].
    fn residual_px(&self, nadir: Local, decided: &Decision) -> Option<(f32, f32)> {
        let (own, all) = (self.tile.pixel(nadir), self.tile.pixel(decided.nadir));
        let (cols, rows) = (own.0 - all.0, own.1 - all.1);
        (hypot(cols, rows) <= WRONG_PX).then_some((cols, rows))
    }

    /// A least-squares match, with the local offset of the map in its covariance if that is of another year: neighbouring frames share it.
    fn with_map_error(&self, shift: Shift) -> Shift {
        if !self.navigation.surface.map_year.is_another() {
            return shift;
        }
        let by_place = squared(MAP_SIGMA_PX);
        let covariance = shift.covariance + Matrix2::identity() * by_place;
        Shift { covariance, map_variance: shift.map_variance + by_place, ..shift }
    }

    /// Counts a frame with or without a valid least-squares match; one whose attitude is in doubt says nothing of the map.
    fn count_least_squares(&mut self, situation: &Situation, holds: bool) {
        if !self.is_unexplained(situation, 0.0) {
            self.navigation.surface.map_year.count(holds);
        }
    }

    /// The surface's decision, if its risk is at most [`RISK_MAX`].
    fn decided(&self, px_m: f32) -> Option<Decision> {
        self.navigation.surface.decision(px_m).filter(|decided| decided.risk <= RISK_MAX)
    }

    /// The search of the match; propagates the surface to it.
    fn sought(&mut self, situation: &Situation, matched: &Matched) -> Option<SearchWindow<'t>> {
        let size = self.placement.size;
        let Matched { corner: (col, row), search_px: radius, prior, .. } = *matched;
        let px_m = self.tile.ground_resolution().0;
        let (left, above) = (col - i32::from(radius), row - i32::from(radius));
        let window = self.tile.view().window(left, above, (size.0 + 2 * radius, size.1 + 2 * radius))?;
        let usual = hypot(self.settings.sigmas.velocity_m_per_s, self.added_sigmas.velocity_m_per_s);
        let known = self.navigation.filter.velocity_error();
        let known = known.filter(|errors| errors.iter().all(|(_, variance)| *variance < squared(usual)));
        let errors = known.unwrap_or([(0.0, squared(usual)); 2]);
        let sigma = sqrt(errors[0].1.max(errors[1].1));
        let moment = self.navigation.filter.extrapolated(situation.mid_exposure_at);
        let surface = &mut self.navigation.surface;
        surface.propagate(moment, errors.map(|(off, _)| off), sigma);
        let Prediction { local, sigma_m, .. } = situation.prediction;
        let nadir = self.tile.local(matched.centre.0, matched.centre.1);
        let side_m = size.0.min(size.1) as f32 * px_m;
        let middle = surface.recentre(nadir, (local, PRIOR_SIGMA_SCALE * sigma_m), side_m, px_m);
        let [east, north] = moment.velocity_m_per_s;
        // A vehicle that hovers begins no key frame.
        let drift_px = (sigma * side_m / (hypot(east, north).max(f32::MIN_POSITIVE) * px_m)).min(WRONG_PX);
        Some(SearchWindow { window, radius, prior, middle, px_m, drift_px })
    }

    /// Whether the directions confirm the least-squares solution.
    fn confirmed(&mut self, matched: &Matched) -> Result<bool, Refusal> {
        let Some(solution) = &matched.found.refined else { return Ok(false) };
        let Buffers { patch, runs, .. } = &*self.buffers;
        let patch = View::new(patch, self.placement.size).ok_or(Refusal::NoFootprint)?;
        let (place, found) = ((self.tile.view(), matched.corner), (matched.found.peak, solution));
        Ok(confirms(&patch, runs, place, found, self.frame_memory)?)
    }

    /// Adds the frame to the surface. The decision, and the frame's own peak near it, refined by least squares where that is valid.
    /// `may_hold`: whether least squares is worth trying.
    fn frame_match(
        &mut self,
        matched: &Matched,
        may_hold: bool,
        sought: &SearchWindow<'_>,
    ) -> Result<(Option<Decision>, Option<Match>), Refusal> {
        let Placement { size, aside } = self.placement;
        let Buffers { patch, runs, .. } = &*self.buffers;
        let patch = View::new(patch, size).ok_or(Refusal::NoFootprint)?;
        let SearchWindow { window, radius, prior, middle, px_m, .. } = *sought;
        let (surface, tile) = (&mut self.navigation.surface, &self.tile);
        let mut together = None;
        let at = (radius, middle);
        let own = frame_peak(&patch, runs, &window, at, (prior, may_hold), self.frame_memory, |scores, valid| {
            let frame = Frame::new(scores, valid);
            surface.add(&frame, px_m);
            together = surface.decision(px_m).filter(|decided| decided.risk <= RISK_MAX);
            let (col, row) = tile.pixel(together.filter(|_| surface.is_consistent(&frame))?.nadir);
            let shift = |at: f32, centre: f32| round((at - centre).clamp(-1e3, 1e3)) as i16;
            Some((shift(col, matched.centre.0), shift(row, matched.centre.1)))
        })?;
        let found = |FramePeak { peak, solution, holds }: FramePeak| {
            let shift = solution.nadir((aside.0.saturating_neg(), aside.1), prior);
            let grey = grey_correlation(&patch, runs, &window, radius, peak);
            let refined = holds.then_some(solution);
            let shift_px = (shift.d_col, shift.d_row);
            Match { shift: shift_px, peak, grey_correlation: [grey, 0.0], refined, accepted: Ok(shift) }
        };
        Ok((together, own.map(found)))
    }
}

impl Decision {
    /// Whether a fix may rest on it.
    fn is_believed(&self) -> bool {
        self.risk <= BELIEVED_RISK
    }
}

impl SearchWindow<'_> {
    /// Whether a nadir is no wrong match by the decision.
    fn is_near(&self, nadir: Local, decided: &Decision) -> bool {
        nadir.off_m(decided.nadir) <= WRONG_PX * self.px_m
    }
}

/// Radius of the gate for a frame's own peak, pixels.
fn gate_px(drift_px: f32) -> f32 {
    (WRONG_PX - GATE_PER_DRIFT * drift_px).max(GATE_MIN_PX)
}

/// Whether that gate is at its minimum.
fn is_adrift(drift_px: f32) -> bool {
    gate_px(drift_px) <= GATE_MIN_PX
}

/// The frame's own match moved to the decision, a shift (columns, rows); none outside the gate. Its covariance is the local offset of the
/// map and the shares of residual, drift and bias, all common to neighbouring frames. `drift_px`: dead reckoning error over a footprint,
/// one sigma. `astray_px`: mean residual of the last frames.
fn at_decision(found: Match, (d_col, d_row): (f32, f32), drift_px: f32, astray_px: f32) -> Option<Match> {
    let shift = found.accepted.ok()?;
    let apart = hypot(d_col - shift.d_col, d_row - shift.d_row);
    if apart > gate_px(drift_px) {
        return None;
    }
    let shares = squared(RESIDUAL_SHARE * apart) + squared(DRIFT_SHARE * drift_px) + squared(BIAS_SHARE * astray_px);
    let map_variance = squared(DECISION_SIGMA_PX) + shares;
    let covariance = Matrix2::identity() * map_variance;
    let shift = Shift { d_col, d_row, covariance, map_variance, ..shift };
    Some(Match { shift: (d_col, d_row), accepted: Ok(shift), ..found })
}

/// Whether a frame's own match is precise enough to correct the surface.
fn may_correct(found: &Match) -> bool {
    found
        .accepted
        .is_ok_and(|shift| (0..2).all(|axis| shift.covariance[(axis, axis)] <= squared(CORRECTING_SIGMA_MAX_PX)))
}

#[cfg(test)]
mod tests {
    use super::{
        BIAS_SHARE, DECISION_SIGMA_PX, DRIFT_SHARE, GATE_MIN_PX, GATE_PER_DRIFT, RESIDUAL_SHARE, WRONG_PX, at_decision,
    };
    use crate::matching::{Alone, Carried, Match, Rejection, Shift};
    use nalgebra::Matrix2;

    /// A frame's own match, three columns and two rows from the search's centre.
    fn own() -> Match {
        let (carried, alone) = (Carried::default(), Alone::default());
        let covariance = Matrix2::new(0.3, 0.1, 0.1, 0.2);
        let shift = Shift { d_col: 3.0, d_row: -2.0, covariance, map_variance: 0.0, carried, alone };
        Match { shift: (3.0, -2.0), peak: (3, -2), grey_correlation: [0.5, 0.0], refined: None, accepted: Ok(shift) }
    }

    #[test]
    fn a_match_within_the_gate_is_moved_to_the_decision() {
        let (apart, drift) = (0.8 * WRONG_PX, 0.1 * WRONG_PX / GATE_PER_DRIFT);
        let found = at_decision(own(), (3.0, -2.0 + apart), drift, 0.7).expect("near");
        let shift = found.accepted.expect("a match");
        assert_eq!((shift.d_col, shift.d_row), (3.0, -2.0 + apart));
        // The reported match is the one that is sent.
        assert_eq!(found.shift, (shift.d_col, shift.d_row));
        // Squares of the shares of residual, drift and bias, and of the local offset, all common to neighbouring frames.
        let of = |share: f32, way: f32| (share * way) * (share * way);
        let variance =
            of(RESIDUAL_SHARE, apart) + of(DRIFT_SHARE, drift) + of(BIAS_SHARE, 0.7) + of(DECISION_SIGMA_PX, 1.0);
        assert!((shift.covariance - Matrix2::identity() * variance).norm() < 1e-6, "{}", shift.covariance);
        assert!((shift.map_variance - variance).abs() < 1e-6, "{}", shift.map_variance);
    }

    #[test]
    fn a_match_outside_the_gate_is_none() {
        let aside = |way: f32| (3.0 + 0.6 * way, -2.0 + 0.8 * way);
        assert_eq!(at_decision(own(), aside(1.01 * WRONG_PX), 0.0, 0.0), None);
        let refused = Match { accepted: Err(Rejection::Undecided), ..own() };
        assert_eq!(at_decision(refused, (3.0, -2.0), 0.0, 0.0), None);
    }

    #[test]
    fn the_gate_shrinks_with_the_dead_reckoning_error() {
        let is_beside = |way: f32, drift_px: f32| at_decision(own(), (3.0 - way, -2.0), drift_px, 0.0).is_some();
        let drift_px = 0.3 * WRONG_PX / GATE_PER_DRIFT;
        assert!(is_beside(0.69 * WRONG_PX, drift_px) && !is_beside(0.71 * WRONG_PX, drift_px));
        // But never below the minimum, however slow the vehicle is.
        assert!(is_beside(0.9 * GATE_MIN_PX, WRONG_PX) && !is_beside(1.1 * GATE_MIN_PX, WRONG_PX));
    }
}
