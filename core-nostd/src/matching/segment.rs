//! A few pixels of a row under one sub-pixel position: what least squares needs of them, in integers.
//!
//! Turn and scale hardly move the position within a few pixels, so the spline's weights are made once for all of them.
//! All numbers of a pixel fit 16 bits: they lie in words of two pixels, two columns apart, and one instruction makes and
//! adds two products. Pixels come in fours; what the last four have too many gets no weight.

use super::View;
use super::histogram::Histogram;
pub(super) use super::smooth::FRACTIONS;
use super::smooth::weights;
use crate::lanes::{self, ONES, SIGNS, bytes, difference, dot, high, low, pack, signed_bytes};

/// Pixels of the longest segment; 32-bit sums hold as many.
pub(super) const LONGEST: usize = 32;
/// Fours of pixels.
const FOURS: usize = LONGEST / 4;
/// Taps of the spline beyond the first pixel of a segment.
const TAPS: usize = 3;
/// Grey level that pictures are measured from, so that gain and offset stay well apart.
pub(super) const MID_GREY: i32 = 128;
/// The same of four bytes: turns them into differences to it, of two's complement.
const MID_GREYS: u32 = 0x8080_8080;

/// Steps of a residual per grey level.
pub(super) const RESIDUAL_STEPS: i32 = 16;
/// Residuals are limited to this, steps; none of them has weight then.
const RESIDUAL_MAX: i32 = 4095;
/// Steps of a weight.
pub(super) const WEIGHT_STEPS: i32 = 64;
/// Bins of the weight function per unit of residual over the outlier's, and how many there are.
const BINS_PER_UNIT: usize = 32;
const BINS: usize = 4 * BINS_PER_UNIT;

/// Geman and McClure's weight 1/(1 + t²)² at the middle of each bin of t; the bins of negative residuals as two's
/// complement.
static WEIGHTS: [u8; 2 * BINS] = {
    let mut weights = [0; 2 * BINS];
    let mut bin = 0;
    while bin < BINS {
        // t = (2 bin + 1) / 2 BINS_PER_UNIT, in exact fractions.
        let (t, unit) = (2 * bin as u64 + 1, 2 * BINS_PER_UNIT as u64);
        let (over, under) = (unit * unit * unit * unit, (unit * unit + t * t) * (unit * unit + t * t));
        weights[bin] = ((2 * WEIGHT_STEPS as u64 * over + under) / (2 * under)) as u8;
        weights[2 * BINS - 1 - bin] = weights[bin];
        bin += 1;
    }
    weights
};

/// How the greys of the reference follow from those of the patch, in fixed point.
#[derive(Clone, Copy)]
pub(super) struct Radiometry {
    gain: i32,
    offset: i32,
    /// Bins of the weight function per step of a residual, Q16.
    bins: i32,
}

impl Radiometry {
    /// reference = `gain` x (patch - [`MID_GREY`]) + `offset`; a residual of `outlier` grey levels has a quarter of the
    /// weight. Products of weight and residual fit 16 bits for outliers up to 98 grey levels.
    pub(super) fn new(gain: f32, offset: f32, outlier: f32) -> Self {
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
    pub(super) fn median(sizes: &Histogram) -> f32 {
        sizes.folded_median() / BINS_PER_UNIT as f32
    }
}

/// Σ over the pixels of a segment of products of: w, the weight, in steps; x and y, the patch's grey difference between
/// the two neighbours along columns and rows; p, its grey less [`MID_GREY`]; e, the residual, in steps.
#[derive(Default)]
pub(super) struct Sums {
    pub(super) xx: i32,
    pub(super) xy: i32,
    pub(super) yy: i32,
    pub(super) xp: i32,
    pub(super) yp: i32,
    pub(super) pp: i32,
    pub(super) x: i32,
    pub(super) y: i32,
    pub(super) p: i32,
    pub(super) w: i32,
    pub(super) xe: i32,
    pub(super) ye: i32,
    pub(super) pe: i32,
    pub(super) e: i32,
    /// Σ w e².
    pub(super) ee: i32,
}

/// How far residuals are correlated, by the scores s = w e (x, y) of both shifts: Σ s² over every other pixel, and
/// Σ s s(right neighbour) over the same.
#[derive(Clone, Copy, Default)]
pub(super) struct Scores {
    pub(super) score: i64,
    pub(super) neighbour: i64,
}

/// The numbers of two pixels.
#[derive(Clone, Copy, Default)]
struct Pair {
    x: u32,
    y: u32,
    p: u32,
    w: u32,
    /// w e.
    we: u32,
    e: u32,
}

/// Working space of a segment.
#[derive(Default)]
pub(super) struct Segment {
    /// Pixels 0 and 2 of each four, then 1 and 3.
    pairs: [[Pair; 2]; FOURS],
    /// The reference weighed along the columns, less [`MID_GREY`], in Q8: two columns a word.
    columns: [[u32; 2]; FOURS + 1],
    /// Pixels.
    length: usize,
}

impl Segment {
    /// The pixels of `patch` from (`col`, `row`) on, the first of which lies at (`u`, `v`) of the reference; `false`
    /// where that or the patch's neighbours leave their pictures.
    pub(super) fn load(
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
        let (left, own, right) = (line(row, left)?, line(row, col)?, line(row, col + 1)?);
        let pairs = self.pairs.get_mut(..fours)?;
        for (((((pair, above), below), left), own), right) in
            pairs.iter_mut().zip(above).zip(below).zip(left).zip(own).zip(right)
        {
            let [above, below, left, right] = [above, below, left, right].map(|four| bytes(u32::from_le_bytes(*four)));
            let p = signed_bytes(u32::from_le_bytes(*own) ^ MID_GREYS);
            for (i, pair) in pair.iter_mut().enumerate() {
                pair.x = difference(right[i], left[i]);
                pair.y = difference(below[i], above[i]);
                pair.p = p[i];
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
        let across = [pack(across[0], across[1]), pack(across[2], across[3])];
        let mut columns = self.columns.iter();
        let [mut a, mut b] = *columns.next()?;
        let fours = self.length.div_ceil(4);
        for (pair, &[c, d]) in self.pairs.get_mut(..fours)?.iter_mut().zip(columns) {
            // Columns 0 1, 2 3 and 4 5, then 1 2, 3 4 and 5 6.
            let (ab, bc, cd) = (lanes::across(a, b), lanes::across(b, c), lanes::across(c, d));
            let [even, odd] = pair;
            let e = [(low(even.p), a, b), (low(odd.p), ab, bc), (high(even.p), b, c), (high(odd.p), bc, cd)].map(
                |(p, first, second)| {
                    let rest = -radiometry.offset - radiometry.gain * p;
                    let e = dot(second, across[1], dot(first, across[0], rest)) >> 12;
                    e.clamp(-RESIDUAL_MAX - 1, RESIDUAL_MAX)
                },
            );
            let w = e.map(|e| WEIGHTS[radiometry.bin(e) as usize] as i32);
            even.e = pack(e[0], e[2]);
            odd.e = pack(e[1], e[3]);
            even.w = pack(w[0], w[2]);
            odd.w = pack(w[1], w[3]);
            even.we = pack(w[0] * e[0], w[2] * e[2]);
            odd.we = pack(w[1] * e[1], w[3] * e[3]);
            (a, b) = (c, d);
        }
        // No weight for what is no pixel.
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

    /// Weighs the reference along its columns, from (`col`, `row`) on.
    #[inline(never)]
    fn columns(&mut self, reference: &View<'_>, (col, row): (usize, usize), down: [i32; 4]) -> Option<()> {
        let words = self.length.div_ceil(4) + 1;
        let line = |nth: usize| {
            reference.run(row + nth, col, self.length + TAPS)?;
            Some(reference.from(row + nth, col).get(..4 * words)?.as_chunks::<4>().0)
        };
        let (a, b, c, d) = (line(0)?, line(1)?, line(2)?, line(3)?);
        let down = down.map(|weight| weight as u32);
        let columns = self.columns.get_mut(..words)?;
        for ((((columns, a), b), c), d) in columns.iter_mut().zip(a).zip(b).zip(c).zip(d) {
            let [a, b, c, d] = [a, b, c, d].map(|four| bytes(u32::from_le_bytes(*four)));
            // At most 255 x 256 in each half.
            let sum = |i: usize| (down[0] * a[i] + down[1] * b[i] + down[2] * c[i] + down[3] * d[i]) ^ SIGNS;
            let (even, odd) = (sum(0), sum(1));
            *columns = [(even & 0xffff) | odd << 16, even >> 16 | (odd & 0xffff_0000)];
        }
        Some(())
    }

    /// Counts the bins of the residuals.
    #[inline(never)]
    pub(super) fn count(&self, radiometry: &Radiometry, sizes: &mut Histogram) {
        for (index, [even, odd]) in self.pairs.iter().take(self.fours()).enumerate() {
            let e = [low(even.e), low(odd.e), high(even.e), high(odd.e)];
            for &e in e.iter().take(self.length - 4 * index) {
                sizes.add(radiometry.bin(e));
            }
        }
    }

    /// The sums.
    #[inline(never)]
    pub(super) fn sums(&self) -> Sums {
        let pairs = self.pairs.get(..self.fours()).unwrap_or(&[]).as_flattened();
        let mut sums = Sums::default();
        for pair in pairs {
            let &Pair { x, y, p, w, .. } = pair;
            let weigh = |z: u32| pack(low(w) * low(z), high(w) * high(z));
            let (wx, wy, wp) = (weigh(x), weigh(y), weigh(p));
            sums.xx = dot(wx, x, sums.xx);
            sums.xy = dot(wx, y, sums.xy);
            sums.xp = dot(wx, p, sums.xp);
            sums.yy = dot(wy, y, sums.yy);
            sums.yp = dot(wy, p, sums.yp);
            sums.pp = dot(wp, p, sums.pp);
        }
        let mut weight = 0;
        for pair in pairs {
            let &Pair { x, y, p, w, we, e } = pair;
            weight += w;
            sums.x = dot(w, x, sums.x);
            sums.y = dot(w, y, sums.y);
            sums.p = dot(w, p, sums.p);
            sums.xe = dot(we, x, sums.xe);
            sums.ye = dot(we, y, sums.ye);
            sums.pe = dot(we, p, sums.pe);
            sums.ee = dot(we, e, sums.ee);
            sums.e = dot(we, ONES, sums.e);
        }
        sums.w = low(weight) + high(weight);
        sums
    }

    /// Adds to the scores.
    #[inline(never)]
    pub(super) fn scores(&self, scores: &mut Scores) {
        for [even, odd] in self.pairs.iter().take(self.fours()) {
            let own = [low(even.we), high(even.we)];
            let other = [low(odd.we), high(odd.we)];
            let squares = [low, high].map(|of| of(even.x) * of(even.x) + of(even.y) * of(even.y));
            let products = [low, high].map(|of| of(even.x) * of(odd.x) + of(even.y) * of(odd.y));
            for i in 0..2 {
                scores.score += (own[i] * own[i]) as i64 * squares[i] as i64;
                scores.neighbour += (own[i] * other[i]) as i64 * products[i] as i64;
            }
        }
    }
}

/// First pixel that the spline weighs at a position, and its weights.
fn position(at: f32) -> Option<(usize, [i32; 4])> {
    let parts = (at * FRACTIONS as f32 + 0.5) as i32;
    let pixel = usize::try_from(parts / FRACTIONS).ok()?;
    Some((pixel.checked_sub(1)?, weights(parts % FRACTIONS)))
}
