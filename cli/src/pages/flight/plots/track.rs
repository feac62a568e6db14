//! Where the vehicle was, and where the fixes say it was.

use crate::pages::flight::Report;
use maud::Markup;
use plotters::element::{Circle, PathElement, Text};
use plotters::series::LineSeries;
use plotters::style::{Color, IntoFont};
use plumbline_charts::plot::{Axes, INK, PlotError, RECTIFIED, REFUSED, UNRECTIFIED, plain, plot};

/// Room around the track, as a share of its larger side.
const ROOM: f64 = 0.08;
/// Narrowest picture, metres: a hovering vehicle stays a point.
const SIDE_MIN_M: f64 = 20.0;

impl Report<'_> {
    pub(in crate::pages::flight) fn track(&self) -> Result<Markup, PlotError> {
        let [east, north] = self.setup.tile_centre;
        let step = self.step();
        let records = || self.flight.frames.iter().step_by(step);
        let truth: Vec<(f64, f64)> = records().map(|r| (r.truth.east_m - east, r.truth.north_m - north)).collect();
        let fix = |record: &plumbline_sim::run::FrameRecord| record.report.and_then(|report| report.fix);
        let fixes: Vec<(f64, f64)> =
            records().filter_map(fix).map(|fix| (f64::from(fix[0]), f64::from(fix[1]))).collect();
        let refused: Vec<(f64, f64)> =
            records().zip(&truth).filter(|(record, _)| fix(record).is_none()).map(|(_, &at)| at).collect();

        let all = || truth.iter().chain(&fixes);
        let [left, right] = extent(all().map(|at| at.0));
        let [bottom, top] = extent(all().map(|at| at.1));
        let half = 0.5 * ((right - left).max(top - bottom) * (1.0 + 2.0 * ROOM)).max(SIDE_MIN_M);
        let (col, row) = (0.5 * (left + right), 0.5 * (bottom + top));
        let axes = Axes {
            x: col - half..col + half,
            y: row - half..row + half,
            x_text: "east (m)",
            y_text: "north (m)",
            x_label: &|value| plain(*value),
        };
        plot("Track: north over east, metres", &axes, |chart| {
            chart.draw_series(LineSeries::new(truth.iter().copied(), UNRECTIFIED.stroke_width(4)))?;
            chart.draw_series(fixes.iter().map(|&at| Circle::new(at, 7, RECTIFIED.filled())))?;
            chart.draw_series(refused.iter().map(|&at| Circle::new(at, 9, REFUSED.stroke_width(3))))?;
            // North arrow, top right.
            let at = |x: f64, y: f64| (col + half * x, row + half * y);
            let arrow = [at(0.9, 0.72), at(0.9, 0.93), at(0.88, 0.88), at(0.92, 0.88), at(0.9, 0.93)];
            chart.draw_series([PathElement::new(arrow.to_vec(), INK.stroke_width(3))])?;
            let letter = ("sans-serif", plumbline_charts::plot::FONT).into_font().color(&INK);
            chart.draw_series([Text::new("N", at(0.8, 0.92), letter)])?;
            Ok(())
        })
    }
}

/// Smallest and largest; 0 of nothing.
fn extent(values: impl Iterator<Item = f64>) -> [f64; 2] {
    let [low, high] = values
        .filter(|value| value.is_finite())
        .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], value| [low.min(value), high.max(value)]);
    if low <= high { [low, high] } else { [0.0, 0.0] }
}
