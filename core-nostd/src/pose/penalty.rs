//! The penalty on a curve's differences, and the cubic interpolation between samples.
//!
//! Times are in units of the nominal interval. For samples exactly that far apart the rows are 1, −2, 1 and −1, 3, −3,
//! 1, as in paper 001; otherwise they are divided differences, so that a lost sample or a jittering stamp does not
//! distort the curve.

use super::band::{BELOW, Band, Column, WINDOW};

/// Order of the differences that are penalised: the curve between samples is a smoothing spline of degree 3 or 5.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Order {
    /// Second differences: bending.
    Second,
    /// Third differences: change of bending.
    Third,
}

impl Order {
    /// 2 or 3.
    pub fn number(self) -> usize {
        match self {
            Order::Second => 2,
            Order::Third => 3,
        }
    }
}

/// Largest α for single precision: the condition number is about 4^d α, and beyond these the error of a window's
/// estimate, relative to a line through its ends, exceeds a thousandth of the noise.
pub const ALPHA_MAX: f32 = 1e4;

/// α R = α D'D over a window's samples, by its rows.
#[derive(Clone, Debug)]
pub struct Penalty {
    /// Row i of D and its part of α, which is 0 beyond the last.
    rows: [([f32; BELOW + 1], f32); WINDOW],
}

impl Penalty {
    /// Over samples at `times`.
    ///
    /// Row i of D is d! times the divided difference over the times i to i + d, times √((t_{i+d} − t_i)/d): the sum of its
    /// squares is the integral of the squared d-th derivative by the rule of rectangles, for any spacing.
    #[inline(never)]
    pub fn new(times: &[f32], order: Order, alpha: f32) -> Self {
        let mut penalty = Penalty { rows: [([0.0; BELOW + 1], 0.0); WINDOW] };
        match order {
            Order::Second => fill::<3>(&mut penalty.rows, times, 2.0, alpha / 2.0),
            Order::Third => fill::<4>(&mut penalty.rows, times, 6.0, alpha / 3.0),
        }
        penalty
    }

    /// Adds it to `band`.
    #[inline(never)]
    pub fn add_to(&self, band: &mut Band) {
        for (first, (row, part)) in self.rows.iter().enumerate() {
            if *part == 0.0 {
                break;
            }
            band.add(first, row, *part);
        }
    }

    /// Roughness of the `channels`, each in units of its `sigmas`; one of sigma 0 is ignored. They must end where the
    /// penalty's samples do.
    pub fn roughness<const C: usize>(&self, channels: &[Column; C], sigmas: [f32; C]) -> Roughness {
        let scales = sigmas.map(|sigma| if sigma > 0.0 { 1.0 / (sigma * sigma) } else { 0.0 });
        let tested = sigmas.iter().filter(|sigma| **sigma > 0.0).count() as f32;
        let (mut squares, mut norms, mut excess) = (0.0f32, 0.0f32, 0.0f32);
        for (first, ([a, b, c, d], part)) in self.rows.iter().enumerate() {
            if *part == 0.0 {
                break;
            }
            let norm = a * a + b * b + c * c + d * d;
            for (values, scale) in channels.iter().zip(scales) {
                let difference =
                    a * values[first] + b * values[first + 1] + c * values[first + 2] + d * values[first + 3];
                let square = difference * difference * scale;
                squares += square;
                excess = excess.max(square - SPIKE * SPIKE * norm);
            }
            norms += norm;
        }
        Roughness { squares, norms: norms * tested, is_spiked: excess > 0.0 }
    }

    /// α R g. Neighbours are subtracted first, so it is exact where its product with a band of large numbers is not.
    #[inline(never)]
    pub fn times(&self, g: &Column) -> Column {
        let mut product = [0.0; WINDOW + BELOW];
        for (first, ([a, b, c, d], part)) in self.rows.iter().enumerate() {
            if *part == 0.0 {
                break;
            }
            let difference = part * (a * g[first] + b * g[first + 1] + c * g[first + 2] + d * g[first + 3]);
            product[first] += difference * a;
            product[first + 1] += difference * b;
            product[first + 2] += difference * c;
            product[first + 3] += difference * d;
        }
        product
    }
}

/// Roughness of samples, in units of their own standard deviation.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Roughness {
    /// Sum of the squared differences.
    pub squares: f32,
    /// Its expectation for white noise.
    pub norms: f32,
    /// Whether a single difference is beyond noise: a spike in a sample.
    pub is_spiked: bool,
}

/// Gate of a spike, standard deviations of a difference. A sample off by six of its own passes it.
const SPIKE: f32 = 5.0;

fn fill<const K: usize>(rows: &mut [([f32; BELOW + 1], f32); WINDOW], times: &[f32], factorial: f32, part: f32) {
    for ((row, of_alpha), knots) in rows.iter_mut().zip(times.windows(K)) {
        let Ok(knots) = <&[f32; K]>::try_from(knots) else { return };
        for (k, element) in row.iter_mut().take(K).enumerate() {
            let mut product = 1.0;
            for (j, other) in knots.iter().enumerate() {
                if j != k {
                    product *= knots[k] - other;
                }
            }
            *element = factorial / product;
        }
        *of_alpha = part * (knots[K - 1] - knots[0]);
    }
}

/// Weights of the fitted samples at `times` for value and rate at `at`.
///
/// Between samples: the cubic through the four around it. The natural spline of second differences differs from it by
/// less than a hundredth of the noise (the reference's FIR rows are this cubic's), and the cubic needs no second system
/// of equations. Ahead of the newest sample: a curve without penalty, a line through the newest two for second
/// differences, a parabola through the newest three for third ones.
#[inline(never)]
pub fn row(times: &[f32], at: f32, order: Order) -> (Column, Column) {
    let after = times.iter().position(|time| *time > at).unwrap_or(times.len());
    let ahead = times.last().is_some_and(|newest| *newest < at);
    let points = if ahead { order.number() } else { 4 };
    let first = after.saturating_sub(if ahead { points } else { 2 }).min(times.len().saturating_sub(points));
    let mut rows = ([0.0; WINDOW + BELOW], [0.0; WINDOW + BELOW]);
    let around = times.get(first..).unwrap_or(&[]);
    let around = around.get(..points).unwrap_or(around);
    for (k, knot) in around.iter().enumerate() {
        // Lagrange: Π (at − other)/(knot − other), and its derivative, the product rule term by term.
        let (mut basis, mut slope) = (1.0, 0.0);
        for other in around.iter().enumerate().filter(|(j, _)| *j != k).map(|(_, other)| other) {
            let reciprocal = 1.0 / (knot - other);
            slope = (slope * (at - other) + basis) * reciprocal;
            basis *= (at - other) * reciprocal;
        }
        if let (Some(value), Some(rate)) = (rows.0.get_mut(first + k), rows.1.get_mut(first + k)) {
            (*value, *rate) = (basis, slope);
        }
    }
    rows
}
