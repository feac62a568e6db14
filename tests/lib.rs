//! What every test target shares: where vectors and expected files lie, and how the real data is found.

use std::path::PathBuf;

/// The golden values of paper 003 (rectification), JSON.
pub const GOLDEN_003: &str = include_str!("vectors/golden_003.json");
/// The golden values of paper 000 (image motion and mid-exposure), JSON.
pub const GOLDEN_000: &str = include_str!("vectors/golden_000.json");

/// The folder of the files that tests compare whole outputs with.
pub fn expected_dir() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("expected")
}

/// The real data: the folder named by `PLUMBLINE_DATA`, else `shared/data` beside the workspace. When neither is a
/// folder, `None`, and one line on stderr that says which test was skipped.
pub fn data_dir(test: &str) -> Option<PathBuf> {
    let beside = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../shared/data");
    let dir = std::env::var_os("PLUMBLINE_DATA").map_or(beside, PathBuf::from);
    if dir.is_dir() {
        return Some(dir);
    }
    eprintln!("skipped: {test}: no real data at {} (set PLUMBLINE_DATA)", dir.display());
    None
}
