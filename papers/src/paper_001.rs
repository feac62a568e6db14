//! Paper 001: its simulation in the Z channel, what it says of it, and what the fit gains over interpolation.
//!
//! [`track`] simulates, [`baselines`] interpolate and fit, [`slips`] are what the paper's text gets wrong, [`figures`] its
//! figures 1 to 4. The paper prints one number, so most rows have no other to stand beside.

pub mod figures;
pub mod baselines;
pub mod slips;
pub mod track;

use super::Row;
use baselines::{Judged, judged};
use serde::Serialize;
use track::{Simulation, attitude, position};

/// Seeds of the noise; every figure is the mean over them.
pub const SEEDS: std::ops::RangeInclusive<u64> = 1..=8;
/// Periods of the track, seconds.
pub const PERIODS_S: [f64; 4] = [5.0, 10.0, 20.0, 60.0];
/// The period that the rows on the paper's text are given for.
const PERIOD_S: f64 = 20.0;
/// Where √(V'V / n) is the paper's 0.11 m.
const ALPHA_OF_011: f64 = 1.820;
/// What the paper says of its residuals, metres.
const PAPER_SIGMA_M: f64 = 0.11;

/// Everything that was reproduced.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Reproduction {
    /// Number of the paper.
    pub paper: &'static str,
    /// Seeds of the noise.
    pub seeds: Vec<u64>,
    /// The rows, table by table.
    pub rows: Vec<Row>,
}

/// Paper 001.
///
/// # Errors
/// None for these samples; what the fit refuses is passed on.
pub fn reproduction() -> Result<Reproduction, plumbline_survey::smooth::SmoothError> {
    let mut rows = Vec::new();
    let (mut tables, mut residuals) = (Vec::new(), Vec::new());
    for period_s in PERIODS_S {
        let judged = mean_of(|seed| position(period_s, seed))?;
        tables.extend(interpolants(&format!("T = {period_s} s: "), "m", 1.0, &judged));
        residuals.push((period_s, judged));
    }
    rows.extend(sigma_rows(&residuals)?);
    rows.extend(gains(&residuals));
    rows.extend(slips::rows());
    rows.extend(tables);
    rows.extend(interpolants("attitude: ", "mdeg", 1e3, &mean_of(attitude)?));
    Ok(Reproduction { paper: "001", seeds: SEEDS.collect(), rows })
}

/// The mean over all seeds.
fn mean_of(simulation: impl Fn(u64) -> Simulation) -> Result<Judged, plumbline_survey::smooth::SmoothError> {
    let all = SEEDS.map(|seed| judged(&simulation(seed))).collect::<Result<Vec<_>, _>>()?;
    Ok(Judged::mean(&all))
}

const SECTION_3: &str = "Section 3, residuals";
const INTERPOLANTS: &str = "Interpolants";

/// The paper's one number, and what it is.
fn sigma_rows(all: &[(f64, Judged)]) -> Result<Vec<Row>, plumbline_survey::smooth::SmoothError> {
    let mut rows = Vec::new();
    let ours: Vec<String> =
        all.iter().map(|(period_s, judged)| format!("{:.3} at {period_s} s", judged.d2.plain_m)).collect();
    for (period_s, judged) in all.iter().filter(|(period_s, _)| *period_s == PERIOD_S) {
        rows.push(Row {
decimals: None,            table: SECTION_3,
            quantity: format!("sigma0 = sqrt(V'V / (n - tr H)), T = {period_s} s, D2 by GCV, m"),
            paper: Some(PAPER_SIGMA_M),
            ours: Some(judged.d2.sigma0),
            difference: Some(format!(
                "0.11 m is called a unit weight variance factor but is a standard deviation, and no correct sigma0: the \
                 noise itself, even within 0.25 m, has {:.4} m. It is sqrt(V'V / n), without the degrees of freedom that \
                 the curve takes; by GCV that is {} (the paper gives neither period nor amplitude nor alpha)",
                track::NOISE_M / 3f64.sqrt(),
                ours.join(", ")
            )),
        });
    }
    let (mut plain_m, mut edf) = (0.0, 0.0);
    let count = SEEDS.count() as f64;
    for seed in SEEDS {
        let fit = position(PERIOD_S, seed).fitted(2, plumbline_survey::smooth::Alpha::Given(ALPHA_OF_011))?;
        plain_m += (fit.vpv / fit.values.len() as f64).sqrt() / count;
        edf += fit.edf / count;
    }
    rows.push(Row {
        decimals: None,
        table: SECTION_3,
        quantity: format!("sqrt(V'V / n), T = {PERIOD_S} s, D2 with alpha = {ALPHA_OF_011} ({edf:.1} parameters), m"),
        paper: Some(PAPER_SIGMA_M),
        ours: Some(plain_m),
        difference: None,
    });
    Ok(rows)
}

/// By how much the fit is better than lines between the samples: the paper's claim, which it gives no number for.
fn gains(all: &[(f64, Judged)]) -> Vec<Row> {
    let gain = |name: &str, of: &dyn Fn(&Judged) -> f64| {
        let factors = || all.iter().map(|(_, judged)| judged.linear / of(judged));
        [("least", factors().fold(f64::INFINITY, f64::min)), ("most", factors().fold(0.0, f64::max))].map(
            |(which, factor)| Row {
                decimals: None,
                table: SECTION_3,
                quantity: format!("rms of linear interpolation / rms of {name}, {which} of all periods"),
                paper: None,
                ours: Some(factor),
                difference: None,
            },
        )
    };
    let d2 = gain("D2 by GCV", &|judged| judged.d2.rms);
    d2.into_iter().chain(gain("D3 by GCV", &|judged| judged.d3.rms)).collect()
}

/// The rows of one simulation; rms between samples in `unit`, which is `scale` times the simulation's.
fn interpolants(of: &str, unit: &str, scale: f64, judged: &Judged) -> Vec<Row> {
    let row = |quantity: String, ours: f64| Row {
        decimals: None,
        table: INTERPOLANTS,
        quantity,
        paper: None,
        ours: Some(ours),
        difference: None,
    };
    let mut rows = vec![
        row(format!("{of}linear, rms between samples, {unit}"), scale * judged.linear),
        row(format!("{of}piecewise quadratic, rms between samples, {unit}"), scale * judged.quadratic),
        row(format!("{of}natural spline, rms between samples, {unit}"), scale * judged.spline),
    ];
    for (name, fit) in [("D2", &judged.d2), ("D3", &judged.d3)] {
        rows.push(row(format!("{of}{name} GCV, rms between samples, {unit}"), scale * fit.rms));
        rows.push(row(format!("{of}{name} GCV, effective parameters"), fit.edf));
        rows.push(row(format!("{of}{name} GCV, log10 alpha"), fit.log_alpha));
    }
    rows.push(row(format!("{of}D2 GCV, sqrt(V'V / (n - tr H)), {unit}"), scale * judged.d2.sigma0));
    rows.push(row(format!("{of}D2 GCV, sqrt(V'V / n), {unit}"), scale * judged.d2.plain_m));
    rows
}

#[cfg(test)]
mod tests;
