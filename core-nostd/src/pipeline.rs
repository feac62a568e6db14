//! Drives the modules: streams in, frame in, fix out.
//!
//! The pipeline owns the histories and the few image buffers, and nothing else: no clock, no link. Its caller feeds
//! the streams as they arrive, begins a frame, hands over its rows, and when the pose at mid-exposure exists runs the
//! stages [`Pipeline::situate`], [`Pipeline::rectify`], [`Pipeline::register`] one after the other. They are apart so
//! that a caller can count what each of them costs.

mod buffers;
mod streams;
mod settings;
mod situation;
mod situate;
mod refusal;
mod velocity;
mod whereabouts;

use crate::auto_exposure::Histogram;
use crate::budget::{FRAME_MEMORY_BYTES, POSE_MAX_BYTES, REACQUIRE_PX};
use crate::fix::{Fix, Footprint, Uncertainty, fix};
use crate::homography::{FrameFromPatch, Placement};
use crate::image::{Run, View};
use crate::matching::{Match, Matcher, OnBoard, Prior, Request, Shift};
use crate::math::hypot;
use crate::navigation::tracks::Sighting;
use crate::pose::position::PositionState;
use crate::rectify::{Source, rectify_into};
use crate::reduce::{Reducer, Reduction};
use crate::tile::Tile;
pub use buffers::Buffers;
pub use refusal::Refusal;
use settings::Smoothers;
pub use settings::{FollowUpMode, Motion, Motions, Settings, SettingsError, Sigmas};
pub use situate::SituateError;
pub use situation::{Prediction, Situation};
pub use streams::{Arrival, Instants, Latencies, PositionSample, SampleError, Streams};
use velocity::VelocityError;
pub use whereabouts::LOST_AFTER;
use whereabouts::{Search, Usual, Whereabouts};

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
    /// The fix, or why there is none.
    pub fix: Result<Fix, Refusal>,
}

/// Where the patch lies in the tile.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Matched {
    found: Match,
    /// Centre of the search in the tile, pixels, and how far that is off the predicted position.
    centre: (f32, f32),
    off: (f32, f32),
    search_px: u16,
    /// Whether it counts as it is, or another frame must find it, too.
    counts: Result<(), Refusal>,
}

/// State of the whole chain.
#[derive(Debug)]
pub struct Pipeline<'t> {
    settings: Settings,
    tile: Tile<'t>,
    /// The stamped streams.
    pub streams: Streams,
    smoothers: Smoothers,
    /// What the navigation is worse than the settings say, for now.
    pub doubt: Doubt,
    /// The newest position lies where the tile's georeference does not reach.
    is_off_the_map: bool,
    reducer: Option<Reducer>,
    /// How bright the frame is whose rows arrive, where somebody wants to know.
    pub histogram: Option<Histogram>,
    /// Of the newest patch.
    placement: Placement,
    whereabouts: Whereabouts,
    velocity: VelocityError,
    buffers: &'t mut Buffers,
    frame_memory: &'t mut [u8],
}

/// One sigma beside what the settings say, of a vehicle whose navigation has not begun.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Doubt {
    /// Each axis, metres.
    pub position_m: f32,
    /// Each axis, m/s.
    pub velocity_m_per_s: f32,
    /// Radians.
    pub heading_rad: f32,
}

/// A position is searched for within so many sigmas of its doubt: of a hundred normal errors of an axis five lie beyond.
const DOUBT_SIGMAS: f32 = 2.0;

/// What matches say of the velocity's error counts up to this where they are compared, m/s: more was not seen of an autopilot.
const VELOCITY_ERROR_MAX_M_PER_S: f32 = 5.0;

impl<'t> Pipeline<'t> {
    /// Settings and reference for one flight. `frame_memory` stands for the camera's frame, of which it holds what the
    /// rectifier needs, [`FRAME_MEMORY_BYTES`] or whatever the board has; between rectification and the next frame it
    /// serves the matcher.
    ///
    /// # Errors
    /// [`SettingsError`] where the settings do not fit this build or each other.
    // Inlined, it is built where it is to lie; otherwise boot carries two copies over the stack.
    #[inline(always)]
    pub fn new(
        settings: Settings,
        tile: Tile<'t>,
        buffers: &'t mut Buffers,
        frame_memory: &'t mut [u8],
    ) -> Result<Self, SettingsError> {
        settings.check()?;
        if frame_memory.len() < OnBoard::WORKING_BYTES {
            return Err(SettingsError::FrameMemory);
        }
        Ok(Pipeline {
            streams: Streams::new(settings.latencies),
            smoothers: settings.smoothers(),
            settings,
            tile,
            doubt: Doubt::default(),
            is_off_the_map: false,
            reducer: None,
            histogram: None,
            placement: Placement::default(),
            whereabouts: Whereabouts::default(),
            velocity: VelocityError::default(),
            buffers,
            frame_memory,
        })
    }

    /// The settings at work.
    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    /// The reference.
    pub fn tile(&self) -> &Tile<'t> {
        &self.tile
    }

    /// Whether the newest position lies within reach of the tile's georeference.
    pub fn is_on_the_map(&self) -> bool {
        !self.is_off_the_map
    }

    /// Takes a position of the navigation.
    ///
    /// # Errors
    /// [`SampleError`].
    pub fn position(&mut self, at: impl Into<Instants>, sample: PositionSample) -> Result<(), SampleError> {
        if !sample.position.is_possible() {
            return Err(SampleError::Invalid);
        }
        let georeference = self.tile.georeference();
        let Some(local) = georeference.local(sample.position) else {
            self.is_off_the_map = true;
            return Ok(());
        };
        // True north and east turned into the grid's: grid heading = true heading − convergence.
        let (s, c) = crate::math::sin_cos(georeference.convergence.0);
        let (north, east) = (sample.north_m_per_s, sample.east_m_per_s);
        let state = PositionState {
            east_m: local.east_m,
            north_m: local.north_m,
            east_m_per_s: east * c - north * s,
            north_m_per_s: north * c + east * s,
        };
        self.streams.position(at, state)?;
        self.is_off_the_map = false;
        Ok(())
    }

    /// A frame's rows are about to arrive. The reduction follows from the newest range: it needs no pose, and being
    /// off by a tilt's cosine does not matter to it.
    ///
    /// # Errors
    /// [`Refusal::NoRange`] before the first range.
    pub fn begin_frame(&mut self) -> Result<(), Refusal> {
        self.reducer = None;
        let (_, slant_m) = self.streams.slant.history().newest().ok_or(Refusal::NoRange)?;
        let camera = &self.settings.camera;
        let ratio = camera.ratio(slant_m, self.tile.ground_resolution().0).min(RATIO_MAX);
        let frame = (camera.cols(), camera.rows());
        let capacity = self.frame_memory.len();
        let reduction = Reduction::choose(frame, ratio, capacity)?;
        self.reducer = Some(Reducer::new(reduction, frame));
        Ok(())
    }

    /// Rows that [`Pipeline::rows`] expects next; 0 where no frame is arriving.
    pub fn rows_wanted(&self) -> u16 {
        self.reducer.as_ref().map_or(0, Reducer::rows_wanted)
    }

    /// The next [`Pipeline::rows_wanted`] rows of the frame, one behind the other, or several times that.
    ///
    /// # Errors
    /// [`Refusal::BadFrame`] for another number of pixels, rows too many, or without [`Pipeline::begin_frame`].
    pub fn rows(&mut self, rows: &[u8]) -> Result<(), Refusal> {
        let reducer = self.reducer.as_mut().ok_or(Refusal::BadFrame)?;
        if let Some(histogram) = &mut self.histogram {
            histogram.count(rows, self.settings.camera.cols(), reducer.rows_taken());
        }
        Ok(reducer.take(rows, self.frame_memory)?)
    }

    /// Rectifies the frame that has arrived for `situation`.
    ///
    /// # Errors
    /// [`Refusal::BadFrame`] while rows are missing, [`Refusal::NoFootprint`] where nothing of the patch is seen.
    pub fn rectify(&mut self, situation: &Situation) -> Result<(), Refusal> {
        let reducer = self.reducer.as_ref().filter(|r| r.is_complete()).ok_or(Refusal::BadFrame)?;
        let reduction = reducer.reduction();
        let camera = &self.settings.camera;
        let resolution = self.tile.ground_resolution().0;
        let Buffers { patch, runs, nodes, .. } = &mut *self.buffers;
        let kept = self.frame_memory.get(..reduction.bytes()).ok_or(Refusal::BadFrame)?;
        let source = Source::new(kept, reduction)?;
        let placement = situation.placement(camera, resolution).ok_or(Refusal::NoFootprint)?;
        let Placement { size, aside } = placement;
        let scale = (situation.height_m, resolution);
        let bands;
        let map = if self.settings.readout_us > 0 {
            bands = situation.bands(camera, self.settings.readout_us)?;
            FrameFromPatch::rolling(&bands, camera, scale, size)
        } else {
            FrameFromPatch::new(situation.homography(camera), camera, scale, size)
        };
        rectify_into(&map.aside(aside), source, patch, nodes, runs)?;
        self.placement = placement;
        // From here on the frame's memory is free.
        self.reducer = None;
        if runs.is_empty() { Err(Refusal::NoFootprint) } else { Ok(()) }
    }

    /// [`Pipeline::match_patch`], then [`Pipeline::fix`].
    ///
    /// # Errors
    /// Those of the first.
    pub fn register(&mut self, situation: &Situation) -> Result<Outcome, Refusal> {
        let matched = self.match_patch(situation)?;
        Ok(self.fix(situation, &matched))
    }

    /// Matches the patch around the predicted position. The search is as wide as the settings say, and
    /// ±[`REACQUIRE_PX`] after [`LOST_AFTER`] frames that were tried in vain, and while the position is in such [`Doubt`] that it
    /// may well lie beyond the other. Where such a search has found it, the next frames are searched, as far as the settings
    /// say; only when one of them finds it, too, is it a fix. From then on the place that the matches know counts, carried on by
    /// the velocity: frames are searched there where the navigation is elsewhere, and what is found must not contradict it.
    ///
    /// # Errors
    /// A [`Refusal`] when no match could be tried at all; of a tried one that was not accepted the [`Outcome`] says why.
    pub fn match_patch(&mut self, situation: &Situation) -> Result<Matched, Refusal> {
        let px_m = self.tile.ground_resolution().0;
        let reach_m = f32::from(self.settings.search_px) * px_m;
        let sigma_m = situation.prediction.sigma_m;
        let usual = Usual {
            reach_m,
            is_in_doubt: DOUBT_SIGMAS * self.doubt.position_m > reach_m,
            px_m,
            sigma_m_per_s: hypot(
                hypot(self.settings.sigmas.velocity_m_per_s, self.velocity.m_per_s().min(VELOCITY_ERROR_MAX_M_PER_S)),
                self.doubt.velocity_m_per_s,
            ),
            // Who says nothing of the position's error and has it searched so far takes it to be as far off.
            prior_m: if sigma_m > 0.0 { sigma_m } else { 0.5 * reach_m },
        };
        let search = self.whereabouts.search(situation, &usual);
        let tried = self.locate(situation, search);
        let sighting = match &tried {
            Err(refusal) => Err(*refusal),
            Ok(Matched { found, centre, .. }) => match found.accepted {
                Err(rejection) => Err(rejection.into()),
                Ok(shift) => Ok(self.sighting(situation, *centre, &shift)),
            },
        };
        let counts = self.whereabouts.ended(search, situation, &usual, sighting);
        if let (Ok(Sighting { nadir, .. }), Ok(())) = (sighting, counts) {
            self.velocity.matched(situation.moment(), nadir, self.settings.sigmas.velocity_m_per_s);
        }
        tried.map(|matched| Matched { counts, ..matched })
    }

    /// Where a match puts the nadir, and how certain that is.
    fn sighting(&self, situation: &Situation, centre: (f32, f32), shift: &Shift) -> Sighting {
        Sighting {
            nadir: self.tile.local(centre.0 + shift.d_col, centre.1 + shift.d_row),
            covariance: self.fixed(situation, centre, shift).covariance,
            side_m: self.placement.size.0.min(self.placement.size.1) as f32 * self.tile.ground_resolution().0,
        }
    }

    fn locate(&mut self, situation: &Situation, search: Search) -> Result<Matched, Refusal> {
        let radius = if search.is_far { REACQUIRE_PX as u16 } else { self.settings.search_px };
        let Buffers { patch, runs, matcher, .. } = &mut *self.buffers;
        let Placement { size, aside } = self.placement;
        let patch = View::new(patch, size).ok_or(Refusal::NoFootprint)?;
        let predicted = self.tile.pixel(situation.prediction.local);
        let looked_for = self.tile.pixel(search.at);
        // The whole pixel at which the upper left one of a patch around the nadir is nearest to that.
        let half = |side: u16| 0.5 * (side as f32 - 1.0);
        let half = (half(size.0), half(size.1));
        let corner = (crate::math::round(looked_for.0 - half.0), crate::math::round(looked_for.1 - half.1));
        if !(corner.0.abs() < 1e6 && corner.1.abs() < 1e6) {
            return Err(Refusal::OutsideReference);
        }
        let centre = (corner.0 + half.0, corner.1 + half.1);
        let off = (centre.0 - predicted.0, centre.1 - predicted.1);
        let prior =
            Prior { turn_rad: situation.sigma_heading_rad, scale: situation.sigma_height_m / situation.height_m };
        let predicted = (corner.0 as i32 + aside.0 as i32, corner.1 as i32 - aside.1 as i32);
        let nadir = (aside.0.saturating_neg(), aside.1);
        let (tile, rule) = (*self.tile.view(), &self.settings.accept);
        let request = Request { patch, runs, tile, predicted, nadir, radius, prior, rule };
        let found = matcher.locate(&request, self.frame_memory)?;
        Ok(Matched { found, centre, off, search_px: radius, counts: Ok(()) })
    }

    /// The fix of a match in the situation that it was made in, or why there is none.
    pub fn fix(&self, situation: &Situation, matched: &Matched) -> Outcome {
        let Matched { found, centre, off, search_px, counts } = matched;
        let fixed = |shift: Shift| self.fixed(situation, *centre, &shift);
        Outcome {
            d_col: found.shift.0 + off.0,
            d_row: found.shift.1 + off.1,
            peak: [found.peak.0 as f32 + off.0, found.peak.1 as f32 + off.1],
            grey_correlation: found.grey_correlation,
            search_px: *search_px,
            fix: found.accepted.map_err(Refusal::from).and_then(|shift| counts.map(|()| fixed(shift))),
        }
    }

    fn fixed(&self, situation: &Situation, centre: (f32, f32), shift: &Shift) -> Fix {
        let footprint = Footprint::of(&self.buffers.runs, &self.placement);
        let uncertainty = Uncertainty {
            tilt_rad: situation.sigma_tilt_rad,
            tilt_drift_rad: situation.sigma_tilt_drift_rad,
            height_m: situation.sigma_height_m,
            along_m: situation.prediction.velocity_m_per_s.map(|speed| speed * situation.sigma_stamp_s),
        };
        let camera = (situation.height_m, situation.camera_offset_m);
        fix(&self.tile, centre, shift, &footprint, camera, uncertainty)
    }

    /// The rectified patch with pixels that may be changed, though not their number: a replay has them from its log.
    pub fn patch_mut(&mut self) -> (&mut [u8], (u16, u16), &[Run]) {
        let pixels = self.placement.size.0 as usize * self.placement.size.1 as usize;
        let Buffers { patch, runs, .. } = &mut *self.buffers;
        (patch.get_mut(..pixels).unwrap_or(&mut []), self.placement.size, runs)
    }

    /// The rectified patch, its size and its valid runs, until the next frame is rectified.
    pub fn patch(&self) -> (&[u8], (u16, u16), &[Run]) {
        let pixels = self.placement.size.0 as usize * self.placement.size.1 as usize;
        (self.buffers.patch.get(..pixels).unwrap_or(&[]), self.placement.size, &self.buffers.runs)
    }
}

const _: () = assert!(size_of::<Streams>() + size_of::<Smoothers>() <= POSE_MAX_BYTES);
/// Ratio of a patch pixel to a frame pixel beyond which boxes grow no further: 16 rows are the most that a front end's ring
/// has to hold at a time.
const RATIO_MAX: f32 = 90.0;
const _: () =
    assert!(OnBoard::WORKING_BYTES <= FRAME_MEMORY_BYTES, "what the matcher needs does not fit the frame's memory");
