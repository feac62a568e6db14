//! The image buffers.

use crate::budget::{PATCH_MAX_AREA, PATCH_MAX_PX, RUNS_MAX};
use crate::image::Run;
use crate::matching::OnBoard;
use crate::navigation::Navigation;
use crate::rectify::Node;
use heapless::Vec;

/// The image buffers, half of the application's memory. The caller owns them, so that they can lie in any free memory
/// of the board and are not moved over a stack.
#[derive(Debug)]
pub struct Buffers {
    pub(super) patch: [u8; PATCH_MAX_AREA],
    pub(super) runs: Vec<Run, RUNS_MAX>,
    /// In use while a frame is rectified.
    pub(super) nodes: [Node; 2 * (PATCH_MAX_PX + 1)],
    pub(super) matcher: OnBoard,
}

impl Buffers {
    /// All zeros: takes no space in an image.
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

/// Memory of a pipeline; the caller owns it and can place it in any free memory of the board.
#[derive(Debug)]
pub struct Memory<'t> {
    /// The image buffers.
    pub buffers: &'t mut Buffers,
    /// State from one frame to the next.
    pub navigation: &'t mut Navigation,
    /// Replaces the camera's frame: holds the reduced frame for the rectifier,
    /// [`FRAME_MEMORY_BYTES`](crate::budget::FRAME_MEMORY_BYTES) or as much as the board has; between rectification and
    /// the next frame it is the matcher's working memory.
    pub frame: &'t mut [u8],
}
