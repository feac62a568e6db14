//! What a frame costs, stage by stage, and what the kernels cost by themselves.
//!
//! The image `src/bin/bench.rs` runs these cases on a board; each piece of work stands between the markers of
//! [`region`]. The cases make their own pictures on board, from seeds, and everything is compiled on the host as well,
//! where a test sees that they are what they pretend to be.
//!
//! | module | what |
//! |---|---|
//! | [`region`] | a marked piece of work, and what a board lends for it |
//! | `counter` | the cycle counter, on a board that has one |
//! | [`poses`] | headings, tilts and follow-up angles, to find the worst |
//! | [`texture`] | pictures |
//! | [`scenery`] | a frame as a tilted camera would take it of a tile |
//! | [`rectify`] | cases of the rectification alone |
//! | [`control`] | the exposure's control and the servo's command |
//! | [`signing`] | a message signed and verified |
//! | [`frame`] | cases of the whole chain from edge to fix, and of getting a lost position back |

#[cfg(all(target_os = "none", feature = "an500"))]
pub mod counter;
pub mod control;
pub mod frame;
pub mod poses;
pub mod rectify;
pub mod region;
pub mod scenery;
pub mod signing;
pub mod texture;
