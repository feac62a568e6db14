//! The algorithm of Plumbline: what happens between a shutter edge and a position fix.
//!
//! A camera that looks down from a tilted vehicle is rectified onto the ground plane at the resolution of a reference
//! orthophoto, matched against it, and the offset becomes a position fix. The source is Zhang et al., "Automatic
//! geometric rectification model of follow-up system" (J. Remote Sensing 9(4), 2005), called *the paper* here; its
//! equations appear in corrected form, and each departure is stated where it is made.
//!
//! No `std`, no allocation, no hardware, no clock: data in, data out, buffers belong to the caller. The modules are
//! declared in the order of the flow, and each uses only what is declared before it, as a test of the source code checks.
//!
//! All arithmetic is IEEE single precision or integer, every transcendental function goes through [`math`]: host,
//! emulator and board give the same bits.
//!
//! One frame of a level camera over synthetic ground, while the navigation says that it is over the reference's centre:
//!
//! ```
//! use plumbline_core::matching::AcceptRule;
//! use plumbline_core::navigation::Navigation;
//! use plumbline_core::pipeline::{Buffers, FollowUpMode, Latencies, Memory, Motions, Pipeline, PositionSample, Settings, Sigmas};
//! use plumbline_core::tile::{Geographic, Georeference, Tile};
//! use plumbline_core::units::{Metres, Micros, Radians};
//! use plumbline_core::{budget::FRAME_MEMORY_BYTES, camera::Camera, mount::Mount, tilt::Attitude};
//!
//! // Grey of the ground, metres east and north of the reference's centre: waves of 14 to 49 m in six directions.
//! let grey = |east: f32, north: f32| {
//!     let wave = |k: f32| ((east * (1.1 * k).cos() + north * (1.1 * k).sin()) * 6.28 / (14.0 + 7.0 * k) + k).sin();
//!     (128.0 + 20.0 * [0.0, 1.0, 2.0, 3.0, 4.0, 5.0].map(wave).iter().sum::<f32>()) as u8
//! };
//! // Square picture, row 0 north, of so many metres a pixel, its centre at (east, north).
//! let picture = |side: usize, metres: f32, (east, north): (f32, f32)| -> Vec<u8> {
//!     let from_centre = |index: usize| metres * (index as f32 - 0.5 * (side as f32 - 1.0));
//!     (0..side * side).map(|i| grey(east + from_centre(i % side), north - from_centre(i / side))).collect()
//! };
//! let reference = picture(100, 3.0, (0.0, 0.0));
//! // From a height of 120 m this camera sees 1 m a pixel. It is 6 m east and 9 m south of where the navigation has it.
//! let (frame, fov) = (picture(120, 1.0, (6.0, -9.0)), Radians(2.0 * 0.5f32.atan()));
//!
//! let centre = Geographic { lat_e7: 480_000_000, lon_e7: 160_000_000 };
//! // Metres in a hundredth of a degree.
//! let (east, north) = ([744.0, 0.0, 0.0, 0.0, 0.0], [0.0, 1112.0, 0.0, 0.0, 0.0]);
//! let georeference = Georeference { epsg: 32633, centre, east, north, convergence: Radians(0.0), point_scale: 1.0 };
//! let settings = Settings {
//!     camera: Camera::new((120, 120), (fov, fov), (0.0, 0.0), None).unwrap(),
//!     follow_up: FollowUpMode::Fixed,
//!     mount: Mount::default(),
//!     sigmas: Sigmas { tilt_white_rad: 0.002, heading_drift_rad: 0.005, range_m: 0.3, ..Sigmas::default() },
//!     motions: Motions::default(),
//!     latencies: Latencies::default(),
//!     readout_us: 0,
//!     lag: 0,
//!     gap_us: 20_000,
//!     range_gap_us: 100_000,
//!     position_age_us: 1_000_000,
//!     patience_us: 100_000,
//!     search_px: 10,
//!     accept: AcceptRule::default(),
//! };
//! let tile = Tile::new(&reference, (100, 100), Metres(3.0), georeference).unwrap();
//! let (mut buffers, mut navigation, mut rows) = (Buffers::new(), Navigation::new(), vec![0; FRAME_MEMORY_BYTES]);
//! let memory = Memory { buffers: &mut buffers, navigation: &mut navigation, frame: &mut rows };
//! let mut pipeline = Pipeline::new(settings, tile, memory).unwrap();
//!
//! let mid_exposure = Micros(1_000_000);
//! for at in [990_000, 997_000, 1_004_000].map(Micros) {
//!     pipeline.streams.attitude(at, Attitude::default()).unwrap();
//!     pipeline.streams.slant(at, Metres(120.0)).unwrap();
//! }
//! let position = PositionSample::standing(centre);
//! pipeline.position(mid_exposure, position).unwrap();
//! pipeline.begin_frame().unwrap();
//! pipeline.rows(&frame).unwrap();
//! let situation = pipeline.situate((mid_exposure, 1.0), pipeline.settings().wait()).unwrap().expect("samples around it");
//! pipeline.rectify(&situation).unwrap();
//! let fix = pipeline.register(&situation).unwrap().fix.unwrap();
//! let error_m = (fix.local.east_m - 6.0).hypot(fix.local.north_m + 9.0);
//! assert!(error_m < 0.3, "a tenth of a reference pixel: {error_m} m");
//! ```
#![no_std]
#![deny(unsafe_code)]

#[cfg(all(feature = "dsp", not(target_arch = "arm")))]
compile_error!("the feature `dsp` is for Armv7E-M: its kernels are assembly of that architecture");

#[cfg(test)]
extern crate std;

mod packed;
mod arch;
pub mod math;
pub mod units;
pub mod tilt;
pub mod frames;
pub mod image;
pub mod budget;
pub mod camera;
pub mod stamp;
pub mod pose;
pub mod mount;
pub mod homography;
pub mod motion;
pub mod auto_exposure;
pub mod reduce;
pub mod rectify;
pub mod matching;
pub mod elevation;
pub mod tile;
pub mod fix;
pub mod navigation;
pub mod exposure;
pub mod pipeline;
#[cfg(feature = "dsp")]
#[doc(hidden)]
pub mod selftest;
