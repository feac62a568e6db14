//! Where the vehicle was, and where the fixes say it was.

use crate::pages::flight::Report;
use maud::Markup;
use plotters::element::{Circle, Text};
use plotters::series::LineSeries;
use plotters::style::{Color, IntoFont};
use plumbline_charts::map::Map;
use plumbline_charts::plot::{FONT, INK, PlotError, RECTIFIED, REFUSED, UNRECTIFIED};

/// Margin around the track, as a share of its larger side. Chosen: keeps a ring on the outermost frame inside the picture.
const MARGIN: f64 = 0.08;
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
            records().filter_map(fix).map(|fix| (f64::from(fix.east_m), f64::from(fix.north_m))).collect();
        let refused: Vec<(f64, f64)> =
            records().zip(&truth).filter(|(record, _)| fix(record).is_none()).map(|(_, &at)| at).collect();

        let map = Map::around(truth.iter().chain(&fixes), MARGIN, SIDE_MIN_M);
        map.plot("Track: north over east, metres", |chart| {
            chart.draw_series(LineSeries::new(truth.iter().copied(), UNRECTIFIED.stroke_width(4)))?;
            chart.draw_series(fixes.iter().map(|&at| Circle::new(at, 7, RECTIFIED.filled())))?;
            chart.draw_series(refused.iter().map(|&at| Circle::new(at, 9, REFUSED.stroke_width(3))))?;
            map.north_arrow(chart, 0.9, 0.72..0.93)?;
            let letter = ("sans-serif", FONT).into_font().color(&INK);
            chart.draw_series([Text::new("N", map.at(0.8, 0.92), letter)])?;
            Ok(())
        })
    }
}
