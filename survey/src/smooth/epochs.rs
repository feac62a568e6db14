//! The instants of the samples, checked, and the differences that measure roughness on them.

use super::Order;
use super::band::Band;
use super::error::{Gap, SmoothError};

/// Spacings this near to each other are equal, in the unit of time; of spacings above 1, relative to them.
const EQUAL: f64 = 1e-6;
/// Spacings whose powers, up to the fifth, are numbers.
const SPACINGS_S: std::ops::RangeInclusive<f64> = 1e-50..=1e50;
/// A gap is a spacing above this many usual ones, unless a limit in seconds is given: 4 s of positions at 5 Hz, 0.4 s of
/// attitudes at 50 Hz.
pub const GAP_SPACINGS: f64 = 20.0;

/// Strictly increasing instants.
#[derive(Clone, Debug, PartialEq)]
pub struct Epochs {
    t_s: Vec<f64>,
    /// The spacing where it is uniform, else the median one.
    spacing_s: f64,
    uniform: bool,
}

impl Epochs {
    /// Checks `t_s`: two at least, finite, each after the one before.
    ///
    /// # Errors
    /// [`SmoothError::TooFew`], [`SmoothError::NotFinite`], [`SmoothError::NotForward`],
    /// [`SmoothError::SpacingOutOfRange`].
    pub fn new(t_s: Vec<f64>) -> Result<Self, SmoothError> {
        for (sample, t) in t_s.iter().enumerate() {
            if !t.is_finite() {
                return Err(SmoothError::NotFinite { sample, what: "time" });
            }
            if sample > 0 && *t <= t_s[sample - 1] {
                return Err(SmoothError::NotForward { sample, t_s: *t, before_s: t_s[sample - 1] });
            }
            if sample > 0 && !SPACINGS_S.contains(&(t - t_s[sample - 1])) {
                return Err(SmoothError::SpacingOutOfRange { sample, spacing_s: t - t_s[sample - 1] });
            }
        }
        let [first, .., last] = t_s[..] else {
            return Err(SmoothError::TooFew { samples: t_s.len(), order: Order::Second });
        };
        let mut spacings: Vec<f64> = t_s.windows(2).map(|pair| pair[1] - pair[0]).collect();
        let mean_s = (last - first) / spacings.len() as f64;
        let equal = (EQUAL * mean_s.max(1.0)).min(0.01 * mean_s);
        let uniform = spacings.iter().all(|spacing| (spacing - mean_s).abs() <= equal);
        let middle = spacings.len() / 2;
        let median_s = *spacings.select_nth_unstable_by(middle, f64::total_cmp).1;
        Ok(Epochs { t_s, spacing_s: if uniform { mean_s } else { median_s }, uniform })
    }

    /// The instants, seconds.
    #[must_use]
    pub fn t_s(&self) -> &[f64] {
        &self.t_s
    }

    /// The spacing where it is uniform, else the median one, seconds.
    #[must_use]
    pub fn spacing_s(&self) -> f64 {
        self.spacing_s
    }

    /// Whether all spacings are equal (to 1e-6), so that plain differences are taken.
    #[must_use]
    pub fn is_uniform(&self) -> bool {
        self.uniform
    }

    /// What counts as a gap unless a limit is given, seconds.
    #[must_use]
    pub fn usual_gap_s(&self) -> f64 {
        GAP_SPACINGS * self.spacing_s
    }

    /// Gaps longer than `limit_s` between neighbours with a weight above zero.
    #[must_use]
    pub fn gaps(&self, weights: &[f64], limit_s: f64) -> Vec<Gap> {
        let mut counting = (0..self.t_s.len()).filter(|&i| weights.get(i).is_none_or(|&weight| weight > 0.0));
        let Some(mut before) = counting.next() else { return Vec::new() };
        let mut gaps = Vec::new();
        for after in counting {
            let gap = Gap { after, from_s: self.t_s[before], to_s: self.t_s[after] };
            if gap.length_s() > limit_s {
                gaps.push(gap);
            }
            before = after;
        }
        gaps
    }

    /// R = D'D, the matrix of the penalty.
    ///
    /// Uniform epochs: rows of D are plain differences, 1 -2 1 or -1 3 -3 1.
    ///
    /// Otherwise row i is the divided difference f[t_i .. t_(i+d)] times d! h^d √(w_i / h), h being the median spacing and
    /// w_i = (t_(i+d) - t_i) / d the time that the row stands for. d! f[..] is the d-th derivative, so that
    /// alpha g'R g = alpha h^(2d-1) Σ w_i (g^(d))², a sum for the integral ∫ (g^(d))² dt with the factor
    /// lambda = alpha h^(2d-1); equal spacings give the plain differences again. For d = 2 this is Reinsch's Q R^-1 Q' with
    /// his tridiagonal R replaced by the diagonal of its row sums.
    pub(super) fn roughness(&self, order: Order) -> Band {
        let (n, d) = (self.t_s.len(), order.differences());
        let mut band = Band::zero(n, d);
        for first in 0..n.saturating_sub(d) {
            let row = if self.uniform { order.plain() } else { self.divided(order, first) };
            for a in 0..=d {
                for b in 0..=a {
                    band.add(first + a, first + b, row[a] * row[b]);
                }
            }
        }
        band
    }

    /// The scaled divided difference that begins at `first`; entries beyond the order's are zero.
    fn divided(&self, order: Order, first: usize) -> [f64; 4] {
        let d = order.differences();
        let h = self.spacing_s;
        let t = |i: usize| self.t_s[first + i] / h;
        let factorial: f64 = (1..=d).product::<usize>() as f64;
        let scale = factorial * ((t(d) - t(0)) / d as f64).sqrt();
        let mut row = [0.0; 4];
        for (j, entry) in row.iter_mut().enumerate().take(d + 1) {
            let product: f64 = (0..=d).filter(|&m| m != j).map(|m| t(j) - t(m)).product();
            *entry = scale / product;
        }
        row
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn divided_differences_of_equal_spacings_are_plain_ones() {
        let epochs = Epochs::new((0..6).map(|i| 3.0 + 0.25 * f64::from(i)).collect()).unwrap();
        assert!(epochs.is_uniform() && epochs.spacing_s() == 0.25);
        for order in [Order::Second, Order::Third] {
            let (plain, divided) = (order.plain(), epochs.divided(order, 1));
            assert!(plain.iter().zip(&divided).all(|(p, q)| (p - q).abs() < 1e-12), "{plain:?} {divided:?}");
        }
    }

    #[test]
    fn uniform_means_to_a_millionth() {
        let with = |off: f64| Epochs::new(vec![0.0, 0.2, 0.4 + off, 0.6, 0.8]).unwrap().is_uniform();
        assert!(with(0.0) && with(9e-7) && !with(2e-6));
        // A spacing of a microsecond is not uniform because it is short.
        assert!(!Epochs::new(vec![0.0, 1e-6, 3e-6, 4e-6]).unwrap().is_uniform());
    }

    #[test]
    fn times_are_checked() {
        let refused = |t: &[f64]| Epochs::new(t.to_vec()).unwrap_err().to_string();
        assert_eq!(refused(&[0.0, 1.0, 1.0]), "sample 3: the time 1 is repeated");
        assert_eq!(refused(&[0.0, 1.0, 0.5]), "sample 3: the time 0.5 goes back, 1 stands before it");
        assert_eq!(refused(&[0.0, f64::NAN, 0.5]), "sample 2: the time is not a finite number");
        assert_eq!(refused(&[0.0, 1e-200]), "sample 2: 1e-200 after the time before, beyond the range of numbers");
        assert!(refused(&[-1e308, 0.0, 1e308]).contains("beyond the range"));
        assert_eq!(refused(&[0.0]), "1 sample, but order 2 needs 3 at least");
        assert_eq!(refused(&[]), "0 samples, but order 2 needs 3 at least");
    }

    #[test]
    fn gaps_are_between_samples_that_count() {
        let epochs = Epochs::new(vec![0.0, 1.0, 2.0, 5.0, 6.0]).unwrap();
        let ends = |weights: &[f64], limit| -> Vec<_> {
            epochs.gaps(weights, limit).iter().map(|gap| (gap.from_s, gap.to_s, gap.after)).collect()
        };
        assert_eq!(ends(&[1.0; 5], 2.0), [(2.0, 5.0, 3)]);
        assert_eq!(ends(&[1.0, 0.0, 1.0, 0.0, 1.0], 1.5), [(0.0, 2.0, 2), (2.0, 6.0, 4)]);
        assert!(ends(&[0.0, 0.0, 0.0, 1.0, 0.0], 0.5).is_empty() && ends(&[1.0; 5], 3.0).is_empty());
    }
}
