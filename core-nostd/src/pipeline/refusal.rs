//! Reasons for which a frame has no fix. Each is counted and reported; none is fatal.

use super::SituateError;
use crate::homography::rolling::BandsError;
use crate::matching::{MatchError, Rejection};
use crate::pose::PoseError;
use crate::rectify::RectifyError;
use crate::reduce::ReduceError;
use crate::stamp::StampError;

/// Why a frame has no fix.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[repr(u8)]
pub enum Refusal {
    /// The capture timer has not been compared with the autopilot's clock yet.
    NoClock = 1,
    /// The shutter edges do not form an exposure.
    BadExposure = 2,
    /// The frame before was still being processed.
    Busy = 3,
    /// Rows were overwritten before they were read.
    Overrun = 4,
    /// The frame has another size than the camera file's, or ended early.
    BadFrame = 5,
    /// The frame cannot be reduced into this build's memory.
    FrameTooLarge = 6,
    /// No attitude around mid-exposure.
    NoAttitude = 7,
    /// Attitude samples around mid-exposure too far apart.
    AttitudeGap = 8,
    /// No follow-up angle around mid-exposure.
    NoFollowUp = 9,
    /// No valid range around mid-exposure.
    NoRange = 10,
    /// The optical axis is too near the horizon, or the attitude is not a number.
    Tilt = 11,
    /// No position recent enough to predict from.
    NoPosition = 12,
    /// The search window leaves the reference tile.
    OutsideReference = 13,
    /// Nothing of the patch lies in the frame, or the patch is too small or too large.
    NoFootprint = 14,
    /// Patch or reference without texture.
    Featureless = 15,
    /// Too few valid pixels.
    FewPixels = 16,
    /// The peak lies on the border of the search.
    OnBorder = 17,
    /// The correlation is too low.
    LowScore = 18,
    /// The second peak is almost as high.
    Ambiguous = 19,
    /// The sub-pixel solution is too uncertain or too far from the peak.
    Imprecise = 20,
    /// The shutter edges contradict each other, the known exposure or the frame's arrival.
    EdgesContradict = 21,
    /// An edge is missing, and no exposure is known to replace it.
    NoExposure = 22,
    /// The clock has run free for so long, or its references contradict each other so much, that a stamp would be too
    /// uncertain; or it made a step after the frame was stamped.
    UncertainClock = 23,
    /// The frame is not later than the one before.
    FrameBackwards = 24,
    /// Several attitudes in a row around mid-exposure are identical to the last bit: the sensor is frozen.
    AttitudeStuck = 25,
    /// The camera moves too fast for its rolling shutter.
    TooFast = 26,
    /// A buffer of this build is too small for what the frame needs.
    Capacity = 27,
    /// The match is far from the prediction, or the first after a long time without; the next frames must confirm it.
    Unconfirmed = 28,
    /// The match contradicts the track of the matches before.
    Contradicted = 29,
    /// The picture is identical to the one before to the last bit: the camera is frozen.
    Repeated = 30,
    /// A match of the greys that the gradient directions do not confirm, and the surface has no decision for its
    /// position.
    Undecided = 31,
}

/// Every refusal, in the order of its code.
pub const ALL: [Refusal; 31] = [
    Refusal::NoClock,
    Refusal::BadExposure,
    Refusal::Busy,
    Refusal::Overrun,
    Refusal::BadFrame,
    Refusal::FrameTooLarge,
    Refusal::NoAttitude,
    Refusal::AttitudeGap,
    Refusal::NoFollowUp,
    Refusal::NoRange,
    Refusal::Tilt,
    Refusal::NoPosition,
    Refusal::OutsideReference,
    Refusal::NoFootprint,
    Refusal::Featureless,
    Refusal::FewPixels,
    Refusal::OnBorder,
    Refusal::LowScore,
    Refusal::Ambiguous,
    Refusal::Imprecise,
    Refusal::EdgesContradict,
    Refusal::NoExposure,
    Refusal::UncertainClock,
    Refusal::FrameBackwards,
    Refusal::AttitudeStuck,
    Refusal::TooFast,
    Refusal::Capacity,
    Refusal::Unconfirmed,
    Refusal::Contradicted,
    Refusal::Repeated,
    Refusal::Undecided,
];

impl Refusal {
    /// The refusal with this code; `None` for 0, which stands for "accepted", and for unknown codes.
    pub fn from_code(code: u8) -> Option<Self> {
        ALL.get((code as usize).checked_sub(1)?).copied()
    }

    /// Its code, from 1.
    pub fn code(self) -> u8 {
        self as u8
    }

    /// Its name in logs and tables.
    pub fn name(self) -> &'static str {
        match self {
            Refusal::NoClock => "no_clock",
            Refusal::BadExposure => "bad_exposure",
            Refusal::Busy => "busy",
            Refusal::Overrun => "overrun",
            Refusal::BadFrame => "bad_frame",
            Refusal::FrameTooLarge => "frame_too_large",
            Refusal::NoAttitude => "no_attitude",
            Refusal::AttitudeGap => "attitude_gap",
            Refusal::NoFollowUp => "no_follow_up",
            Refusal::NoRange => "no_range",
            Refusal::Tilt => "tilt",
            Refusal::NoPosition => "no_position",
            Refusal::OutsideReference => "outside_reference",
            Refusal::NoFootprint => "no_footprint",
            Refusal::Featureless => "featureless",
            Refusal::FewPixels => "few_pixels",
            Refusal::OnBorder => "on_border",
            Refusal::LowScore => "low_score",
            Refusal::Ambiguous => "ambiguous",
            Refusal::Imprecise => "imprecise",
            Refusal::AttitudeStuck => "attitude_stuck",
            Refusal::TooFast => "too_fast",
            Refusal::Capacity => "capacity",
            Refusal::Unconfirmed => "unconfirmed",
            Refusal::Contradicted => "contradicted",
            Refusal::Repeated => "repeated",
            Refusal::Undecided => "undecided",
            Refusal::EdgesContradict => "edges_contradict",
            Refusal::NoExposure => "no_exposure",
            Refusal::UncertainClock => "uncertain_clock",
            Refusal::FrameBackwards => "frame_backwards",
        }
    }
}

impl From<SituateError> for Refusal {
    fn from(error: SituateError) -> Self {
        match error {
            SituateError::Attitude(PoseError::Gap) => Refusal::AttitudeGap,
            SituateError::Attitude(PoseError::Frozen) => Refusal::AttitudeStuck,
            SituateError::Attitude(PoseError::TooOld | PoseError::NotYet) => Refusal::NoAttitude,
            SituateError::FollowUp(_) => Refusal::NoFollowUp,
            SituateError::Range(_) => Refusal::NoRange,
            SituateError::Position(_) => Refusal::NoPosition,
            SituateError::Tilt => Refusal::Tilt,
            SituateError::OffTheMap => Refusal::OutsideReference,
        }
    }
}

impl From<BandsError> for Refusal {
    fn from(error: BandsError) -> Self {
        match error {
            BandsError::TooFast => Refusal::TooFast,
            BandsError::Height => Refusal::NoRange,
            BandsError::NotFinite | BandsError::Count => Refusal::Tilt,
        }
    }
}

impl From<StampError> for Refusal {
    fn from(error: StampError) -> Self {
        match error {
            StampError::NoClock => Refusal::NoClock,
            StampError::UncertainClock => Refusal::UncertainClock,
            StampError::BadExposure => Refusal::BadExposure,
            StampError::Contradiction => Refusal::EdgesContradict,
            StampError::NoExposure => Refusal::NoExposure,
            StampError::Backwards => Refusal::FrameBackwards,
        }
    }
}

impl From<ReduceError> for Refusal {
    fn from(error: ReduceError) -> Self {
        match error {
            ReduceError::Capacity => Refusal::FrameTooLarge,
            ReduceError::Size => Refusal::BadFrame,
        }
    }
}

impl From<RectifyError> for Refusal {
    fn from(error: RectifyError) -> Self {
        match error {
            RectifyError::Capacity => Refusal::Capacity,
            RectifyError::Size => Refusal::BadFrame,
        }
    }
}

impl From<MatchError> for Refusal {
    fn from(error: MatchError) -> Self {
        match error {
            MatchError::OutsideReference => Refusal::OutsideReference,
            MatchError::Capacity => Refusal::Capacity,
            MatchError::Featureless => Refusal::Featureless,
        }
    }
}

impl From<Rejection> for Refusal {
    fn from(rejection: Rejection) -> Self {
        match rejection {
            Rejection::FewPixels | Rejection::TooLittle => Refusal::FewPixels,
            Rejection::OnBorder => Refusal::OnBorder,
            Rejection::LowScore => Refusal::LowScore,
            Rejection::Ambiguous => Refusal::Ambiguous,
            Rejection::Undecided => Refusal::Undecided,
            Rejection::Imprecise | Rejection::Diverged => Refusal::Imprecise,
        }
    }
}
