//! Log-likelihood surface of the nadir over several key frames: track-before-detect.
//!
//! Over a map of another year a single patch is weak evidence and may be wrong (a moved shore line, a harvested field), but false peaks of
//! different ground lie at different shifts. So the correlation scores of all shifts are summed along the motion before anything is decided
//! (track-before-detect: Barniv 1985; for scenes, US patent 5,146,228 of 1990, expired). The sum is a surface over candidate positions of
//! the nadir, two pixels apart, propagated by the velocity. Between two key frames the velocity's error enters as process noise: each cell
//! takes the best of its neighbours less the cost of the step (max-sum recursion, Viterbi).
//!
//! Ground counts once: a key frame begins where the vehicle is three quarters of a footprint away from all earlier ones. Until the next
//! one, a frame of more texture replaces it.
//!
//! *Evidence* is log-likelihood in units of about 1/20 nat. A key frame contributes at most 90, since one in 120 is wrong however clear its
//! peak is.

pub mod agreement;
pub mod map_year;
mod peak;
mod grid;

use super::reckoning::{Moment, displacement_m};
use crate::matching::directions::half::{MIDDLE, SHIFTS, STEP_PX, Scores};
use crate::matching::local_maximum::vertex;
use crate::math::{exp, hypot, ln, round};
use crate::tile::Local;
use crate::units::Micros;
use agreement::Agreement;
use grid::{LikelihoodGrid, PROCESS_NOISE_MIN, StoredGrid};
use heapless::Deque;
use map_year::MapYear;
use peak::Peak;

/// Most evidence of one key frame against a shift: one in 120 single patches of 21 to 64 pixels whose evidence reaches it is wrong. Of 40,
/// 60, 90 and no limit the value that decides most sums of two to eight patches at one wrong of 10,000.
const CAP: f32 = 90.0;
/// Log-odds that the surface's peak is more than three pixels off: `INTERCEPT` − `SLOPE` l^`EXPONENT`, with l the peak's lead over the
/// second peak.
///
/// Fitted by logistic regression over sums of one, two, three, five and eight adjacent patches of 21 to 64 pixels, each of eight years
/// matched against every other (5 m a pixel, farmland and lakes). Stated and observed risk agree within a factor of 2.5 from 0.2 down to
/// 1e-3, whatever the number of patches; below, fewer are wrong than stated.
const INTERCEPT: f32 = 1.115;
const SLOPE: f32 = 0.3612;
const EXPONENT: f32 = 0.6;
/// Most evidence that a frame may have for another shift and still be matched at the decided position: a twentieth of what decides. Nothing
/// is asked of the frame alone: of 5,800 frames whose peak lay near the decided position in flights between years one was off by more than
/// 3 pixels, whatever their lead.
const CONTRADICTION_MAX: f32 = 10.0;
/// Share of the evidence that is kept at each new key frame over a map of another year (exponential forgetting): the sum is worth the last
/// ten. The map's offset changes by place and the velocity is off by more than it states, so that old evidence holds the peak back where
/// the nadir was: with all of it kept 82 of 3,100 decided positions in flights between years were off by more than 3 pixels. With 0.95 a
/// twentieth more frames of 35 and a tenth more of 24 pixels are fixed, none wrong, but of 42,000 frames outside the map one is accepted as
/// well, and none with 0.9. Over a map of the ground's own year all is kept: it has to outweigh what a wrong attitude puts elsewhere.
const FORGETTING_FACTOR: f32 = 0.9;
/// Least curvature of a frame's peak.
const CURVATURE_MIN: f32 = 0.02;
/// A frame of the newest key frame's ground replaces it if it has so many times its texture. Chosen: a smaller gain is not worth the
/// computing time.
const TEXTURE_RATIO_MIN: f32 = 1.1;
/// Share of the footprint's smaller side that the vehicle has to be away from all key frames for a new one to begin.
const KEY_FRAME_DISTANCE: f32 = 0.75;
/// Key frames that are remembered. Chosen: a circle of as many footprints is flown for the second time after a minute or more.
const KEY_FRAMES: usize = 13;
/// Longest time between two frames over which the surface is propagated, microseconds: as for tracks.
const STEP_MAX_US: i32 = 9_000_000;
/// Longest time between two frames that agree with the decision one after the other, microseconds: what drifts, drifts further in a longer
/// one. Chosen: four frames at two a second.
const CONSECUTIVE_US: i32 = 2_000_000;
/// Share of the residual by which the surface is moved towards a measured nadir. Chosen: a velocity error is corrected over a few of them.
const GAIN: f32 = 0.3;
/// Residuals count up to this, pixels: a larger one is seldom due to the velocity, and frames of the same ground are wrong alike. In 28
/// flights between years, patches of 35 pixels, seven frames of a surface that had been pulled away were fixed more than 3 pixels off, and
/// none with this limit. Of 0.5, 0.75, 1 and none the one that had none of those.
const RESIDUAL_MAX_PX: f32 = 0.75;
/// Frames over the ground of one key frame move the surface by at most this in all, pixels, in addition to the dead reckoning error since:
/// their errors are common. In 56 closed loops between years after the loss of satellites, patches of 35 and 64 pixels, two of 2,471 fixes
/// were more than 3 pixels off without this limit and none of 1,920 with it. Chosen: less than the local offset of a map of another year.
const CORRECTION_MAX_PX: f32 = 0.4;
/// Largest dead reckoning error since the newest key frame, one sigma, pixels, for the surface to give a decision: a third of what is
/// called wrong. A vehicle over ground it had seen before was fixed 5.9 pixels off by evidence that was a minute old.
const DRIFT_SIGMA_MAX_PX: f32 = 1.0;
/// No position on any tile is as far from its centre, metres: a quarter of the Earth's circumference.
const FAR_M: f32 = 1e7;
/// Evidence of a valid least-squares match against a shift this many shifts away and beyond; nearer it grows with the squared distance, as
/// by a sigma of 0.6 pixels. One of 23,000 wrong peaks had such a match, so it is as much as has frames searched there.
const LEAST_SQUARES_EVIDENCE: f32 = 250.0;
const LEAST_SQUARES_CELLS: f32 = 1.5;

/// All constants behind the risk of a decision, for a record of which ones were in use.
pub const COEFFICIENTS: [f32; 10] = [
    CAP,
    INTERCEPT,
    SLOPE,
    EXPONENT,
    CONTRADICTION_MAX,
    FORGETTING_FACTOR,
    CURVATURE_MIN,
    KEY_FRAME_DISTANCE,
    CORRECTION_MAX_PX,
    DRIFT_SIGMA_MAX_PX,
];

/// Position at the surface's peak.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Decision {
    /// Nadir, in the tile's frame, metres.
    pub nadir: Local,
    /// Probability that it is more than three pixels off.
    pub risk: f32,
}

/// Log-likelihood surface of the nadir, propagated from frame to frame.
#[derive(Clone, Debug)]
pub struct Surface {
    grid: LikelihoodGrid,
    /// The grid before the newest key frame was added, and the texture of the frame that stands for it.
    previous_grid: StoredGrid,
    texture: f32,
    /// Nadir at the grid's centre.
    centre: Local,
    moment: Moment,
    /// Dead reckoning error, one sigma of each axis, metres: since it was last applied to the grid, reduced by each correction; and all of
    /// it since the newest key frame.
    drift_sigma_m: f32,
    key_frame_drift_m: f32,
    /// Sum of the corrections by frames of the newest key frame's ground, metres east and north.
    correction_m: [f32; 2],
    /// Dead-reckoned position from an arbitrary origin; the key frames' are on the same path.
    dead_reckoned: Local,
    /// Whether the newest frame's ground overlaps no key frame's, or the newest one's alone.
    is_new_ground: bool,
    is_newest_ground: bool,
    key_frames: Deque<Local, KEY_FRAMES>,
    /// Whether single frames agree with the decision.
    pub agreement: Agreement,
    /// Whether the map is of the ground's own year.
    pub map_year: MapYear,
}

impl Default for Surface {
    fn default() -> Self {
        Surface::new()
    }
}

impl Surface {
    /// No evidence.
    pub const fn new() -> Self {
        let origin = Local { east_m: 0.0, north_m: 0.0 };
        Surface {
            grid: LikelihoodGrid::new(),
            previous_grid: StoredGrid::new(),
            texture: 0.0,
            centre: origin,
            moment: Moment { at: Micros(0), velocity_m_per_s: [0.0; 2] },
            drift_sigma_m: 0.0,
            key_frame_drift_m: 0.0,
            correction_m: [0.0; 2],
            dead_reckoned: origin,
            is_new_ground: false,
            is_newest_ground: false,
            key_frames: Deque::new(),
            agreement: Agreement::new(),
            map_year: MapYear::new(),
        }
    }

    /// Propagates it to a frame by the mean reported velocity. `off_m_per_s`: estimated error of the velocity, east and north, which is
    /// taken out; `sigma_m_per_s`: what remains unknown, one sigma, each axis. A gap of more than `STEP_MAX_US` clears it.
    pub fn propagate(&mut self, moment: Moment, off_m_per_s: [f32; 2], sigma_m_per_s: f32) {
        let before = core::mem::replace(&mut self.moment, moment);
        let step_us = moment.at.since(before.at);
        if !(0..=STEP_MAX_US).contains(&step_us) {
            self.clear();
            return;
        }
        if step_us > CONSECUTIVE_US {
            self.agreement.gap();
        }
        let seconds = step_us as f32 * 1e-6;
        let [east_m, north_m] = displacement_m(before, moment);
        let way = [east_m - off_m_per_s[0] * seconds, north_m - off_m_per_s[1] * seconds];
        self.centre = self.centre.moved(way);
        self.dead_reckoned = self.dead_reckoned.moved(way);
        self.drift_sigma_m += sigma_m_per_s * seconds;
        self.key_frame_drift_m += sigma_m_per_s * seconds;
    }

    /// Drops all evidence.
    fn clear(&mut self) {
        self.key_frames.clear();
        self.agreement = Agreement::new();
    }

    /// Shifts the grid by whole cells so that it covers the search around `nadir`; returns what is left, centre of the grid less centre of
    /// the search in pixels (columns, rows), each −1, 0 or 1. A surface that does not overlap the search is cleared.
    ///
    /// `expected`: position by the navigation and its sigma, each axis, metres, 0 where unknown; it is the prior of an empty surface.
    ///
    /// `side_m`: smaller side of the frame's footprint. `px_m`: metres a pixel.
    pub fn recentre(&mut self, nadir: Local, expected: (Local, f32), side_m: f32, px_m: f32) -> (i16, i16) {
        let is_other = |ground: &Local| ground.off_m(self.dead_reckoned) >= KEY_FRAME_DISTANCE * side_m;
        let mut key_frames = self.key_frames.iter().rev();
        let newest = key_frames.next().is_none_or(is_other);
        let others = key_frames.all(is_other);
        (self.is_new_ground, self.is_newest_ground) = (newest && others, !newest && others);
        if self.key_frames.is_empty() {
            (self.centre, self.drift_sigma_m) = (nadir, 0.0);
            self.grid =
                LikelihoodGrid::from_prior(self.cells_to(expected.0, px_m), expected.1 / (f32::from(STEP_PX) * px_m));
            return (0, 0);
        }
        let off = |metres: f32| round((metres / px_m).clamp(-1e3, 1e3)) as i16;
        let by = (off(self.centre.east_m - nadir.east_m), off(nadir.north_m - self.centre.north_m));
        let steps = |px: i16| px / STEP_PX;
        let (cols, rows) = (steps(by.0), steps(by.1));
        if cols.unsigned_abs().max(rows.unsigned_abs()) as usize >= SHIFTS {
            self.clear();
            return self.recentre(nadir, expected, side_m, px_m);
        }
        self.shift(cols, rows, px_m);
        (by.0 - STEP_PX * cols, by.1 - STEP_PX * rows)
    }

    /// Moves the grid's centre by so many cells to the left and upwards.
    fn shift(&mut self, cols: i16, rows: i16, px_m: f32) {
        if (cols, rows) == (0, 0) {
            return;
        }
        let step_m = f32::from(STEP_PX) * px_m;
        self.centre = self.centre.moved([-f32::from(cols) * step_m, f32::from(rows) * step_m]);
        self.grid.shift(cols, rows);
        self.previous_grid.shift(cols, rows);
    }

    /// From the centre to a position, cells (columns, rows).
    fn cells_to(&self, place: Local, px_m: f32) -> (f32, f32) {
        let step_m = f32::from(STEP_PX) * px_m;
        ((place.east_m - self.centre.east_m) / step_m, (self.centre.north_m - place.north_m) / step_m)
    }
}

impl Surface {
    /// Begins a key frame; the dead reckoning error since the last one becomes process noise.
    fn begin_key_frame(&mut self, px_m: f32) {
        if self.key_frames.back() == Some(&self.dead_reckoned) {
            return;
        }
        if self.key_frames.is_full() {
            self.key_frames.pop_front();
        }
        // There is room.
        let _ = self.key_frames.push_back(self.dead_reckoned);
        (self.correction_m, self.key_frame_drift_m) = ([0.0; 2], 0.0);
        if self.map_year.is_another() {
            self.grid.discount(FORGETTING_FACTOR);
        }
        // An error too small for the grid goes on adding up.
        let steps = self.drift_sigma_m / (f32::from(STEP_PX) * px_m);
        if steps > PROCESS_NOISE_MIN {
            self.grid.add_process_noise(steps);
            self.drift_sigma_m = 0.0;
        }
        self.previous_grid = StoredGrid::of(&self.grid);
    }

    /// Adds the scores of a frame if it begins a key frame, or replaces the newest one by a frame of more texture.
    pub fn add(&mut self, frame: &Frame<'_>, px_m: f32) {
        if self.is_new_ground {
            self.begin_key_frame(px_m);
        } else if self.is_newest_ground && frame.texture > TEXTURE_RATIO_MIN * self.texture {
            self.grid = self.previous_grid.restored();
        } else {
            return;
        }
        self.texture = frame.texture;
        self.grid.add(frame.scores, frame.weight, frame.peak.score);
        self.grid.normalise();
    }

    /// The nadir at the peak and its risk; nothing on the border, or beyond `DRIFT_SIGMA_MAX_PX` of dead reckoning error.
    pub fn decision(&self, px_m: f32) -> Option<Decision> {
        if self.drift_sigma_m > DRIFT_SIGMA_MAX_PX * px_m {
            return None;
        }
        let (peak, second) = self.grid.peaks();
        Some(Decision { nadir: self.peak_nadir(&peak, px_m)?, risk: risk(peak.score - second) })
    }

    /// The nadir at the vertex of the parabolas through a peak; nothing on the border, or where it is no position.
    fn peak_nadir(&self, peak: &Peak, px_m: f32) -> Option<Local> {
        let at = |row: usize, col: usize| self.grid.evidence.get(row).and_then(|line| line.get(col)).copied();
        let (above, left) = (peak.row.checked_sub(1)?, peak.col.checked_sub(1)?);
        let of = |before: f32, after: f32| vertex(before, peak.score, after);
        let cols = peak.col as f32 - MIDDLE as f32 + of(at(peak.row, left)?, at(peak.row, peak.col + 1)?);
        let rows = peak.row as f32 - MIDDLE as f32 + of(at(above, peak.col)?, at(peak.row + 1, peak.col)?);
        let step_m = f32::from(STEP_PX) * px_m;
        let nadir = self.centre.moved([cols * step_m, -rows * step_m]);
        (nadir.east_m.abs() < FAR_M && nadir.north_m.abs() < FAR_M).then_some(nadir)
    }

    /// Whether a frame's evidence against the surface's peak is small enough.
    pub fn is_consistent(&self, frame: &Frame<'_>) -> bool {
        frame.weight * (frame.peak.score - Peak::of(&self.grid.evidence).max_near(frame.scores)) <= CONTRADICTION_MAX
    }

    /// Adds a valid least-squares match at `nadir`: evidence against every cell by its distance. If the peak is there, the surface is corrected
    /// towards it.
    pub fn add_least_squares(&mut self, nadir: Local, px_m: f32) {
        let (cols, rows) = self.cells_to(nadir, px_m);
        let (col, row) = (MIDDLE as f32 + cols, MIDDLE as f32 + rows);
        if self.is_new_ground {
            self.begin_key_frame(px_m);
            // No later frame replaces a key frame of that certainty.
            self.texture = f32::MAX;
            self.grid.penalise_distance(LEAST_SQUARES_EVIDENCE, (col, row), LEAST_SQUARES_CELLS);
        }
        let peak = self.grid.normalise();
        let is_there = (peak.row as f32 - row).abs().max((peak.col as f32 - col).abs()) <= LEAST_SQUARES_CELLS;
        if is_there && let Some(before) = self.peak_nadir(&peak, px_m) {
            let by_m = self.correction(before, nadir, px_m);
            self.centre = self.centre.moved(by_m);
        }
    }

    /// Corrects the surface towards a frame's own peak at `nadir`, where the decision is at `before`; limited by `CORRECTION_MAX_PX`.
    pub fn correct(&mut self, before: Local, nadir: Local, px_m: f32) {
        let by_m = self.correction(before, nadir, px_m);
        let corrected_m: [f32; 2] = core::array::from_fn(|axis| self.correction_m[axis] + by_m[axis]);
        let most_m = hypot(CORRECTION_MAX_PX * px_m, self.key_frame_drift_m);
        let share = (most_m / hypot(corrected_m[0], corrected_m[1]).max(f32::MIN_POSITIVE)).min(1.0);
        let corrected_m = corrected_m.map(|metres| share * metres);
        self.centre = self.centre.moved(core::array::from_fn(|axis| corrected_m[axis] - self.correction_m[axis]));
        self.correction_m = corrected_m;
    }

    /// A share of the residual, metres east and north; reduces the dead reckoning sigma.
    fn correction(&mut self, before: Local, nadir: Local, px_m: f32) -> [f32; 2] {
        let off_m = nadir.off_m(before);
        let most_m = RESIDUAL_MAX_PX * px_m;
        let gain = if off_m > most_m { GAIN * most_m / off_m } else { GAIN };
        self.drift_sigma_m *= 1.0 - gain;
        [nadir.east_m - before.east_m, nadir.north_m - before.north_m].map(|metres| gain * metres)
    }
}

/// Scores of a frame, with what they weigh.
#[derive(Clone, Copy, Debug)]
pub struct Frame<'s> {
    scores: &'s Scores,
    peak: Peak,
    /// Evidence of a score of 1, limited by [`CAP`]; the texture is the same without the limit.
    weight: f32,
    texture: f32,
}

impl<'s> Frame<'s> {
    /// `valid`: number of valid pixels.
    ///
    /// Above the limit all scores are scaled down: clipping would leave a plateau of a single shift, next to which the following frame's
    /// peak falls.
    pub fn new(scores: &'s Scores, valid: u32) -> Self {
        let peak = Peak::of(scores);
        let texture = valid as f32 * peak.curvature(scores).max(CURVATURE_MIN);
        let lead = texture * (peak.score - peak.second_peak(scores));
        let weight = if lead > CAP { texture * (CAP / lead) } else { texture };
        Frame { scores, peak, weight, texture }
    }
}

/// Probability that the surface's peak is wrong, by its lead over the second peak.
fn risk(lead: f32) -> f32 {
    let log_odds = INTERCEPT - SLOPE * exp(EXPONENT * ln(lead.max(f32::MIN_POSITIVE)));
    1.0 / (1.0 + exp(-log_odds))
}

#[cfg(test)]
mod tests;
