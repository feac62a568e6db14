//! How redundancies and standardised residuals are spread.

use super::Page;
use maud::{Markup, html};
use plotters::series::LineSeries;
use plotters::style::{Color, RGBColor};
use plumbline_charts::plot::{Axes, PAPER, RECTIFIED, UNRECTIFIED, bars, from_zero, plain, plot};

/// Classes of a histogram.
const CLASSES: usize = 40;
/// Standardised residuals beyond it are counted in the outer classes.
const REACH: f64 = 5.0;
/// Points of a curve.
const CURVE: usize = 200;

/// Values over equal classes of a range.
struct Histogram {
    from: f64,
    width: f64,
    counts: [usize; CLASSES],
}

impl Histogram {
    /// Counts values; those outside fall into the outer classes.
    fn new(values: impl Iterator<Item = f64>, from: f64, to: f64) -> Self {
        let width = (to - from) / CLASSES as f64;
        let mut counts = [0; CLASSES];
        for value in values.filter(|value| value.is_finite()) {
            // A cast from a float saturates.
            counts[(((value - from) / width).floor() as usize).min(CLASSES - 1)] += 1;
        }
        Histogram { from, width, counts }
    }

    /// The picture, with a curve of counts over it.
    fn plot(&self, label: &str, x_text: &str, colour: RGBColor, curve: &[(f64, f64)]) -> Markup {
        let left = |class: usize| self.from + self.width * class as f64;
        let heights = self.counts.iter().map(|&count| count as f64).chain(curve.iter().map(|at| at.1));
        let axes = Axes {
            x: self.from..left(CLASSES),
            y: from_zero(heights),
            x_text,
            y_text: "image coordinates",
            x_label: &|value| plain(*value),
            y_label: &|value| plain(*value),
        };
        let drawn = plot(label, &axes, |chart| {
            let filled = self.counts.iter().enumerate().filter(|(_, count)| **count > 0);
            bars(chart, filled.map(|(class, &count)| [(left(class), 0.0), (left(class + 1), count as f64)]), colour)?;
            chart.draw_series(LineSeries::new(curve.iter().copied(), PAPER.stroke_width(4)))?;
            Ok(())
        });
        drawn.unwrap_or_else(|error| html! { p class="note" { (error) } })
    }
}

impl Page<'_> {
    pub(super) fn redundancy_histogram(&self) -> Markup {
        let values = self.calibration.residuals.iter().flat_map(|residual| residual.redundancy);
        let histogram = Histogram::new(values, 0.0, 1.0);
        histogram.plot("Histogram of the redundancy numbers", "redundancy number", UNRECTIFIED, &[])
    }

    pub(super) fn standardised_histogram(&self) -> Markup {
        let values: Vec<f64> = self.standardised().collect();
        let histogram = Histogram::new(values.iter().copied(), -REACH, REACH);
        let expected = values.len() as f64 * histogram.width / std::f64::consts::TAU.sqrt();
        let curve: Vec<(f64, f64)> = (0..=CURVE)
            .map(|k| 2.0 * REACH * (k as f64 / CURVE as f64 - 0.5))
            .map(|at| (at, expected * (-0.5 * at * at).exp()))
            .collect();
        let label = "Histogram of the standardised residuals with the normal curve";
        histogram.plot(label, "standardised residual", RECTIFIED, &curve)
    }

    /// Standardised residuals of the image coordinates that others control.
    pub(super) fn standardised(&self) -> impl Iterator<Item = f64> {
        self.calibration.residuals.iter().flat_map(|residual| residual.standardised).filter(|value| *value != 0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_value_is_counted_once_and_in_its_class() {
        let values = [-9.0, -5.0, -0.01, 0.01, 0.26, 9.0, f64::NAN];
        let counts = Histogram::new(values.into_iter(), -REACH, REACH).counts;
        assert_eq!(counts.iter().sum::<usize>(), 6);
        assert_eq!([counts[0], counts[19], counts[20], counts[21], counts[CLASSES - 1]], [2, 1, 1, 1, 1]);
    }
}
