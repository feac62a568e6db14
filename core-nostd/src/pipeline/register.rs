//! From the rectified patch to the fix: search, acceptance, covariance.

use super::search_state::{Search, SearchParameters};
use super::{Buffers, Pipeline, Prediction, Refusal, Situation};
use crate::budget::REACQUIRE_PX;
use crate::fix::{Fix, Footprint, Uncertainty, fix};
use crate::homography::Placement;
use crate::image::View;
use crate::matching::{Match, Matcher, OnBoard, Prior, Request, Shift};
use crate::math::{hypot, squared};
use crate::navigation::observed::Observed;
use crate::navigation::protection::{Place, Protection, larger_sigma_m};
use crate::navigation::tracks::Sighting;
use nalgebra::{Matrix2, Vector2};

/// Result of a frame's match, accepted or not.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Outcome {
    /// Position of the patch's centre relative to the predicted position, columns east, pixels of the tile. Sub-pixel
    /// if the least-squares solution exists, else the whole-pixel peak.
    pub d_col: f32,
    /// Rows south.
    pub d_row: f32,
    /// The whole-pixel peak, (columns, rows), relative likewise.
    pub peak: [f32; 2],
    /// Normalised cross-correlation of the greys at the peak and at the best other shift.
    pub grey_correlation: [f32; 2],
    /// Radius of the search, pixels: the configured one, or [`REACQUIRE_PX`] in reacquisition.
    pub search_px: u16,
    /// Probability that the fix is wrong, by more than three pixels; 1 without a fix.
    pub risk: f32,
    /// The fix, or why there is none.
    pub fix: Result<Fix, Refusal>,
}

/// A match in the tile.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Matched {
    pub(super) found: Match,
    /// Centre of the search in the tile, pixels.
    pub(super) centre: (f32, f32),
    /// Upper left pixel of the patch in the tile at the centre of the search, column and row.
    pub(super) corner: (i32, i32),
    pub(super) search_px: u16,
    /// Priors of rotation and scale.
    pub(super) prior: Prior,
    /// Sigma of a tilt beyond the situation's, radians.
    unexplained_rad: f32,
    /// Whether the surface has a decision for a fix.
    pub(super) is_decided: bool,
    /// Whether the fix is by that decision, not by the match alone.
    pub(super) by_decision: bool,
    /// Whether the match is accepted alone, and the decision is for another position: attitude or position may have jumped.
    pub(super) is_elsewhere: bool,
    /// Probability that the match is wrong.
    pub(super) risk: f32,
    /// Whether it is a fix as it is, or why not: for example, another frame has to confirm it.
    counts: Result<(), Refusal>,
}

/// Number of sigmas of a doubtful position within which it is searched: five of a hundred normal errors of an axis lie
/// beyond.
const SEARCH_SIGMAS: f32 = 2.0;

/// Largest velocity error from matches that widens their gate, m/s: no larger one was seen of an autopilot.
const VELOCITY_ERROR_MAX_M_PER_S: f32 = 5.0;

impl Pipeline<'_> {
    /// [`Pipeline::match_patch`], then [`Pipeline::fix`].
    ///
    /// # Errors
    /// Those of the first.
    pub fn register(&mut self, situation: &Situation) -> Result<Outcome, Refusal> {
        let matched = self.match_patch(situation)?;
        Ok(self.fix(situation, &matched))
    }

    /// Matches the patch around the predicted position, within the configured radius. If nothing is found after
    /// [`LOST_AFTER`](super::LOST_AFTER) frames without a match, or while the position is uncertain beyond that radius
    /// ([`AddedSigmas`](super::AddedSigmas)), a search over ±[`REACQUIRE_PX`] follows. A match by that is searched for
    /// in the next frames with the configured radius, and is a fix once one of them confirms it. From then on the track
    /// counts, propagated by the velocity: frames are searched there if the navigation is elsewhere, and a match must
    /// not contradict it.
    ///
    /// # Errors
    /// [`Refusal`] if no match could be tried; if one was tried and not accepted the [`Outcome`] has the reason.
    #[inline(never)]
    pub fn match_patch(&mut self, situation: &Situation) -> Result<Matched, Refusal> {
        let parameters = self.search_parameters(situation);
        let mut search = self.search_state.search(&mut self.navigation.tracks, situation, &parameters);
        let mut tried = self.locate(situation, search);
        match &mut tried {
            Ok(matched) => self.together(situation, matched),
            Err(_) => self.navigation.surface.agreement.gap(),
        }
        let mut sighting = self.plausible_sighting(situation, &tried);
        let is_decided = tried.as_ref().is_ok_and(|matched| matched.is_decided);
        let peak = self.unaccepted_peak(&tried);
        if !is_decided
            // What was found near by is counted once.
            && matches!(sighting, Err(refusal) if !matches!(refusal, Refusal::Featureless | Refusal::Contradicted))
            && let Some(far) = self.search_state.far(&self.navigation.tracks, situation, &parameters)
        {
            search = far;
            tried = self.locate(situation, search);
            sighting = self.plausible_sighting(situation, &tried);
        }
        let (counts, unexplained_rad) = self.take(situation, (search, &parameters), &tried, sighting);
        self.look_for_departure(situation, peak, counts);
        tried.map(|matched| Matched { counts, unexplained_rad, ..matched })
    }

    /// Parameters of the usual search for a frame.
    fn search_parameters(&self, situation: &Situation) -> SearchParameters {
        let px_m = self.tile.ground_resolution().0;
        let reach_m = f32::from(self.settings.search_px) * px_m;
        SearchParameters {
            reach_m,
            is_uncertain: SEARCH_SIGMAS * self.added_sigmas.position_m > reach_m,
            px_m,
            tile_m: [self.tile.size().0, self.tile.size().1].map(|side| 0.5 * f32::from(side) * px_m),
            sigma_m_per_s: hypot(
                hypot(
                    self.settings.sigmas.velocity_m_per_s,
                    self.navigation.velocity.m_per_s().min(VELOCITY_ERROR_MAX_M_PER_S),
                ),
                self.added_sigmas.velocity_m_per_s,
            ),
            prior_m: self.prior_m(situation),
        }
    }

    /// The nadir by a tried match, or why there is none.
    fn plausible_sighting(
        &mut self,
        situation: &Situation,
        tried: &Result<Matched, Refusal>,
    ) -> Result<Sighting, Refusal> {
        let Matched { found, centre, .. } = tried.as_ref().map_err(|refusal| *refusal)?;
        let shift = found.accepted?;
        if !self.is_plausible(situation, &shift) {
            return Err(Refusal::Contradicted);
        }
        Ok(self.sighting(situation, *centre, &shift))
    }

    /// Sigma of the navigation's position, each axis, metres; if none is reported, half the configured search radius.
    fn prior_m(&self, situation: &Situation) -> f32 {
        let reach_m = f32::from(self.settings.search_px) * self.tile.ground_resolution().0;
        let sigma_m = situation.prediction.sigma_m;
        if sigma_m > 0.0 { sigma_m } else { 0.5 * reach_m }
    }

    /// Whether rotation and scale of a match are within the gates of heading and height.
    #[inline(never)]
    fn is_plausible(&mut self, situation: &Situation, shift: &Shift) -> bool {
        let ground_m = self.elevation_m(situation.prediction.local).unwrap_or_default();
        let (at, height, altitude_prior) = (situation.mid_exposure_at, situation.height(), self.altitude_prior());
        let navigation = &mut *self.navigation;
        let white_rad = situation.white_heading_rad(navigation.azimuth.variance());
        let turn = |(off, variance)| {
            navigation.azimuth.is_plausible(situation.attitude.heading, Observed { off, variance }, white_rad)
        };
        let scale = |(off, variance)| {
            navigation.heights.is_plausible(at, height, Observed { off, variance }, ground_m, &altitude_prior)
        };
        shift.alone.turn.is_none_or(turn) & shift.alone.scale.is_none_or(scale)
    }

    /// The nadir by a match, with covariance.
    #[inline(never)]
    fn sighting(&self, situation: &Situation, centre: (f32, f32), shift: &Shift) -> Sighting {
        let Fix { covariance, tilt_drift_covariance, .. } = self.fixed(situation, centre, shift, 0.0);
        Sighting {
            nadir: self.tile.local(centre.0 + shift.d_col, centre.1 + shift.d_row),
            covariance,
            white: covariance - tilt_drift_covariance,
            side_m: self.placement.size.0.min(self.placement.size.1) as f32 * self.tile.ground_resolution().0,
            heading_rad: situation.attitude.heading.0,
        }
    }

    /// Position of the point that positions refer to, by the filter, with its protection level, after a frame with this
    /// `fix`. `map_sigma_m`: sigma of the map, each axis. Before the first match it is the navigation's position;
    /// `None` if the error of that is not known.
    pub fn place(&self, situation: &Situation, fix: Option<&Fix>, map_sigma_m: f32) -> Option<Place> {
        let Prediction { local: predicted, sigma_m: prior_m, .. } = situation.prediction;
        let prior = (prior_m > 0.0).then(|| Matrix2::identity() * squared(prior_m));
        let filter = &self.navigation.filter;
        let pictured = Matrix2::identity() * squared(filter.pictured_rad() * situation.height_m);
        let position = filter.position().map(|(local, covariance)| (local, covariance + pictured));
        let protection = match (position, filter.prediction()) {
            (None, _) => Protection::around(predicted, prior?),
            (Some((local, covariance)), Some((off_m, without))) => {
                Protection::around(local, covariance).without(off_m, larger_sigma_m(&without))
            }
            (Some((local, covariance)), None) => {
                let off_m = Vector2::from(local.to(predicted));
                Protection::around(local, covariance).without(off_m, self.prior_m(situation))
            }
        };
        let others = self.navigation.tracks.others();
        let protection =
            others.fold(protection, |protection, (other, sigma_m)| protection.or_alternative(other, sigma_m));
        let protection = fix.map_or(protection, |fix| protection.with_fix(&fix.covariance));
        let place = protection.with_map_sigma(map_sigma_m);
        if !place.protection_m.is_finite() {
            return None;
        }
        Some(Place { local: place.local.moved(situation.camera_offset_m.map(|offset| -offset)), ..place })
    }

    /// What the matcher is asked, with what it works with; `None` without a patch. `corner`: of the patch in the tile at
    /// the centre of the search.
    // Returned by a call, the request would be on the stack twice below a match.
    #[inline(always)]
    pub(super) fn request(
        &mut self,
        corner: (i32, i32),
        radius: u16,
        prior: Prior,
    ) -> Option<(Request<'_>, &mut OnBoard, &mut [u8])> {
        let Buffers { patch, runs, matcher, .. } = &mut *self.buffers;
        let Placement { size, aside } = self.placement;
        let nadir = (aside.0.saturating_neg(), aside.1);
        let (patch, tile, rule) = (View::new(patch, size)?, *self.tile.view(), &self.settings.accept);
        let request = Request { patch, runs, tile, predicted: corner, nadir, radius, prior, rule };
        Some((request, matcher, &mut *self.frame_memory))
    }

    fn locate(&mut self, situation: &Situation, search: Search) -> Result<Matched, Refusal> {
        let radius = if search.is_far { REACQUIRE_PX as u16 } else { self.settings.search_px };
        let Placement { size, aside } = self.placement;
        let looked_for = self.tile.pixel(search.at);
        // The whole pixel at which the upper left one of a patch around the nadir is nearest to that.
        let half = |side: u16| 0.5 * (side as f32 - 1.0);
        let half = (half(size.0), half(size.1));
        let corner = (crate::math::round(looked_for.0 - half.0), crate::math::round(looked_for.1 - half.1));
        if !(corner.0.abs() < 1e6 && corner.1.abs() < 1e6) {
            return Err(Refusal::OutsideReference);
        }
        let centre = (corner.0 + half.0, corner.1 + half.1);
        let prior =
            Prior { turn_rad: situation.sigma_heading_rad, scale: situation.sigma_height_m / situation.height_m };
        let predicted = (corner.0 as i32 + aside.0 as i32, corner.1 as i32 - aside.1 as i32);
        let (corner, search_px) = (predicted, radius);
        let (request, matcher, memory) = self.request(corner, search_px, prior).ok_or(Refusal::NoFootprint)?;
        let found = matcher.locate(&request, memory)?;
        Ok(Matched {
            found,
            centre,
            corner,
            search_px,
            prior,
            unexplained_rad: 0.0,
            is_decided: false,
            by_decision: false,
            is_elsewhere: false,
            risk: 1.0,
            counts: Ok(()),
        })
    }

    /// The fix of a match in the situation that it was made in, or why there is none.
    #[inline(never)]
    pub fn fix(&self, situation: &Situation, matched: &Matched) -> Outcome {
        let Matched { found, centre, search_px, unexplained_rad, counts, risk, .. } = matched;
        let predicted = self.tile.pixel(situation.prediction.local);
        let off = (centre.0 - predicted.0, centre.1 - predicted.1);
        let fixed = |shift: Shift| self.fixed(situation, *centre, &shift, *unexplained_rad);
        let fix = found.accepted.map_err(Refusal::from).and_then(|shift| counts.map(|()| fixed(shift)));
        Outcome {
            d_col: found.shift.0 + off.0,
            d_row: found.shift.1 + off.1,
            peak: [found.peak.0 as f32 + off.0, found.peak.1 as f32 + off.1],
            grey_correlation: found.grey_correlation,
            search_px: *search_px,
            risk: if fix.is_ok() { *risk } else { 1.0 },
            fix,
        }
    }

    fn fixed(&self, situation: &Situation, centre: (f32, f32), shift: &Shift, unexplained_rad: f32) -> Fix {
        let footprint = Footprint::of(&self.buffers.runs, &self.placement);
        let uncertainty = Uncertainty {
            tilt_rad: hypot(situation.sigma_tilt_rad, unexplained_rad),
            tilt_drift_rad: hypot(situation.sigma_tilt_drift_rad, unexplained_rad),
            height_m: situation.sigma_height_m,
            relief_m: situation.relief_m,
            along_m: situation.prediction.velocity_m_per_s.map(|speed| speed * situation.sigma_stamp_s),
        };
        let camera = (situation.height_m, situation.camera_offset_m);
        fix(&self.tile, centre, shift, &footprint, camera, uncertainty)
    }
}
