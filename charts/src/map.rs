//! A map: north over east in metres, equal axes.

use crate::plot::{Axes, Chart, Drawn, INK, PlotError, plain, plot_over};
use crate::png::{Colour, encode, uri};
use maud::Markup;
use plotters::element::PathElement;
use plotters::style::Color;
use std::ops::Range;

/// Side of a picture under a map: about what is shown of it on a screen.
const PICTURE_PX: usize = 480;

/// A square of ground.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Map {
    /// East and north of its centre.
    centre: (f64, f64),
    /// From the centre to each side.
    half: f64,
}

impl Map {
    /// The square around all finite `points`, (east, north), with a margin on each side of `margin` times their larger extent;
    /// no narrower than `side_min_m`.
    pub fn around<'p>(points: impl Iterator<Item = &'p (f64, f64)> + Clone, margin: f64, side_min_m: f64) -> Self {
        let [left, right] = extent(points.clone().map(|at| at.0));
        let [bottom, top] = extent(points.map(|at| at.1));
        let half = 0.5 * ((right - left).max(top - bottom) * (1.0 + 2.0 * margin)).max(side_min_m);
        Map { centre: (0.5 * (left + right), 0.5 * (bottom + top)), half }
    }

    /// East and north of a position in the square: −1 to 1 from left to right, and from bottom to top.
    pub fn at(&self, x: f64, y: f64) -> (f64, f64) {
        (self.centre.0 + self.half * x, self.centre.1 + self.half * y)
    }

    /// Draws the map; `label` is what those who cannot see it are told.
    ///
    /// # Errors
    /// [`PlotError`].
    pub fn plot(&self, label: &str, draw: impl FnOnce(&mut Chart<'_, '_>) -> Drawn) -> Result<Markup, PlotError> {
        self.plot_under(label, "", draw)
    }

    /// As [`Self::plot`], over a picture: `grey` of a place, (east, north); the page shows through where there is none.
    ///
    /// # Errors
    /// [`PlotError`].
    pub fn plot_over(
        &self,
        label: &str,
        grey: impl Fn((f64, f64)) -> Option<u8>,
        draw: impl FnOnce(&mut Chart<'_, '_>) -> Drawn,
    ) -> Result<Markup, PlotError> {
        let along = |index: usize| (index as f64 + 0.5) / (0.5 * PICTURE_PX as f64) - 1.0;
        let pixel = |index: usize| grey(self.at(along(index % PICTURE_PX), -along(index / PICTURE_PX)));
        let samples = |grey: Option<u8>| grey.map_or([0, 0], |grey| [grey, u8::MAX]);
        let pixels: Vec<u8> = (0..PICTURE_PX * PICTURE_PX).flat_map(|index| samples(pixel(index))).collect();
        self.plot_under(label, &uri(&encode(PICTURE_PX, PICTURE_PX, Colour::GreyAlpha, &pixels)), draw)
    }

    fn plot_under(
        &self,
        label: &str,
        picture: &str,
        draw: impl FnOnce(&mut Chart<'_, '_>) -> Drawn,
    ) -> Result<Markup, PlotError> {
        let (col, row) = self.centre;
        let axes = Axes {
            x: col - self.half..col + self.half,
            y: row - self.half..row + self.half,
            x_text: "east (m)",
            y_text: "north (m)",
            x_label: &|value| plain(*value),
            y_label: &|value| plain(*value),
        };
        plot_over(label, picture, &axes, draw)
    }

    /// Metres of a share of half the side.
    pub fn metres(&self, share: f64) -> f64 {
        self.half * share
    }

    /// An arrow to the north, at positions as [`Map::at`] takes them.
    ///
    /// # Errors
    /// What the drawing library says.
    pub fn north_arrow(&self, chart: &mut Chart<'_, '_>, x: f64, y: Range<f64>) -> Drawn {
        let (tip, barb) = (self.at(x, y.end), y.end - 0.05);
        let path = vec![self.at(x, y.start), tip, self.at(x - 0.02, barb), self.at(x + 0.02, barb), tip];
        chart.draw_series([PathElement::new(path, INK.stroke_width(3))])?;
        Ok(())
    }
}

/// Smallest and largest; 0 of nothing.
fn extent(values: impl Iterator<Item = f64>) -> [f64; 2] {
    let [low, high] = values
        .filter(|value| value.is_finite())
        .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], value| [low.min(value), high.max(value)]);
    if low <= high { [low, high] } else { [0.0, 0.0] }
}

#[cfg(test)]
mod tests {
    use super::Map;

    #[test]
    fn the_square_holds_the_larger_extent_with_its_margins() {
        let points = [(10.0, -3.0), (30.0, 1.0), (f64::NAN, f64::INFINITY), (20.0, 0.0)];
        let map = Map::around(points.iter(), 0.05, 1.0);
        assert_eq!((map.centre, map.half), ((20.0, -1.0), 11.0));
        assert_eq!((map.at(-1.0, 0.0), map.at(0.5, 1.0)), ((9.0, -1.0), (25.5, 10.0)));
    }

    #[test]
    fn a_point_or_none_has_the_least_width() {
        for (points, centre) in [(vec![(5.0, 6.0)], (5.0, 6.0)), (vec![], (0.0, 0.0))] {
            let map = Map::around(points.iter(), 0.05, 20.0);
            assert_eq!((map.centre, map.half), (centre, 10.0));
        }
    }
}
