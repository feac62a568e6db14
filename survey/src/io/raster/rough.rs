//! Grey values are no ground: whether samples jump from post to post as those of an orthophoto do.
//!
//! Measured on what is at hand, over all pairs of neighbours. Elevation models rounded to whole metres, six of posts from 0.8 to 90 m, among
//! them a surface model of a town: 0 to 6 % of the pairs are steeper than 45 degrees and more than one unit apart. Eight aerial orthophotos of 5 m,
//! two others of 5 m and one of 0.3 m, each band by itself: 16 to 70 %. Models in whole feet or decimetres that do not say so are as steep, but
//! smooth: the mean second difference of three posts is 0.4 to 1.0 of the mean difference of two, and 1.3 to 1.5 of it in these pictures. A
//! satellite's picture of 10 m, 1 to 6 %, is not told from ground.

use super::posts::Posts;

/// Share of pairs of neighbours that are as steep in a picture at least: between 6 and 16 %.
const STEEP_SHARE: f64 = 0.1;
/// Mean second difference as a share of the mean difference in a picture at least: between 1.02 and 1.28.
const ROUGH: f64 = 1.15;
/// Slope of a steep pair: 45 degrees.
const SLOPE: f64 = 1.0;
/// Samples of a picture of 16 bits without a sign.
const GREY_MAX: f64 = 65_535.0;
/// Fewest pairs that say anything. Chosen: a share of 10 % of them is then good to 1 %.
const PAIRS_MIN: usize = 1000;

/// Whether the samples are such as a picture has: whole, without a sign, steep and rough.
pub(super) fn is_picture(posts: &Posts<'_>) -> bool {
    let is_grey = |sample: &f64| sample.is_nan() || (0.0..=GREY_MAX).contains(sample) && sample.fract() == 0.0;
    posts.samples.iter().all(is_grey) && {
        let (along, across) = (runs(posts, true), runs(posts, false));
        let [pairs, steep] = [along.pairs + across.pairs, along.steep + across.steep];
        let of = |sum: f64, count: usize| sum / count.max(1) as f64;
        let second = of(along.second + across.second, along.triples + across.triples);
        let first = of(along.first + across.first, pairs);
        pairs >= PAIRS_MIN && steep as f64 > STEEP_SHARE * pairs as f64 && second > ROUGH * first
    }
}

/// What differs along the rows, or from row to row.
#[derive(Default)]
struct Differences {
    pairs: usize,
    /// Pairs that are steeper than the slope and more than a unit apart.
    steep: usize,
    /// Sum of the pairs' differences.
    first: f64,
    triples: usize,
    /// Sum of the second differences.
    second: f64,
}

fn runs(posts: &Posts<'_>, is_along: bool) -> Differences {
    let (cols, count) = (posts.cols, posts.samples.len());
    let (stride, step_m) = if is_along { (1, posts.step_m[0]) } else { (cols, posts.step_m[1]) };
    let apart = (SLOPE * step_m / posts.unit_m).max(1.0);
    let at = |index: usize| posts.samples[index];
    // The post so many strides on, if it is in the same row or column.
    let on = |index: usize, strides: usize| {
        let is_in = if is_along { index % cols + strides < cols } else { index + strides * cols < count };
        is_in.then(|| at(index + strides * stride)).filter(|sample| !sample.is_nan())
    };
    let mut found = Differences::default();
    for index in (0..count).filter(|index| !at(*index).is_nan()) {
        let Some(next) = on(index, 1) else { continue };
        let difference = (next - at(index)).abs();
        found.pairs += 1;
        found.first += difference;
        found.steep += usize::from(difference > apart);
        if let Some(after) = on(index, 2) {
            found.triples += 1;
            found.second += (after - 2.0 * next + at(index)).abs();
        }
    }
    found
}
