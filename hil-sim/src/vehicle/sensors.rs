//! What the vehicle's sensors say, and when it reaches the board.
//!
//! Every sample has two instants: when it was sampled, by which its message is stamped, and when it arrives. Both are
//! integer microseconds of the autopilot's clock; only the board's capture timer runs on its own.

mod attitude_faults;
mod edges;
mod faulty;
mod reading;
mod sensed;
mod shutter;
mod streams;
#[cfg(test)]
mod tests;
mod timer;

pub use edges::{LineEdge, ShutterLine, hold_off_us, line_edges, lost_frames};
pub use reading::{Reading, Sample};
pub use sensed::Sensed;
pub use shutter::{Exposure, Shutter, exposures, openings};
pub use streams::Streams;
pub use timer::TimerModel;
