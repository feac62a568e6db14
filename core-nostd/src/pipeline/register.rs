//! From the rectified patch to the fix: where it is searched, whether what is found is to be believed, and what it says.

use super::whereabouts::{Search, Usual};
use super::{Buffers, Pipeline, Prediction, Refusal, Situation};
use crate::budget::REACQUIRE_PX;
use crate::fix::{Fix, Footprint, Uncertainty, fix};
use crate::homography::Placement;
use crate::image::View;
use crate::matching::{Match, Matcher, Prior, Rejection, Request, Shift};
use crate::math::{hypot, sqrt, squared};
use crate::navigation::filter::Measurement;
use crate::navigation::observed::Observed;
use crate::navigation::protection::{Place, Protection, larger_sigma_m};
use crate::navigation::tracks::Sighting;
use nalgebra::{Matrix2, Vector2};

/// What a frame's match says, accepted or not.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Outcome {
    /// Where the patch's centre lies relative to the predicted position, columns east, pixels of the tile. Sub-pixel
    /// where the least-squares solution exists, the whole-pixel peak otherwise.
    pub d_col: f32,
    /// Rows south.
    pub d_row: f32,
    /// Where the whole-pixel peak lies, (columns, rows) in that sense.
    pub peak: [f32; 2],
    /// Normalised cross-correlation of the greys at the peak and at the best other shift.
    pub grey_correlation: [f32; 2],
    /// Radius of the search, pixels: the settings', or [`REACQUIRE_PX`] where the position had been lost.
    pub search_px: u16,
    /// Probability that the fix is a wrong place, more than three pixels off; 1 without one.
    pub risk: f32,
    /// The fix, or why there is none.
    pub fix: Result<Fix, Refusal>,
}

/// Where the patch lies in the tile.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Matched {
    pub(super) found: Match,
    /// Centre of the search in the tile, pixels.
    pub(super) centre: (f32, f32),
    /// The patch's upper left pixel in the tile at the centre of the search, column and row.
    pub(super) corner: (i32, i32),
    pub(super) search_px: u16,
    /// Of turn and scale.
    pub(super) prior: Prior,
    /// One sigma of a tilt by which it is more uncertain than the situation says, radians.
    doubt_rad: f32,
    /// Whether the surface has a decision for a fix.
    pub(super) is_decided: bool,
    /// Whether the fix is by that decision, not by the match alone.
    pub(super) by_place: bool,
    /// Whether the match is accepted alone, and the decision is for another position: attitude or position may have jumped.
    pub(super) is_elsewhere: bool,
    /// Probability that it is a wrong place.
    pub(super) risk: f32,
    /// Whether it counts as it is, or another frame must find it, too.
    counts: Result<(), Refusal>,
}

/// A position is searched for within so many sigmas of its doubt: of a hundred normal errors of an axis five lie beyond.
const DOUBT_SIGMAS: f32 = 2.0;

/// Beside the place that the filter expected matches may lie so far, one sigma, pixels, and count. Chosen: a fifth of what is a wrong fix.
const SWING_MAX_PX: f32 = 0.6;

/// What matches say of the velocity's error counts up to this where they are compared, m/s: more was not seen of an autopilot.
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

    /// Matches the patch around the predicted position. The search is as wide as the settings say; where it finds nothing after
    /// [`LOST_AFTER`](super::LOST_AFTER) frames in vain, or while the position is in such [`Doubt`](super::Doubt) that it may
    /// well lie beyond, one over ±[`REACQUIRE_PX`] follows. Where that has found it, the next frames are searched, as far as the
    /// settings say; only when one of them finds it, too, is it a fix. From then on the place that the matches know counts,
    /// carried on by the velocity: frames are searched there where the navigation is elsewhere, and what is found must not
    /// contradict it.
    ///
    /// # Errors
    /// A [`Refusal`] when no match could be tried at all; of a tried one that was not accepted the [`Outcome`] says why.
    #[inline(never)]
    pub fn match_patch(&mut self, situation: &Situation) -> Result<Matched, Refusal> {
        let usual = self.usual(situation);
        let mut search = self.whereabouts.search(&mut self.navigation.tracks, situation, &usual);
        let mut tried = self.locate(situation, search);
        if let Ok(matched) = &mut tried {
            self.together(situation, matched);
        }
        let mut sighting = self.seen(situation, &tried);
        let is_decided = tried.as_ref().is_ok_and(|matched| matched.is_decided);
        if !is_decided
            && matches!(sighting, Err(refusal) if refusal != Refusal::Featureless)
            && let Some(far) = self.whereabouts.far(&self.navigation.tracks, situation, &usual)
        {
            search = far;
            tried = self.locate(situation, search);
            sighting = self.seen(situation, &tried);
        }
        let by_place = tried.as_ref().is_ok_and(|matched| matched.by_place);
        let ended = (sighting, by_place);
        let counts = self.whereabouts.ended(&mut self.navigation.tracks, search, situation, &usual, ended);
        if let Ok(Matched { found: Match { accepted: Err(Rejection::OnBorder), shift, .. }, centre, .. }) = &tried
            && !search.is_far
            && self.navigation.tracks.is_empty()
        {
            self.whereabouts.leads_to(situation, self.tile.local(centre.0 + shift.0, centre.1 + shift.1));
        }
        if !self.whereabouts.has_found() {
            self.navigation.candidate = self.navigation.candidate.wrapping_add(1);
        }
        let doubt_rad = match (&tried, sighting, counts) {
            (Ok(Matched { found: Match { accepted: Ok(shift), .. }, .. }), Ok(sighting), Ok(())) => {
                self.learn(situation, shift, &sighting)
            }
            _ => 0.0,
        };
        let is_elsewhere = tried.as_ref().is_ok_and(|matched| matched.is_elsewhere);
        // What contradicts heading or height was never asked where it lies.
        let counts = self.uncontradicted(situation, doubt_rad, is_elsewhere, sighting.map(|_| ()).and(counts));
        tried.map(|matched| Matched { counts, doubt_rad, ..matched })
    }

    /// What is usual about the search for a frame.
    fn usual(&self, situation: &Situation) -> Usual {
        let px_m = self.tile.ground_resolution().0;
        let reach_m = f32::from(self.settings.search_px) * px_m;
        Usual {
            reach_m,
            is_in_doubt: DOUBT_SIGMAS * self.doubt.position_m > reach_m,
            px_m,
            tile_m: [self.tile.size().0, self.tile.size().1].map(|side| 0.5 * f32::from(side) * px_m),
            sigma_m_per_s: hypot(
                hypot(
                    self.settings.sigmas.velocity_m_per_s,
                    self.navigation.velocity.m_per_s().min(VELOCITY_ERROR_MAX_M_PER_S),
                ),
                self.doubt.velocity_m_per_s,
            ),
            prior_m: self.prior_m(situation),
        }
    }

    /// What `counts`, but not while anything contradicts: what was expected nowhere near is no fix, however it came about, since the
    /// attitude may be off as much as the place. `doubt_rad`: by how much a tilt was not expected.
    fn uncontradicted(
        &mut self,
        situation: &Situation,
        doubt_rad: f32,
        is_elsewhere: bool,
        counts: Result<(), Refusal>,
    ) -> Result<(), Refusal> {
        let swing_m =
            hypot(doubt_rad, self.navigation.filter.unexplained_rad(&self.prior_sigmas())) * situation.height_m;
        let is_calm = self.navigation.tracks.is_calm();
        if is_elsewhere || counts == Err(Refusal::Contradicted) {
            self.navigation.tracks.contradicted();
        }
        let is_doubted = swing_m > SWING_MAX_PX * self.tile.ground_resolution().0 || !is_calm || is_elsewhere;
        if is_doubted { counts.and(Err(Refusal::Contradicted)) } else { counts }
    }

    /// Where what was tried puts the vehicle, or why nowhere.
    fn seen(&mut self, situation: &Situation, tried: &Result<Matched, Refusal>) -> Result<Sighting, Refusal> {
        let Matched { found, centre, .. } = tried.as_ref().map_err(|refusal| *refusal)?;
        let shift = found.accepted?;
        if !self.is_plausible(situation, &shift) {
            return Err(Refusal::Contradicted);
        }
        Ok(self.sighting(situation, *centre, &shift))
    }

    /// One sigma of the navigation's position, each axis. Who says nothing of its error and has it searched so far takes it to be half as far off.
    fn prior_m(&self, situation: &Situation) -> f32 {
        let reach_m = f32::from(self.settings.search_px) * self.tile.ground_resolution().0;
        let sigma_m = situation.prediction.sigma_m;
        if sigma_m > 0.0 { sigma_m } else { 0.5 * reach_m }
    }

    /// Whether turn and scale of a match are what heading and height may be off.
    #[inline(never)]
    fn is_plausible(&mut self, situation: &Situation, shift: &Shift) -> bool {
        let ground_m = self.elevation_m(situation.prediction.local).unwrap_or_default();
        let (at, height, expected) = (situation.mid_exposure_at, situation.height(), self.expected());
        let navigation = &mut *self.navigation;
        let white_rad = white_rad(situation, navigation.azimuth.variance());
        let turn = |(off, variance)| {
            navigation.azimuth.is_plausible(situation.attitude.heading, Observed { off, variance }, white_rad)
        };
        let scale = |(off, variance)| {
            navigation.heights.is_plausible(at, height, Observed { off, variance }, ground_m, &expected)
        };
        shift.alone.turn.is_none_or(turn) & shift.alone.scale.is_none_or(scale)
    }

    /// What a match that counts says of velocity, heading and height.
    ///
    /// One sigma of a tilt by which it was not expected, radians.
    #[inline(never)]
    fn learn(&mut self, situation: &Situation, shift: &Shift, sighting: &Sighting) -> f32 {
        self.navigation.velocity.matched(situation.moment(), sighting.nadir, self.settings.sigmas.velocity_m_per_s);
        let ground_m = self.elevation_m(sighting.nadir).unwrap_or_default();
        let (at, height, expected) = (situation.mid_exposure_at, situation.height(), self.expected());
        let prior = self.prior_sigmas();
        let navigation = &mut *self.navigation;
        navigation.candidate = 0;
        if let Some((off, variance)) = shift.alone.turn {
            let white_rad = white_rad(situation, navigation.azimuth.variance());
            navigation.azimuth.update(situation.attitude.heading, Observed { off, variance }, white_rad);
        }
        if let Some((off, variance)) = shift.alone.scale {
            navigation.heights.update_scale(at, height, Observed { off, variance }, ground_m, &expected);
        }
        let known_rad = navigation.filter.tilt_sigma_rad(&prior);
        let measurement = Measurement {
            nadir: sighting.nadir,
            covariance: sighting.white,
            inflation_m2: navigation.filter.inflation_m2(shift.map_variance * squared(self.tile.resolution().0)),
            transient_rad: sqrt((squared(situation.sigma_tilt_drift_rad) - squared(known_rad)).max(0.0)),
            corrected_tilt_rad: navigation.filter.tilt_rad(),
            height_m: situation.height_m,
            heading_rad: situation.attitude.heading.0,
        };
        let overruled = navigation.tracks.overruled();
        navigation.filter.matched(&measurement, overruled.map(|aside| aside.turned_to(measurement.heading_rad)), &prior)
    }

    /// Where a match puts the nadir, and how certain that is.
    #[inline(never)]
    fn sighting(&self, situation: &Situation, centre: (f32, f32), shift: &Shift) -> Sighting {
        let Fix { covariance, by_tilt, .. } = self.fixed(situation, centre, shift, 0.0);
        Sighting {
            nadir: self.tile.local(centre.0 + shift.d_col, centre.1 + shift.d_row),
            covariance,
            white: covariance - by_tilt,
            side_m: self.placement.size.0.min(self.placement.size.1) as f32 * self.tile.ground_resolution().0,
            heading_rad: situation.attitude.heading.0,
        }
    }

    /// Where the point is that positions refer to, as far as the filter knows, and how far off that may be, behind a frame that came to
    /// `fix`. `map_sigma_m`: of the map, each axis. Without a match yet it is the navigation's position; nothing where the error of that
    /// is not known.
    pub fn place(&self, situation: &Situation, fix: Option<&Fix>, map_sigma_m: f32) -> Option<Place> {
        let Prediction { local: predicted, sigma_m: prior_m, .. } = situation.prediction;
        let prior = (prior_m > 0.0).then(|| Matrix2::identity() * squared(prior_m));
        let filter = &self.navigation.filter;
        let protection = match (filter.position(), filter.prediction()) {
            (None, _) => Protection::around(predicted, prior?),
            (Some((local, covariance)), Some((off_m, without))) => {
                Protection::around(local, covariance).without(off_m, larger_sigma_m(&without))
            }
            (Some((local, covariance)), None) => {
                let off_m = Vector2::new(predicted.east_m - local.east_m, predicted.north_m - local.north_m);
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

    fn locate(&mut self, situation: &Situation, search: Search) -> Result<Matched, Refusal> {
        let radius = if search.is_far { REACQUIRE_PX as u16 } else { self.settings.search_px };
        let Buffers { patch, runs, matcher, .. } = &mut *self.buffers;
        let Placement { size, aside } = self.placement;
        let patch = View::new(patch, size).ok_or(Refusal::NoFootprint)?;
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
        let nadir = (aside.0.saturating_neg(), aside.1);
        let (tile, rule) = (*self.tile.view(), &self.settings.accept);
        let request = Request { patch, runs, tile, predicted, nadir, radius, prior, rule };
        let found = matcher.locate(&request, self.frame_memory)?;
        let (corner, search_px) = (predicted, radius);
        Ok(Matched {
            found,
            centre,
            corner,
            search_px,
            prior,
            doubt_rad: 0.0,
            is_decided: false,
            by_place: false,
            is_elsewhere: false,
            risk: 1.0,
            counts: Ok(()),
        })
    }

    /// The fix of a match in the situation that it was made in, or why there is none.
    #[inline(never)]
    pub fn fix(&self, situation: &Situation, matched: &Matched) -> Outcome {
        let Matched { found, centre, search_px, doubt_rad, counts, risk, .. } = matched;
        let predicted = self.tile.pixel(situation.prediction.local);
        let off = (centre.0 - predicted.0, centre.1 - predicted.1);
        let fixed = |shift: Shift| self.fixed(situation, *centre, &shift, *doubt_rad);
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

    fn fixed(&self, situation: &Situation, centre: (f32, f32), shift: &Shift, doubt_rad: f32) -> Fix {
        let footprint = Footprint::of(&self.buffers.runs, &self.placement);
        let uncertainty = Uncertainty {
            tilt_rad: hypot(situation.sigma_tilt_rad, doubt_rad),
            tilt_drift_rad: hypot(situation.sigma_tilt_drift_rad, doubt_rad),
            height_m: situation.sigma_height_m,
            relief_m: situation.relief_m,
            along_m: situation.prediction.velocity_m_per_s.map(|speed| speed * situation.sigma_stamp_s),
        };
        let camera = (situation.height_m, situation.camera_offset_m);
        fix(&self.tile, centre, shift, &footprint, camera, uncertainty)
    }
}

/// One sigma of what is new in a frame's heading, beside the error that lasts.
fn white_rad(situation: &Situation, variance: f32) -> f32 {
    sqrt((squared(situation.sigma_heading_rad) - variance).max(0.0))
}
