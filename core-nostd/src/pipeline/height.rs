//! The height above ground of a frame: by a range, by the autopilot's altitude, or by both.

use super::{Pipeline, Prediction};
use crate::math::hypot;
use crate::navigation::heights::{AltitudePrior, Height};
use crate::pose::{Interpolated, PoseError, Wait};
use crate::tile::Local;
use crate::units::Micros;

/// A range that is older than this does not come any more, microseconds: a frame waits for no next one. Chosen: a laser at 5 Hz, and
/// twice what it takes to arrive.
const SILENT_US: i32 = 500_000;

impl Pipeline<'_> {
    /// What is known of the autopilot's altitude beforehand.
    pub(super) fn expected(&self) -> AltitudePrior {
        let sigmas = &self.settings.sigmas;
        let has_elevation = self.tile.elevation().is_some();
        let has_ranges = self.streams.slant.history().newest().is_some();
        AltitudePrior { bias_m: sigmas.altitude_m, scale: sigmas.altitude_scale, has_elevation, has_ranges }
    }

    /// Elevation of the ground, 0 where it is taken to be level: of the plane under the frame, or the model's; nothing off that.
    pub(super) fn elevation_m(&self, local: Local) -> Option<f32> {
        let Some(elevation) = self.tile.elevation() else { return Some(0.0) };
        self.navigation.plane.map(|plane| plane.height_m(local)).or_else(|| elevation.height_m(local))
    }

    /// The height without a range.
    fn known(&self, at: Micros, local: Local) -> Option<Height> {
        self.navigation.heights.known(at, self.elevation_m(local)?, &self.expected())
    }

    /// The slant range at an instant; `Ok(None)` where there is none and the height is known without, and
    /// [`PoseError::NotYet`] while it is worth waiting for.
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
        let comes = history.newest().is_some_and(|(newest, _)| at.since(newest) < SILENT_US);
        match history.at(at, self.settings.range_gap_us) {
            Ok(slant) => Ok(Some(slant)),
            Err(PoseError::NotYet) if comes && wait != Wait::No => Err(PoseError::NotYet),
            Err(error) => self.known(at, local).map(|_| None).ok_or(error),
        }
    }

    /// The newest range, or the height at the newest altitude where no range comes any more.
    pub(super) fn newest_height_m(&self) -> Option<f32> {
        let range = self.streams.slant.history().newest();
        let Some((at, position)) = self.streams.position.history().newest() else { return range.map(|(_, m)| m) };
        let comes = range.filter(|(newest, _)| at.since(*newest) < SILENT_US).map(|(_, slant_m)| slant_m);
        let local = Local { east_m: position.east_m, north_m: position.north_m };
        comes.or_else(|| self.known(at, local).map(|height| height.metres)).or(range.map(|(_, slant_m)| slant_m))
    }

    /// The height at an instant, which the heights that are kept then learn of; `None` where nothing says how high.
    pub(super) fn height(&mut self, at: Micros, range: Option<Height>, prediction: &Prediction) -> Option<Height> {
        let ground_m = self.elevation_m(prediction.local).unwrap_or_default();
        let [v_east, v_north] = prediction.velocity_m_per_s;
        let expected = self.expected();
        let heights = &mut self.navigation.heights;
        let best = heights.best(at, range, ground_m, &expected)?;
        heights.frame(at, range, (ground_m, hypot(v_east, v_north)), &expected);
        Some(best)
    }
}
