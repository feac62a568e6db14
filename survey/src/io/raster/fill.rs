//! No-data that a file does not declare: connected posts of one number far below all the ground around them.
//!
//! `gdalwarp` writes 0 where its cut line or the turned picture leaves nothing, unless `-dstnodata` says otherwise; a hole of such posts in a
//! model of 800 m is a pit of 800 m to whoever plans a flight over it, and the ground beside it is only as high as the pit's edge. Real water of
//! the same number lies level with its shores.

use super::posts::Posts;
use std::collections::BTreeSet;

/// Least height of the ground beside a block over it, metres. Chosen: no dock, quarry pond or sea cliff rises by so much from the water within a
/// step of the model along three quarters of its shore.
const BELOW_M: f64 = 50.0;
/// Slope that is too steep for a shore, where posts are so far apart that it rises by more: 60 degrees, steeper than the shores of fjords along three quarters of their length.
const SLOPE: f64 = 1.732;
/// Share of the border that may be lower: where the resampling has blended number and ground, or the ground is as low.
const LOWER_SHARE: f64 = 0.25;
/// Pairs of posts across the border, as a share of the root of the posts on the side that has fewer, at least. Of a square hole or a square
/// island it is 4, of a square in the model's corner 2.
const BORDER_SHARE: f64 = 1.0;
/// Heights that the ground beside a block has at least, or half as many as there are pairs: real ground has many. A step, a wall or a block of
/// one height is made.
const HEIGHTS_MIN: usize = 8;
/// Fewest posts that the model has beside a block: a mast on a plain of 0 is no model with a hole.
const REST_MIN: usize = 100;
/// Fewest posts of a block of another number than 0: a single one may be a well or an error.
const POSTS_MIN: usize = 9;

/// Blocks of posts that stand for no data.
#[derive(Debug, PartialEq)]
pub(super) struct Fill {
    /// Their sample.
    pub sample: f64,
    /// How many they are, and the index of one.
    pub count: usize,
    pub first: usize,
    /// How far below the ground around them, metres: the quarter of the border that is lowest lies nearer.
    pub below_m: f64,
}

/// The blocks of 0, or else of the lowest number, if they are fill.
pub(super) fn find(posts: &Posts<'_>) -> Option<Fill> {
    let lowest = posts
        .samples
        .iter()
        .copied()
        .filter(|sample| !sample.is_nan())
        .min_by(|a, b| posts.height_m(*a).total_cmp(&posts.height_m(*b)))?;
    of_sample(posts, 0.0, 1).or_else(|| of_sample(posts, lowest, POSTS_MIN))
}

/// All blocks of a sample of at least so many posts that are fill, as one.
fn of_sample(posts: &Posts<'_>, sample: f64, least: usize) -> Option<Fill> {
    let mut seen = vec![false; if posts.samples.contains(&sample) { posts.samples.len() } else { 0 }];
    let known = posts.samples.iter().filter(|sample| !sample.is_nan()).count();
    let mut all: Option<Fill> = None;
    for first in 0..seen.len() {
        if seen[first] || posts.samples[first] != sample {
            continue;
        }
        let block = Block::from(posts, first, &mut seen);
        let Some(below_m) = block.below_m(known).filter(|_| block.count >= least) else { continue };
        let before = all.take().unwrap_or(Fill { sample, count: 0, first, below_m });
        all = Some(Fill { count: before.count + block.count, below_m: before.below_m.min(below_m), ..before });
    }
    all
}

/// Connected posts of one sample.
struct Block {
    count: usize,
    /// How far the posts beside it are above it, metres, each with the least that is too far for a shore.
    border_m: Vec<[f64; 2]>,
}

impl Block {
    /// The block of a post; its posts are marked as seen.
    fn from(posts: &Posts<'_>, first: usize, seen: &mut [bool]) -> Self {
        let (sample, level_m) = (posts.samples[first], posts.height_m(posts.samples[first]));
        let mut block = Block { count: 0, border_m: Vec::new() };
        let mut open = vec![first];
        seen[first] = true;
        while let Some(index) = open.pop() {
            block.count += 1;
            for (beside, step_m) in neighbours(posts, index) {
                let other = posts.samples[beside];
                if other == sample {
                    if !std::mem::replace(&mut seen[beside], true) {
                        open.push(beside);
                    }
                } else if !other.is_nan() {
                    block.border_m.push([posts.height_m(other) - level_m, BELOW_M.max(SLOPE * step_m)]);
                }
            }
        }
        block
    }

    /// How far it is below the ground around it, where that is too far for a shore. The model has `known` posts.
    fn below_m(&self, known: usize) -> Option<f64> {
        let (pairs, rest) = (self.border_m.len(), known - self.count);
        if rest < REST_MIN || (pairs as f64) < BORDER_SHARE * (self.count.min(rest) as f64).sqrt() {
            return None;
        }
        let heights: BTreeSet<u64> = self.border_m.iter().map(|[above_m, _]| above_m.to_bits()).collect();
        if heights.len() < HEIGHTS_MIN.min(pairs.div_ceil(2)) {
            return None;
        }
        let lower = self.border_m.iter().filter(|[above_m, shore_m]| above_m <= shore_m).count();
        let mut above_m: Vec<f64> = self.border_m.iter().map(|pair| pair[0]).collect();
        let quarter = (LOWER_SHARE * pairs as f64) as usize;
        let (_, quarter_m, _) = above_m.select_nth_unstable_by(quarter, f64::total_cmp);
        (lower as f64 <= LOWER_SHARE * pairs as f64).then_some(*quarter_m)
    }
}

/// The posts beside one, each with its distance.
fn neighbours(posts: &Posts<'_>, index: usize) -> impl Iterator<Item = (usize, f64)> {
    let (cols, rows) = (posts.cols, posts.samples.len() / posts.cols);
    let (col, row) = (index % cols, index / cols);
    let [along_m, across_m] = posts.step_m;
    let beside = [
        (col > 0).then(|| (index - 1, along_m)),
        (col + 1 < cols).then(|| (index + 1, along_m)),
        (row > 0).then(|| (index - cols, across_m)),
        (row + 1 < rows).then(|| (index + cols, across_m)),
    ];
    beside.into_iter().flatten()
}
