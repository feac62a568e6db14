//! Figures 1 to 4: the simulated track, its errors, the fitted track, its corrections.

use super::SEEDS;
use super::track::position;
use plumbline_charts::panels::{FITTED, MEASURED, Mark, Panel, svg};
use plumbline_survey::smooth::{Alpha, Fit};

/// Period of the track, seconds.
const PERIOD_S: f64 = 20.0;
/// Points of the curve to an interval of the samples.
const PARTS: usize = 4;

/// The four pictures by name, SVG, of the first seed.
///
/// # Errors
/// What the drawing library or the fit refuses: nothing that is known of.
pub fn pictures() -> Result<Vec<(&'static str, String)>, String> {
    let simulation = position(PERIOD_S, *SEEDS.start());
    let (t, observed) = (simulation.instants(), simulation.observed());
    let fit = simulation.fitted(2, Alpha::Gcv).map_err(|error| error.to_string())?;
    let dense: Vec<f64> = dense(&t);
    let over = |values: &dyn Fn(usize) -> f64| -> Vec<(f64, f64)> { (0..t.len()).map(|i| (t[i], values(i))).collect() };
    let truth = Mark::Line(dense.iter().map(|&t| (t, simulation.truth(t))).collect());
    let errors = Mark::Line(over(&|i| observed[i] - simulation.truth(t[i])));
    let samples = Mark::Dots(over(&|i| observed[i]));
    let band: Vec<(f64, f64)> = over(&|i| 2.0 * fit.at_sample(i).sigma);
    let left = Mark::Line(
        dense.iter().map(|&t| (t, fit.value(t).map_or(f64::NAN, |value| value - simulation.truth(t)))).collect(),
    );
    let panel = |caption: String, y_text: &str, share, marks| Panel { caption, y_text: y_text.into(), share, marks };
    let figures = [
        (
            "figure_1",
            vec![panel("Figure 1: simulated Z of the projection centre".into(), "Z (m)", 4, vec![(truth, MEASURED)])],
        ),
        (
            "figure_2",
            vec![panel("Figure 2: simulated errors of GPS in Z".into(), "error (m)", 4, vec![(errors, MEASURED)])],
        ),
        (
            "figure_3",
            vec![
                panel(fitted(&fit), "Z (m)", 4, vec![(samples, MEASURED), (Mark::Line(curve(&fit, &dense)), FITTED)]),
                panel(
                    "fitted minus true Z, and two sigmas".into(),
                    "error (m)",
                    2,
                    vec![
                        (Mark::Band(band.into_iter().map(|(t, two)| (t, -two, two)).collect()), FITTED),
                        (left, FITTED),
                    ],
                ),
            ],
        ),
        (
            "figure_4",
            vec![panel(corrected(&fit, t.len()), "V (m)", 4, vec![(Mark::Line(over(&|i| fit.residuals[i])), FITTED)])],
        ),
    ];
    let draw = |(name, panels): (&'static str, Vec<Panel>)| Ok((name, svg(t[0]..t[t.len() - 1], "t (s)", &panels)?));
    figures.into_iter().map(draw).collect()
}

/// What stands above figure 3.
fn fitted(fit: &Fit) -> String {
    format!(
        "Figure 3: samples (grey) and fitted Z (blue); second differences, alpha = {:.2} by GCV, {:.1} parameters",
        fit.alpha, fit.edf
    )
}

/// What stands above figure 4, of so many samples.
fn corrected(fit: &Fit, count: usize) -> String {
    format!(
        "Figure 4: corrections V of the samples; sigma0 = {:.4} m, sqrt(V'V / n) = {:.4} m",
        fit.sigma0,
        (fit.vpv / count as f64).sqrt()
    )
}

/// The samples' instants and some between them.
fn dense(t: &[f64]) -> Vec<f64> {
    let parts = |i: usize| (0..PARTS).map(move |k| t[i] + (t[i + 1] - t[i]) * k as f64 / PARTS as f64);
    (0..t.len() - 1).flat_map(parts).collect()
}

fn curve(fit: &Fit, instants: &[f64]) -> Vec<(f64, f64)> {
    instants.iter().map(|&t| (t, fit.value(t).unwrap_or(f64::NAN))).collect()
}
