//! What belongs to the instant of a frame's exposure, beside the frame's report, which fills its message.

use plumbline_core::math::sqrt;
use plumbline_core::motion::ImageMotion;
use plumbline_core::navigation::protection::Place;
use plumbline_core::pipeline::Situation;
use plumbline_core::pose::Method;
use plumbline_core::stamp::{ClockState, Stamp, StampCounters, StampSource};
use serde::{Deserialize, Serialize};

/// What is known of the instant of a frame's exposure.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct InstantReport {
    /// Number of the frame.
    pub sequence: u32,
    /// Its stamp; the frame's report says why there is none.
    pub stamp: Option<StampReport>,
    /// How attitude and position at that instant were found.
    pub pose: Option<PoseReport>,
    /// How far the picture moved while the shutter was open.
    pub motion: Option<MotionReport>,
    /// Where the vehicle was then, by all that is known.
    pub place: Option<PlaceReport>,
}

impl InstantReport {
    /// Nothing known yet.
    pub fn new(sequence: u32) -> Self {
        InstantReport { sequence, stamp: None, pose: None, motion: None, place: None }
    }
}

/// Where the vehicle is by the filter on board: not a fix, since it rests on all of them.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct PlaceReport {
    /// Grid metres east of the tile's centre, of the point that positions refer to.
    pub east_m: f32,
    /// Grid metres north of the tile's centre.
    pub north_m: f32,
    /// One sigma of the east coordinate, metres.
    pub sigma_east_m: f32,
    /// One sigma of the north coordinate.
    pub sigma_north_m: f32,
    /// The position is within this but for the risk of [`plumbline_core::navigation::protection::RISK`].
    pub protection_m: f32,
}

impl PlaceReport {
    /// Of a place.
    pub fn new(place: &Place) -> Self {
        let sigma = |axis: usize| sqrt(place.covariance[(axis, axis)]);
        PlaceReport {
            east_m: place.local.east_m,
            north_m: place.local.north_m,
            sigma_east_m: sigma(0),
            sigma_north_m: sigma(1),
            protection_m: place.protection_m,
        }
    }
}

/// A stamp as it is reported.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct StampReport {
    /// Mid-exposure on the autopilot's clock, microseconds.
    pub mid_us: u64,
    /// From the opening to the middle, and from there to the closing.
    pub halves_us: (u32, u32),
    /// One sigma of the middle.
    pub sigma_us: f32,
    /// [`StampSource`] by its code.
    pub source: u8,
    /// Whether pulses discipline the clock; TIMESYNC otherwise.
    pub by_pulses: bool,
    /// Microseconds that the autopilot's clock gains on the capture timer in a second, and one sigma of it.
    pub rate_ppm: (f32, f32),
    /// Seconds since the newest pulse; `u32::MAX` where there was none.
    pub free_wheeling_s: u32,
}

impl StampReport {
    /// A stamp, and the clock when the frame arrived.
    pub fn new(stamp: &Stamp, clock: &ClockState) -> Self {
        StampReport {
            mid_us: stamp.mid.0,
            halves_us: (stamp.mid.since(stamp.open).max(0) as u32, stamp.close.since(stamp.mid).max(0) as u32),
            sigma_us: stamp.sigma_us,
            source: stamp.source as u8,
            by_pulses: clock.by_pulses,
            rate_ppm: (clock.rate_ppm, clock.rate_sigma_ppm),
            free_wheeling_s: clock.free_wheeling_s,
        }
    }

    /// What it was made of.
    pub fn source(&self) -> Option<StampSource> {
        StampSource::from_code(self.source)
    }
}

/// How a pose was found, as it is reported.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct PoseReport {
    /// How the attitude was: 0 by linear interpolation, 2 or 3 by a fit of that order.
    pub order: u8,
    /// α of the fit; 0 without one.
    pub alpha: f32,
    /// Whole samples between the instant's own interval and the nearer end of the window; samples in the window; samples
    /// rejected as outliers.
    pub samples: [u8; 3],
    /// The samples' noise over its configured sigma.
    pub noise: f32,
    /// One sigma of pitch and roll, each, radians, and of their rates, radians a second.
    pub sigma: [f32; 2],
    /// Rates of heading, pitch and roll, radians a second.
    pub rates: [f32; 3],
    /// Whether the position was predicted by a fit; by the newest sample's velocity otherwise.
    pub is_position_fitted: bool,
    /// One sigma of the predicted position, each axis, metres.
    pub position_sigma_m: f32,
}

impl PoseReport {
    /// Of a situation.
    pub fn new(situation: &Situation) -> Self {
        let rates = &situation.rates;
        let report = PoseReport {
            order: 0,
            alpha: 0.0,
            samples: [0; 3],
            noise: 0.0,
            sigma: [situation.sigma_tilt_rad, situation.sigma_rate_rad_s],
            rates: [rates.heading, rates.pitch, rates.roll],
            is_position_fitted: matches!(situation.position_method, Method::Fitted { .. }),
            position_sigma_m: situation.prediction.sigma_m,
        };
        match situation.attitude_method {
            Method::Fitted { order, alpha, lag, count, rejected, scale } => PoseReport {
                order: order.number() as u8,
                alpha,
                samples: [lag, count, rejected],
                noise: scale,
                ..report
            },
            Method::Linear | Method::Propagated => report,
        }
    }
}

/// Image motion as it is reported.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct MotionReport {
    /// Longest displacement in the frame, pixels of the frame: the blur.
    pub max_px: f32,
    /// Displacement at the frame's centre, right and forward.
    pub centre_px: [f32; 2],
    /// Longest exposure that keeps the blur at half a pixel, microseconds.
    pub exposure_max_us: u32,
    /// Whether the blur is above half a pixel, and above the limit of GB/T 27920.1.
    pub warnings: [bool; 2],
}

impl MotionReport {
    /// Of a motion.
    pub fn new(motion: &ImageMotion) -> Self {
        MotionReport {
            max_px: motion.max_px,
            centre_px: motion.centre_px.into(),
            exposure_max_us: motion.exposure_max_us,
            warnings: [motion.is_blurred(), motion.exceeds_standard()],
        }
    }
}

/// What was wrong with edges and pulses, since start.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct StampHealth {
    /// Edges that were bounces or stray short pulses.
    pub edges_bounced: u32,
    /// Edges latched twice or backwards.
    pub edges_bad: u32,
    /// Edges that a frame should have had and had not.
    pub edges_missing: u32,
    /// Pulses off by more than the clock's gate.
    pub pulses_ignored: u32,
    /// Clock epochs since start; the first is its start.
    pub ties: u32,
    /// Seconds since the newest pulse; `u32::MAX` where there was none.
    pub free_wheeling_s: u32,
}

impl StampHealth {
    /// Counters, and the clock now.
    pub fn new(counters: StampCounters, clock: &ClockState) -> Self {
        StampHealth {
            edges_bounced: counters.edges_bounced,
            edges_bad: counters.edges_bad,
            edges_missing: counters.edges_missing,
            pulses_ignored: counters.pulses_ignored,
            ties: counters.clock_epochs,
            free_wheeling_s: clock.free_wheeling_s,
        }
    }
}
