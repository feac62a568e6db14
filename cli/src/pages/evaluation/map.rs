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
/// Offsets are drawn so many times as long: as many as keep the longest within a quarter of the side that shows the places, the last whatever
/// comes of it.
const LONGER: [f64; 6] = [5.0, 2.0, 1.0, 0.5, 0.2, 0.1];
const LONGEST: f64 = 0.5;

impl Page<'_> {
    pub(super) fn map(&self) -> Result<Markup, PlotError> {
        let [east, north] = self.setup.tile_centre;
        let places: Vec<(f64, f64)> =
            self.table.rows.iter().map(|row| (row.place_m[0] - east, row.place_m[1] - north)).collect();
        let refused = places.iter().zip(&self.verdict.frames).filter(|(_, frame)| frame.fix.is_err());
        let longest_m = self.verdict.fixes().map(|(_, fix)| fix.offset_m[0].hypot(fix.offset_m[1])).fold(0.0, f64::max);
        let longer = longer(longest_m, Map::around(places.iter(), MARGIN, SIDE_MIN_M).metres(LONGEST));
        let ends = self.verdict.fixes().map(|(index, fix)| {
            let (at, [off_east, off_north]) = (places[index], fix.offset_m);
            (at, (at.0 + longer * off_east, at.1 + longer * off_north), self.verdict.is_right(fix))
        });
        let shown: Vec<(f64, f64)> = places.iter().copied().chain(ends.clone().map(|(_, end, _)| end)).collect();
        let colour = |is_right: bool| if is_right { RECTIFIED } else { REFUSED };
        let map = Map::around(shown.iter(), MARGIN, SIDE_MIN_M);
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
                span class="key dot k-raw" {} "without a fix. Lines: from the navigation’s position to the fix, "
                @if longer == 1.0 { "to scale." } @else { (longer) " times as long." }
            } }
        })
    }
}

/// How many times as long as it is the longest offset is drawn, so that none leaves the map.
fn longer(longest_m: f64, room_m: f64) -> f64 {
    let fits = |longer: &f64| longest_m * longer <= room_m;
    LONGER.into_iter().find(fits).unwrap_or(LONGER[LONGER.len() - 1])
}

#[cfg(test)]
mod tests {
    use super::longer;

    #[test]
    fn long_offsets_are_drawn_shorter() {
        assert_eq!(
            [0.0, 20.0, 20.1, 100.0, 101.0, 5000.0].map(|longest_m| longer(longest_m, 100.0)),
            [5.0, 5.0, 2.0, 1.0, 0.5, 0.1]
        );
    }
}
