//! The estimate of least-squares matching, its initial value and steps.
use super::segment::{self, MID_GREY};
use crate::arch::{add_bytes, difference, dot};
use crate::image::{Run, View};
use crate::matching::histogram::Histogram;
use crate::math;
use crate::packed::bytes;
use nalgebra::SVector;

/// Shift along columns and rows, rotation, scale, gain and offset.
pub(super) const UNKNOWNS: usize = 6;
pub(super) type Vector = SVector<f32, UNKNOWNS>;

/// Smallest sigma of the residuals, grey levels: half a level is that of quantisation alone in both pictures.
pub(in crate::matching) const SIGMA_MIN: f32 = 0.5;
/// Residual, in sigmas, at which a pixel's weight has fallen to a quarter. Chosen: at 2.5, one in eighty normal
/// residuals lies beyond. [`super::EFFICIENCY`] and [`super::OVERRELAXATION`] hold for this one only.
const OUTLIER: f32 = 2.5;
/// Sigma of a normal distribution over the median of its absolute values: 1/Φ⁻¹(3/4).
const SIGMA_PER_MEDIAN: f32 = 1.4826;
/// Largest sigma of the residuals, grey levels: products of weight and residual hold outliers up to 98 levels,
/// see [`segment::Radiometry`].
const SIGMA_MAX: f32 = 32.0;
/// Largest gain, and grey levels of offset, between two pictures of the same ground. Chosen: a picture of 32 grey
/// levels against one of 256, and the offset of such a gain.
const GAIN_MAX: f32 = 8.0;
const OFFSET_MAX: f32 = 1024.0;
/// Stride of the runs for the initial value, which needs to be right to a few per cent only.
const START_STRIDE: usize = 3;
/// Grey levels in a bin of differences, as a shift: 256 bins of two hold all differences of bytes.
const BIN_SHIFT: i32 = 1;
/// Largest change of the position by rotation and scale between the middle and the end of a segment, pixels. Chosen: it
/// is of opposite sign at both ends, so that in a shift it cancels.
const BEND_PX: f32 = 0.1;

/// The current estimate.
pub(in crate::matching) struct Estimate {
    pub(super) shift: (f32, f32),
    /// Displacement by rotation and scale at the patch's edge, pixels.
    pub(super) turn: f32,
    pub(super) scale: f32,
    pub(in crate::matching) gain: f32,
    pub(in crate::matching) offset: f32,
    /// Robust sigma of the residuals of the pass before.
    pub(super) sigma: f32,
    pub(in crate::matching) centre: (f32, f32),
    /// Half the patch's longer side: with it rotation and scale are in pixels too, which keeps the normal matrix well
    /// scaled.
    pub(in crate::matching) half: f32,
    pub(in crate::matching) radius: f32,
}

impl Estimate {
    /// The initial value at the whole-pixel peak and the vertex beside it. The gain is that of the differences along the rows, which changed
    /// ground hardly affects, the offset the median difference with that gain.
    // Inlined, so that least-squares matching, the deepest of all, needs no other stack frame below its own.
    #[inline(always)]
    pub(in crate::matching) fn new(
        patch: &View<'_>,
        runs: &[Run],
        reference: &View<'_>,
        radius: u16,
        (peak, vertex): ((i16, i16), (f32, f32)),
        histogram: &mut Histogram,
    ) -> Option<Self> {
        let (cols, rows) = patch.size();
        let shifted = |at: u16, d: i16| usize::try_from(at as i32 + radius as i32 + d as i32).ok();
        let mut slopes = Slopes::default();
        let pairs = || {
            runs.iter().step_by(START_STRIDE).map(|run| {
                let length = run.end.checked_sub(run.start)? as usize;
                let own = patch.run(run.row as usize, run.start as usize, length)?;
                Some((own, reference.run(shifted(run.row, peak.1)?, shifted(run.start, peak.0)?, length)?))
            })
        };
        for pair in pairs() {
            let (own, other) = pair?;
            slopes.add(own, other);
        }
        let gain = slopes.gain().filter(|&gain| gain <= GAIN_MAX)?;
        let gain_q8 = (256.0 * gain) as i32;
        let middle = slopes.other_mean() - ((gain_q8 * (slopes.own_mean() - MID_GREY)) >> 8);
        histogram.clear();
        for pair in pairs() {
            let (own, other) = pair?;
            for (&own, &other) in own.iter().zip(other) {
                let difference = other as i32 - middle - ((gain_q8 * (own as i32 - MID_GREY)) >> 8);
                histogram.add(((difference >> BIN_SHIFT) + 128).clamp(0, 255) as u8);
            }
        }
        let quartile = |part| histogram.quantile(part) * (1 << BIN_SHIFT) as f32;
        Some(Estimate {
            shift: (peak.0 as f32 + vertex.0, peak.1 as f32 + vertex.1),
            turn: 0.0,
            scale: 0.0,
            gain,
            offset: middle as f32 + quartile(0.5) - 256.0,
            sigma: sigma(0.5 * (quartile(0.75) - quartile(0.25))),
            centre: (0.5 * (cols as f32 - 1.0), 0.5 * (rows as f32 - 1.0)),
            half: 0.5 * cols.max(rows) as f32,
            radius: radius as f32,
        })
    }

    /// Residual at which a pixel's weight has fallen to a quarter, grey levels.
    pub(in crate::matching) fn outlier(&self) -> f32 {
        OUTLIER * self.sigma
    }

    /// Whether gain and offset are possible between two pictures of the same ground.
    pub(in crate::matching) fn is_radiometry(&self) -> bool {
        self.gain > 0.0 && self.gain <= GAIN_MAX && self.offset.abs() <= OFFSET_MAX
    }

    /// Position in the searched reference of the patch pixel at (`x`, `y`) from the centre.
    pub(super) fn reference_position(&self, x: f32, y: f32) -> (f32, f32) {
        let (across, down) = (1.0 + self.scale / self.half, self.turn / self.half);
        let (centre, shift) = (&self.centre, self.read_shift());
        (
            across * x - down * y + shift.0 + centre.0 + self.radius,
            across * y + down * x + shift.1 + centre.1 + self.radius,
        )
    }

    /// The shift at which the reference is read: rounded to the spline's fractions.
    pub(super) fn read_shift(&self) -> (f32, f32) {
        let parts = segment::FRACTIONS as f32;
        let held = |shift: f32| math::round(shift * parts) / parts;
        (held(self.shift.0), held(self.shift.1))
    }

    /// Longest segment, pixels.
    pub(super) fn segment(&self) -> usize {
        let bend = (self.turn.abs() + self.scale.abs()) / self.half;
        let reach = |length: usize| 0.5 * length as f32 * bend <= BEND_PX;
        [segment::LONGEST, segment::LONGEST / 2].into_iter().find(|&l| reach(l)).unwrap_or(segment::LONGEST / 4)
    }

    /// Applies a step of the solution; returns its size, the larger of both axes, pixels. `median_size`: of the
    /// residuals, over the outlier's. The equations are solved for gain x displacement, and the new gain is the better
    /// one to divide by.
    pub(super) fn step(&mut self, step: &Vector, median_size: f32) -> f32 {
        let (before, read) = (self.shift, self.read_shift());
        let step = self.radiometric(step, Some(median_size));
        self.shift = (read.0 + step[0], read.1 + step[1]);
        self.turn += step[2];
        self.scale += step[3];
        (self.shift.0 - before.0).abs().max((self.shift.1 - before.1).abs())
    }

    /// Applies gain and offset, the last two of a step; returns its displacements divided by the new gain. `median_size`:
    /// of the residuals, over the outlier's, if it was determined.
    pub(in crate::matching) fn radiometric<const N: usize>(
        &mut self,
        step: &SVector<f32, N>,
        median_size: Option<f32>,
    ) -> SVector<f32, N> {
        let gain = self.gain + step[N - 2];
        let ratio = self.gain / gain;
        self.gain = gain;
        self.offset += step[N - 1];
        self.sigma = median_size.map_or(self.sigma, |median| sigma(median * self.outlier()));
        step * ratio
    }
}

fn sigma(median: f32) -> f32 {
    (SIGMA_PER_MEDIAN * median).clamp(SIGMA_MIN, SIGMA_MAX)
}

/// Differences between pixels four apart of both pictures.
#[derive(Default)]
struct Slopes {
    products: i64,
    squares: i64,
    own: u32,
    other: u32,
    pixels: u32,
}

impl Slopes {
    fn add(&mut self, own: &[u8], other: &[u8]) {
        let (mut products, mut squares) = (0, 0);
        let words = |four: &[u8; 4]| u32::from_le_bytes(*four);
        let mut fours = own.as_chunks::<4>().0.iter().map(words).zip(other.as_chunks::<4>().0.iter().map(words));
        let Some(mut before) = fours.next() else { return };
        for four in fours {
            let ([p, q], [r, s]) = (bytes(four.0), bytes(four.1));
            let ([p0, q0], [r0, s0]) = (bytes(before.0), bytes(before.1));
            let (p, q, r, s) = (difference(p, p0), difference(q, q0), difference(r, r0), difference(s, s0));
            products = dot(p, r, dot(q, s, products));
            squares = dot(p, p, dot(q, q, squares));
            self.own = add_bytes(four.0, self.own);
            self.other = add_bytes(four.1, self.other);
            self.pixels += 4;
            before = four;
        }
        self.products += products as i64;
        self.squares += squares as i64;
    }

    /// Σ p r / Σ p²: the gain of the other picture over the own one.
    fn gain(&self) -> Option<f32> {
        (self.squares > 0 && self.products > 0).then(|| self.products as f32 / self.squares as f32)
    }

    fn own_mean(&self) -> i32 {
        (self.own / self.pixels.max(1)) as i32
    }

    fn other_mean(&self) -> i32 {
        (self.other / self.pixels.max(1)) as i32
    }
}
