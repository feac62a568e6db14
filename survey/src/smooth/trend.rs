//! The parametric part of a curve, split off afterwards.
//!
//! With B in the null space of the penalty the curve does not depend on the split, so B x is what the paper's constraints
//! make it: the mean for B = [1] and sum S = 0 (eq. 9, 10); for B = [1 t] the straight line by least squares through the
//! curve. The paper gives the line sum S = 0 alone (eq. 8, 18 to 20), which leaves its equations singular: sum t S = 0 is
//! needed too.

/// Constant and line of a curve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Trend {
    /// The constant: mean of the curve at the samples.
    pub constant: f64,
    /// The line through it.
    pub line: Line,
}

/// A straight line over time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Line {
    /// Value at time 0.
    pub at_zero: f64,
    /// Change in a second.
    pub slope: f64,
}

impl Trend {
    /// Of a curve's values at two or more different times.
    pub(super) fn of(t: &[f64], values: &[f64]) -> Self {
        let n = t.len() as f64;
        let first = t[0];
        let mean_t = t.iter().map(|t| t - first).sum::<f64>() / n;
        let constant = values.iter().map(|value| value / n).sum::<f64>();
        let (mut tt, mut tv) = (0.0, 0.0);
        for (t, value) in t.iter().zip(values) {
            let off = t - first - mean_t;
            tt += off * off;
            tv += off * (value - constant);
        }
        let slope = tv / tt;
        Trend { constant, line: Line { at_zero: constant - slope * (mean_t + first), slope } }
    }
}
