//! Checks a doubted attitude against the perspective of the pictures.
//!
//! Once a match has jumped its position and the attitude are both in doubt, and on a straight leg no later match shows
//! which of them it was. The perspective of a picture does: it shows the tilt alone, and so the position.

use super::conclusions::Near;
use super::register::Matched;
use super::together::{MAP_SIGMA_PX, WRONG_PX};
use super::{Pipeline, Refusal, Situation};
use crate::budget::SEARCH_MAX_PX;
use crate::matching::{Matcher, Prior, Rejection};
use crate::math::{hypot, squared};
use crate::navigation::filter::{JUMP_GATE, Resected, TRANSIENT_GATE};
use crate::navigation::tracks::Sighting;
use crate::tile::Local;
use nalgebra::{Matrix2, Vector2};

/// One sigma of the ground's slope beyond the plane of rectification, along each axis. Chosen: half a metre over a
/// footprint of 100 m, as by an elevation model of 30 m posts, or over ground that is stated to be level.
const SLOPE_SIGMA: f32 = 0.005;
/// One sigma of the slope where there is no elevation model, while pictures are asked only because frames were not matched: the ground may have any
/// slope that land has. Chosen: slopes up to 7 % show nothing.
const UNKNOWN_SLOPE_SIGMA: f32 = 0.05;
/// Slope that relief about that plane passes for, as a share of relief over half of the patch's shorter side: the
/// curvature of displacements by random relief, of which a match has a share of 0.15 ([`crate::fix`]), is 1.8 times that.
const RELIEF_SHARE: f32 = 0.27;
/// One sigma of the tilt in doubt, radians, for what it turns and scales the picture by: a roll about the axis of a vehicle that is pitched
/// turns it, and the height by a slant range is as much off. Chosen: that of an attitude 0.3 s late of a vehicle that rocks by 20 degrees
/// a second. With the priors of a correct attitude pictures showed two thirds of such tilts.
const DOUBTED_RAD: f32 = 0.1;

/// Variance of what a picture shows where the map may be of another year, as a share of that over a map of the ground's own: changed ground
/// makes a curvature. Measured between years: 7 to 12.
const ANOTHER_YEAR_SHARE: f32 = 12.0;
/// Displacement by a jump of the tilt, pixels, for which pictures are asked where it could pass the gate. Chosen: three quarters of a wrong fix's
/// error. With half of it they are asked in flights in which nothing fails, two metres a pixel, and the ground's slope costs fixes.
const HIDDEN_PX: f32 = 0.75 * WRONG_PX;
/// Largest unexplained displacement by tilt with which frames have fixes, one sigma, pixels. Chosen: a fifth of a wrong
/// fix's error.
const UNEXPLAINED_MAX_PX: f32 = 0.6;

impl Pipeline<'_> {
    /// Resects an accepted match before the filter takes it, if its frame's attitude is in doubt or has to be checked. Returns the sighting
    /// for the tracks: while the attitude is in doubt the position by resection, which a tilt does not displace. `None` without a resection.
    #[inline(never)]
    pub(super) fn resect(&mut self, situation: &Situation, near: &Near<'_>) -> Option<Sighting> {
        let Near { matched, sighting, measurement, .. } = near;
        let prior = self.prior_sigmas();
        let hidden_m = HIDDEN_PX * self.tile.ground_resolution().0;
        // Photos of a plan are rare, but there is no gap between them where each is matched.
        let is_gap = self.navigation.begun > 1;
        let filter = &mut self.navigation.filter;
        // In a wider search no picture shows a tilt.
        if self.settings.search_px as usize <= SEARCH_MAX_PX && filter.may_hide(is_gap, hidden_m) {
            filter.ask_pictures();
        }
        let filter = &self.navigation.filter;
        let is_in_doubt = filter.innovation_beyond(JUMP_GATE, measurement).is_some()
            || filter.is_other_tilt_tried()
            || self.is_unexplained(situation, 0.0);
        if !is_in_doubt && !filter.is_attitude_checked(&prior) {
            self.navigation.filter.clear_resections();
            return None;
        }
        let resected = self.resected(situation, matched, is_in_doubt);
        let (nadir, covariance) =
            self.navigation.filter.resect(resected.as_ref(), !is_in_doubt, measurement, &prior)?;
        Some(if is_in_doubt { Sighting { nadir, covariance, white: covariance, ..*sighting } } else { *sighting })
    }

    /// Checks the attitude of an accepted match's frame once the filter has taken the match. `unexplained_rad`: sigma of a tilt beyond the
    /// situation's by this match. `is_resected`: [`Pipeline::resect`] had a result. Returns that sigma with what this adds, and
    /// whether the attitude is in doubt.
    #[inline(never)]
    pub(super) fn check_attitude(
        &mut self,
        situation: &Situation,
        (unexplained_rad, is_resected): (f32, bool),
        near: &Near<'_>,
    ) -> (f32, bool) {
        let (prior, measurement) = (self.prior_sigmas(), &near.measurement);
        let filter = &self.navigation.filter;
        // A frame that was corrected for another tilt than the estimated one has no fix.
        let is_in_doubt = self.is_unexplained(situation, unexplained_rad) || filter.is_other_tilt_tried();
        let known_rad = UNEXPLAINED_MAX_PX * self.tile.ground_resolution().0 / situation.height_m;
        if !is_resected {
            // Frames that are decided by several together have no picture.
            let is_silent = !near.matched.by_decision && filter.are_pictures_asked();
            return (unexplained_rad, is_in_doubt || is_silent || filter.was_attitude_in_doubt());
        }
        let Some(shown_rad) = self.navigation.filter.conclude((is_in_doubt, known_rad), measurement, &prior) else {
            return (unexplained_rad, true);
        };
        let unexplained_rad = hypot(unexplained_rad, shown_rad);
        (unexplained_rad, self.is_unexplained(situation, unexplained_rad))
    }

    /// The peak of a usual search over a map of another year that is unambiguous, though not accepted.
    pub(super) fn unaccepted_peak(&self, tried: &Result<Matched, Refusal>) -> Option<Local> {
        let Ok(Matched { found, centre, .. }) = tried else { return None };
        let is_peak = matches!(found.accepted, Err(Rejection::Imprecise | Rejection::Undecided));
        let is_one = is_peak && self.navigation.surface.map_year.is_another();
        is_one.then(|| self.tile.local(centre.0 + found.shift.0, centre.1 + found.shift.1))
    }

    /// Takes a run of such peaks that are together elsewhere than the fixes before for a jump. `counts`: whether the frame has a fix, or why
    /// not.
    pub(super) fn look_for_departure(
        &mut self,
        situation: &Situation,
        peak: Option<Local>,
        counts: Result<(), Refusal>,
    ) {
        let at = situation.mid_exposure_at;
        if counts.is_ok() {
            return self.navigation.departure.fixed(at);
        }
        let px_m = self.tile.ground_resolution().0;
        let variance = squared(MAP_SIGMA_PX * px_m);
        let covariance = Matrix2::identity() * variance;
        let awaited = peak.filter(|_| self.navigation.departure.is_awaited(at));
        let measurement = awaited.map(|nadir| self.measurement(situation, nadir, covariance, variance));
        let filter = &self.navigation.filter;
        let off_m = measurement.and_then(|measurement| filter.innovation_beyond(TRANSIENT_GATE, &measurement));
        let off_m = off_m.filter(|[east, north]| hypot(*east, *north) > WRONG_PX * px_m);
        if self.navigation.departure.unfixed(at, off_m, px_m)
            && let Some(measurement) = measurement
        {
            let prior = self.prior_sigmas();
            self.navigation.filter.matched(&measurement, off_m, &prior);
        }
    }

    /// Whether matches have shown a tilt that nothing explains, which may displace fixes. `unexplained_rad`: by the
    /// newest one.
    pub(super) fn is_unexplained(&self, situation: &Situation, unexplained_rad: f32) -> bool {
        let unexplained_rad = hypot(unexplained_rad, self.navigation.filter.unexplained_rad(&self.prior_sigmas()));
        unexplained_rad * situation.height_m > UNEXPLAINED_MAX_PX * self.tile.ground_resolution().0
    }

    /// A match corrected for the tilt that its picture shows; `None` if it does not determine it.
    fn resected(&mut self, situation: &Situation, matched: &Matched, is_in_doubt: bool) -> Option<Resected> {
        if matched.by_decision {
            return None;
        }
        let share = if self.navigation.surface.map_year.is_own() { 1.0 } else { ANOTHER_YEAR_SHARE };
        let px_m = self.tile.ground_resolution().0;
        let (height_px, size) = (situation.height_m / px_m, self.placement.size);
        let coupled = DOUBTED_RAD * hypot(situation.attitude.pitch.0, situation.attitude.roll.0);
        let Prior { turn_rad, scale } = matched.prior;
        let prior = Prior { turn_rad: hypot(turn_rad, coupled), scale: hypot(scale, coupled) };
        let (request, matcher, memory) = self.request(matched.corner, matched.search_px, prior)?;
        let curvature = matcher.curvature(&request, &matched.found, memory)?;
        // Rows run south.
        let (by_px, c) = curvature.resected(height_px);
        let covariance = Matrix2::new(c[(0, 0)], -c[(0, 1)], -c[(1, 0)], c[(1, 1)]) * (share * squared(px_m));
        let is_taken_for_level =
            self.navigation.plane.is_some() || is_in_doubt || self.navigation.filter.has_been_off(&self.prior_sigmas());
        let slope = if is_taken_for_level { SLOPE_SIGMA } else { UNKNOWN_SLOPE_SIGMA };
        let relief = RELIEF_SHARE * situation.relief_m / (0.5 * size.0.min(size.1) as f32 * px_m);
        Some(Resected {
            by_m: Vector2::new(by_px.x, -by_px.y) * px_m,
            covariance,
            common_variance: (squared(slope) + squared(relief)) * squared(situation.height_m),
        })
    }
}
