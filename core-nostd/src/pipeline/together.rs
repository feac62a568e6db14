//! What a frame adds to those before it, and the match that all of them together lead to.
//!
//! A match of high-pass images is believed by itself where least squares hold by the directions, too: the map is of the ground's own year, or
//! the ground has not changed. Else the frame's directions are added to those of frames before, and once all of them have decided for a
//! place, a frame that says the same by itself is matched there.

use super::register::Matched;
use super::{Buffers, Pipeline, Prediction, Refusal, Situation};
use crate::budget::SEARCH_MAX_PX;
use crate::homography::Placement;
use crate::image::View;
use crate::matching::directions::aboard::{Own, confirms, look};
use crate::matching::{Match, Prior, Rejection, Shift, grey_correlation};
use crate::math::{hypot, round, sqrt, squared};
use crate::navigation::surface::{Decision, Frame};
use crate::tile::Local;
use nalgebra::Matrix2;

/// Largest risk that all frames together are wrong about the place for frames to be looked for there, and to lead the surface.
const RISK_MAX: f32 = 1e-3;
/// And for one of them to be believed. Of 131,000 fixes at and below it in 500 flights between years none was more than 1.9 pixels off, of 11,800
/// between it and twice that 2.6 pixels.
pub const BELIEVED_RISK: f32 = 1e-4;
/// What the navigation says of its error is taken times so much, before there is any evidence. Chosen: it may be off by three of its sigmas at
/// the cost of two.
const EXPECTED: f32 = 1.5;
/// A match that lies further from where all frames together put the nadir is not believed, nor does a frame's own top confirm that, pixels: it
/// is what is called a wrong place.
const WRONG_PX: f32 = 3.0;
/// So much nearer a frame's own top has to lie, for each pixel of what dead reckoning may be off by over a footprint, one sigma: after the loss
/// of satellites velocities were off by three to six of their sigmas. With 0 in its place 44 of 761 fixes were wrong there, with 3, 4 and 6
/// alike none or one of 2,400.
const NEARER: f32 = 4.0;
/// But not nearer than this, pixels: so far own tops lie from the right place by themselves.
const BESIDE_PX: f32 = 0.8;
/// One sigma, each axis, of what two years lie apart by place, pixels, where a frame is matched by itself: neighbouring frames show the same,
/// and no part of a patch says it. With 0.37 in its place 21 of 601 such matches between years were off by more than five of their sigmas.
const BY_PLACE_PX: f32 = 0.6;
/// And where all frames together put the nadir, which have seen several places: so far that was off in 84 flights between eight years where a
/// frame's own top lay beside it and the last ones' about it, 0.33 pixels, and a fifth more. With a tenth more eight of 13,600 fixes of patches of
/// 35 pixels, in one flight, were off by five of their sigmas.
const TOGETHER_PX: f32 = 0.4;
/// And what it grows by for each pixel that the own top lies from there, that dead reckoning may be off by over a footprint, and that the last
/// frames' own tops lie off in the mean: with the first, errors are as stated up to 3 pixels; of the second own tops take off half; with the
/// third, errors are as stated where velocities are off by five of their sigmas.
const APART_SHARE: f32 = 0.2;
const DRIFT_SHARE: f32 = 0.5;
const ASTRAY_SHARE: f32 = 0.5;
/// The surface is moved to own tops that are known better than this along both axes, pixels, one sigma: those that are not say little
/// more than where they were looked for, and lead it astray. With them at a gain that falls with their
/// variance 27 % of frames of 35 pixels were fixed instead of 22, and ten times as many wrong.
const LEADS_PX: f32 = 0.55;
/// Probability that least squares hold by the directions, too, at a wrong place. Of 23,000 wrong peaks between years one had such a solution, which
/// is one in 4,800 at most, 19 times of 20, and of what the high-pass images alone accept between years a quarter is wrong: 0.5e-4. Twice
/// that, for grounds where more of it is.
const CONFIRMED_RISK: f32 = 1e-4;
/// And that the decided place is wrong though the frame's own top lies beside it: of 5,800 within one pixel one was, once in 1,200 at most, 19
/// times of 20.
const BESIDE_RISK: f32 = 5e-4;

/// All numbers that the risk of a fix is made of beside those of the decision, for whoever keeps a record of which they were.
pub const COEFFICIENTS: [f32; 8] =
    [RISK_MAX, BELIEVED_RISK, EXPECTED, NEARER, BESIDE_PX, LEADS_PX, CONFIRMED_RISK, BESIDE_RISK];

/// Where a match was looked for.
struct Sought<'a> {
    window: View<'a>,
    radius: u16,
    prior: Prior,
    /// The middle of the surface off that of the search, pixels.
    middle: (i16, i16),
    px_m: f32,
    /// What dead reckoning may be off by over a footprint, one sigma, pixels.
    drift_px: f32,
}

impl<'t> Pipeline<'t> {
    /// Confirms a usual search's match that was accepted by itself, or finds one with the frames before it.
    #[inline(never)]
    pub(super) fn together(&mut self, situation: &Situation, matched: &mut Matched) {
        let accepted = matched.found.accepted;
        matched.found.accepted = accepted.and(Err(Rejection::Undecided));
        if matched.search_px as usize > SEARCH_MAX_PX {
            // A surface does not reach as far.
            if accepted.is_ok() && self.confirmed(matched) == Ok(true) {
                (matched.found.accepted, matched.risk) = (accepted, CONFIRMED_RISK);
            }
            return;
        }
        let Some(sought) = self.sought(situation, matched) else { return };
        let decided = self.decided(sought.px_m);
        if let Ok(shift) = accepted
            && self.confirmed(matched) == Ok(true)
        {
            let nadir = self.tile.local(matched.centre.0 + shift.d_col, matched.centre.1 + shift.d_row);
            self.held(nadir, decided, sought.px_m);
            self.navigation.surface.count_least_squares(true);
            let believed = decided.filter(Decision::is_believed);
            matched.is_decided = believed.is_some();
            matched.is_elsewhere = believed.is_some_and(|decided| !sought.is_near(nadir, &decided));
            (matched.found.accepted, matched.risk) = (Ok(self.of_year(shift)), CONFIRMED_RISK);
            return;
        }
        self.navigation.surface.count_least_squares(false);
        let Ok((decided, own)) = self.looked(matched, accepted.is_err(), &sought) else { return };
        let Some(decided) = decided else {
            self.navigation.surface.agreement.gap();
            return;
        };
        (matched.is_decided, matched.by_place) = (decided.is_believed(), true);
        let at = |found: &Match| self.tile.local(matched.centre.0 + found.shift.0, matched.centre.1 + found.shift.1);
        // Over ground that repeats least squares hold at many places.
        if let Some(found) = own.filter(|own| decided.is_believed() && own.refined.is_some())
            && sought.is_near(at(&found), &decided)
        {
            self.held(at(&found), Some(decided), sought.px_m);
            let accepted = found.accepted.map(|shift| self.of_year(shift));
            (matched.found, matched.risk) = (Match { accepted, ..found }, CONFIRMED_RISK);
            return;
        }
        // What least squares found confirms the place as well as a top does.
        let by_itself = accepted.ok().map(|shift| Match { accepted: Ok(shift), ..matched.found });
        let (col, row) = self.tile.pixel(decided.nadir);
        let together = (col - matched.centre.0, row - matched.centre.1);
        // What lies to one side of the place by the last frames is another one.
        if let Some(found) = own.filter(|own| leads(own) && !self.navigation.surface.agreement.is_astray()) {
            self.navigation.surface.correct(decided.nadir, at(&found), sought.px_m);
        }
        let own = own.or(by_itself);
        let off_px = own.and_then(|own| self.off_px(at(&own), &decided));
        let (agree, astray_px) = self.agreed(off_px, sought.drift_px);
        let counts = decided.is_believed() && agree;
        let own = own.and_then(|own| beside(own, together, sought.drift_px, astray_px));
        if let Some(found) = own.filter(|_| counts) {
            (matched.found, matched.risk) = (found, decided.risk + BESIDE_RISK);
        }
    }

    /// Whether the last frames, this one included, say the same as all of them together, and how far off that their tops lie in the mean, pixels.
    fn agreed(&mut self, off_px: Option<(f32, f32)>, drift_px: f32) -> (bool, f32) {
        let is_own_year = !self.navigation.surface.is_another_year();
        let agreement = &mut self.navigation.surface.agreement;
        agreement.frame(off_px, near_px(drift_px));
        // Over a map of its own year it is least squares that hold.
        let agree = agreement.is_enough(is_adrift(drift_px)) || is_own_year && !agreement.is_astray();
        (agree, agreement.off_px())
    }

    /// Least squares hold at a nadir; all frames together may have decided for a place.
    fn held(&mut self, nadir: Local, decided: Option<Decision>, px_m: f32) {
        if let Some(decided) = decided {
            let off_px = self.off_px(nadir, &decided);
            self.navigation.surface.agreement.frame(off_px, WRONG_PX);
        }
        self.navigation.surface.add_least_squares(nadir, px_m);
    }

    /// How far a nadir lies off the decided place, pixels to the right and downwards, where that is no wrong place.
    fn off_px(&self, nadir: Local, decided: &Decision) -> Option<(f32, f32)> {
        let (own, all) = (self.tile.pixel(nadir), self.tile.pixel(decided.nadir));
        let (cols, rows) = (own.0 - all.0, own.1 - all.1);
        (hypot(cols, rows) <= WRONG_PX).then_some((cols, rows))
    }

    /// A match of least squares, as uncertain as two years make it where the map is of another one: alike in its neighbours.
    fn of_year(&self, shift: Shift) -> Shift {
        if !self.navigation.surface.is_another_year() {
            return shift;
        }
        let by_place = squared(BY_PLACE_PX);
        let covariance = shift.covariance + Matrix2::identity() * by_place;
        Shift { covariance, map_variance: shift.map_variance + by_place, ..shift }
    }

    /// Where all frames together put the nadir, once they have decided.
    fn decided(&self, px_m: f32) -> Option<Decision> {
        self.navigation.surface.decision(px_m).filter(|decided| decided.risk <= RISK_MAX)
    }

    /// Where the match was looked for, with the surface carried on to there.
    fn sought(&mut self, situation: &Situation, matched: &Matched) -> Option<Sought<'t>> {
        let size = self.placement.size;
        let Matched { corner: (col, row), search_px: radius, prior, .. } = *matched;
        let px_m = self.tile.ground_resolution().0;
        let (left, above) = (col - i32::from(radius), row - i32::from(radius));
        let window = self.tile.view().window(left, above, (size.0 + 2 * radius, size.1 + 2 * radius))?;
        let usual = hypot(self.settings.sigmas.velocity_m_per_s, self.doubt.velocity_m_per_s);
        let known = self.navigation.filter.velocity_error();
        let known = known.filter(|errors| errors.iter().all(|(_, variance)| *variance < squared(usual)));
        let errors = known.unwrap_or([(0.0, squared(usual)); 2]);
        let sigma = sqrt(errors[0].1.max(errors[1].1));
        let moment = self.navigation.filter.reckoned(situation.mid_exposure_at);
        let surface = &mut self.navigation.surface;
        surface.propagate(moment, errors.map(|(off, _)| off), sigma);
        let Prediction { local, sigma_m, .. } = situation.prediction;
        let nadir = self.tile.local(matched.centre.0, matched.centre.1);
        let side_m = size.0.min(size.1) as f32 * px_m;
        let middle = surface.recentre(nadir, (local, EXPECTED * sigma_m), side_m, px_m);
        let [east, north] = moment.velocity_m_per_s;
        // One that stands still sees no other ground.
        let drift_px = (sigma * side_m / (hypot(east, north).max(f32::MIN_POSITIVE) * px_m)).min(WRONG_PX);
        Some(Sought { window, radius, prior, middle, px_m, drift_px })
    }

    /// Whether least squares hold by the directions, too.
    fn confirmed(&mut self, matched: &Matched) -> Result<bool, Refusal> {
        let Some(solution) = &matched.found.refined else { return Ok(false) };
        let Buffers { patch, runs, .. } = &*self.buffers;
        let patch = View::new(patch, self.placement.size).ok_or(Refusal::NoFootprint)?;
        let (place, found) = ((self.tile.view(), matched.corner), (matched.found.peak, solution));
        Ok(confirms(&patch, runs, place, found, self.frame_memory)?)
    }

    /// Where all frames together put the nadir, this one included, and the frame's own match there, refined where least squares hold, as far as
    /// there are both. `may_hold`: whether least squares are worth a try.
    fn looked(
        &mut self,
        matched: &Matched,
        may_hold: bool,
        sought: &Sought<'_>,
    ) -> Result<(Option<Decision>, Option<Match>), Refusal> {
        let Placement { size, aside } = self.placement;
        let Buffers { patch, runs, .. } = &*self.buffers;
        let patch = View::new(patch, size).ok_or(Refusal::NoFootprint)?;
        let Sought { window, radius, prior, middle, px_m, .. } = *sought;
        let (surface, tile) = (&mut self.navigation.surface, &self.tile);
        let mut together = None;
        let at = (radius, middle);
        let own = look(&patch, runs, &window, at, (prior, may_hold), self.frame_memory, |scores, valid| {
            let frame = Frame::new(scores, valid);
            surface.add(&frame, px_m);
            together = surface.decision(px_m).filter(|decided| decided.risk <= RISK_MAX);
            let (col, row) = tile.pixel(together.filter(|_| surface.is_consistent(&frame))?.nadir);
            let shift = |at: f32, centre: f32| round((at - centre).clamp(-1e3, 1e3)) as i16;
            Some((shift(col, matched.centre.0), shift(row, matched.centre.1)))
        })?;
        let found = |Own { peak, solution, holds }: Own| {
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
    /// Whether a frame may have its fix there.
    fn is_believed(&self) -> bool {
        self.risk <= BELIEVED_RISK
    }
}

impl Sought<'_> {
    /// Whether a nadir lies where all frames together put it.
    fn is_near(&self, nadir: Local, decided: &Decision) -> bool {
        nadir.off_m(decided.nadir) <= WRONG_PX * self.px_m
    }
}

/// How near to the decided place a frame's own top has to lie, pixels.
fn near_px(drift_px: f32) -> f32 {
    (WRONG_PX - NEARER * drift_px).max(BESIDE_PX)
}

/// Whether that is as near as it lies by itself.
fn is_adrift(drift_px: f32) -> bool {
    near_px(drift_px) <= BESIDE_PX
}

/// A frame's own match moved to where all frames together put the nadir, and as uncertain as two years, the way between the two and dead
/// reckoning make that; nothing where they are too far apart. All of that is alike in its neighbours. `drift_px`: what dead reckoning
/// may be off by over a footprint, one sigma. `astray_px`: how far the last frames' tops lie off the place in the mean.
fn beside(found: Match, (d_col, d_row): (f32, f32), drift_px: f32, astray_px: f32) -> Option<Match> {
    let shift = found.accepted.ok()?;
    let apart = hypot(d_col - shift.d_col, d_row - shift.d_row);
    if apart > near_px(drift_px) {
        return None;
    }
    let shares = squared(APART_SHARE * apart) + squared(DRIFT_SHARE * drift_px) + squared(ASTRAY_SHARE * astray_px);
    let map_variance = squared(TOGETHER_PX) + shares;
    let covariance = Matrix2::identity() * map_variance;
    let shift = Shift { d_col, d_row, covariance, map_variance, ..shift };
    Some(Match { shift: (d_col, d_row), accepted: Ok(shift), ..found })
}

/// Whether a frame's own match is known well enough to move the surface.
fn leads(found: &Match) -> bool {
    found.accepted.is_ok_and(|shift| (0..2).all(|axis| shift.covariance[(axis, axis)] <= squared(LEADS_PX)))
}

#[cfg(test)]
mod tests {
    use super::{APART_SHARE, ASTRAY_SHARE, BESIDE_PX, DRIFT_SHARE, NEARER, TOGETHER_PX, WRONG_PX, beside};
    use crate::matching::{Alone, Carried, Match, Rejection, Shift};
    use nalgebra::Matrix2;

    /// A frame's own match, three columns and two rows off.
    fn own() -> Match {
        let (carried, alone) = (Carried::default(), Alone::default());
        let covariance = Matrix2::new(0.3, 0.1, 0.1, 0.2);
        let shift = Shift { d_col: 3.0, d_row: -2.0, covariance, map_variance: 0.0, carried, alone };
        Match { shift: (3.0, -2.0), peak: (3, -2), grey_correlation: [0.5, 0.0], refined: None, accepted: Ok(shift) }
    }

    #[test]
    fn what_lies_beside_the_decided_place_is_moved_there() {
        let (apart, drift) = (0.8 * WRONG_PX, 0.1 * WRONG_PX / NEARER);
        let found = beside(own(), (3.0, -2.0 + apart), drift, 0.7).expect("near");
        let shift = found.accepted.expect("a match");
        assert_eq!((shift.d_col, shift.d_row), (3.0, -2.0 + apart));
        // What is told of the match is what is sent.
        assert_eq!(found.shift, (shift.d_col, shift.d_row));
        // The way between the two, the drift, what tops are astray, and what two years lie apart by place: alike in all of its neighbours.
        let of = |share: f32, way: f32| (share * way) * (share * way);
        let variance = of(APART_SHARE, apart) + of(DRIFT_SHARE, drift) + of(ASTRAY_SHARE, 0.7) + of(TOGETHER_PX, 1.0);
        assert!((shift.covariance - Matrix2::identity() * variance).norm() < 1e-6, "{}", shift.covariance);
        assert!((shift.map_variance - variance).abs() < 1e-6, "{}", shift.map_variance);
    }

    #[test]
    fn what_does_not_is_none() {
        let aside = |way: f32| (3.0 + 0.6 * way, -2.0 + 0.8 * way);
        assert_eq!(beside(own(), aside(1.01 * WRONG_PX), 0.0, 0.0), None);
        let refused = Match { accepted: Err(Rejection::Undecided), ..own() };
        assert_eq!(beside(refused, (3.0, -2.0), 0.0, 0.0), None);
    }

    #[test]
    fn it_has_to_lie_nearer_where_dead_reckoning_is_worse() {
        let is_beside = |way: f32, drift_px: f32| beside(own(), (3.0 - way, -2.0), drift_px, 0.0).is_some();
        let drift_px = 0.3 * WRONG_PX / NEARER;
        assert!(is_beside(0.69 * WRONG_PX, drift_px) && !is_beside(0.71 * WRONG_PX, drift_px));
        // But never nearer than it lies by itself, however slow the vehicle is.
        assert!(is_beside(0.9 * BESIDE_PX, WRONG_PX) && !is_beside(1.1 * BESIDE_PX, WRONG_PX));
    }
}
