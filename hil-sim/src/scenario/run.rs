//! One run: its seed and its frames, where the vehicle goes.

use super::bounds::Bounded;
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// Most frames of a flight: a day at 4 Hz is 345 600.
pub const FRAMES_MAX: u32 = 1_000_000;
/// The sensors run this long before the first frame, microseconds: the board needs two pulses per second, a clock
/// offset and a position before it can fix anything.
pub const WARM_UP_US: u64 = 3_000_000;
/// The flight goes on this long after the last frame's interval, microseconds, so that the last frame gets its pose.
pub const COOL_DOWN_US: u64 = 1_000_000;

/// Keys carry their units.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize)]
#[serde(default)]
pub struct Run {
    /// What the report calls it.
    pub name: String,
    /// Every random number of the flight comes from this. Same seed, same bytes.
    pub seed: u64,
    /// Frames to take.
    pub frames: u32,
    /// From one frame to the next, milliseconds.
    pub frame_interval_ms: u32,
    /// Each frame opens late by a random part of this, microseconds, so that frames and attitude samples, both driven
    /// by quartz, do not keep one phase for the whole flight.
    pub frame_jitter_us: u32,
    /// Where the vehicle goes.
    pub flight: Flight,
    /// A recorded attitude instead of a synthetic one.
    pub replay: Option<Replay>,
    /// How a plan is flown.
    pub plan: Plan,
    /// How a flight with a real autopilot is flown.
    pub live: Live,
    /// What the link is given for this run.
    pub link: RunLink,
}

impl Default for Run {
    fn default() -> Self {
        Run {
            name: "default".into(),
            seed: 1,
            frames: 300,
            frame_interval_ms: 250,
            frame_jitter_us: 5000,
            flight: Flight::default(),
            replay: None,
            plan: Plan::default(),
            live: Live::default(),
            link: RunLink::default(),
        }
    }
}

/// Where the vehicle goes.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize, Serialize)]
#[serde(default)]
pub struct Flight {
    /// Lowest and highest height above the ground's base, metres; heights between are equally frequent.
    pub height_m: [f64; 2],
    /// Standard deviation of the heading around the course.
    pub heading_wander_deg: f64,
}

impl Default for Flight {
    fn default() -> Self {
        Flight { height_m: [100.0, 150.0], heading_wander_deg: 20.0 }
    }
}

/// How a plan is flown.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct Plan {
    /// Deviations from the planned track, one sigma: east and north each, and up, metres.
    pub deviation_m: [f64; 2],
}

impl Default for Plan {
    fn default() -> Self {
        Plan { deviation_m: [1.0, 1.0] }
    }
}

/// How a flight with a real autopilot is flown.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct Live {
    /// Side of the reference tile; 5.6 km, or what fits on board, unless given.
    pub tile_side_m: Option<f64>,
    /// The tile's centre from where the vehicle stands at the start, east and north.
    pub tile_offset_m: [f64; 2],
    /// Side of procedural ground, centred on the start.
    pub ground_side_m: f64,
    /// Height above the start at which the camera is switched on.
    pub from_height_m: f64,
}

impl Default for Live {
    fn default() -> Self {
        Live { tile_side_m: None, tile_offset_m: [0.0; 2], ground_side_m: 8000.0, from_height_m: 30.0 }
    }
}

/// What the link is given for a run, beside the settings of the vehicle's.
#[derive(Debug, Clone, PartialEq, Eq, Default, Deserialize, Serialize)]
#[serde(default)]
pub struct RunLink {
    /// File of 64 hexadecimal digits: the key that both sides sign their messages with. They are not signed without.
    pub signing_key_path: Option<PathBuf>,
}

/// A recorded attitude, flown as the true one.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Replay {
    /// CSV with the columns `t_s`, `roll_deg`, `pitch_deg`, `yaw_deg`, or a flight log.
    pub att: PathBuf,
    /// Seconds of the log's clock at which the flight begins; the log's first row unless given.
    #[serde(default)]
    pub start_s: Option<f64>,
    /// Seconds of the log flown in a second; below 1 calms the log down.
    #[serde(default = "real_time")]
    pub time_scale: f64,
}

fn real_time() -> f64 {
    1.0
}

impl Run {
    /// From power-on of the autopilot's clock to the end of the flight, microseconds.
    #[must_use]
    pub fn duration_us(&self) -> u64 {
        WARM_UP_US + u64::from(self.frames) * self.frame_interval_us() + COOL_DOWN_US
    }

    /// From one frame to the next, microseconds.
    #[must_use]
    pub fn frame_interval_us(&self) -> u64 {
        u64::from(self.frame_interval_ms) * 1000
    }

    /// Each value that has bounds.
    pub(super) fn ranges(&self) -> Vec<Bounded> {
        let mut ranges = vec![
            ("frames", self.frames.into(), 1.0, FRAMES_MAX.into()),
            ("frame_interval_ms", self.frame_interval_ms.into(), 10.0, 3_600_000.0),
            ("frame_jitter_us", self.frame_jitter_us.into(), 0.0, 1e6),
            ("flight.heading_wander_deg", self.flight.heading_wander_deg, 0.0, 180.0),
        ];
        ranges.extend(self.flight.height_m.map(|m| ("flight.height_m", m, 0.1, 1e5)));
        ranges.extend(self.plan.deviation_m.map(|m| ("plan.deviation_m", m, 0.0, 1000.0)));
        let live = &self.live;
        ranges.push(("live.tile_side_m", live.tile_side_m.unwrap_or(1.0), 1.0, 1e6));
        ranges.extend(live.tile_offset_m.map(|m| ("live.tile_offset_m", m, -1e6, 1e6)));
        ranges.push(("live.ground_side_m", live.ground_side_m, 100.0, 1e6));
        ranges.push(("live.from_height_m", live.from_height_m, 0.1, 1e5));
        if let Some(replay) = &self.replay {
            ranges.push(("replay.start_s", replay.start_s.unwrap_or(0.0), -1e9, 1e9));
            ranges.push(("replay.time_scale", replay.time_scale, 0.01, 100.0));
        }
        ranges
    }
}
