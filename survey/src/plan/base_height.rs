//! The base plane: the height from which the flying height counts (paper 004, 1.1).

use super::area::Area;
use super::terrain::SNAP;
use crate::dem::Dem;
use crate::error::InputError;

/// Share of the posts that are its high ones, and of those that are its low ones.
const DECILE: f64 = 0.1;
/// Steps of height that posts are counted in.
const BINS: usize = 1 << 16;

/// Mean of the means of the highest and the lowest tenth of the posts of all cells that the area touches. The paper takes
/// "representative high and low points", which nobody can repeat.
///
/// # Errors
/// The area touches a cell with a post whose height is not known.
pub fn base_height_m(dem: &Dem, area: &Area) -> Result<f64, InputError> {
    let (mut count, mut least, mut most) = (0_usize, f64::INFINITY, f64::NEG_INFINITY);
    posts(dem, area, &mut |height| {
        (count, least, most) = (count + 1, least.min(height), most.max(height));
    })?;
    if least == most {
        return Ok(least);
    }
    // How many posts lie in each of many equal steps of height: only the step that a tenth ends in needs sorting, so a
    // model of any size needs no copy.
    let bin = |height: f64| (((height - least) / (most - least) * BINS as f64) as usize).min(BINS - 1);
    let mut bins = vec![(0_usize, 0.0); BINS];
    posts(dem, area, &mut |height| {
        let (number, sum) = &mut bins[bin(height)];
        (*number, *sum) = (*number + 1, *sum + height);
    })?;
    let tenth = ((count as f64 * DECILE) as usize).max(1);
    let low = full(bins.iter(), tenth);
    let high = full(bins.iter().rev(), tenth);
    let (low_bin, high_bin) = (low.bins, BINS - 1 - high.bins);
    let (mut low_rest, mut high_rest) = (Vec::new(), Vec::new());
    posts(dem, area, &mut |height| {
        let bin = bin(height);
        if bin == low_bin {
            low_rest.push(height);
        }
        if bin == high_bin {
            high_rest.push(height);
        }
    })?;
    low_rest.sort_by(f64::total_cmp);
    high_rest.sort_by(|a, b| b.total_cmp(a));
    let mean = |full: &Full, rest: &[f64]| (full.sum + rest.iter().take(full.missing).sum::<f64>()) / tenth as f64;
    Ok(0.5 * (mean(&low, &low_rest) + mean(&high, &high_rest)))
}

/// Bins that go whole into a tenth.
struct Full {
    bins: usize,
    sum: f64,
    /// How many of the next bin are still missing.
    missing: usize,
}

fn full<'b>(bins: impl Iterator<Item = &'b (usize, f64)>, tenth: usize) -> Full {
    let mut full = Full { bins: 0, sum: 0.0, missing: tenth };
    for (number, sum) in bins {
        if *number > full.missing {
            break;
        }
        full = Full { bins: full.bins + 1, sum: full.sum + sum, missing: full.missing - number };
    }
    full
}

/// Visits the heights of the posts of all cells that the area touches, each post once.
fn posts(dem: &Dem, area: &Area, visit: &mut dyn FnMut(f64)) -> Result<(), InputError> {
    let [dx, dy] = dem.step_m;
    let [_, y0, _, y1] = area.bounds();
    let clip = |at: f64, posts: usize| (at + SNAP).floor().clamp(0.0, (posts - 2) as f64) as usize;
    let rows = [y0, y1].map(|y| clip((y - dem.south_m) / dy, dem.rows));
    let mut below: Vec<[usize; 2]> = Vec::new();
    for row in rows[0]..=rows[1] + 1 {
        // Columns of posts that the cells above this row of posts need; those of the cells below come along.
        let above = if row <= rows[1] {
            let low = dem.south_m + row as f64 * dy;
            // The model's border rows of cells stand for what lies beyond them.
            let from = if row == rows[0] { y0.min(low) } else { low };
            let to = if row == rows[1] { y1.max(low + dy) } else { low + dy };
            area.ranges([from, to])
                .into_iter()
                .map(|[x0, x1]| [clip((x0 - dem.west_m) / dx, dem.cols), clip((x1 - dem.west_m) / dx, dem.cols) + 1])
                .collect()
        } else {
            Vec::new()
        };
        let mut wanted: Vec<[usize; 2]> = above.iter().chain(&below).copied().collect();
        wanted.sort_unstable();
        let mut next = 0;
        for [first, last] in wanted {
            for col in first.max(next)..=last {
                let height = dem.at(col, row);
                if !height.is_finite() {
                    let (x, y) = (dem.west_m + col as f64 * dx, dem.south_m + row as f64 * dy);
                    return Err(InputError::new(format!(
                        "the elevation model knows no height under the area, at x {x:.1} m, y {y:.1} m of its grid"
                    )));
                }
                visit(height);
            }
            next = next.max(last + 1);
        }
        below = above;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_post_counts_once_and_unknown_ones_are_named() {
        let heights = (0..25).map(|k| k as f64).collect();
        let mut dem = Dem { cols: 5, rows: 5, west_m: 0.0, south_m: 0.0, step_m: [10.0, 10.0], heights };
        let area = |x0: f64, y0: f64, x1: f64, y1: f64| {
            Area::new(&[[x0, y0], [x1, y0], [x1, y1], [x0, y1]]).expect("a rectangle")
        };
        // Posts 1..=3 of columns, 1..=2 of rows: the upper border on post 2 of x takes in post 3, as the rule has it.
        let posts_of = |area: &Area, dem: &Dem| {
            let mut heights = Vec::new();
            posts(dem, area, &mut |height| heights.push(height)).map(|()| heights)
        };
        assert_eq!(posts_of(&area(12.0, 12.0, 20.0, 18.0), &dem).expect("known"), [6.0, 7.0, 8.0, 11.0, 12.0, 13.0]);
        // The whole model: lowest two 0, 1, highest two 23, 24.
        assert_eq!(base_height_m(&dem, &area(0.0, 0.0, 40.0, 40.0)).expect("known"), 12.0);
        dem.heights[12] = f64::NAN;
        let error = base_height_m(&dem, &area(12.0, 12.0, 20.0, 18.0)).expect_err("unknown").to_string();
        assert!(error.contains("x 20.0 m, y 20.0 m"), "{error}");
        assert!(base_height_m(&dem, &area(0.0, 0.0, 5.0, 5.0)).is_ok());
    }
}
