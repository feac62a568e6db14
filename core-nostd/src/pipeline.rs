//! Drives the stages: streams in, frame in, fix out.
//!
//! The pipeline owns the histories and the few image buffers, and nothing else: no clock, no link. Its caller feeds the
//! streams as they arrive, begins a frame, passes its rows, and when the pose at mid-exposure exists runs the stages
//! [`Pipeline::situate`], [`Pipeline::rectify`], [`Pipeline::register`] one after the other. They are separate so that
//! a caller can measure the cost of each.

mod buffers;
mod streams;
mod settings;
mod situation;
mod height;
mod situate;
mod refusal;
mod terrain;
mod search_state;
mod register;
mod together;
mod conclusions;
mod attitude_check;

use crate::auto_exposure::Histogram;
use crate::budget::{FRAME_MEMORY_BYTES, POSE_MAX_BYTES};
use crate::homography::{FrameFromPatch, Placement};
use crate::image::Run;
use crate::matching::directions::aboard;
use crate::matching::{Matcher, OnBoard};
use crate::navigation::Navigation;
use crate::navigation::filter::SatellitePosition;
use crate::navigation::heights::Altitude;
use crate::navigation::reckoning::Moment;
use crate::pose::position::PositionState;
use crate::rectify::{Source, rectify_into};
use crate::reduce::{Reducer, Reduction};
use crate::tile::{Geographic, Tile};
pub use buffers::{Buffers, Memory};
pub use refusal::Refusal;
pub use register::{Matched, Outcome};
pub use search_state::LOST_AFTER;
use search_state::SearchState;
use settings::Smoothers;
pub use settings::{FollowUpMode, Motion, Motions, Settings, SettingsError, Sigmas};
pub use situate::SituateError;
pub use situation::{Prediction, Situation};
pub use streams::{Arrival, Instants, Latencies, PositionSample, SampleError, Streams};
pub use together::{BELIEVED_RISK, COEFFICIENTS};

/// State of the pipeline.
#[derive(Debug)]
pub struct Pipeline<'t> {
    settings: Settings,
    tile: Tile<'t>,
    /// The stamped streams.
    pub streams: Streams,
    smoothers: Smoothers,
    /// Additional sigmas of the navigation, for now.
    pub added_sigmas: AddedSigmas,
    /// The newest position lies beyond the tile's georeference.
    is_off_the_map: bool,
    reducer: Option<Reducer>,
    /// [`sampled`] of the newest frame.
    sample: Option<u32>,
    /// Histogram of the frame whose rows arrive, if wanted.
    pub histogram: Option<Histogram>,
    /// Size and position of the newest patch.
    placement: Placement,
    search_state: SearchState,
    buffers: &'t mut Buffers,
    navigation: &'t mut Navigation,
    frame_memory: &'t mut [u8],
}

/// Sigmas to be added to the configured ones, while the vehicle's navigation is not initialised.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct AddedSigmas {
    /// Each axis, metres.
    pub position_m: f32,
    /// Each axis, m/s.
    pub velocity_m_per_s: f32,
    /// Radians.
    pub heading_rad: f32,
}

impl<'t> Pipeline<'t> {
    /// A pipeline for one flight, with an unused memory.
    ///
    /// # Errors
    /// [`SettingsError`] if the settings do not fit this build or each other.
    // Inlined, it is built in place; otherwise boot copies it over the stack twice.
    #[inline(always)]
    pub fn new(settings: Settings, tile: Tile<'t>, memory: Memory<'t>) -> Result<Self, SettingsError> {
        settings.check()?;
        let Memory { buffers, navigation, frame: frame_memory } = memory;
        if frame_memory.len() < OnBoard::WORKING_BYTES {
            return Err(SettingsError::FrameMemory);
        }
        Ok(Pipeline {
            streams: Streams::new(settings.latencies),
            smoothers: settings.smoothers(),
            settings,
            tile,
            added_sigmas: AddedSigmas::default(),
            is_off_the_map: false,
            reducer: None,
            sample: None,
            histogram: None,
            placement: Placement::default(),
            search_state: SearchState::default(),
            buffers,
            navigation,
            frame_memory,
        })
    }

    /// The settings.
    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    /// The reference.
    pub fn tile(&self) -> &Tile<'t> {
        &self.tile
    }

    /// Whether the newest position lies within the tile's georeference.
    pub fn is_on_the_map(&self) -> bool {
        !self.is_off_the_map
    }

    /// Sets whether the autopilot's estimator has recently changed its position source, so that its attitude swings.
    pub fn autopilot_changes(&mut self, is_changing: bool) {
        self.navigation.is_changing = is_changing;
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
        // From true north and east to the grid: grid heading = true heading − convergence.
        let (s, c) = crate::math::sin_cos(georeference.convergence.0);
        let (north, east) = (sample.north_m_per_s, sample.east_m_per_s);
        let state = PositionState {
            east_m: local.east_m,
            north_m: local.north_m,
            east_m_per_s: east * c - north * s,
            north_m_per_s: north * c + east * s,
        };
        let at = at.into();
        self.streams.position(at, state)?;
        self.is_off_the_map = false;
        let history = self.streams.position.history();
        if self.smoothers.position.is_frozen(history) {
            // Its velocity may be frozen as well.
            self.navigation.filter.forget();
        } else if let Some((at, state)) = history.newest() {
            let prior = self.prior_sigmas();
            let velocity_m_per_s = [state.east_m_per_s, state.north_m_per_s];
            self.navigation.filter.reported(Moment { at, velocity_m_per_s }, &prior);
        }
        if let Some(metres) = sample.altitude_m {
            let climb_m_per_s = sample.climb_m_per_s;
            let altitude = Altitude { at: at.sampled_at, metres, climb_m_per_s, home_m: sample.home_m };
            self.navigation.heights.reported(altitude);
        }
        Ok(())
    }

    /// Takes a position of satellite navigation, stamped by its receiver, with its sigma and that of the map, each
    /// axis, metres. It is compared with the matches; the search does not use it.
    ///
    /// # Errors
    /// [`SampleError`].
    pub fn satellites(&mut self, at: Instants, place: Geographic, sigmas_m: [f32; 2]) -> Result<(), SampleError> {
        if !place.is_possible() {
            return Err(SampleError::Invalid);
        }
        let at = at.recent(SATELLITES_AGE_US)?;
        let newest = self.streams.attitude.history().newest();
        if let (Some(local), Some((_, attitude))) = (self.tile.georeference().local(place), newest) {
            let [north_m, _, east_m] = self.settings.mount.camera_offset(attitude);
            let [sigma_m, map_sigma_m] = sigmas_m;
            let local = local.moved([east_m, north_m]);
            self.navigation.filter.satellites(SatellitePosition { at, local, sigma_m, map_sigma_m });
        }
        Ok(())
    }

    /// Distance between satellite navigation and the map, metres, if they disagree.
    pub fn disagreement_m(&self) -> Option<f32> {
        self.navigation.filter.disagreement_m()
    }

    /// Prepares for a frame's rows. The reduction is chosen by the newest range, or by the height without one: it needs
    /// no pose, and an error by the tilt's cosine does not matter.
    ///
    /// # Errors
    /// [`Refusal::NoRange`] if neither is known.
    pub fn begin_frame(&mut self) -> Result<(), Refusal> {
        self.reducer = None;
        self.navigation.begun = self.navigation.begun.saturating_add(1);
        let slant_m = self.newest_height_m().ok_or(Refusal::NoRange)?;
        self.navigation.plane = self.plane_below(slant_m);
        let camera = &self.settings.camera;
        let ratio = camera.ratio(slant_m, self.tile.ground_resolution().0).min(RATIO_MAX);
        let frame = (camera.cols(), camera.rows());
        let capacity = self.frame_memory.len();
        let reduction = Reduction::choose(frame, ratio, capacity)?;
        self.reducer = Some(Reducer::new(reduction, frame));
        Ok(())
    }

    /// Number of rows that [`Pipeline::rows`] expects next; 0 without a frame.
    pub fn rows_wanted(&self) -> u16 {
        self.reducer.as_ref().map_or(0, Reducer::rows_wanted)
    }

    /// Takes the next [`Pipeline::rows_wanted`] rows of the frame, row-major, or a multiple of that.
    ///
    /// # Errors
    /// [`Refusal::BadFrame`] for another number of pixels, too many rows, or without [`Pipeline::begin_frame`];
    /// [`Refusal::Repeated`] after the last row if the frame equals the one before.
    pub fn rows(&mut self, rows: &[u8]) -> Result<(), Refusal> {
        let reducer = self.reducer.as_mut().ok_or(Refusal::BadFrame)?;
        if let Some(histogram) = &mut self.histogram {
            histogram.count(rows, self.settings.camera.cols(), reducer.rows_taken());
        }
        reducer.take(rows, self.frame_memory)?;
        let sample = reducer.is_complete().then(|| sampled(self.frame_memory, reducer.reduction().bytes()));
        if sample.is_some() && core::mem::replace(&mut self.sample, sample) == sample {
            return Err(Refusal::Repeated);
        }
        Ok(())
    }

    /// Rectifies the arrived frame for `situation`.
    ///
    /// # Errors
    /// [`Refusal::BadFrame`] while rows are missing, [`Refusal::NoFootprint`] if no pixel of the patch is seen.
    #[inline(never)]
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

    /// The rectified patch with mutable pixels, for a replay that takes them from its log.
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
/// A hash by which identical frames are recognised; noise makes it differ for others. Of four pixels of each
/// [`SAMPLED_EVERY`] in the first `bytes` bytes.
fn sampled(memory: &[u8], bytes: usize) -> u32 {
    let fours = memory.get(..bytes).unwrap_or(&[]).chunks(SAMPLED_EVERY).filter_map(|chunk| chunk.first_chunk::<4>());
    // The multiplier is Knuth's, 2^32 over the golden ratio.
    fours.fold(0, |sum, four| (sum.rotate_left(5) ^ u32::from_le_bytes(*four)).wrapping_mul(0x9e37_79b9))
}

/// Oldest position of satellite navigation, microseconds; an older stamp is of another clock. Chosen: ten of five a
/// second.
const SATELLITES_AGE_US: i32 = 2_000_000;
/// Sampling interval of the hash, bytes. Chosen: some 180 words of the largest frame, and 60 of one of 128 x 128 that
/// is not reduced.
const SAMPLED_EVERY: usize = 256;
/// Largest ratio of a patch pixel to a frame pixel for the size of boxes: 16 rows are the most that a front end's ring
/// has to hold at a time.
const RATIO_MAX: f32 = 90.0;
const _: () =
    assert!(OnBoard::WORKING_BYTES <= FRAME_MEMORY_BYTES, "what the matcher needs does not fit the frame's memory");
const _: () =
    assert!(aboard::WORKING_BYTES <= FRAME_MEMORY_BYTES, "what the directions need does not fit the frame's memory");
