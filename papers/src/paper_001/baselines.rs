//! Ways from samples to a curve, judged between the samples against the curve without noise.

use super::track::Simulation;
use plumbline_survey::smooth::{Alpha, Fit, SmoothError};

/// Instants of each interval at which a curve is judged: tenths, the sample at its beginning among them.
const PARTS: usize = 10;

/// Root mean squares between samples, in the simulation's unit.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Judged {
    /// Lines from sample to sample.
    pub linear: f64,
    /// A parabola through three samples, for the two intervals between them.
    pub quadratic: f64,
    /// The natural cubic spline through all samples.
    pub spline: f64,
    /// The fit with second differences, alpha by GCV.
    pub d2: Fitted,
    /// As above with third differences.
    pub d3: Fitted,
}

/// A fit and how good it is.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Fitted {
    /// Root mean square between samples.
    pub rms: f64,
    /// Effective number of parameters.
    pub edf: f64,
    /// Decimal logarithm of alpha.
    pub log_alpha: f64,
    /// √(V'V / (n - tr H)).
    pub sigma0: f64,
    /// √(V'V / n).
    pub plain_m: f64,
}

/// All of them on one simulation.
///
/// # Errors
/// None for samples with noise; what the fit refuses is passed on.
pub fn judged(simulation: &Simulation) -> Result<Judged, SmoothError> {
    let (t, y) = (simulation.instants(), simulation.observed());
    let between = between(&t);
    let rms = |value: &dyn Fn(usize, f64) -> f64| {
        let squares = between.iter().map(|&(i, t_s)| (value(i, t_s) - simulation.truth(t_s)).powi(2));
        (squares.sum::<f64>() / between.len() as f64).sqrt()
    };
    let fitted = |order| {
        let fit = simulation.fitted(order, Alpha::Gcv)?;
        let rms = rms(&|_, t_s| value(&fit, t_s));
        let plain_m = (fit.vpv / y.len() as f64).sqrt();
        Ok(Fitted { rms, edf: fit.edf, log_alpha: fit.alpha.log10(), sigma0: fit.sigma0, plain_m })
    };
    // A fit that hardly smooths: its curve through the samples is the natural spline but for 1e-8 of them.
    let through = simulation.fitted(2, Alpha::Given(1e-9))?;
    Ok(Judged {
        linear: rms(&|i, t_s| lagrange(&t[i..i + 2], &y[i..i + 2], t_s)),
        quadratic: rms(&|i, t_s| {
            // An odd interval at the end is taken from the last three samples.
            let first = (i - i % 2).min(t.len() - 3);
            lagrange(&t[first..first + 3], &y[first..first + 3], t_s)
        }),
        spline: rms(&|_, t_s| value(&through, t_s)),
        d2: fitted(2)?,
        d3: fitted(3)?,
    })
}

/// The curve at an instant within the samples; no number outside, which no sum survives.
fn value(fit: &Fit, t_s: f64) -> f64 {
    fit.value(t_s).unwrap_or(f64::NAN)
}

/// Where curves are judged: interval and instant.
fn between(t: &[f64]) -> Vec<(usize, f64)> {
    let part = |i: usize, part: usize| t[i] + (t[i + 1] - t[i]) * part as f64 / PARTS as f64;
    (0..t.len() - 1).flat_map(|i| (0..PARTS).map(move |k| (i, part(i, k)))).collect()
}

/// The polynomial through all given samples.
fn lagrange(t: &[f64], y: &[f64], at: f64) -> f64 {
    let share = |i: usize| -> f64 { (0..t.len()).filter(|&j| j != i).map(|j| (at - t[j]) / (t[i] - t[j])).product() };
    (0..t.len()).map(|i| share(i) * y[i]).sum()
}

impl Judged {
    /// The mean of each figure.
    #[must_use]
    pub fn mean(all: &[Judged]) -> Judged {
        let mean = |of: &dyn Fn(&Judged) -> f64| all.iter().map(of).sum::<f64>() / all.len() as f64;
        let fitted = |which: &dyn Fn(&Judged) -> Fitted| Fitted {
            rms: mean(&|judged| which(judged).rms),
            edf: mean(&|judged| which(judged).edf),
            log_alpha: mean(&|judged| which(judged).log_alpha),
            sigma0: mean(&|judged| which(judged).sigma0),
            plain_m: mean(&|judged| which(judged).plain_m),
        };
        Judged {
            linear: mean(&|judged| judged.linear),
            quadratic: mean(&|judged| judged.quadratic),
            spline: mean(&|judged| judged.spline),
            d2: fitted(&|judged| judged.d2),
            d3: fitted(&|judged| judged.d3),
        }
    }
}
