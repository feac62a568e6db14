//! Where the frames were taken, over the reference.

use super::Page;
use crate::pages::tile;
use maud::{Markup, html};
use plotters::element::{Circle, PathElement};
use plotters::series::LineSeries;
use plotters::style::Color;
use plumbline_charts::map::Map;
use plumbline_charts::plot::{INK, PAPER, PlotError, RECTIFIED, REFUSED, UNRECTIFIED};

/// Margin around the places, as a share of their larger extent; narrowest picture, metres.
const MARGIN: f64 = 0.12;
const SIDE_MIN_M: f64 = 40.0;
/// Offsets are drawn so many times as long.
const LONGER: f64 = 5.0;

impl Page<'_> {
    pub(super) fn map(&self) -> Result<Markup, PlotError> {
        let [east, north] = self.setup.tile_centre;
        let places: Vec<(f64, f64)> =
            self.table.rows.iter().map(|row| (row.place_m[0] - east, row.place_m[1] - north)).collect();
        let refused = places.iter().zip(&self.verdict.frames).filter(|(_, frame)| frame.fix.is_err());
        let ends = self.verdict.fixes().map(|(index, fix)| {
            let (at, [off_east, off_north]) = (places[index], fix.offset_m);
            (at, (at.0 + LONGER * off_east, at.1 + LONGER * off_north), self.verdict.is_right(fix))
        });
        let colour = |is_right: bool| if is_right { RECTIFIED } else { REFUSED };
        let map = Map::around(places.iter(), MARGIN, SIDE_MIN_M);
        let svg = map.plot_over(
            "Frames over the reference: north over east, metres",
            |at| tile::grey(self.setup, at),
            |chart| {
                chart.draw_series(LineSeries::new(places.iter().copied(), PAPER.stroke_width(3)))?;
                chart.draw_series(refused.map(|(at, _)| Circle::new(*at, 8, UNRECTIFIED.filled())))?;
                chart
                    .draw_series(ends.clone().map(|(at, end, is_right)| {
                        PathElement::new(vec![at, end], colour(is_right).stroke_width(4))
                    }))?;
                chart.draw_series(ends.map(|(at, _, is_right)| Circle::new(at, 8, colour(is_right).filled())))?;
                chart.draw_series(places.first().iter().map(|at| Circle::new(**at, 16, INK.stroke_width(4))))?;
                map.north_arrow(chart, 0.9, 0.72..0.93)
            },
        )?;
        Ok(html! {
            figure { (svg) figcaption {
                b { "Frames over the reference" } ", metres from the tile’s centre; a ring around the first one. "
                span class="key dot k-ours" {} "right, "
                span class="key dot k-bad" {} "wrong, "
                span class="key dot k-raw" {} "without a fix. Lines: from the navigation’s position to the fix, five times as long."
            } }
        })
    }
}
