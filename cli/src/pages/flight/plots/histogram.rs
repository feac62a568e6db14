//! How the matching errors are spread, on a logarithmic axis: rectified and unrectified ones lie decades apart.

use crate::pages::flight::{Report, paper};
use maud::Markup;
use plotters::element::PathElement;
use plotters::style::Color;
use plumbline_charts::plot::{Axes, PAPER, PlotError, RECTIFIED, UNRECTIFIED, bars, from_zero, plain, plot};
use plumbline_sim::score::length;

/// Lower border of the first class as a power of ten, pixels; smaller errors are counted in it.
const FIRST: f64 = -2.0;
/// Classes of a decade.
const PER_DECADE: f64 = 6.0;
/// Classes: up to 21.5 px; larger errors are counted in the last.
const CLASSES: usize = 20;

/// Errors of each class.
fn classes(errors: impl Iterator<Item = f64>) -> [usize; CLASSES] {
    let mut counts = [0; CLASSES];
    for error in errors.filter(|error| error.is_finite()) {
        // A cast from a float saturates: an error of 0 falls into the first class.
        let class = ((error.log10() - FIRST) * PER_DECADE).floor() as usize;
        counts[class.min(CLASSES - 1)] += 1;
    }
    counts
}

impl Report<'_> {
    pub(in crate::pages::flight) fn histogram(&self) -> Result<Markup, PlotError> {
        let raw = classes(self.scored.iter().filter_map(|s| s.raw_px).map(length));
        let accepted = self.scored.iter().filter(|s| s.accepted);
        let rectified = classes(accepted.filter_map(|s| s.error_px).map(length));
        let axes = Axes {
            x: FIRST..FIRST + CLASSES as f64 / PER_DECADE,
            y: from_zero(raw.iter().chain(&rectified).map(|&count| count as f64)),
            x_text: "matching error (px of the reference)",
            y_text: "frames",
            x_label: &|power| plain(10f64.powf(*power)),
            y_label: &|value| plain(*value),
        };
        plot("Histogram of the matching errors, pixels, logarithmic", &axes, |chart| {
            for (counts, colour) in [(raw, UNRECTIFIED), (rectified, RECTIFIED)] {
                let left = |class: usize| FIRST + class as f64 / PER_DECADE;
                let filled = counts.into_iter().enumerate().filter(|&(_, count)| count > 0);
                bars(
                    chart,
                    filled.map(|(class, count)| [(left(class), 0.0), (left(class + 1), count as f64)]),
                    colour,
                )?;
            }
            let top = axes.y.end;
            chart.draw_series([paper::RAW_PX, paper::RECTIFIED_PX].map(|px| {
                let at = px.log10();
                PathElement::new(vec![(at, 0.0), (at, top)], PAPER.stroke_width(4))
            }))?;
            Ok(())
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_error_is_counted_once_and_in_its_class() {
        let counts = classes([0.0, 0.0100001, 0.101, 1.01, 50.0, f64::INFINITY].into_iter());
        assert_eq!(counts.iter().sum::<usize>(), 5);
        assert_eq!([counts[0], counts[6], counts[12], counts[CLASSES - 1]], [2, 1, 1, 1]);
    }
}
