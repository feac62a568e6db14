//! Local maxima of a grid of scores: the highest of them, and the sub-pixel vertex of one.

/// Shifts nearer than this to a local maximum lie on its main lobe, pixels: noise makes it jagged, and texture averaged
/// to the pixel correlates over two of them.
pub(super) const MAIN_LOBE_PX: i16 = 3;

/// A local maximum.
#[derive(Clone, Copy, Default)]
pub(super) struct LocalMaximum<S> {
    pub(super) col: u16,
    pub(super) row: u16,
    pub(super) score: S,
}

/// The highest local maxima of `scores`, (`cols`, `rows`) of them, highest first; `score` reads one. Of equal ones the
/// first in the grid comes first.
pub(super) fn highest<'r, E, S: Copy + PartialOrd, const N: usize>(
    scores: &[E],
    (cols, rows): (usize, usize),
    score: impl Fn(&E) -> S + Copy,
    buffer: &'r mut [LocalMaximum<S>; N],
) -> &'r [LocalMaximum<S>] {
    let mut count = 0;
    let mut lowest = None;
    for (row, line) in scores.chunks_exact(cols.max(1)).take(rows).enumerate() {
        for (col, own) in line.iter().map(score).enumerate() {
            let is_among = lowest.is_none_or(|lowest| own > lowest);
            if is_among && is_local_maximum(scores, (cols, rows), score, (col, row), own) {
                insert(buffer, &mut count, LocalMaximum { col: col as u16, row: row as u16, score: own });
                lowest = buffer.last().filter(|_| count == N).map(|last| last.score);
            }
        }
    }
    buffer.get(..count).unwrap_or(&[])
}

/// Whether no neighbour is higher. The flank of a main lobe is no maximum, even if it is high at the limit of the lobe.
#[inline(never)]
fn is_local_maximum<E, S: PartialOrd>(
    scores: &[E],
    (cols, rows): (usize, usize),
    score: impl Fn(&E) -> S,
    (col, row): (usize, usize),
    own: S,
) -> bool {
    let (left, right) = (col.saturating_sub(1), (col + 1).min(cols - 1));
    let is_top = |row: usize| {
        let line = scores.get(row * cols + left..=row * cols + right);
        line.is_some_and(|line| line.iter().all(|other| score(other) <= own))
    };
    is_top(row) && is_top(row.saturating_sub(1)) && is_top((row + 1).min(rows - 1))
}

/// Inserts a maximum after those as high. Kept apart: it is rare.
#[inline(never)]
fn insert<S: Copy + PartialOrd, const N: usize>(
    buffer: &mut [LocalMaximum<S>; N],
    count: &mut usize,
    maximum: LocalMaximum<S>,
) {
    let at = buffer.iter().take(*count).position(|other| maximum.score > other.score).unwrap_or(*count);
    *count = (*count + 1).min(N);
    let mut moved = maximum;
    for other in buffer.iter_mut().take(*count).skip(at) {
        core::mem::swap(other, &mut moved);
    }
}

/// Vertex of the parabola through the scores before, at and after a maximum, pixels from it, −0.5 to 0.5.
pub(crate) fn vertex(before: f32, top: f32, behind: f32) -> f32 {
    let curvature = 2.0 * top - before - behind;
    if curvature > 0.0 { (0.5 * (behind - before) / curvature).clamp(-0.5, 0.5) } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(scores: &[i16], size: (usize, usize)) -> ([LocalMaximum<i16>; 3], usize) {
        let mut buffer = [LocalMaximum::default(); 3];
        let count = highest(scores, size, |&score| score, &mut buffer).len();
        (buffer, count)
    }

    #[test]
    fn the_highest_are_found_in_their_order() {
        #[rustfmt::skip]
        let scores = [
            5, 1, 0, 0, 7,
            1, 1, 0, 0, 6,
            0, 0, 3, 0, 0,
            9, 8, 0, 0, 4,
        ];
        let (buffer, count) = found(&scores, (5, 4));
        assert_eq!(count, 3);
        assert_eq!(buffer.map(|m| (m.col, m.row, m.score)), [(0, 3, 9), (4, 0, 7), (0, 0, 5)]);
    }

    #[test]
    fn of_a_plateau_every_shift_is_one_and_the_first_comes_first() {
        let (buffer, count) = found(&[2; 6], (3, 2));
        assert_eq!(count, 3);
        assert_eq!(buffer.map(|m| (m.col, m.row)), [(0, 0), (1, 0), (2, 0)]);
    }

    #[test]
    fn the_top_is_that_of_the_parabola() {
        // 1 - (x - 0.25)^2 at -1, 0 and 1.
        let height = |x: f32| 1.0 - (x - 0.25) * (x - 0.25);
        assert_eq!(vertex(height(-1.0), height(0.0), height(1.0)), 0.25);
        assert_eq!(vertex(1.0, 1.0, 1.0), 0.0);
        assert_eq!(vertex(0.0, 1.0, 5.0), 0.0, "no maximum");
    }
}
