//! Working memory of the three kernels on board, from the sizes of the real buffers and types.
//!
//! All three share the patch, the corners of its cells and the list of valid runs. They differ in what they keep beside
//! them. The frame is in none of them, neither whole (256 KB, which the paper's 25 KB cannot hold either) nor as the sums
//! of boxes that are kept in its place, nor is the matching.

use super::baselines::{CONTROL_POINTS, ControlPoint, Polynomial, PolynomialWorkspace, ResectionWorkspace};
use super::kernel::Kernel;
use plumbline_core::budget::SCORES_MAX;
use plumbline_core::camera::Camera;
use plumbline_core::homography::FrameFromPatch;
use plumbline_core::pipeline::Buffers;
use plumbline_core::tilt::Attitude;
use std::mem::size_of;

/// The pipeline's buffers less the matching's scores. Only the length of the list of runs is as wide as the machine,
/// which is 4 bytes fewer on board.
const PICTURES: usize = size_of::<Buffers>() - size_of::<[i16; SCORES_MAX]>();

/// Bytes of working memory.
pub fn working_set(kernel: Kernel) -> usize {
    let perspective = size_of::<Attitude>() + size_of::<Camera>() + size_of::<FrameFromPatch<'_>>();
    let points = size_of::<[ControlPoint; CONTROL_POINTS]>();
    PICTURES
        + match kernel {
            Kernel::Automatic => perspective,
            Kernel::Polynomial => points + size_of::<Polynomial>() + size_of::<PolynomialWorkspace>(),
            Kernel::Collinearity => perspective + points + size_of::<ResectionWorkspace>(),
        }
}

#[cfg(test)]
mod tests {
    use super::*;
    use plumbline_core::budget::PAPER_MEMORY_BYTES;

    #[test]
    fn the_automatic_kernel_is_within_the_papers_memory_and_the_alternatives_take_more() {
        let [automatic, polynomial, collinearity] = Kernel::ALL.map(working_set);
        assert!(automatic < PAPER_MEMORY_BYTES, "{automatic}");
        assert!(automatic < polynomial && polynomial < collinearity, "{automatic} {polynomial} {collinearity}");
    }
}
