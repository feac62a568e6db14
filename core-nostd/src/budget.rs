//! Limits: the paper's own figures and the sizes that keep us below them.
//!
//! They are constants so that a build that passes one fails; what is measured against them is in docs/figures.md.

/// The paper's time for one rectification (Table 2), milliseconds.
pub const PAPER_TIME_MS: u32 = 38;
/// The paper's memory for program and data (Table 2), in bytes of 1024.
pub const PAPER_MEMORY_BYTES: usize = 25 * 1024;
/// The clock of the paper's TMS320C6701, in Hz, by its data sheet (167 MHz parts).
pub const PAPER_CLOCK_HZ: u32 = 167_000_000;

/// Largest patch side on board, pixels of the reference.
pub const PATCH_MAX_PX: usize = 64;
/// Pixels of the largest patch.
pub const PATCH_MAX_AREA: usize = PATCH_MAX_PX * PATCH_MAX_PX;
/// Bytes of frame memory: the sums of boxes of 4 x 4 of a frame of 752 x 480, the flight computer's sensor. Boxes of 2 x 2 of
/// 512 x 512 would take 132,096, the frame itself, which is not kept, up to 1.2 MB.
pub const FRAME_MEMORY_BYTES: usize = 45_600;
/// Largest radius on board of a search of every pixel around the prediction, pixels of the reference; searches beyond are
/// made from coarse to fine.
pub const SEARCH_MAX_PX: usize = 10;
/// Radius of the search for a position that was lost, pixels of the reference.
pub const REACQUIRE_PX: usize = 64;
/// Correlation scores of the largest search around the prediction.
pub const SCORES_MAX: usize = (2 * SEARCH_MAX_PX + 1) * (2 * SEARCH_MAX_PX + 1);
/// Runs of valid pixels a patch may have on board: convex footprints need one a row, strong distortion a few more.
pub const RUNS_MAX: usize = PATCH_MAX_PX + 16;

const _: () = assert!(
    PATCH_MAX_AREA + 2 * SCORES_MAX + 6 * RUNS_MAX < PAPER_MEMORY_BYTES,
    "the image buffers alone pass the paper's 25 KB"
);
/// What the pose keeps: the streams' rings and how to smooth them, bytes.
pub const POSE_MAX_BYTES: usize = 3 * 1024;
