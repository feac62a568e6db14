//! How long the frames were exposed, where that changed.

use crate::pages::flight::Report;
use maud::Markup;
use plotters::element::Circle;
use plotters::series::LineSeries;
use plotters::style::Color;
use plumbline_charts::plot::{Axes, PAPER, PlotError, RECTIFIED, from_zero, plain, plot};

impl Report<'_> {
    /// Nothing of a flight whose frames were all exposed alike.
    pub(in crate::pages::flight) fn exposures(&self) -> Result<Option<Markup>, PlotError> {
        if self.summary.exposure_us.changes == 0 {
            return Ok(None);
        }
        let frames = || self.flight.frames.iter().step_by(self.step());
        let ms = |us: f64| 1e-3 * us;
        let exposures: Vec<(f64, f64)> = frames()
            .map(|frame| &frame.exposure)
            .map(|e| (f64::from(e.frame), ms((e.close_us - e.open_us) as f64)))
            .collect();
        // Where nothing moves no exposure is too long.
        let highest = 2.0 * exposures.iter().map(|point| point.1).fold(0.0, f64::max);
        let sharp: Vec<(f64, f64)> = frames()
            .filter_map(|f| Some((f64::from(f.exposure.frame), ms(f64::from(f.instant?.motion?.exposure_max_us)))))
            .map(|(frame, sharp)| (frame, sharp.min(highest)))
            .collect();
        let last = self.scored.last().map_or(1, |scored| scored.frame.max(1));
        let axes = Axes {
            x: 0.0..f64::from(last),
            y: from_zero(exposures.iter().chain(&sharp).map(|point| point.1)),
            x_text: "frame",
            y_text: "exposure (ms)",
            x_label: &|value| plain(*value),
            y_label: &|value| plain(*value),
        };
        plot("Exposure of each frame, milliseconds", &axes, |chart| {
            chart.draw_series(LineSeries::new(sharp.iter().copied(), PAPER.stroke_width(3)))?;
            chart.draw_series(exposures.iter().map(|&at| Circle::new(at, 7, RECTIFIED.filled())))?;
            Ok(())
        })
        .map(Some)
    }
}
