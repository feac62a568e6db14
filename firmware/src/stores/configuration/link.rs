//! The settings of the link as they are stored: who is listened to, and how fixes are sent.

use crate::autopilot::fixes::{FixSettings, Form};
use crate::autopilot::sources::Switching;
use crate::autopilot::start::StartSettings;
use crate::stores::StoreError;
use crate::wire::incoming::Speakers;
use crate::wire::outgoing::COMPONENT;
use plumbline_core::tile::Geographic;
use serde::{Deserialize, Serialize};

/// Who is on the link, and how fixes are sent to it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Link {
    /// The autopilot's system and component. The system is ours too.
    pub autopilot: (u8, u8),
    /// The component that sends DISTANCE_SENSOR, and the id of the sensor; without one the first that looks down.
    pub range: (u8, Option<u8>),
    /// The component that sends the follow-up axis' angle.
    pub encoder: u8,
    /// Nominal interval of ranges, microseconds.
    pub range_interval_us: u32,
    /// 0 by the autopilot's heartbeat, 1 ODOMETRY, 2 GLOBAL_POSITION_SENSOR, 3 VISION_POSITION_ESTIMATE.
    pub fix_message: u8,
    /// GLOBAL_POSITION_SENSOR.id.
    pub sensor_id: u8,
    /// Least time from one fix that is sent to the next, microseconds.
    pub fix_interval_us: u32,
    /// How long errors of fixes stay alike, seconds.
    pub correlation_s: f32,
    /// What the map may lie beside the ground, one sigma of each axis, metres.
    pub map_sigma_m: f32,
    /// 0 the autopilot's sources are left alone, 1 switched where satellite navigation is lost, 2 as a ground station says.
    pub switching: u8,
    /// The ground station's system, whose orders are taken; 0 for nobody's.
    pub ground_station: u8,
    /// Whether a fix that finds a lost position changes the reset counter.
    pub resets_on_reacquisition: bool,
    /// Where the vehicle stands at first, where satellite navigation does not tell.
    pub start: Option<Start>,
}

/// A start without satellite navigation.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Start {
    /// Latitude and longitude, 1e-7 degrees.
    pub place_e7: (i32, i32),
    /// One sigma of each axis, metres.
    pub sigma_m: f32,
    /// One sigma of the heading, radians.
    pub heading_sigma_rad: f32,
    /// Height above sea level, metres.
    pub altitude_m: f32,
    /// Whether the autopilot is given the place as the origin of its frame.
    pub sets_origin: bool,
}

/// Longest time for which errors of fixes are taken to be alike, seconds: one that lasts longer is followed rather than
/// averaged by the autopilot's filter, whose own memory of positions is of that order.
pub const CORRELATION_MAX_S: f32 = 5.0;
/// Fixes are as far apart as a minute, no nearer than the frames of a fast camera.
const FIX_INTERVAL_US: core::ops::RangeInclusive<u32> = 10_000..=60_000_000;
/// A map that is further off is the wrong one.
const MAP_SIGMA_MAX_M: f32 = 1000.0;
/// A start that is known no better is not known: as far as a large reference reaches.
pub const START_SIGMA_MAX_M: f32 = 10_000.0;
/// Half a turn.
const HEADING_SIGMA_MAX_RAD: f32 = core::f32::consts::PI;
/// From the Dead Sea to the summit of Everest, and some more.
pub const ALTITUDES_M: core::ops::RangeInclusive<f32> = -500.0..=10_000.0;

impl Link {
    /// Whose messages are taken.
    pub fn speakers(&self) -> Speakers {
        let system = self.autopilot.0;
        Speakers {
            us: (system, COMPONENT),
            autopilot: self.autopilot,
            range: ((system, self.range.0), self.range.1),
            encoder: (system, self.encoder),
            ground_station: Some(self.ground_station).filter(|system| *system != 0),
        }
    }

    /// Who chooses the autopilot's sources.
    ///
    /// # Errors
    /// [`StoreError::Encoding`].
    pub fn switching(&self) -> Result<Switching, StoreError> {
        match self.switching {
            0 => Ok(Switching::Never),
            1 => Ok(Switching::OnGnssLoss),
            2 => Ok(Switching::Told),
            _ => Err(StoreError::Encoding),
        }
    }

    /// A start without satellite navigation, where one is set.
    ///
    /// # Errors
    /// [`StoreError::Link`].
    pub fn start(&self) -> Result<Option<StartSettings>, StoreError> {
        self.start.map(|start| start.settings()).transpose()
    }

    /// How fixes are sent.
    ///
    /// # Errors
    /// [`StoreError::Link`], [`StoreError::Encoding`].
    pub fn fixes(&self) -> Result<FixSettings, StoreError> {
        let form = match self.fix_message {
            0 => None,
            1 => Some(Form::Odometry),
            2 => Some(Form::GlobalPositionSensor),
            3 => Some(Form::VisionPosition),
            _ => return Err(StoreError::Encoding),
        };
        let is_sound = self.autopilot.0 != 0
            && self.sensor_id != 0
            && self.range_interval_us > 0
            && FIX_INTERVAL_US.contains(&self.fix_interval_us)
            && (0.0..=CORRELATION_MAX_S).contains(&self.correlation_s)
            && (0.0..=MAP_SIGMA_MAX_M).contains(&self.map_sigma_m);
        if !is_sound {
            return Err(StoreError::Link);
        }
        Ok(FixSettings {
            form,
            sensor_id: self.sensor_id,
            interval_us: self.fix_interval_us,
            correlation_s: self.correlation_s,
            map_sigma_m: self.map_sigma_m,
            resets_on_reacquisition: self.resets_on_reacquisition,
        })
    }
}

impl Start {
    fn settings(self) -> Result<StartSettings, StoreError> {
        let Start { place_e7: (lat_e7, lon_e7), sigma_m, heading_sigma_rad, altitude_m, sets_origin } = self;
        let place = Geographic { lat_e7, lon_e7 };
        let is_sound = place.is_possible()
            && sigma_m > 0.0
            && sigma_m <= START_SIGMA_MAX_M
            && (0.0..=HEADING_SIGMA_MAX_RAD).contains(&heading_sigma_rad)
            && ALTITUDES_M.contains(&altitude_m);
        if !is_sound {
            return Err(StoreError::Link);
        }
        Ok(StartSettings { place, sigma_m, heading_sigma_rad, altitude_mm: (altitude_m * 1000.0) as i32, sets_origin })
    }
}
