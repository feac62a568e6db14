//! The tables of a scenario file. Keys carry their units; angles are degrees here and nowhere else.

use super::faults::Seconds;
use serde::Deserialize;
use std::path::PathBuf;

/// The camera: the six keys of every camera file, and distortion.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Camera {
    /// Frame width, pixels.
    pub cols: u16,
    /// Frame height, pixels.
    pub rows: u16,
    /// Full field of view across, over the columns.
    pub fov_h_deg: f64,
    /// Full field of view along, over the rows.
    pub fov_v_deg: f64,
    /// Principal point right of the frame's centre, pixels.
    pub offset_m_px: f64,
    /// Principal point forward of the frame's centre, pixels.
    pub offset_n_px: f64,
    /// Brown-Conrady, ideal to distorted.
    pub distortion: Option<Distortion>,
}

impl Default for Camera {
    fn default() -> Self {
        Camera {
            cols: 512,
            rows: 512,
            fov_h_deg: 60.0,
            fov_v_deg: 60.0,
            offset_m_px: 0.0,
            offset_n_px: 0.0,
            distortion: None,
        }
    }
}

impl Camera {
    /// Tangents per pixel, across and along: kH = tan(V_H/2)/(cols/2) and kV likewise.
    #[must_use]
    pub fn tangent_per_px(&self) -> (f64, f64) {
        let per_px = |fov_deg: f64, count: u16| (0.5 * fov_deg.to_radians()).tan() / (0.5 * f64::from(count));
        (per_px(self.fov_h_deg, self.cols), per_px(self.fov_v_deg, self.rows))
    }
}

/// Brown-Conrady coefficients on normalised coordinates, ideal to distorted.
#[derive(Debug, Clone, Copy, PartialEq, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Distortion {
    /// Radial, of r².
    pub k1: f64,
    /// Radial, of r⁴.
    pub k2: f64,
    /// Radial, of r⁶.
    pub k3: f64,
    /// Tangential, first.
    pub p1: f64,
    /// Tangential, second.
    pub p2: f64,
}

/// True motion.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Flight {
    /// Lowest and highest height above the ground's base, metres; heights between are equally frequent.
    pub height_m: [f64; 2],
    /// Pitch and roll are uniform within plus and minus this.
    pub tilt_max_deg: f64,
    /// Slowest and fastest parts of pitch and roll, hertz.
    pub tilt_hz: [f64; 2],
    /// Root-mean-square horizontal speed; lower where the ground is too small to turn at it.
    pub speed_m_s: f64,
    /// Standard deviation of the heading around the course.
    pub heading_wander_deg: f64,
}

impl Default for Flight {
    fn default() -> Self {
        Flight {
            height_m: [100.0, 150.0],
            tilt_max_deg: 10.0,
            tilt_hz: [0.05, 0.25],
            speed_m_s: 35.0,
            heading_wander_deg: 20.0,
        }
    }
}

/// Attitude sensor. Each of heading, pitch and roll has noise of its own: white, plus a first-order Gauss-Markov drift.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Attitude {
    /// Samples a second.
    pub rate_hz: u32,
    /// From its stamp to its arrival.
    pub latency_us: u32,
    /// How much older than its stamp a value is: the sensor's own filters. The firmware knows it.
    pub delay_us: u32,
    /// Whole samples that the firmware's pose lags behind the newest.
    pub lag: u8,
    /// White noise, one sigma.
    pub white_deg: f64,
    /// Drift, one sigma.
    pub drift_deg: f64,
    /// Time constant of the drift.
    pub drift_s: f64,
    /// White noise of the heading; that of pitch and roll unless given.
    pub heading_white_deg: Option<f64>,
    /// Drift of the heading; that of pitch and roll unless given.
    pub heading_drift_deg: Option<f64>,
}

impl Default for Attitude {
    fn default() -> Self {
        Attitude {
            rate_hz: 200,
            latency_us: 8000,
            delay_us: 0,
            lag: 2,
            white_deg: 0.1,
            drift_deg: 0.0,
            drift_s: 30.0,
            heading_white_deg: None,
            heading_drift_deg: None,
        }
    }
}

/// What the camera does about the heading, and what the firmware is configured for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum FollowUpMode {
    /// A servo follows; the firmware computes the follow-up angle.
    #[default]
    Followed,
    /// A servo follows; the firmware reads its encoder.
    Measured,
    /// No servo: the follow-up angle is zero.
    Fixed,
}

/// Camera servo and encoder. The encoder sends in the mode "measured" only.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct FollowUp {
    /// Which of the three.
    pub mode: FollowUpMode,
    /// Time constant of the servo, seconds; 0 follows exactly.
    pub servo_lag_s: f64,
    /// White noise of the encoder, one sigma.
    pub noise_deg: f64,
    /// Samples a second.
    pub rate_hz: u32,
    /// From its stamp to its arrival.
    pub latency_us: u32,
    /// As for attitude.
    pub delay_us: u32,
}

impl Default for FollowUp {
    fn default() -> Self {
        FollowUp {
            mode: FollowUpMode::Followed,
            servo_lag_s: 0.0,
            noise_deg: 0.05,
            rate_hz: 100,
            latency_us: 5000,
            delay_us: 0,
        }
    }
}

/// Laser rangefinder, strapped down along the camera's axis.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Range {
    /// White noise of the slant, one sigma.
    pub sigma_m: f64,
    /// Samples a second.
    pub rate_hz: u32,
    /// From its stamp to its arrival.
    pub latency_us: u32,
    /// As for attitude.
    pub delay_us: u32,
    /// Share of the samples without an echo.
    pub dropout_percent: f64,
}

impl Default for Range {
    fn default() -> Self {
        Range { sigma_m: 0.03, rate_hz: 50, latency_us: 10_000, delay_us: 0, dropout_percent: 0.0 }
    }
}

/// Position prior, as a vehicle without satellite navigation has it: good to a few pixels, drifting.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Position {
    /// Gauss-Markov error of each of east, north and up, one sigma; two pixels of the reference unless given, so that
    /// the usual search of ten covers five sigmas.
    pub sigma_m: Option<f64>,
    /// Its time constant.
    pub time_constant_s: f64,
    /// White noise of each of east, north and up, one sigma.
    pub white_m: f64,
    /// White noise of each velocity, one sigma.
    pub velocity_sigma_m_s: f64,
    /// Samples a second.
    pub rate_hz: u32,
    /// From its stamp to its arrival.
    pub latency_us: u32,
    /// As for attitude.
    pub delay_us: u32,
}

impl Default for Position {
    fn default() -> Self {
        Position {
            sigma_m: None,
            time_constant_s: 60.0,
            white_m: 0.0,
            velocity_sigma_m_s: 0.1,
            rate_hz: 5,
            latency_us: 100_000,
            delay_us: 0,
        }
    }
}

/// How the camera sits in the vehicle.
#[derive(Debug, Clone, Copy, PartialEq, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Mount {
    /// From the antenna, whose position is reported and corrected, to the camera: forward, right, down.
    pub lever_arm_m: [f64; 3],
    /// Rotation of the camera against where the follow-up axis has it look: heading, pitch, roll.
    pub boresight_deg: [f64; 3],
    /// That rotation as it really is, where the board is configured with another: what `plumbline boresight` finds. As configured
    /// unless given.
    pub true_boresight_deg: Option<[f64; 3]>,
    /// From the virtual projection centre of a combined camera to the head that flies, along the axes of the mount, which
    /// turn with the follow-up axis: forward, right, down. From the camera file alone.
    #[serde(skip)]
    pub head_arm_m: [f64; 3],
}

impl Mount {
    /// The camera's turn as it really is, radians.
    #[must_use]
    pub fn true_boresight_rad(&self) -> [f64; 3] {
        self.true_boresight_deg.unwrap_or(self.boresight_deg).map(f64::to_radians)
    }
}

/// How the reference differs from the ground: offset + gain · 255 (DN/255)^gamma, noise, and patches that changed. What is not
/// given depends on the ground: a procedural one has differences made up, over an orthophoto there are none.
#[derive(Debug, Clone, Copy, PartialEq, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Reference {
    /// Exponent of the tone curve.
    pub gamma: Option<f64>,
    /// Gain after it.
    pub gain: Option<f64>,
    /// Offset after it, DN.
    pub offset_dn: Option<f64>,
    /// White noise, DN.
    pub noise_dn: Option<f64>,
    /// Share of the area that looks different today.
    pub changed_fraction: Option<f64>,
}

/// Which of the shutter's edges are wired to the capture timer.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum EdgeSource {
    /// Both.
    #[default]
    Both,
    /// The opening one.
    One,
    /// None: frames are stamped by their arrival.
    None,
}

/// The shutter's line, and the way of a frame to the board. The firmware is configured with delays, latency and sigmas, as a
/// calibration would find them.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Shutter {
    /// Which edges are wired.
    pub edges: EdgeSource,
    /// White noise of each edge, one sigma.
    pub edge_jitter_us: f64,
    /// From the shutter's opening to its edge.
    pub open_delay_us: i32,
    /// From the shutter's closing to its edge.
    pub close_delay_us: i32,
    /// White noise of the exposure's length, one sigma, rounded to whole microseconds.
    pub exposure_jitter_us: f64,
    /// From the shutter's closing to the arrival of the first row.
    pub arrival_latency_us: u32,
    /// White noise of the arrival, one sigma; none is off by more than four.
    pub arrival_jitter_us: f64,
    /// Share of the edges that are lost.
    pub lost_edge_percent: f64,
    /// Share of the edges beside which a bounce, a short pulse or a stray edge is put.
    pub extra_edge_percent: f64,
    /// Share of the frames that never arrive, though the shutter opened.
    pub lost_frame_percent: f64,
}

impl Default for Shutter {
    fn default() -> Self {
        Shutter {
            edges: EdgeSource::Both,
            edge_jitter_us: 1.0,
            open_delay_us: 0,
            close_delay_us: 0,
            exposure_jitter_us: 0.0,
            arrival_latency_us: 50,
            arrival_jitter_us: 5.0,
            lost_edge_percent: 0.0,
            extra_edge_percent: 0.0,
            lost_frame_percent: 0.0,
        }
    }
}

/// The free-running 32-bit capture timer of 1 MHz, and the pulse per second that ties it to the autopilot.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Timer {
    /// Its count at the autopilot's time 0. The default wraps 5 s into the flight.
    pub start_ticks: u32,
    /// How much faster than the autopilot's clock it runs at first, parts per million.
    pub drift_ppm: f64,
    /// Random walk of that, one sigma in a second.
    pub rate_walk_ppm: f64,
    /// Whether the pulse per second is wired.
    pub pps: bool,
    /// White noise of the pulse, one sigma.
    pub pps_jitter_us: f64,
    /// When there are no pulses.
    pub pps_lost_s: Option<Seconds>,
    /// Whether the autopilot answers TIMESYNC, without which no pulse has a name.
    pub timesync: bool,
}

impl Default for Timer {
    fn default() -> Self {
        Timer {
            start_ticks: 4_290_000_000,
            drift_ppm: 20.0,
            rate_walk_ppm: 0.01,
            pps: true,
            pps_jitter_us: 0.5,
            pps_lost_s: None,
            timesync: true,
        }
    }
}

/// How a plan is flown.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Plan {
    /// Deviations from the planned track, one sigma: east and north each, and up, metres.
    pub deviation_m: [f64; 2],
    /// The plan; a caller puts it here.
    #[serde(skip)]
    pub file: Option<PathBuf>,
    /// The elevation model in the place of the plan's own.
    #[serde(skip)]
    pub dem: Option<PathBuf>,
    /// Whether `resolution_m` is what somebody wanted; otherwise it is chosen.
    #[serde(skip)]
    pub has_resolution: bool,
}

impl Default for Plan {
    fn default() -> Self {
        Plan { deviation_m: [1.0, 1.0], file: None, dem: None, has_resolution: false }
    }
}

/// A recorded attitude, flown as the true one.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Replay {
    /// CSV with the columns `t_s`, `roll_deg`, `pitch_deg`, `yaw_deg`.
    pub att: PathBuf,
    /// The `t_s` at which the flight begins; the log's first row unless given.
    #[serde(default)]
    pub start_s: Option<f64>,
    /// Seconds of the log flown in a second; below 1 calms the log down.
    #[serde(default = "real_time")]
    pub time_scale: f64,
}

fn real_time() -> f64 {
    1.0
}
