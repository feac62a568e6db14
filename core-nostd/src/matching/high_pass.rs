//! The high-pass image: what a picture shows beyond the mean of its surroundings.
//!
//! A value is the difference of a pixel to the mean of the 5 x 5 around it. Fields, shadows of clouds and other slow changes
//! vanish in it, a new field keeps its border only, and neighbouring pixels hardly correlate any more: the correlation of
//! two high-pass images has a sharp peak. Over the default scene with 10 % changed ground the correlation of the greys
//! themselves has its peak at a wrong shift in 6 % of the frames, that of the high-pass images in none.
//!
//! Every pixel has 5 x 5 around it: beyond the end of a run its last pixel goes on, beyond the first and the last row that
//! row. Over true matches this correlates as well as the mean of those pixels that are valid, and no pixel needs a count
//! of its own: four come out of one turn of packed sums.

use super::histogram::Histogram;
use super::kernels::high_pass::{SIDE, STRIP, WIDTH, high_pass};
use super::kernels::rows::{copy, fill};
use crate::arch::clamp_bytes;
use crate::image::{Run, View};

/// Largest value.
const MAX: i32 = i8::MAX as i32;
/// Values beyond this many medians of their size are clipped: such a value says "different", not "how different". Over
/// the four series the peak is wrong 0, 0, 0 and 38 times of 1,500 each. With one median it is 0, 0, 0 and 35 times, but a
/// quarter of the weak matches that are accepted now are refused; with four it is 0, 0, 48 and 144 times.
const CLIP_MEDIANS: f32 = 2.0;

/// Rows around one, as they come, each from two columns before the strip on.
#[repr(align(4))]
struct Ring([[u8; WIDTH]; SIDE]);

/// What the filter makes of a strip.
#[repr(align(4))]
struct Strip([[u8; 4]; STRIP / 4]);

impl Ring {
    fn slot(row: usize) -> usize {
        row % SIDE
    }

    /// Lays `pixels` from `start` on into a row; its last pixel goes on behind them, and before them the first one where
    /// they are the row's first.
    fn lay(&mut self, row: usize, strip: usize, start: usize, pixels: &[u8], leads: bool) {
        let line = &mut self.0[Self::slot(row)];
        let (Some(&first), Some(&last)) = (pixels.first(), pixels.last()) else { return };
        let at = |col: usize| (col + REACH).saturating_sub(strip).min(WIDTH);
        let (from, to) = (at(start), at(start + pixels.len()));
        let (before, line) = line.split_at_mut(from);
        if leads {
            fill(first, before);
        }
        // At most the whole line, since `to` is not below `from`.
        let length = to.wrapping_sub(from).min(line.len());
        let (line, behind) = line.split_at_mut(length);
        let skipped = strip.saturating_sub(start + REACH);
        if let Some(pixels) = pixels.get(skipped..skipped + line.len()) {
            copy(pixels, line);
        }
        fill(last, behind);
    }
}

/// Pixels to each side that make the surroundings.
const REACH: usize = SIDE / 2;

/// Filters `runs`, sorted by row, piece by piece of at most [`STRIP`] pixels: values as bytes of two's complement, not
/// clipped yet.
pub(super) fn filter(view: &View<'_>, runs: impl Iterator<Item = Run> + Clone, mut each: impl FnMut(Run, &mut [u8])) {
    let Some(first) = runs.clone().next() else { return };
    for strip in (0..view.size().0 as usize).step_by(STRIP) {
        let mut ring = Ring([[0; WIDTH]; SIDE]);
        let mut ahead = runs.clone().peekable();
        let mut take = |ring: &mut Ring, row: usize| {
            let mut leads = true;
            while let Some(run) = ahead.next_if(|run| run.row as usize == row) {
                let length = run.end.saturating_sub(run.start) as usize;
                let pixels = view.run(row, run.start as usize, length).unwrap_or(&[]);
                ring.lay(row, strip, run.start as usize, pixels, leads);
                leads = false;
            }
            if leads {
                ring.0[Ring::slot(row)] = ring.0[Ring::slot(row + SIDE - 1)];
            }
        };
        let first = first.row as usize;
        take(&mut ring, first);
        for before in 1..=REACH {
            ring.0[Ring::slot(first + SIDE - before)] = ring.0[Ring::slot(first)];
        }
        let mut next = first + 1;
        let mut out = Strip([[0; 4]; STRIP / 4]);
        for run in runs.clone() {
            while next <= run.row as usize + REACH {
                take(&mut ring, next);
                next += 1;
            }
            let Some(piece) = piece(&run, strip as u16) else { continue };
            let (from, to) = (piece.start as usize - strip, piece.end as usize - strip);
            let words = from / 4..to.div_ceil(4);
            let Some(out) = out.0.get_mut(words.clone()) else { continue };
            high_pass(&ring.0, Ring::slot(run.row as usize), words.start, out);
            if let Some(bytes) = out.as_flattened_mut().get_mut(from - 4 * words.start..to - 4 * words.start) {
                each(piece, bytes);
            }
        }
    }
}

/// The pieces that [`filter`] makes of `runs`.
#[inline(always)]
pub(super) fn each_piece(view: &View<'_>, runs: &[Run], mut each: impl FnMut(Run)) {
    for strip in (0..view.size().0).step_by(STRIP) {
        runs.iter().filter_map(|run| piece(run, strip)).for_each(&mut each);
    }
}

/// The part of a run that lies in a strip.
pub(super) fn piece(run: &Run, strip: u16) -> Option<Run> {
    let (start, end) = (run.start.max(strip), run.end.min(strip.saturating_add(STRIP as u16)));
    (start < end).then_some(Run { row: run.row, start, end })
}

/// The size beyond which values are clipped, from those that it has seen.
pub(super) struct ClippingThreshold {
    sizes: Histogram,
}

impl ClippingThreshold {
    /// Of no values yet.
    pub(super) fn new() -> Self {
        ClippingThreshold { sizes: Histogram::new() }
    }

    /// Takes values into account.
    pub(super) fn add(&mut self, values: &[u8]) {
        for &value in values {
            self.sizes.add((value as i8).unsigned_abs());
        }
    }

    /// The threshold for the values taken into account.
    pub(super) fn value(&self) -> u8 {
        (CLIP_MEDIANS * self.sizes.median()).clamp(2.0, MAX as f32) as u8
    }
}

/// Clips values to ±`threshold`.
pub(super) fn clip(threshold: u8, values: &mut [u8]) {
    let (fours, rest) = values.as_chunks_mut::<4>();
    for four in fours {
        *four = clamp_bytes(u32::from_le_bytes(*four), threshold).to_le_bytes();
    }
    for value in rest {
        *value = (*value as i8).max(-(threshold as i8)).min(threshold as i8) as u8;
    }
}
