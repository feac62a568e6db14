//! Our own telemetry: what MAVLink has no field for, as postcard inside TUNNEL messages.
//!
//! The payload begins with [`MARK`] and a kind. A frame's report holds everything that the simulator scores and a
//! ground station would want to see; floats travel as their bits, so every link gives the same figures.

mod exposure;
mod frame;
mod instant;
mod plan;

use super::signing::Refused;
pub use exposure::ExposureReport;
pub use frame::{FixReport, FrameReport, MatchReport, PositionReport, Risk, STAGES, SituationReport};
pub use instant::{InstantReport, MotionReport, PlaceReport, PoseReport, StampHealth, StampReport};
pub use plan::{PhotoReport, PlanReport};
use serde::{Deserialize, Serialize};

/// First bytes of every payload of ours, since TUNNEL's own types name other vendors only.
pub const MARK: [u8; 2] = *b"PL";
/// Bytes a TUNNEL message carries.
pub const TUNNEL_BYTES: usize = 128;

/// State of the vehicle's link and board, once a second.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Health {
    /// Good messages.
    pub messages: u32,
    /// Failed checksums.
    pub bad_checksum: u32,
    /// Unknown ids.
    pub unknown_id: u32,
    /// Unknown incompatibility flags.
    pub incompatible: u32,
    /// Bytes that belonged to no message.
    pub skipped_bytes: u32,
    /// Samples whose stamp ran backwards.
    pub backwards: u32,
    /// Samples whose value cannot be meant.
    pub invalid: u32,
    /// Messages of a kind that is used, from somebody who is not listened to, and answers to what was not asked.
    pub foreign: u32,
    /// Samples stamped later than they arrived.
    pub future: u32,
    /// Rows lost.
    pub overruns: u32,
    /// Frames lost while another was being worked on.
    pub frames_lost: u32,
    /// Patches whose transmission the next frame cut short.
    pub patches_cut: u32,
    /// Bytes of static memory and the stack's high-water mark.
    pub memory: (u32, u32),
    /// How long the newest sample of attitude, follow-up angle, range and position took from the instant at which its value
    /// held to its arrival, microseconds; 0 where that is not known.
    pub delays_us: [u32; 4],
    /// What was wrong with edges and pulses.
    pub stamps: StampHealth,
}

/// Messages that were refused since there is a key, by the reason.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct SigningReport {
    /// Not signed.
    pub unsigned: u32,
    /// Signed with another key, or changed on their way.
    pub wrong: u32,
    /// Not newer than the last of their stream.
    pub replayed: u32,
    /// The first of their stream, and more than a minute behind our own time.
    pub late: u32,
    /// Of one stream more than there is room for.
    pub crowded: u32,
}

impl From<Refused> for SigningReport {
    fn from([unsigned, wrong, replayed, late, crowded]: Refused) -> Self {
        SigningReport { unsigned, wrong, replayed, late, crowded }
    }
}

/// One of ours.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Telemetry {
    /// A frame's report.
    Frame(FrameReport),
    /// Health.
    Health(Health),
    /// What belongs to the instant of a frame's exposure; sent before the frame's report.
    Instant(InstantReport),
    /// A planned photo, before its exposure and with its frame.
    Photo(PhotoReport),
    /// How far the plan has been flown; sent behind health.
    Plan(PlanReport),
    /// What signing has refused; sent behind health where there is a key.
    Signing(SigningReport),
    /// A command to the camera, when it is given.
    Exposure(ExposureReport),
}

impl Telemetry {
    /// Encodes into a TUNNEL payload; the bytes used. `None` cannot happen for the variants above, whose longest
    /// encoding is below [`TUNNEL_BYTES`]; a test holds that.
    pub fn encode(&self, payload: &mut [u8; TUNNEL_BYTES]) -> Option<u8> {
        let (mark, rest) = payload.split_at_mut(MARK.len());
        mark.copy_from_slice(&MARK);
        let used = postcard::to_slice(self, rest).ok()?.len();
        Some((MARK.len() + used) as u8)
    }

    /// Decodes a TUNNEL payload; `None` for somebody else's.
    pub fn decode(payload: &[u8]) -> Option<Self> {
        postcard::from_bytes(payload.strip_prefix(&MARK)?).ok()
    }
}
