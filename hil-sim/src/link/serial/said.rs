//! Answers that stay after the buffer they came in is used again.

use plumbline_firmware::serial::message::{Answer, Counts, Envelope, Next, Refused, Store, Welcome};

/// Why a request was not answered.
#[derive(Debug)]
pub enum Failed {
    /// The board knows nothing of the session: it has booted anew.
    Rebooted,
    /// The board speaks another version.
    OtherVersion(u16),
    /// It is silent, or gone.
    Lost(String),
}

/// An answer that stays.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Said {
    Done,
    Refused(Refusal),
    Stepped { cost: u32, next: Next, is_at_work: bool, sent: Vec<u8> },
}

/// Why a request was not done.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Refusal {
    Busy,
    /// The room there is, bytes.
    TooLarge(u32),
    /// A sentence's part.
    Because(String),
}

/// Who the board is.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Welcomed {
    pub boot: u32,
    pub core_clock_hz: u32,
    pub counts: Counts,
    pub piece_max: usize,
    pub configuration_capacity: usize,
    pub tile_capacity: usize,
    pub plan_capacity: usize,
    pub key_capacity: usize,
    /// Name of the board and version of its firmware.
    pub board: String,
}

impl From<Welcome<'_>> for Welcomed {
    fn from(welcome: Welcome<'_>) -> Self {
        Welcomed {
            boot: welcome.boot,
            core_clock_hz: welcome.core_clock_hz,
            counts: welcome.counts,
            piece_max: welcome.piece_max.into(),
            configuration_capacity: welcome.configuration_capacity as usize,
            tile_capacity: welcome.tile_capacity as usize,
            plan_capacity: welcome.plan_capacity as usize,
            key_capacity: welcome.key_capacity as usize,
            board: format!("{} {}", welcome.board, welcome.firmware),
        }
    }
}

/// The answer to a request of a session.
pub fn matches(envelope: &Envelope<Answer<'_>>, session: u32, id: u32) -> Option<Result<Said, Failed>> {
    if (envelope.session, envelope.id) != (session, id) {
        return None;
    }
    Some(match envelope.message {
        Answer::Stranger { .. } => Err(Failed::Rebooted),
        Answer::Done => Ok(Said::Done),
        Answer::Stepped { cost, next, is_at_work, sent } => {
            Ok(Said::Stepped { cost, next, is_at_work, sent: sent.to_vec() })
        }
        Answer::Refused(refused) => Ok(Said::Refused(match refused {
            Refused::Busy => Refusal::Busy,
            Refused::TooLarge { capacity } => Refusal::TooLarge(capacity),
            Refused::Damaged(Store::Configuration) => {
                Refusal::Because("the configuration did not arrive whole".to_owned())
            }
            Refused::Damaged(Store::Plan) => Refusal::Because("the plan did not arrive whole".to_owned()),
            Refused::Damaged(Store::Key) => Refusal::Because("the key did not arrive whole".to_owned()),
            Refused::Damaged(Store::Tile) => Refusal::Because("the tile did not arrive whole".to_owned()),
            Refused::Boot(why) => Refusal::Because(why.concat()),
            Refused::Order => Refusal::Because("a request out of order".to_owned()),
        })),
        Answer::Welcome(_) => return None,
    })
}
