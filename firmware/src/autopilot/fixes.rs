//! What is sent of the fixes: which of them, in which message, and with which covariance.
//!
//! What is sent is a match, never an estimate of ours: the autopilot's filter is the one that smooths. Its filter takes the
//! errors of successive fixes for independent. Some are not: those of a tilt that drifts, and of a map that lies beside the
//! ground, are the same for many fixes, and a filter that averages n of them believes to have taken them off. So only some
//! fixes are sent, and the part of their covariance that they share is sent n times: R = white + n correlated with
//! n = max(1, 2 f τ), the number of fixes at the rate f within the time constant of an error that is correlated over τ. The
//! white part is the match's own and that of the stamp; the correlated one that of the tilt's drift
//! ([`Fix::correlated`]), and the map's offset, which the settings have.

use crate::wire::fix_message::SentFix;
use crate::wire::incoming::AutopilotKind;
use plumbline_core::fix::Fix;
use plumbline_core::math;
use plumbline_core::pose::History;
use plumbline_core::tile::Geographic;
use plumbline_core::tilt::Attitude;
use plumbline_core::units::Micros;

/// In which message fixes are sent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Form {
    /// ODOMETRY: ArduPilot.
    Odometry,
    /// GLOBAL_POSITION_SENSOR: PX4.
    GlobalPositionSensor,
    /// VISION_POSITION_ESTIMATE.
    VisionPosition,
}

impl Form {
    /// What an autopilot takes, unless the settings say so.
    pub fn of(kind: AutopilotKind) -> Self {
        match kind {
            AutopilotKind::Ardupilot => Form::Odometry,
            AutopilotKind::Px4 | AutopilotKind::Other => Form::GlobalPositionSensor,
        }
    }

    /// Whether it is in metres of the autopilot's local frame.
    pub fn is_local(self) -> bool {
        self != Form::GlobalPositionSensor
    }
}

/// How fixes are sent.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FixSettings {
    /// The message; `None` is chosen by the autopilot's heartbeat.
    pub form: Option<Form>,
    /// GLOBAL_POSITION_SENSOR.id, at least 1.
    pub sensor_id: u8,
    /// Least time from one fix to the next, microseconds.
    pub interval_us: u32,
    /// How long errors stay alike, seconds: τ.
    pub correlation_s: f32,
    /// What the map may lie beside the ground, one sigma of each axis, metres.
    pub map_sigma_m: f32,
}

/// Longest gap between two heights to interpolate in, and oldest height that is still taken, microseconds. Heights come ten
/// times a second; a vehicle that climbs at 5 m/s is 5 m off after a second, which the autopilot does not use.
const HEIGHT_GAP_US: u32 = 500_000;
const HEIGHT_AGE_US: i32 = 1_000_000;

/// State of the fixes that are sent.
#[derive(Debug)]
pub struct Fixes {
    settings: FixSettings,
    /// Where the autopilot's local frame begins.
    pub origin: Option<Geographic>,
    down: History<f32, 1, 16>,
    /// Newest velocity to true north and east, m/s, as the autopilot has it.
    pub velocity_m_per_s: [f32; 2],
    newest_at: Option<Micros>,
}

impl Fixes {
    /// None sent yet.
    pub fn new(settings: FixSettings) -> Self {
        Fixes { settings, origin: None, down: History::new(), velocity_m_per_s: [0.0; 2], newest_at: None }
    }

    /// In which message fixes are sent to an autopilot of this kind.
    pub fn form(&self, kind: AutopilotKind) -> Form {
        self.settings.form.unwrap_or(Form::of(kind))
    }

    /// GLOBAL_POSITION_SENSOR.id.
    pub fn sensor_id(&self) -> u8 {
        self.settings.sensor_id
    }

    /// The vehicle's distance below the origin, metres. One whose stamp runs backwards is of a clock that is no more.
    pub fn down(&mut self, at: Micros, down_m: f32) {
        if self.down.push(at, down_m).is_err() {
            self.down = History::new();
            let _ = self.down.push(at, down_m);
        }
    }

    /// The vehicle's distance below the origin at an instant, as the autopilot itself has it.
    pub fn down_at(&self, at: Micros) -> Option<f32> {
        if let Ok(between) = self.down.at(at, HEIGHT_GAP_US) {
            return Some(between.value);
        }
        let (newest_at, newest_m) = self.down.newest()?;
        (0..=HEIGHT_AGE_US).contains(&at.since(newest_at)).then_some(newest_m)
    }

    /// Whether there is a height.
    pub fn has_height(&self) -> bool {
        self.down.newest().is_some()
    }

    /// Forgets what belongs to a clock that is no more.
    pub fn clear(&mut self) {
        (self.down, self.newest_at) = (History::new(), None);
    }

    /// The fix of a frame exposed at `at` as it is sent; nothing where it comes too soon after the last. `attitude`: of the
    /// vehicle, from true north.
    pub fn take(&mut self, fix: &Fix, at: Micros, attitude: Attitude) -> Option<SentFix> {
        let FixSettings { interval_us, correlation_s, map_sigma_m, .. } = self.settings;
        // Frames may come a little early: half of their own interval would still be a rate, a tenth is none.
        let least_us = (interval_us - interval_us / 10) as i32;
        if self.newest_at.is_some_and(|newest| (0..least_us).contains(&at.since(newest))) {
            return None;
        }
        self.newest_at = Some(at);
        let alike = (2e6 * correlation_s / interval_us.max(1) as f32).max(1.0);
        let (c, shared) = (&fix.covariance, &fix.correlated);
        let enlarged = |row: usize, col: usize| {
            let map = if row == col { alike * map_sigma_m * map_sigma_m } else { 0.0 };
            c[(row, col)] + (alike - 1.0) * shared[(row, col)] + map
        };
        let (east, north, cross) = (enlarged(0, 0), enlarged(1, 1), enlarged(0, 1));
        let half = 0.5 * (east - north);
        Some(SentFix {
            at,
            position: fix.position,
            variance_m2: [east, north],
            largest_m2: 0.5 * (east + north) + math::sqrt(half * half + cross * cross),
            attitude,
            velocity_m_per_s: self.velocity_m_per_s,
            resets: 0,
        })
    }
}
