//! What lies in flash: camera, settings and the reference's georeference, guarded by a CRC.
//!
//! Written on the ground, read once at boot. A mission that cannot be read leaves the vehicle without fixes and with a
//! reason, never with wrong ones.

mod stamps;

use plumbline_core::camera::{Camera, Distortion};
use plumbline_core::matching::judge::AcceptRule;
use plumbline_core::pipeline::{FollowUpMode, Settings, Sigmas};
use plumbline_core::stamp::StampSettings;
use plumbline_core::tile::{Geographic, Georeference, Tile};
use plumbline_core::units::{Metres, Radians};
use serde::{Deserialize, Serialize};
pub use stamps::Stamps;

/// Why a mission was refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MissionError {
    /// The bytes are not a mission, or not this version's, or damaged.
    Encoding,
    /// The camera's figures cannot be a camera's.
    Camera,
    /// The settings do not fit each other or this build.
    Settings,
    /// The tile's georeference or size is unusable.
    Tile,
}

/// Format version: the first field of the encoding.
pub const VERSION: u16 = 2;

/// A mission as it is stored. Angles in radians, lengths in metres.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Mission {
    /// [`VERSION`].
    pub version: u16,
    /// Frame size, (cols, rows).
    pub frame: (u16, u16),
    /// Full fields of view, (across, along).
    pub fov_rad: (f32, f32),
    /// Principal point from the centre, (right, forward) pixels.
    pub offset_px: (f32, f32),
    /// k1, k2, k3, p1, p2.
    pub distortion: Option<[f32; 5]>,
    /// 0 followed, 1 measured, 2 fixed.
    pub follow_up: u8,
    /// Tilt white, tilt drift, heading, follow-up (radians), range (metres).
    pub sigmas: [f32; 5],
    /// Attitude gap, range gap, position age, patience, microseconds.
    pub limits_us: [u32; 4],
    /// Search radius, pixels.
    pub search_px: u16,
    /// Tile size, (cols, rows).
    pub tile: (u16, u16),
    /// Grid metres a tile pixel.
    pub resolution_m: f32,
    /// The grid's EPSG code.
    pub epsg: u32,
    /// Tile centre, latitude and longitude in 1e-7 degrees.
    pub centre_e7: (i32, i32),
    /// See [`Georeference`].
    pub east: [f32; 5],
    /// See [`Georeference`].
    pub north: [f32; 5],
    /// Grid convergence.
    pub convergence_rad: f32,
    /// Grid metres in a ground metre.
    pub point_scale: f32,
    /// Whether rectified patches are sent by the image transmission protocol.
    pub send_patches: bool,
    /// Shutter line, capture timer and pulses.
    pub stamps: Stamps,
}

const CRC: crc::Crc<u32> = crc::Crc::<u32>::new(&crc::CRC_32_ISO_HDLC);

impl Mission {
    /// Decodes and checks version and CRC.
    ///
    /// # Errors
    /// [`MissionError::Encoding`].
    pub fn decode(bytes: &[u8]) -> Result<Self, MissionError> {
        let mission: Mission = postcard::from_bytes_crc32(bytes, CRC.digest()).map_err(|_| MissionError::Encoding)?;
        if mission.version == VERSION { Ok(mission) } else { Err(MissionError::Encoding) }
    }

    /// Encodes into `buffer`; the part used.
    ///
    /// # Errors
    /// [`MissionError::Encoding`] when the buffer is too small; 256 bytes are enough.
    pub fn encode<'b>(&self, buffer: &'b mut [u8]) -> Result<&'b mut [u8], MissionError> {
        postcard::to_slice_crc32(self, buffer, CRC.digest()).map_err(|_| MissionError::Encoding)
    }

    /// The core's settings.
    ///
    /// # Errors
    /// [`MissionError::Camera`], [`MissionError::Settings`].
    pub fn settings(&self) -> Result<Settings, MissionError> {
        let distortion = self.distortion.map(|[k1, k2, k3, p1, p2]| Distortion { k1, k2, k3, p1, p2 });
        let fov = (Radians(self.fov_rad.0), Radians(self.fov_rad.1));
        let camera = Camera::new(self.frame, fov, self.offset_px, distortion).map_err(|_| MissionError::Camera)?;
        let follow_up = match self.follow_up {
            0 => FollowUpMode::Followed,
            1 => FollowUpMode::Measured,
            2 => FollowUpMode::Fixed,
            _ => return Err(MissionError::Settings),
        };
        let [tilt_white_rad, tilt_drift_rad, heading_rad, follow_up_rad, range_m] = self.sigmas;
        let [gap_us, range_gap_us, position_age_us, patience_us] = self.limits_us;
        let settings = Settings {
            camera,
            follow_up,
            sigmas: Sigmas { tilt_white_rad, tilt_drift_rad, heading_rad, follow_up_rad, range_m },
            gap_us,
            range_gap_us,
            position_age_us,
            patience_us,
            search_px: self.search_px,
            accept: AcceptRule::default(),
        };
        settings.check().map_err(|_| MissionError::Settings)?;
        Ok(settings)
    }

    /// What stamps depend on.
    ///
    /// # Errors
    /// [`MissionError::Settings`].
    pub fn stamp_settings(&self) -> Result<StampSettings, MissionError> {
        self.stamps.settings().ok_or(MissionError::Settings)
    }

    /// The reference tile over `pixels`.
    ///
    /// # Errors
    /// [`MissionError::Tile`].
    pub fn tile<'a>(&self, pixels: &'a [u8]) -> Result<Tile<'a>, MissionError> {
        let georeference = Georeference {
            epsg: self.epsg,
            centre: Geographic { lat_e7: self.centre_e7.0, lon_e7: self.centre_e7.1 },
            east: self.east,
            north: self.north,
            convergence: Radians(self.convergence_rad),
            point_scale: self.point_scale,
        };
        Tile::new(pixels, self.tile, Metres(self.resolution_m), georeference).map_err(|_| MissionError::Tile)
    }
}
