//! The configuration store: camera, calibration and settings.
//!
//! Its payload is [`Configuration`] in postcard's encoding (fields in their order, integers as varints, floats as their four
//! bytes), and nothing behind it.

mod link;
mod stamps;

use super::StoreError;
use super::framing::{HEADER_BYTES, Kind, header, open};
pub use link::{ALTITUDES_M, CORRELATION_MAX_S, Link, START_SIGMA_MAX_M, Start};
use plumbline_core::camera::{Camera, Distortion};
use plumbline_core::matching::acceptance::AcceptRule;
use plumbline_core::mount::{LeverArm, Mount};
use plumbline_core::pipeline::{FollowUpMode, Latencies, Motion, Motions, Settings, Sigmas};
use plumbline_core::pose::noise::Wave;
use plumbline_core::stamp::StampSettings;
use plumbline_core::tilt::Attitude;
use plumbline_core::units::Radians;
use serde::{Deserialize, Serialize};
pub use stamps::Stamps;

/// This store's magic and version.
pub const KIND: Kind = Kind { magic: *b"PLBM", version: 7 };
/// Bytes that hold any configuration with its header.
pub const STORE_MAX: usize = 512;

/// A configuration as it is stored. Angles in radians, lengths in metres.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Configuration {
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
    /// (metres), velocity, that of turns (m/s).
    pub sigmas: [f32; 10],
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
    /// Whether rectified patches are sent by the image transmission protocol.
    pub send_patches: bool,
    /// Shutter line, capture timer and pulses.
    pub stamps: Stamps,
    /// Who is on the link, and how fixes are sent.
    pub link: Link,
}

/// The configuration in the store that `region` begins with. Any bytes may come. Whether it can be flown,
/// [`Configuration::settings`] and [`Configuration::stamp_settings`] say.
///
/// # Errors
/// [`StoreError`].
pub fn read(region: &[u8]) -> Result<Configuration, StoreError> {
    match postcard::take_from_bytes(open(KIND, region)?) {
        Ok((configuration, [])) => Ok(configuration),
        _ => Err(StoreError::Encoding),
    }
}

impl Configuration {
    /// The whole store, in `buffer`; [`STORE_MAX`] bytes are enough.
    ///
    /// # Errors
    /// [`StoreError::Encoding`] when the buffer is too small.
    pub fn store<'b>(&self, buffer: &'b mut [u8]) -> Result<&'b mut [u8], StoreError> {
        let (front, rest) = buffer.split_at_mut_checked(HEADER_BYTES).ok_or(StoreError::Encoding)?;
        let payload = postcard::to_slice(self, rest).map_err(|_| StoreError::Encoding)?;
        front.copy_from_slice(&header(KIND, &[payload]));
        let length = HEADER_BYTES + payload.len();
        buffer.get_mut(..length).ok_or(StoreError::Encoding)
    }

    /// The core's settings.
    ///
    /// # Errors
    /// [`StoreError::Camera`], [`StoreError::Settings`], [`StoreError::Encoding`].
    pub fn settings(&self) -> Result<Settings, StoreError> {
        let distortion = self.distortion.map(|[k1, k2, k3, p1, p2]| Distortion { k1, k2, k3, p1, p2 });
        let fov = (Radians(self.fov_rad.0), Radians(self.fov_rad.1));
        let camera = Camera::new(self.frame, fov, self.offset_px, distortion).map_err(StoreError::Camera)?;
        let follow_up = match self.follow_up {
            0 => FollowUpMode::Followed,
            1 => FollowUpMode::Measured,
            2 => FollowUpMode::Fixed,
            _ => return Err(StoreError::Encoding),
        };
        let [tilt_white_rad, tilt_drift_rad, heading_white_rad, heading_drift_rad, follow_up_rad, ..] = self.sigmas;
        let [.., range_m, position_white_m, position_drift_m, velocity_m_per_s, turn_velocity_m_per_s] = self.sigmas;
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
                turn_velocity_m_per_s,
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
        settings.check().map_err(StoreError::Settings)?;
        Ok(settings)
    }

    /// What stamps depend on.
    ///
    /// # Errors
    /// [`StoreError::Stamps`], [`StoreError::Encoding`].
    pub fn stamp_settings(&self) -> Result<StampSettings, StoreError> {
        self.stamps.settings()
    }
}
