//! What lies in flash: camera, settings and the reference's georeference, guarded by a CRC.
//!
//! Written on the ground, read once at boot. A mission that cannot be read leaves the vehicle without fixes and with a
//! reason, never with wrong ones.

mod stamps;

use plumbline_core::camera::{Camera, Distortion};
use plumbline_core::matching::judge::AcceptRule;
use plumbline_core::mount::{LeverArm, Mount};
use plumbline_core::pipeline::{FollowUpMode, Latencies, Motion, Motions, Settings, Sigmas};
use plumbline_core::pose::noise::Wave;
use plumbline_core::stamp::StampSettings;
use plumbline_core::tile::{Geographic, Georeference, Tile};
use plumbline_core::tilt::Attitude;
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
    /// Antenna to camera: forward, right, down, metres.
    pub lever_arm_m: [f32; 3],
    /// Turn of the camera in its mount: heading, pitch, roll.
    pub boresight_rad: [f32; 3],
    /// Tilt white, tilt drift, heading white, heading drift, follow-up (radians), range, position white, position drift
    /// (metres), velocity (m/s).
    pub sigmas: [f32; 9],
    /// Attitude, position: nominal interval in microseconds, amplitude (radians, metres) and period
    /// (seconds) of two motions.
    pub motions: [(u32, [f32; 4]); 2],
    /// How much older than their stamps attitude, follow-up angle, range and position are, microseconds.
    pub latencies_us: [u32; 4],
    /// Rolling shutter: from the first row's mid-exposure to the last one's, microseconds; 0 for a global one.
    pub readout_us: u32,
    /// Samples that the pose lags behind the newest.
    pub lag: u8,
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

/// Bytes that hold any mission.
pub const ENCODED_MAX: usize = 512;

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
    /// [`MissionError::Encoding`] when the buffer is too small; [`ENCODED_MAX`] bytes are enough.
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
        let [tilt_white_rad, tilt_drift_rad, heading_white_rad, heading_drift_rad, follow_up_rad, ..] = self.sigmas;
        let [.., range_m, position_white_m, position_drift_m, velocity_m_per_s] = self.sigmas;
        let motion = |(interval_us, [a0, t0, a1, t1]): (u32, [f32; 4])| Motion {
            interval_us,
            waves: [Wave { amplitude: a0, period_s: t0 }, Wave { amplitude: a1, period_s: t1 }],
        };
        let [attitude, position] = self.motions.map(motion);
        let [forward_m, right_m, down_m] = self.lever_arm_m;
        let [heading, pitch, roll] = self.boresight_rad.map(Radians);
        let [attitude_us, follow_up_us, range_us, position_us] = self.latencies_us;
        let [gap_us, range_gap_us, position_age_us, patience_us] = self.limits_us;
        let settings = Settings {
            camera,
            follow_up,
            mount: Mount {
                lever_arm: LeverArm { forward_m, right_m, down_m },
                boresight: Attitude { heading, pitch, roll },
            },
            sigmas: Sigmas {
                tilt_white_rad,
                tilt_drift_rad,
                heading_white_rad,
                heading_drift_rad,
                follow_up_rad,
                range_m,
                position_white_m,
                position_drift_m,
                velocity_m_per_s,
            },
            motions: Motions { attitude, position },
            latencies: Latencies { attitude_us, follow_up_us, range_us, position_us },
            readout_us: self.readout_us,
            lag: self.lag,
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
