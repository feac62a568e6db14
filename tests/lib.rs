//! What every test target shares, the golden values; the comparison of kernels and the hunt for inputs that break a
//! reader, which are programs as well.

#[path = "timing/compare/mod.rs"]
pub mod compare;
#[path = "fuzz/mod.rs"]
pub mod fuzz;

/// The golden values of paper 003 (rectification), JSON.
pub const GOLDEN_003: &str = include_str!("vectors/golden_003.json");
/// The golden values of paper 000 (image motion and mid-exposure), JSON.
pub const GOLDEN_000: &str = include_str!("vectors/golden_000.json");
/// The golden values of paper 001 (semi-parametric fit), JSON.
pub const GOLDEN_001: &str = include_str!("vectors/golden_001.json");
