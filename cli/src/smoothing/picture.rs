//! Samples, curve, band of two sigmas and residuals of each column.

use super::Smoothed;
use plumbline_charts::panels::{FITTED, LEFT_OUT, MEASURED, Mark, Panel, svg};
use plumbline_survey::smooth::{Estimate, Fit};

/// Most samples that are drawn one by one.
const DRAWN_MAX: usize = 4000;
/// Up to so many samples the curve is drawn between them too, at quarters.
const CLOSE_MAX: usize = 600;

impl Smoothed {
    /// The picture, SVG.
    ///
    /// # Errors
    /// As [`svg`].
    pub fn picture(&self) -> Result<String, String> {
        let t = &self.samples.t_s;
        let panels: Vec<Panel> = (0..self.columns.len()).flat_map(|column| self.panels(column)).collect();
        svg(t[0]..t[t.len() - 1], &self.time, &panels)
    }

    /// The two panels of a column.
    fn panels(&self, column: usize) -> [Panel; 2] {
        let (name, fit, samples) = (&self.columns[column], &self.fits[column], &self.samples.channels[column]);
        let t = &self.samples.t_s;
        let step = t.len().div_ceil(DRAWN_MAX);
        let counts = |&i: &usize| self.samples.weights[i] > 0.0;
        let is_out = |i: &usize| fit.rejected.binary_search(i).is_ok();
        let drawn = || (0..t.len()).step_by(step).filter(counts);
        let kept: Vec<usize> = drawn().filter(|i| !is_out(i)).collect();
        let points = |all: &[usize], value: &dyn Fn(usize) -> f64| all.iter().map(|&i| (t[i], value(i))).collect();
        let curve = curve(fit, t, step);
        let two = if fit.tells_noise() { 2.0 } else { 0.0 };
        let band = curve.iter().map(|(t, at)| (*t, at.value - two * at.sigma, at.value + two * at.sigma)).collect();
        let spread = curve.iter().map(|(t, at)| (*t, -two * at.sigma, two * at.sigma)).collect();
        let sigma0 = if fit.tells_noise() { format!("sigma0 {:.4e}", fit.sigma0) } else { "no sigma".to_owned() };
        let line = curve.iter().map(|(t, at)| (*t, at.value)).collect();
        let sparse = if step > 1 { format!("; one sample of {step} is drawn") } else { String::new() };
        let upper = Panel {
            caption: format!(
                "{name}: samples (grey), curve and its two-sigma band (blue){}; alpha {:.3e}, edf {:.1}, {sigma0}{sparse}",
                if fit.rejected.is_empty() { "" } else { ", left out (red)" },
                fit.alpha,
                fit.edf
            ),
            y_text: name.clone(),
            share: 4,
            marks: vec![
                (Mark::Band(band), FITTED),
                (Mark::Dots(points(&kept, &|i| samples[i])), MEASURED),
                (Mark::Line(line), FITTED),
                (Mark::Rings(points(&fit.rejected, &|i| samples[i])), LEFT_OUT),
            ],
        };
        let lower = Panel {
            caption:
                "residuals, curve minus sample (grey); two sigmas of the curve (blue area) and of a sample (lines)"
                    .to_owned(),
            y_text: format!("residual of {name}"),
            share: 2,
            marks: vec![
                (Mark::Band(spread), FITTED),
                (Mark::Level(-two * fit.sigma0), FITTED),
                (Mark::Level(two * fit.sigma0), FITTED),
                (Mark::Dots(points(&kept, &|i| fit.residuals[i])), MEASURED),
            ],
        };
        [upper, lower]
    }
}

/// The curve where it is drawn.
fn curve(fit: &Fit, t: &[f64], step: usize) -> Vec<(f64, Estimate)> {
    let mut curve = Vec::new();
    for i in (0..t.len()).step_by(step) {
        curve.push((t[i], fit.at_sample(i)));
        if t.len() > CLOSE_MAX || i + 1 == t.len() {
            continue;
        }
        let between = [0.25, 0.5, 0.75].map(|share| t[i] + share * (t[i + 1] - t[i]));
        curve.extend(between.into_iter().filter_map(|t| Some((t, fit.at(t).ok()?))));
    }
    curve
}
