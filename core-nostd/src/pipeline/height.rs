//! Height of a frame above ground: from a range, the autopilot's altitude, or both.

use super::{Pipeline, Prediction};
use crate::math::hypot;
use crate::navigation::heights::{AltitudePrior, Height};
use crate::pose::{Interpolated, PoseError, Wait};
use crate::tile::Local;
use crate::units::Micros;

/// Age of the newest range after which a frame waits for no further one, microseconds. Chosen: a laser at 5 Hz, and
/// twice its latency.
const RANGE_TIMEOUT_US: i32 = 500_000;

impl Pipeline<'_> {
    /// Prior of the autopilot's altitude.
    pub(super) fn altitude_prior(&self) -> AltitudePrior {
        let sigmas = &self.settings.sigmas;
        let has_elevation = self.tile.elevation().is_some();
        let has_ranges = self.streams.slant.history().newest().is_some();
        AltitudePrior { bias_m: sigmas.altitude_m, scale: sigmas.altitude_scale, has_elevation, has_ranges }
    }

    /// Elevation of the ground: of the plane under the frame, else the model's, 0 without a model; `None` off the
    /// model.
    pub(super) fn elevation_m(&self, local: Local) -> Option<f32> {
        let Some(elevation) = self.tile.elevation() else { return Some(0.0) };
        self.navigation.plane.map(|plane| plane.height_m(local)).or_else(|| elevation.height_m(local))
    }

    /// The height without a range.
    fn by_altitude(&self, at: Micros, local: Local) -> Option<Height> {
        self.navigation.heights.known(at, self.elevation_m(local)?, &self.altitude_prior())
    }

    /// The slant range at an instant; `Ok(None)` if there is none but the height is known otherwise, and
    /// [`PoseError::NotYet`] while a range may be waited for.
    ///
    /// # Errors
    /// [`PoseError`].
    pub(super) fn slant_at(
        &self,
        at: Micros,
        local: Local,
        wait: Wait,
    ) -> Result<Option<Interpolated<f32, 1>>, PoseError> {
        let history = self.streams.slant.history();
        let is_live = history.newest().is_some_and(|(newest, _)| at.since(newest) < RANGE_TIMEOUT_US);
        match history.at(at, self.settings.range_gap_us) {
            Ok(slant) => Ok(Some(slant)),
            Err(PoseError::NotYet) if is_live && wait != Wait::No => Err(PoseError::NotYet),
            Err(error) => self.by_altitude(at, local).map(|_| None).ok_or(error),
        }
    }

    /// The newest range, or the height by the newest altitude if ranges have stopped.
    pub(super) fn newest_height_m(&self) -> Option<f32> {
        let range = self.streams.slant.history().newest();
        let Some((at, position)) = self.streams.position.history().newest() else { return range.map(|(_, m)| m) };
        let is_live = range.filter(|(newest, _)| at.since(*newest) < RANGE_TIMEOUT_US).map(|(_, slant_m)| slant_m);
        let local = Local { east_m: position.east_m, north_m: position.north_m };
        is_live
            .or_else(|| self.by_altitude(at, local).map(|height| height.metres))
            .or(range.map(|(_, slant_m)| slant_m))
    }

    /// The height at an instant, by which the height estimates are updated; `None` without any source.
    pub(super) fn height(&mut self, at: Micros, range: Option<Height>, prediction: &Prediction) -> Option<Height> {
        let ground_m = self.elevation_m(prediction.local).unwrap_or_default();
        let [v_east, v_north] = prediction.velocity_m_per_s;
        let altitude_prior = self.altitude_prior();
        let heights = &mut self.navigation.heights;
        let best = heights.best(at, range, ground_m, &altitude_prior)?;
        heights.frame(at, range, (ground_m, hypot(v_east, v_north)), &altitude_prior);
        Some(best)
    }
}
