//! What is told of a live flight: `live` of `report.json`.

use super::clock::ClockErrors;
use super::truth::Shift;
use serde::Serialize;

/// Of this share of exchanges, the quickest, the firmware's clock is judged: those that its own filter leans on.
const QUICKEST: usize = 4;

/// An interval of attitudes above this is a gap: a firmware that interpolates across more is guessing, milliseconds.
const GAP_MS: f64 = 100.0;

/// `live` of `report.json`.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Live {
    /// What ended the flight: `frames`, `disarmed`, `closed`, `interrupted`.
    pub ended: String,
    /// Flights begun anew since a connection closed before the vehicle was armed.
    pub reconnects: u32,
    /// The truth and its time.
    pub truth: TruthTime,
    /// The capture timer and the autopilot's clock.
    pub clock: ClockTime,
    /// The attitude as the firmware got it: AUTOPILOT_STATE_FOR_GIMBAL_DEVICE or ATTITUDE_QUATERNION.
    pub attitude: AttitudeStream,
    /// What became of the exposures.
    pub exposures: ExposureCounts,
    /// Bytes from the autopilot to the firmware, and back.
    pub bytes: [u64; 2],
}

/// How well the truth's instants are known.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct TruthTime {
    /// SIM_STATE and ATTITUDE_QUATERNION a second, as was asked for.
    pub rate_hz: u32,
    /// True states received.
    pub samples: u64,
    /// Of these without an attitude of their own.
    pub unordered: u64,
    /// Share of true states whose instant a stamp behind them tells.
    pub pinned: f64,
    /// Of the others: from the stamp of the attitude before a true state to its own instant, milliseconds.
    pub shift_ms: f64,
    /// The error of the instants, milliseconds, at most: of states that are not pinned what the order of arrival leaves open.
    pub error_ms: f64,
    /// How much older than its stamp the autopilot's estimated attitude is, and one sigma, milliseconds; null where the vehicle has
    /// hardly turned or the instants are not pinned.
    pub attitude_delay_ms: Option<[f64; 2]>,
    /// Seconds of turning motion that the attitudes were compared in.
    pub turning_s: usize,
}

/// How well the capture timer followed the autopilot's clock.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct ClockTime {
    /// Seconds of the autopilot's clock in one of ours, at the end.
    pub rate: f64,
    /// Root mean square of the quickest exchanges off the relation, milliseconds.
    pub scatter_ms: f64,
    /// Half of the quickest exchanges' round trip, milliseconds: what their asymmetry can hide.
    pub half_trip_ms: f64,
    /// TIMESYNC exchanges on the truth's connection.
    pub exchanges: u64,
    /// How much the stamps of messages are ahead of the exchanges, milliseconds: what the autopilot takes off for its serial line.
    pub ahead_ms: f64,
    /// How often the autopilot's clock was found to have stood still or jumped.
    pub jumps: u32,
    /// The firmware's own exchanges that were answered.
    pub firmware_exchanges: usize,
    /// Of the quickest quarter of these: the relation's clock less the autopilot's answer, mean and root mean square about it,
    /// milliseconds; null without any.
    pub firmware_offset_ms: Option<[f64; 2]>,
}

/// What became of the exposures.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct ExposureCounts {
    /// Frames that reached the board.
    pub delivered: u32,
    /// Not exposed, since the pictures could not be made in time.
    pub dropped: u32,
    /// Exposed, but they saw beyond the ground.
    pub beyond_ground: u32,
    /// Exposed, but no truth came for them.
    pub without_truth: u32,
    /// From mid-exposure to the delivery, milliseconds of the autopilot's clock: mean and largest.
    pub delivery_ms: [f64; 2],
}

/// A stream on the firmware's connection from the first exposure on.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct AttitudeStream {
    /// Messages.
    pub messages: usize,
    /// Messages a second.
    pub rate_hz: f64,
    /// Largest interval between two stamps, milliseconds.
    pub gap_ms: f64,
    /// Intervals above a tenth of a second.
    pub gaps: usize,
    /// From stamp to arrival, milliseconds: mean and largest.
    pub latency_ms: [f64; 2],
}

impl AttitudeStream {
    /// Of stamps and arrivals since `begin_us`, microseconds.
    pub fn new(all: &[[f64; 2]], begin_us: f64) -> Self {
        let stream = all.get(all.partition_point(|[stamp_us, _]| *stamp_us < begin_us)..).unwrap_or_default();
        let (Some([first_us, _]), Some([last_us, _])) = (stream.first(), stream.last()) else {
            return AttitudeStream::default();
        };
        let intervals_ms = || stream.windows(2).map(|pair| 1e-3 * (pair[1][0] - pair[0][0]));
        let latencies_ms = || stream.iter().map(|[stamp_us, arrived_us]| 1e-3 * (arrived_us - stamp_us));
        AttitudeStream {
            messages: stream.len(),
            rate_hz: 1e6 * (stream.len() as f64 - 1.0) / (last_us - first_us).max(1.0),
            gap_ms: intervals_ms().fold(0.0, f64::max),
            gaps: intervals_ms().filter(|ms| *ms > GAP_MS).count(),
            latency_ms: [latencies_ms().sum::<f64>() / stream.len() as f64, latencies_ms().fold(0.0, f64::max)],
        }
    }
}

impl TruthTime {
    /// Of a shift.
    pub fn new(shift: &Shift, rate_hz: u32, samples: u64, unordered: u64) -> Self {
        TruthTime {
            rate_hz,
            samples,
            unordered,
            pinned: shift.pinned,
            shift_ms: shift.us * 1e-3,
            error_ms: shift.error_us * 1e-3,
            attitude_delay_ms: shift.attitude_delay_us().map(|delay| delay.map(|us| us * 1e-3)),
            turning_s: shift.fitted.map_or(0, |fitted| fitted.blocks),
        }
    }
}

impl ClockTime {
    /// Of the relation, and of the firmware's exchanges: (round trip, relation less answer), microseconds.
    pub fn new(errors: &ClockErrors, exchanges: &[(f64, f64)]) -> Self {
        let mut quickest = exchanges.to_vec();
        quickest.sort_by(|a, b| a.0.total_cmp(&b.0));
        quickest.truncate(exchanges.len().div_ceil(QUICKEST));
        let count = quickest.len() as f64;
        let mean_us = quickest.iter().map(|(_, off)| off).sum::<f64>() / count;
        let square = quickest.iter().map(|(_, off)| (off - mean_us).powi(2)).sum::<f64>() / count;
        ClockTime {
            rate: errors.rate,
            scatter_ms: errors.scatter_us * 1e-3,
            half_trip_ms: errors.half_trip_us * 1e-3,
            exchanges: errors.exchanges,
            ahead_ms: errors.ahead_us * 1e-3,
            jumps: errors.jumps,
            firmware_exchanges: exchanges.len(),
            firmware_offset_ms: (!quickest.is_empty()).then(|| [mean_us * 1e-3, square.sqrt() * 1e-3]),
        }
    }
}
