//! What a frame's match means for what is known: search, tracks, heading, height, velocity, attitude.

use super::register::Matched;
use super::search_state::{Search, SearchParameters};
use super::{Pipeline, Refusal, Situation};
use crate::matching::{Match, Rejection, Shift};
use crate::math::{sqrt, squared};
use crate::navigation::filter::Measurement;
use crate::navigation::observed::Observed;
use crate::navigation::tracks::Sighting;
use crate::tile::Local;
use nalgebra::Matrix2;

/// An accepted match of the usual search.
pub(super) struct Near<'a> {
    pub matched: &'a Matched,
    pub shift: &'a Shift,
    pub sighting: Sighting,
    /// The filter's measurement by it.
    pub measurement: Measurement,
}

impl Pipeline<'_> {
    /// Takes what a search has found into the state of the search and into the navigation. Returns whether the match counts, or why not, and
    /// the sigma of a tilt beyond the situation's, radians.
    // Inlined, its variables would lie on the stack below a match.
    #[inline(never)]
    pub(super) fn take(
        &mut self,
        situation: &Situation,
        (search, parameters): (Search, &SearchParameters),
        tried: &Result<Matched, Refusal>,
        sighting: Result<Sighting, Refusal>,
    ) -> (Result<(), Refusal>, f32) {
        let by_decision = tried.as_ref().is_ok_and(|matched| matched.by_decision);
        // A match by a far search counts once another frame has found it.
        let near = match (tried, sighting) {
            (Ok(matched), Ok(sighting)) if !search.is_far => self.measured(situation, matched, sighting),
            _ => None,
        };
        let resected = near.as_ref().and_then(|near| self.resect(situation, near));
        let ended = (sighting.map(|sighting| resected.unwrap_or(sighting)), by_decision);
        let counts = self.search_state.finish(&mut self.navigation.tracks, search, situation, parameters, ended);
        if let Ok(Matched { found: Match { accepted: Err(Rejection::OnBorder), shift, .. }, centre, .. }) = tried
            && !search.is_far
            && self.navigation.tracks.is_empty()
        {
            self.search_state.recentre(situation, self.tile.local(centre.0 + shift.0, centre.1 + shift.1));
        }
        if !self.search_state.has_unconfirmed() {
            self.navigation.candidate = self.navigation.candidate.wrapping_add(1);
        }
        let (unexplained_rad, is_doubted) = match near {
            Some(near) if counts.is_ok() => self.update_navigation(situation, &near, resected.is_some()),
            _ => (0.0, false),
        };
        let is_elsewhere = tried.as_ref().is_ok_and(|matched| matched.is_elsewhere);
        // A match that is implausible in heading or height has not been compared with the tracks.
        let counts = sighting.map(|_| ()).and(counts);
        (self.without_contradiction(situation, is_doubted, is_elsewhere, counts), unexplained_rad)
    }

    /// `counts`, unless there is a contradiction: a match far off its prediction is no fix, however it was accepted,
    /// since the attitude may be off as much as the position. `is_doubted`: the attitude.
    fn without_contradiction(
        &mut self,
        situation: &Situation,
        is_doubted: bool,
        is_elsewhere: bool,
        counts: Result<(), Refusal>,
    ) -> Result<(), Refusal> {
        let is_calm = self.navigation.tracks.is_calm();
        if is_elsewhere || counts == Err(Refusal::Contradicted) {
            self.navigation.tracks.contradicted();
        }
        let is_doubted = is_doubted || self.is_unexplained(situation, 0.0) || !is_calm || is_elsewhere;
        if is_doubted { counts.and(Err(Refusal::Contradicted)) } else { counts }
    }

    /// An accepted match with the filter's measurement by it.
    fn measured<'a>(&self, situation: &Situation, matched: &'a Matched, sighting: Sighting) -> Option<Near<'a>> {
        let shift = matched.found.accepted.as_ref().ok()?;
        let map_variance = shift.map_variance * squared(self.tile.resolution().0);
        let measurement = self.measurement(situation, sighting.nadir, sighting.white, map_variance);
        Some(Near { matched, shift, sighting, measurement })
    }

    /// The filter's measurement by a match. `covariance`: east and north, square metres, of which `map_variance` is by a map of another
    /// year.
    pub(super) fn measurement(
        &self,
        situation: &Situation,
        nadir: Local,
        covariance: Matrix2<f32>,
        map_variance: f32,
    ) -> Measurement {
        let filter = &self.navigation.filter;
        let known_rad = filter.tilt_sigma_rad(&self.prior_sigmas());
        Measurement {
            nadir,
            covariance,
            map_variance_m2: map_variance,
            inflation_m2: filter.inflation_m2(&covariance, map_variance),
            transient_rad: sqrt((squared(situation.sigma_tilt_drift_rad) - squared(known_rad)).max(0.0)),
            corrected_tilt_rad: filter.tilt_rad(),
            height_m: situation.height_m,
            heading_rad: situation.attitude.heading.0,
        }
    }

    /// Updates velocity, heading, height and filter by an accepted match.
    ///
    /// Returns the additional sigma of a tilt, radians, if the match was inconsistent, and whether the attitude is in
    /// doubt.
    #[inline(never)]
    fn update_navigation(&mut self, situation: &Situation, near: &Near<'_>, is_resected: bool) -> (f32, bool) {
        let Near { shift, measurement, .. } = near;
        let nadir = measurement.nadir;
        self.navigation.velocity.matched(situation.moment(), nadir, self.settings.sigmas.velocity_m_per_s);
        let ground_m = self.elevation_m(nadir).unwrap_or_default();
        let (at, height, altitude_prior) = (situation.mid_exposure_at, situation.height(), self.altitude_prior());
        let prior = self.prior_sigmas();
        let navigation = &mut *self.navigation;
        (navigation.candidate, navigation.begun) = (0, 0);
        if let Some((off, variance)) = shift.alone.turn {
            let white_rad = situation.white_heading_rad(navigation.azimuth.variance());
            navigation.azimuth.update(situation.attitude.heading, Observed { off, variance }, white_rad);
        }
        if let Some((off, variance)) = shift.alone.scale {
            navigation.heights.update_scale(at, height, Observed { off, variance }, ground_m, &altitude_prior);
        }
        let overruled = navigation.tracks.overruled().map(|aside| aside.turned_to(measurement.heading_rad));
        let unexplained_rad = self.navigation.filter.matched(measurement, overruled, &prior);
        self.check_attitude(situation, (unexplained_rad, is_resected), near)
    }
}
