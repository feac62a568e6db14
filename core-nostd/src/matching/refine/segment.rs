//! A few pixels of a row with a common sub-pixel position: their sums for least squares, in integers.
//!
//! Rotation and scale hardly change the sub-pixel position within a few pixels, so the spline's weights are computed
//! once for all of them. All numbers of a pixel fit 16 bits: they lie in words of two pixels, two columns apart, and
//! one instruction makes and adds two products. Pixels come in fours; surplus pixels of the last four get no weight.
pub(super) use super::smooth::FRACTIONS;
use super::smooth::weights;
use crate::arch::difference;
use crate::image::View;
use crate::matching::histogram::Histogram;
use crate::matching::kernels::least_squares::{
    Pair, Weighing, weigh_residuals, weigh_rows, weighed_products, weighed_sums,
};
use crate::math::squared;
use crate::packed::{bytes, high, low, pack};

/// Pixels of the longest segment; its sums fit 32 bits.
pub(super) const LONGEST: usize = 32;
/// Fours of pixels.
const FOURS: usize = LONGEST / 4;
/// Taps of the spline beyond the first pixel of a segment.
const TAPS: usize = 3;
/// Grey level from which pictures are measured, to keep gain and offset nearly uncorrelated.
pub(super) const MID_GREY: i32 = 128;
/// [`MID_GREY`] in both halves of a word.
const MID_GREYS: u32 = 0x0080_0080;

/// Steps of a residual per grey level.
pub(in crate::matching) const RESIDUAL_STEPS: i32 = 16;
/// Steps of a weight.
pub(in crate::matching) const WEIGHT_STEPS: i32 = 64;
/// Largest correlation of neighbours that is used. Chosen: for white noise the spline makes 0.44 at whole pixels to
/// 0.54 at halves.
const CORRELATION_MAX: f32 = 0.6;
/// Bins of the weight function per unit of residual over the outlier's, and their number.
const BINS_PER_UNIT: usize = 32;
const BINS: usize = 4 * BINS_PER_UNIT;

/// Geman and McClure's weight 1/(1 + t²)² at the middle of each bin of t, from the lowest bin of negative residuals on.
static WEIGHTS: [u8; 2 * BINS] = {
    let mut weights = [0; 2 * BINS];
    let mut bin = 0;
    while bin < BINS {
        // t = (2 bin + 1) / 2 BINS_PER_UNIT, in exact fractions.
        let (t, unit) = (2 * bin as u64 + 1, 2 * BINS_PER_UNIT as u64);
        let (over, under) = (unit * unit * unit * unit, (unit * unit + t * t) * (unit * unit + t * t));
        weights[BINS + bin] = ((2 * WEIGHT_STEPS as u64 * over + under) / (2 * under)) as u8;
        weights[BINS - 1 - bin] = weights[BINS + bin];
        bin += 1;
    }
    weights
};

/// Gain and offset from the patch's greys to the reference's, in fixed point.
#[derive(Clone, Copy)]
pub(in crate::matching) struct Radiometry {
    gain: i32,
    offset: i32,
    /// Bins of the weight function per step of a residual, Q16.
    bins: i32,
}

impl Radiometry {
    /// reference = `gain` x (patch - [`MID_GREY`]) + `offset`; a residual of `outlier` grey levels has a quarter of the
    /// weight. Products of weight and residual fit 16 bits for outliers up to 98 grey levels.
    pub(in crate::matching) fn new(gain: f32, offset: f32, outlier: f32) -> Self {
        let q16 = |value: f32| (65536.0 * value) as i32;
        let bins = (65536 * BINS_PER_UNIT / RESIDUAL_STEPS as usize) as f32 / outlier;
        Radiometry { gain: q16(gain), offset: q16(offset - MID_GREY as f32), bins: bins as i32 }
    }

    /// Bin of a residual, as two's complement.
    #[inline(always)]
    fn bin(&self, residual: i32) -> u8 {
        ((residual * self.bins) >> 16).clamp(-(BINS as i32), BINS as i32 - 1) as u8
    }

    /// Median size of the residuals over the outlier's.
    pub(in crate::matching) fn median(sizes: &Histogram) -> f32 {
        sizes.folded_median() / BINS_PER_UNIT as f32
    }
}

/// Σ over the pixels of a segment of products of: w, the weight, in steps; x and y, the patch's grey difference between
/// the two neighbours along columns and rows; p, its grey less [`MID_GREY`]; e, the residual, in steps.
#[derive(Default)]
pub(in crate::matching) struct Sums {
    pub(in crate::matching) xx: i32,
    pub(in crate::matching) xy: i32,
    pub(in crate::matching) yy: i32,
    pub(in crate::matching) xp: i32,
    pub(in crate::matching) yp: i32,
    pub(in crate::matching) pp: i32,
    pub(in crate::matching) x: i32,
    pub(in crate::matching) y: i32,
    pub(in crate::matching) p: i32,
    pub(in crate::matching) w: i32,
    pub(in crate::matching) xe: i32,
    pub(in crate::matching) ye: i32,
    pub(in crate::matching) pe: i32,
    pub(in crate::matching) e: i32,
    /// Σ w e².
    pub(in crate::matching) ee: i32,
}

/// Autocorrelation of the residuals along a row, by the influence s = w e (x, y) of each pixel on both shifts: Σ s²
/// over every other pixel, and Σ s s(right neighbour) over those.
#[derive(Clone, Copy, Default)]
pub(in crate::matching) struct Autocorrelation {
    own: i64,
    neighbour: i64,
}

impl Autocorrelation {
    /// Inflation of the variance by correlated residuals: (1 + 2 ρ)² for a correlation ρ to each neighbour along both
    /// axes. Never below 1.
    pub(in crate::matching) fn inflation(&self) -> f32 {
        let rho =
            if self.own > 0 { (self.neighbour as f32 / self.own as f32).clamp(0.0, CORRELATION_MAX) } else { 0.0 };
        squared(1.0 + 2.0 * rho)
    }
}

/// Working space of a segment.
#[derive(Default)]
pub(in crate::matching) struct Segment {
    /// Pixels 0 and 2 of each four, then 1 and 3.
    pairs: [[Pair; 2]; FOURS],
    /// The reference interpolated along the columns, less [`MID_GREY`], in Q8: two columns a word.
    columns: [[u32; 2]; FOURS + 1],
    /// Pixels.
    length: usize,
}

impl Segment {
    /// Loads the pixels of `patch` from (`col`, `row`) on, the first of which lies at (`u`, `v`) of the reference;
    /// `false` if that or the patch's neighbours leave their pictures.
    pub(in crate::matching) fn load(
        &mut self,
        patch: &View<'_>,
        (col, row, length): (usize, usize, usize),
        reference: &View<'_>,
        (u, v): (f32, f32),
        radiometry: &Radiometry,
    ) -> bool {
        self.length = length;
        self.gradients(patch, (col, row)).and_then(|()| self.residuals(reference, (u, v), radiometry)).is_some()
    }

    /// Fours of pixels.
    fn fours(&self) -> usize {
        self.length.div_ceil(4)
    }

    /// x, y and p.
    #[inline(never)]
    fn gradients(&mut self, patch: &View<'_>, (col, row): (usize, usize)) -> Option<()> {
        let (fours, left) = (self.fours(), col.checked_sub(1)?);
        let line = |row: usize, col: usize| Some(patch.from(row, col).get(..4 * fours)?.as_chunks::<4>().0);
        let (above, below) = (line(row.checked_sub(1)?, col)?, line(row + 1, col)?);
        let (left, right) = (line(row, left)?, line(row, col + 1)?);
        let pairs = self.pairs.get_mut(..fours)?;
        for ((((pair, above), below), left), right) in pairs.iter_mut().zip(above).zip(below).zip(left).zip(right) {
            let [above, below, left, right] = [above, below, left, right].map(|four| bytes(u32::from_le_bytes(*four)));
            // A pixel is its right neighbour's left and its left one's right.
            let p = [left[1], right[0]];
            for (i, pair) in pair.iter_mut().enumerate() {
                pair.x = difference(right[i], left[i]);
                pair.y = difference(below[i], above[i]);
                pair.p = difference(p[i], MID_GREYS);
            }
        }
        Some(())
    }

    /// e, w and their product.
    #[inline(never)]
    fn residuals(&mut self, reference: &View<'_>, (u, v): (f32, f32), radiometry: &Radiometry) -> Option<()> {
        let (col, across) = position(u)?;
        let (row, down) = position(v)?;
        self.columns(reference, (col, row), down)?;
        let weighing = Weighing {
            across: [pack(across[0], across[1]), pack(across[2], across[3])],
            gain: radiometry.gain,
            rest: -radiometry.offset,
            bins: radiometry.bins,
            weights: &WEIGHTS,
        };
        let fours = self.fours();
        weigh_residuals(self.pairs.get_mut(..fours)?, &self.columns, &weighing);
        // No weight for surplus pixels.
        if let Some([even, odd]) = self.pairs.get_mut(self.length / 4) {
            let keep: [u32; 2] = match self.length % 4 {
                0 => return Some(()),
                1 => [0xffff, 0],
                2 => [0xffff, 0xffff],
                _ => [u32::MAX, 0xffff],
            };
            for (pair, keep) in [even, odd].into_iter().zip(keep) {
                pair.w &= keep;
                pair.we &= keep;
            }
        }
        Some(())
    }

    /// Interpolates the reference along its columns, from (`col`, `row`) on.
    #[inline(never)]
    fn columns(&mut self, reference: &View<'_>, (col, row): (usize, usize), down: [i32; 4]) -> Option<()> {
        let words = self.length.div_ceil(4) + 1;
        for nth in 0..=TAPS {
            reference.run(row + nth, col, self.length + TAPS)?;
        }
        let down = down.map(|weight| weight as u32);
        weigh_rows(reference.from(row, col), reference.stride(), down, self.columns.get_mut(..words)?)
    }

    /// Counts the bins of every other residual, which is enough for the median.
    #[inline(never)]
    pub(in crate::matching) fn count(&self, radiometry: &Radiometry, sizes: &mut Histogram) {
        for (index, [even, _]) in self.pairs.iter().take(self.fours()).enumerate() {
            sizes.add(radiometry.bin(low(even.e)));
            if self.length > 4 * index + 2 {
                sizes.add(radiometry.bin(high(even.e)));
            }
        }
    }

    /// The sums.
    #[inline(never)]
    pub(in crate::matching) fn sums(&self) -> Sums {
        let pairs = self.pairs.get(..self.fours()).unwrap_or(&[]).as_flattened();
        let [xx, xy, xp, yy, yp, pp] = weighed_products(pairs);
        let [x, y, p, w, xe, ye, pe, e, ee] = weighed_sums(pairs);
        Sums { xx, xy, yy, xp, yp, pp, x, y, p, w, xe, ye, pe, e, ee }
    }

    /// Adds to the autocorrelation of the residuals.
    #[inline(never)]
    pub(in crate::matching) fn correlate(&self, sums: &mut Autocorrelation) {
        for [even, odd] in self.pairs.iter().take(self.fours()) {
            let own = [low(even.we), high(even.we)];
            let other = [low(odd.we), high(odd.we)];
            let squares = [low, high].map(|of| of(even.x) * of(even.x) + of(even.y) * of(even.y));
            let products = [low, high].map(|of| of(even.x) * of(odd.x) + of(even.y) * of(odd.y));
            for i in 0..2 {
                sums.own += (own[i] * own[i]) as i64 * squares[i] as i64;
                sums.neighbour += (own[i] * other[i]) as i64 * products[i] as i64;
            }
        }
    }
}

/// First pixel of the spline at a position, and its weights.
fn position(at: f32) -> Option<(usize, [i32; 4])> {
    let parts = (at * FRACTIONS as f32 + 0.5) as i32;
    let pixel = usize::try_from(parts / FRACTIONS).ok()?;
    Some((pixel.checked_sub(1)?, weights(parts % FRACTIONS)))
}
