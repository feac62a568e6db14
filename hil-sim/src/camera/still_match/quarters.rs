//! What the four quarters of a patch say of a solution by least squares, each located by itself.

use nalgebra::{Matrix2, Vector2};
use plumbline_core::image::{Run, View};
use plumbline_core::matching::Prior;
use plumbline_core::matching::refine::{SubPixel, refine};
use plumbline_core::matching::search::{Peak, working_bytes};

/// How far the quarters are at odds.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Odds {
    /// Quarters that were located.
    pub count: usize,
    /// Sum of the products of their distances from where the whole has them, square pixels.
    pub scatter: Matrix2<f32>,
}

impl Odds {
    /// Root mean square of the distances along an axis, pixels.
    #[must_use]
    pub fn scatter_px(&self) -> f32 {
        (0.5 * self.scatter.trace() / self.count as f32).sqrt()
    }
}

/// Locates each quarter of `patch` by itself around where `whole` has it. `reference`: what was searched within ±`radius`.
#[must_use]
pub fn odds(
    patch: &View<'_>,
    runs: &[Run],
    (reference, radius): (&View<'_>, u16),
    whole: &SubPixel,
    prior: Prior,
) -> Odds {
    let mut odds = Odds::default();
    let mut bytes = vec![0; working_bytes(reference.size())];
    let halves = |length: u16| [(0, length / 2), (length / 2, length - length / 2)];
    let (cols, rows) = patch.size();
    for (top, height) in halves(rows) {
        for (left, width) in halves(cols) {
            let size = (width + 2 * radius, height + 2 * radius);
            let (at_col, at_row) = (i32::from(left), i32::from(top));
            let part = patch.window(at_col, at_row, (width, height)).zip(reference.window(at_col, at_row, size));
            let Some((part, window)) = part else { continue };
            let middle = |start: u16, length: u16, all: u16| {
                f32::from(start) + 0.5 * (f32::from(length) - 1.0) - 0.5 * (f32::from(all) - 1.0)
            };
            let here = whole.at((middle(left, width, cols), middle(top, height, rows)));
            let peak = near(&here);
            let own: Vec<Run> = runs.iter().filter_map(|run| within(*run, (left, top), (width, height))).collect();
            let Ok(found) = refine(&part, &own, &window, radius, &peak, prior, &mut bytes) else { continue };
            let off = Vector2::new(found.d_col - here.d_col, found.d_row - here.d_row);
            odds.count += 1;
            odds.scatter += off * off.transpose();
        }
    }
    odds
}

/// The whole pixel beside a solution.
fn near(here: &SubPixel) -> Peak {
    let (col, row) = (here.d_col.round(), here.d_row.round());
    let (d_col, d_row) = (col as i16, row as i16);
    let vertex = (here.d_col - col, here.d_row - row);
    Peak { d_col, d_row, score: 0.0, second: 0.0, second_at: (d_col, d_row), vertex, on_border: false }
}

/// What of a run lies in a window, counted from there.
fn within(run: Run, (left, top): (u16, u16), (width, height): (u16, u16)) -> Option<Run> {
    let row = run.row.checked_sub(top).filter(|row| *row < height)?;
    let along = |col: u16| col.saturating_sub(left).min(width);
    let (start, end) = (along(run.start), along(run.end));
    (start < end).then_some(Run { row, start, end })
}
