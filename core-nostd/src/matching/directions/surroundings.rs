//! A rolling window of three rows with padded borders, for filters of 3 x 3.

use crate::image::{Run, View};
use crate::matching::kernels::gradients::WIDTH;
use crate::matching::kernels::rows::{copy, fill};

/// Columns before the strip.
const REACH: usize = 2;
/// Rows in the window.
const ROWS: usize = 3;

/// Three rows of a strip of a picture, each from two columns before the strip on. Invalid pixels repeat the nearest valid one of the row,
/// rows without a run the row above.
#[repr(align(4))]
pub(super) struct Ring<'a, R: Iterator<Item = Run>> {
    rows: [[u8; WIDTH]; ROWS],
    view: &'a View<'a>,
    ahead: core::iter::Peekable<R>,
    strip: usize,
    /// The next row to be read.
    next: usize,
}

impl<'a, R: Iterator<Item = Run>> Ring<'a, R> {
    /// Before the first row of `runs`, which are sorted by row.
    pub(super) fn new(view: &'a View<'a>, runs: R, strip: usize) -> Self {
        let mut ahead = runs.peekable();
        let first = ahead.peek().map_or(0, |run| run.row as usize);
        let mut ring = Ring { rows: [[0; WIDTH]; ROWS], view, ahead, strip, next: first };
        ring.take();
        ring.rows = [ring.rows[first % ROWS]; ROWS];
        ring
    }

    /// The row `below`, read if necessary, after the two rows above it.
    pub(super) fn down_to(&mut self, below: usize) -> [&[u8; WIDTH]; ROWS] {
        while self.next <= below {
            self.take();
        }
        [1, 2, 3].map(|by| &self.rows[(below + by) % ROWS])
    }

    fn take(&mut self) {
        let row = self.next;
        self.next += 1;
        let mut leads = true;
        while let Some(run) = self.ahead.next_if(|run| run.row as usize == row) {
            let length = run.end.saturating_sub(run.start) as usize;
            let pixels = self.view.run(row, run.start as usize, length).unwrap_or(&[]);
            self.lay(row, run.start as usize, pixels, leads);
            leads = false;
        }
        if leads {
            self.rows[row % ROWS] = self.rows[(row + ROWS - 1) % ROWS];
        }
    }

    /// Copies `pixels` into a row from `start` on; repeats the last one after them, and the first one before them if they are the row's
    /// first.
    fn lay(&mut self, row: usize, start: usize, pixels: &[u8], leads: bool) {
        let line = &mut self.rows[row % ROWS];
        let (Some(&first), Some(&last)) = (pixels.first(), pixels.last()) else { return };
        let at = |col: usize| (col + REACH).saturating_sub(self.strip).min(WIDTH);
        let (from, to) = (at(start), at(start + pixels.len()));
        let (before, line) = line.split_at_mut(from);
        if leads {
            fill(first, before);
        }
        // At most the whole line, since `to` is not below `from`.
        let length = to.wrapping_sub(from).min(line.len());
        let (line, behind) = line.split_at_mut(length);
        let skipped = self.strip.saturating_sub(start + REACH);
        if let Some(pixels) = pixels.get(skipped..skipped + line.len()) {
            copy(pixels, line);
        }
        fill(last, behind);
    }
}
