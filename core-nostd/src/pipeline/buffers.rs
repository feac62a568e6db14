//! The image buffers.

use crate::budget::{PATCH_MAX_AREA, PATCH_MAX_PX, RUNS_MAX};
use crate::image::Run;
use crate::matching::OnBoard;
use crate::rectify::Node;
use heapless::Vec;

/// The image buffers, half of what the whole application needs. They belong to the caller, who can put them where the
/// board has free memory and need not carry them over a stack.
#[derive(Debug)]
pub struct Buffers {
    pub(super) patch: [u8; PATCH_MAX_AREA],
    pub(super) runs: Vec<Run, RUNS_MAX>,
    /// While a frame is rectified.
    pub(super) nodes: [Node; 2 * (PATCH_MAX_PX + 1)],
    pub(super) matcher: OnBoard,
}

impl Buffers {
    /// All zeros: costs no space in an image.
    pub const fn new() -> Self {
        Buffers {
            patch: [0; PATCH_MAX_AREA],
            runs: Vec::new(),
            nodes: [Node::NOWHERE; 2 * (PATCH_MAX_PX + 1)],
            matcher: OnBoard::new(),
        }
    }
}

impl Default for Buffers {
    fn default() -> Self {
        Buffers::new()
    }
}
