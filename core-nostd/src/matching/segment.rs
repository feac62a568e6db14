//! A few pixels of a row under one sub-pixel position: what least squares needs of them, in integers.
//!
//! Turn and scale hardly move the position within a few pixels, so the spline's weights are made once for all of them and
//! the pixels themselves cost additions and 16-bit products only, the same on every machine.

use super::View;
use super::histogram::Histogram;
pub(super) use super::smooth::FRACTIONS;
use super::smooth::weights;

/// Pixels of the longest segment; 32-bit sums hold twice as many.
pub(super) const LONGEST: usize = 16;
/// Taps of the spline beyond the pixels of a segment.
const TAPS: usize = 4;
/// Grey level that pictures are measured from, so that gain and offset stay well apart.
pub(super) const MID_GREY: i32 = 128;

/// Steps of a residual per grey level.
pub(super) const RESIDUAL_STEPS: i32 = 16;
/// Residuals beyond this have no weight whatever they are, steps.
const RESIDUAL_MAX: i32 = 4095;
/// Steps of a weight.
pub(super) const WEIGHT_STEPS: i32 = 64;
/// Bins of the weight function per unit of residual over [`Radiometry::outlier`], and how many there are.
const BINS_PER_UNIT: usize = 32;
const BINS: usize = 4 * BINS_PER_UNIT;

/// Geman and McClure's weight 1/(1 + t²)² at the middle of each bin of t.
static WEIGHTS: [u8; BINS] = {
    let mut weights = [0; BINS];
    let mut bin = 0;
    while bin < BINS {
        // t = (2 bin + 1) / 2 BINS_PER_UNIT, in exact fractions.
        let (t, unit) = (2 * bin as u64 + 1, 2 * BINS_PER_UNIT as u64);
        let (over, under) = (unit * unit * unit * unit, (unit * unit + t * t) * (unit * unit + t * t));
        weights[bin] = ((2 * WEIGHT_STEPS as u64 * over + under) / (2 * under)) as u8;
        bin += 1;
    }
    weights
};

/// How the greys of the reference follow from those of the patch, in fixed point.
#[derive(Clone, Copy)]
pub(super) struct Radiometry {
    gain: i32,
    offset: i32,
    /// Bins of the weight function per step of a residual.
    bins: u32,
}

impl Radiometry {
    /// reference = `gain` x (patch - [`MID_GREY`]) + `offset`; a residual of `outlier` grey levels has a quarter of the
    /// weight.
    pub(super) fn new(gain: f32, offset: f32, outlier: f32) -> Self {
        let q16 = |value: f32| (65536.0 * value) as i32;
        let bins = (65536 * BINS_PER_UNIT / RESIDUAL_STEPS as usize) as f32 / outlier;
        Radiometry { gain: q16(gain), offset: q16(offset - MID_GREY as f32), bins: bins as u32 }
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
    /// Σ w e², in weight steps x residual steps² / [`WEIGHT_STEPS`].
    pub(super) ee: i32,
    /// Σ s² and Σ s s(left neighbour) of the scores s = w e (x, y) of both shifts: how far residuals are correlated.
    pub(super) score: i64,
    pub(super) neighbour: i64,
}

/// w e (x, y) of a pixel.
pub(super) type Score = (i32, i32);

/// Three rows of the patch around a segment, from one pixel before it to one behind.
pub(super) struct Patch<'a> {
    pub(super) above: &'a [u8],
    pub(super) own: &'a [u8],
    pub(super) below: &'a [u8],
}

/// Adds the pixels of a segment up, whose first one lies at (`u`, `v`) of the reference; `None` where that leaves it.
/// `sizes` counts the sizes of the residuals, in quarters of a grey level; `left`: the score of the pixel before.
pub(super) fn sums(
    patch: &Patch<'_>,
    reference: &View<'_>,
    (u, v): (f32, f32),
    radiometry: &Radiometry,
    sizes: &mut Histogram,
    left: &mut Score,
) -> Option<Sums> {
    let length = patch.own.len().checked_sub(2)?;
    let mut greys = [0; LONGEST];
    let greys = read(reference, (u, v), greys.get_mut(..length)?)?;
    let mut sums = Sums::default();
    let rows = patch.own.windows(3).zip(patch.above.get(1..)?).zip(patch.below.get(1..)?);
    for (((own, &above), &below), &grey) in rows.zip(&*greys) {
        let (x, y) = (own[2] as i32 - own[0] as i32, below as i32 - above as i32);
        let p = own[1] as i32 - MID_GREY;
        let e = ((grey - radiometry.gain * p - radiometry.offset) >> 12).clamp(-RESIDUAL_MAX, RESIDUAL_MAX);
        let size = e.unsigned_abs();
        sizes.add((size >> 2).min(255) as u8);
        let w = WEIGHTS[((size * radiometry.bins) >> 16).min(BINS as u32 - 1) as usize] as i32;
        let (wx, wy, wp, we) = (w * x, w * y, w * p, w * e);
        sums.xx += wx * x;
        sums.xy += wx * y;
        sums.yy += wy * y;
        sums.xp += wx * p;
        sums.yp += wy * p;
        sums.pp += wp * p;
        sums.x += wx;
        sums.y += wy;
        sums.p += wp;
        sums.w += w;
        sums.pe += wp * e;
        sums.e += we;
        sums.ee += (we >> 6) * e;
        let (xe, ye) = (wx * e, wy * e);
        sums.xe += xe;
        sums.ye += ye;
        let (sx, sy) = (xe as i64, ye as i64);
        sums.score += sx * sx + sy * sy;
        sums.neighbour += sx * left.0 as i64 + sy * left.1 as i64;
        *left = (xe, ye);
    }
    Some(sums)
}

/// Values of the cubic B-spline over `reference` at (`u`, `v`) and the positions to the right of it, less [`MID_GREY`],
/// in Q16; `None` where its pixels leave the reference.
fn read<'g>(reference: &View<'_>, (u, v): (f32, f32), greys: &'g mut [i32]) -> Option<&'g mut [i32]> {
    let (col, across) = position(u)?;
    let (row, down) = position(v)?;
    let columns = greys.len() + TAPS - 1;
    let line = |nth: usize| reference.run(row + nth, col, columns);
    let (a, b, c, d) = (line(0)?, line(1)?, line(2)?, line(3)?);
    let mut lanes = [0i16; LONGEST + TAPS - 1];
    let lanes = lanes.get_mut(..columns)?;
    for ((((lane, &a), &b), &c), &d) in lanes.iter_mut().zip(a).zip(b).zip(c).zip(d) {
        let sum = down[0] * a as i32 + down[1] * b as i32 + down[2] * c as i32 + down[3] * d as i32;
        *lane = (sum - FRACTIONS * MID_GREY) as i16;
    }
    for (grey, lanes) in greys.iter_mut().zip(lanes.windows(TAPS)) {
        *grey = lanes.iter().zip(across).map(|(&lane, weight)| lane as i32 * weight).sum();
    }
    Some(greys)
}

/// First pixel that the spline weighs at a position, and its weights.
fn position(at: f32) -> Option<(usize, [i32; 4])> {
    let parts = (at * FRACTIONS as f32 + 0.5) as i32;
    let pixel = usize::try_from(parts / FRACTIONS).ok()?;
    Some((pixel.checked_sub(1)?, weights(parts % FRACTIONS)))
}
