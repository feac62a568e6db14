//! The tilt that the perspective of pictures shows while the attitude is in doubt.
//!
//! A single picture shows it to about a degree, and only its own: an attitude that swings passes its correct value now
//! and then, and moves the matches as it does. So the tilts of consecutive pictures are averaged for as long as they
//! agree and their matches lie where the velocity leads. Once the mean agrees with the tilt before the doubt, the
//! attitude is taken to be correct again: the filter restarts with it. With any other mean, the next frames are
//! corrected for that tilt, and the doubt remains.

use super::innovation_test::TRANSIENT_MAX_RAD;
use super::jumps::{LEARNT_SIGMAS, PERIOD_US};
use super::measurement::{Measurement, PriorSigmas, tilt_jacobian};
use super::{Filter, HIDDEN_M_PER_S, TRANSIENT_GATE};
use crate::math::{combined_sigma, sqrt, squared};
use crate::navigation::protection::larger_sigma_m;
use crate::navigation::reckoning::{JUMP_ONSET_US, Moment, displacement_m};
use crate::tile::Local;
use crate::units::Micros;
use nalgebra::{Matrix2, Vector2};

/// Pictures count as one independent one more after so long, microseconds, as long as no more than [`AVERAGED_US`] of
/// them are averaged. Measured over 8 flights of 290 frames, four a second (patches of 24 and 35 pixels): their errors
/// are correlated by 0.6, 0.4, 0.1 and nothing after 0.25, 0.5, 1 and 2 s; twice the integral of that.
const INDEPENDENT_US: f32 = 0.9e6;
/// Chosen: what a slow swing moves within that time is little.
const AVERAGED_US: i32 = 2_000_000;
/// Longest interval between two pictures of a mean, microseconds, and longest time over which their matches are
/// compared. Chosen: beyond it an attitude may have swung there and back.
const GAP_US: i32 = 1_000_000;

/// The tilt that a picture shows, beyond the one that its frame was corrected for.
#[derive(Clone, Copy, Debug)]
pub struct ShownTilt {
    /// Displacement of the nadir by it, towards east and north, per metre of height: radians.
    pub nadir_per_height: Vector2<f32>,
    /// Its covariance, square radians.
    pub covariance: Matrix2<f32>,
    /// Variance that pictures of the same ground have in common besides, each axis, square radians.
    pub common_variance: f32,
}

/// A picture's tilt, and where its match is.
#[derive(Clone, Copy, Debug)]
struct Picture {
    moment: Moment,
    /// Nadir as if the frame had been corrected for the mean's reference.
    nadir: Local,
    /// Larger variance of that without the tilt, square metres.
    nadir_variance: f32,
    /// Pitch and roll, radians, and the larger variance of both, square radians.
    rad: Vector2<f32>,
    variance: f32,
    common_variance: f32,
}

impl Picture {
    fn is_finite(&self) -> bool {
        let rad = self.rad.iter().all(|rad| rad.is_finite());
        // A NaN is no variance.
        rad && self.variance > 0.0 && (self.variance + self.common_variance + self.nadir_variance).is_finite()
    }
}

/// Mean of the tilts that consecutive pictures show.
#[derive(Clone, Copy, Debug)]
struct MeanTilt {
    since: Micros,
    /// The newest picture's moment.
    moment: Moment,
    /// A match, propagated to that moment: its instant, nadir, and variance as of a picture.
    from_at: Micros,
    from: Local,
    from_variance: f32,
    /// Tilt that nadirs are corrected for, the one before the doubt when the mean began, pitch and roll, radians.
    reference_rad: [f32; 2],
    /// Pitch and roll, radians, and the larger variance of both, square radians.
    rad: Vector2<f32>,
    variance: f32,
    /// The least variance of one picture, and the newest one's common variance.
    single: f32,
    common_variance: f32,
}

impl MeanTilt {
    fn new(picture: Picture, reference_rad: [f32; 2]) -> Self {
        let Picture { moment, nadir, nadir_variance, rad, variance, common_variance } = picture;
        MeanTilt {
            since: moment.at,
            moment,
            from_at: moment.at,
            from: nadir,
            from_variance: nadir_variance,
            reference_rad,
            rad,
            variance,
            single: variance,
            common_variance,
        }
    }

    /// Propagated to a moment; `None` after too long a gap.
    fn propagated(self, moment: Moment) -> Option<Self> {
        if !(0..GAP_US).contains(&moment.at.since(self.moment.at)) {
            return None;
        }
        let from = self.from.moved(displacement_m(self.moment, moment));
        Some(MeanTilt { moment, from, ..self })
    }

    /// Whether a picture's match lies where the velocity leads: a tilt that swings moves it.
    fn is_steady(&self, picture: &Picture, sigma_m_per_s: f32) -> bool {
        let drift_m = sigma_m_per_s * picture.moment.at.since(self.from_at) as f32 * 1e-6;
        let variance = self.from_variance + picture.nadir_variance + squared(drift_m);
        squared(picture.nadir.off_m(self.from)) <= TRANSIENT_GATE * variance
    }

    /// With another picture's: their weighted mean, or that picture's alone if they disagree.
    fn with(self, picture: Picture) -> Self {
        let Picture { moment, nadir, nadir_variance, rad, variance, common_variance } = picture;
        let off = rad - self.rad;
        if off.norm_squared() > TRANSIENT_GATE * (self.variance + variance) {
            return MeanTilt::new(picture, self.reference_rad);
        }
        let gain = self.variance / (self.variance + variance);
        let single = self.single.min(variance);
        let mean = self.variance * (1.0 - gain);
        let independent = 1.0 + moment.at.since(self.since).min(AVERAGED_US) as f32 / INDEPENDENT_US;
        let is_old = moment.at.since(self.from_at) >= GAP_US;
        let (from_at, from, from_variance) =
            if is_old { (moment.at, nadir, nadir_variance) } else { (self.from_at, self.from, self.from_variance) };
        MeanTilt {
            from_at,
            from,
            from_variance,
            rad: self.rad + off * gain,
            variance: mean.max(single / independent),
            single,
            common_variance,
            ..self
        }
    }

    fn total_variance(&self) -> f32 {
        self.variance + self.common_variance
    }

    /// Whether a tilt of this sigma may be the one shown, radians.
    fn is_near(&self, rad: &Vector2<f32>, sigma_rad: f32) -> bool {
        (self.rad - rad).norm_squared() <= TRANSIENT_GATE * (self.total_variance() + squared(sigma_rad))
    }
}

/// What pictures show of the tilt while the attitude is in doubt or checked.
#[derive(Clone, Copy, Debug)]
pub(super) struct ShownTilts {
    mean: Option<MeanTilt>,
    was_in_doubt: bool,
    /// When they showed that the attitude was correct again.
    correct_at: Option<Micros>,
}

impl ShownTilts {
    pub(super) const fn new() -> Self {
        ShownTilts { mean: None, was_in_doubt: false, correct_at: None }
    }
}

impl Filter {
    /// Has the newest frame corrected for the tilt before the jumps, if the estimated one was learnt and is far off it:
    /// where no match is found, the learnt error may have ended.
    pub fn try_tilt_before(&mut self, is_tried: bool, prior: &PriorSigmas) {
        self.is_tilt_before_tried = is_tried && self.is_tilt_learnt(prior);
    }

    /// Whether the newest frame is corrected for that one.
    pub fn is_tilt_before_tried(&self) -> bool {
        self.is_tilt_before_tried
    }

    /// Whether the estimated tilt is far off the one before the jumps.
    fn is_tilt_learnt(&self, prior: &PriorSigmas) -> bool {
        let learnt_rad = Vector2::from(self.matched_tilt_rad()) - Vector2::from(self.jumps.before_rad());
        learnt_rad.norm() > LEARNT_SIGMAS * prior.tilt_rad
    }

    /// Whether pictures have shown a moment ago that the attitude is correct again: what swings would be off again within
    /// that time.
    pub fn was_attitude_in_doubt(&self) -> bool {
        self.shown.correct_at.is_some_and(|at| (0..PERIOD_US).contains(&self.moment.at.since(at)))
    }

    /// Whether pictures have to show the tilt although the attitude is not in doubt: it was a moment ago, or its error was
    /// learnt, and may end.
    pub fn is_attitude_checked(&self, prior: &PriorSigmas) -> bool {
        self.was_attitude_in_doubt() || self.is_tilt_learnt(prior)
    }

    /// Forgets what pictures have shown.
    pub fn clear_shown_tilt(&mut self) {
        self.shown = ShownTilts::new();
    }

    /// Takes the tilt that the newest frame's picture shows, after its match, while the attitude is in doubt or checked.
    /// `is_in_doubt`: which of them. `known_rad`: sigma of a tilt with which frames have fixes. Returns the sigma of a
    /// tilt that it adds to the frame's, radians.
    pub fn tilt_shown(
        &mut self,
        shown: &ShownTilt,
        (is_in_doubt, known_rad): (bool, f32),
        measurement: &Measurement,
        prior: &PriorSigmas,
    ) -> f32 {
        let reference_rad = self.shown.mean.map_or(self.jumps.before_rad(), |mean| mean.reference_rad);
        let rotation = tilt_jacobian(measurement).transpose() / measurement.height_m;
        let picture = Picture {
            moment: self.moment,
            nadir: measurement.with_tilt(reference_rad).nadir,
            nadir_variance: squared(larger_sigma_m(&measurement.covariance)),
            rad: Vector2::from(measurement.corrected_tilt_rad) + rotation * shown.nadir_per_height,
            variance: squared(larger_sigma_m(&shown.covariance)),
            common_variance: shown.common_variance,
        };
        if !picture.is_finite() {
            return 0.0;
        }
        // What was shown before a jump is not of the tilt after it.
        let has_begun = !core::mem::replace(&mut self.shown.was_in_doubt, is_in_doubt) && is_in_doubt;
        let sigma_m_per_s = prior.velocity_m_per_s.min(HIDDEN_M_PER_S);
        let propagated = self.shown.mean.filter(|_| !has_begun).and_then(|mean| mean.propagated(picture.moment));
        let steady = propagated.filter(|mean| mean.is_steady(&picture, sigma_m_per_s));
        let mean = steady.map_or(MeanTilt::new(picture, reference_rad), |mean| mean.with(picture));
        self.shown.mean = Some(mean);
        if !is_in_doubt {
            return self.check_shown(&mean, propagated.is_some() && steady.is_none());
        }
        // A frame's attitude is fitted to samples over as long: pictures of so long a time show one after a jump.
        if self.moment.at.since(mean.since) >= JUMP_ONSET_US {
            self.restart_as_shown(&mean, known_rad, measurement, prior);
        }
        0.0
    }

    /// Checks an attitude that is not in doubt: it has a transient tilt again if matches have left where the velocity leads
    /// (`is_swinging`), or pictures show another tilt than the estimated one. Returns the sigma that this adds, radians.
    fn check_shown(&mut self, mean: &MeanTilt, is_swinging: bool) -> f32 {
        let estimated_rad = Vector2::from(self.matched_tilt_rad());
        let shown_rad = if is_swinging && self.was_attitude_in_doubt() {
            TRANSIENT_MAX_RAD
        } else if mean.is_near(&estimated_rad, self.newest.map_or(0.0, |newest| newest.tilt_sigma_rad())) {
            0.0
        } else {
            // Of each axis.
            sqrt(0.5 * (mean.rad - estimated_rad).norm_squared())
        };
        let before_rad = self.transient_rad;
        self.transient_rad = before_rad.max(shown_rad);
        sqrt((squared(self.transient_rad) - squared(before_rad)).max(0.0))
    }

    /// Restarts from a match with the tilt before the doubt, if pictures show that one well enough for fixes. Otherwise, if
    /// they do not show the estimated one, with what they show, as uncertain as after a jump there.
    fn restart_as_shown(&mut self, mean: &MeanTilt, known_rad: f32, measurement: &Measurement, prior: &PriorSigmas) {
        let correct = self.jumps.means().find(|correct| mean.is_near(correct, 0.0));
        // What is shown beyond it may be noise or not, so it counts as uncertainty of each axis.
        let left_rad = |correct: &Vector2<f32>| sqrt(mean.total_variance() + 0.5 * (mean.rad - correct).norm_squared());
        if let Some(correct_rad) = correct.filter(|correct| left_rad(correct) <= known_rad) {
            let left_rad = left_rad(&correct_rad);
            self.jumps.end(correct_rad.into());
            (self.transient_rad, self.before_swing_rad) = (0.0, 0.0);
            self.shown.correct_at = Some(mean.moment.at);
            let prior = PriorSigmas { tilt_rad: combined_sigma(prior.tilt_rad, left_rad), ..*prior };
            self.start(&measurement.with_tilt(correct_rad.into()), &prior);
            return;
        }
        let estimated_rad = Vector2::from(self.matched_tilt_rad());
        if mean.is_near(&estimated_rad, 0.0) {
            return;
        }
        let shown_rad = correct.unwrap_or(mean.rad);
        let from_rad = [estimated_rad, Vector2::from(self.jumps.before_rad())];
        let squares = from_rad.map(|from_rad| (shown_rad - from_rad).norm_squared());
        let jump_rad = sqrt(0.5 * squares.into_iter().fold(0.0, f32::max));
        let prior = PriorSigmas { tilt_rad: combined_sigma(prior.tilt_rad, jump_rad), ..*prior };
        self.start(&measurement.with_tilt(shown_rad.into()), &prior);
    }
}
