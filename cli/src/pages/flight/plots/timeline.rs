//! How far off each fix was, and how far off it might have been by its own account.

use crate::pages::flight::Report;
use maud::Markup;
use plotters::element::{Circle, PathElement};
use plotters::series::LineSeries;
use plotters::style::Color;
use plumbline_charts::plot::{Axes, PAPER, PlotError, RECTIFIED, REFUSED, from_zero, plain, plot};
use plumbline_sim::score::length;

/// Height of the tick of a refused frame, as a share of the axis.
const TICK: f64 = 0.035;

impl Report<'_> {
    pub(in crate::pages::flight) fn timeline(&self) -> Result<Markup, PlotError> {
        let step = self.step();
        let frames = || self.flight.frames.iter().zip(self.scored).step_by(step);
        let errors: Vec<(f64, f64)> =
            frames().filter_map(|(_, s)| Some((f64::from(s.frame), length(s.error_m?)))).collect();
        let sigmas: Vec<(f64, f64)> = frames()
            .filter_map(|(record, scored)| {
                let fix = record.report?.fix?;
                let variance_m2 = fix.variance_east_m2 + fix.variance_north_m2;
                Some((f64::from(scored.frame), f64::from(variance_m2).sqrt()))
            })
            .filter(|(_, sigma)| sigma.is_finite())
            .collect();
        let drawn = self.drawn().into_iter().map(|index| &self.scored[index]);
        let refused: Vec<f64> = drawn.filter(|s| !s.accepted).map(|s| f64::from(s.frame)).collect();
        let last = self.scored.last().map_or(1, |scored| scored.frame.max(1));
        let axes = Axes {
            x: 0.0..f64::from(last),
            y: from_zero(errors.iter().chain(&sigmas).map(|point| point.1)),
            x_text: "frame",
            y_text: "ground error (m)",
            x_label: &|value| plain(*value),
            y_label: &|value| plain(*value),
        };
        plot("Ground error of each fix over the frames, metres", &axes, |chart| {
            // A refused frame interrupts the line.
            for run in sigmas.chunk_by(|a, b| b.0 - a.0 < step as f64 + 0.5) {
                chart.draw_series(LineSeries::new(run.iter().copied(), PAPER.stroke_width(4)))?;
            }
            chart.draw_series(errors.iter().map(|&at| Circle::new(at, 7, RECTIFIED.filled())))?;
            let tick = TICK * axes.y.end;
            chart.draw_series(
                refused
                    .iter()
                    .map(|&frame| PathElement::new(vec![(frame, 0.0), (frame, tick)], REFUSED.stroke_width(4))),
            )?;
            Ok(())
        })
    }
}
