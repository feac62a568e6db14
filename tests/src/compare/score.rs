//! A patch against the exact average.

use super::view::View;

/// How far off a patch is.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Score {
    /// Root mean square, grey levels.
    pub rms: f64,
    /// Largest, grey levels.
    pub worst: f64,
    /// Cells that were compared.
    pub cells: usize,
}

/// `patch` against `exact` over the cells that have an exact average and are `counted`.
pub fn score(patch: &[u8], exact: &[Option<f64>], counted: &[bool]) -> Score {
    let off = patch.iter().zip(exact).zip(counted).filter(|&(_, &counted)| counted);
    let off = off.filter_map(|((&pixel, exact), _)| exact.map(|exact| (f64::from(pixel) - exact).abs()));
    let (sum, worst, cells) =
        off.fold((0.0, 0.0f64, 0), |(sum, worst, cells), off| (sum + off * off, worst.max(off), cells + 1));
    Score { rms: (sum / f64::max(cells as f64, 1.0)).sqrt(), worst, cells }
}

/// By how much `patch` is shifted against `exact`, frame pixels at nadir: least squares over the exact average's slopes,
/// which must be small beside its waves. `None` where the picture has no slopes in both directions.
pub fn shift_px(patch: &[u8], exact: &[Option<f64>], counted: &[bool], view: &View) -> Option<f64> {
    let cols = usize::from(view.ground().cells.0);
    let mut normal = [0.0f64; 5];
    for (i, &is_counted) in counted.iter().enumerate() {
        // Neighbours to both sides in the same row, and above and below.
        if !is_counted || i < cols || i % cols == 0 || i % cols == cols - 1 {
            continue;
        }
        let at = |i: usize| exact.get(i).copied().flatten();
        let neighbours = (at(i), at(i - 1), at(i + 1), at(i - cols), at(i + cols));
        let (Some(centre), Some(left), Some(right), Some(above), Some(below)) = neighbours else { continue };
        let (across, along) = (0.5 * (right - left), 0.5 * (below - above));
        let off = f64::from(*patch.get(i)?) - centre;
        let terms = [across * across, across * along, along * along, across * off, along * off];
        normal.iter_mut().zip(terms).for_each(|(sum, term)| *sum += term);
    }
    let [aa, ab, bb, ao, bo] = normal;
    let determinant = aa * bb - ab * ab;
    let (col, row) = ((ao * bb - bo * ab) / determinant, (bo * aa - ao * ab) / determinant);
    let shift = col.hypot(row) * f64::from(view.ratio());
    (determinant > 0.0 && shift.is_finite()).then_some(shift)
}
