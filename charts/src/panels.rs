//! Curves over a common axis, panel below panel, as one SVG picture.

use plotters::chart::{ChartBuilder, ChartContext};
use plotters::coord::cartesian::Cartesian2d;
use plotters::coord::types::RangedCoordf64;
use plotters::drawing::IntoDrawingArea;
use plotters::element::{Circle, PathElement, Polygon, Text};
use plotters::prelude::SVGBackend;
use plotters::style::{Color, IntoFont, RGBColor, TextStyle, WHITE};
use std::error::Error;
use std::ops::Range;

/// What was measured.
pub const MEASURED: RGBColor = RGBColor(150, 145, 133);
/// What was made of it.
pub const FITTED: RGBColor = RGBColor(31, 90, 140);
/// What was left out.
pub const LEFT_OUT: RGBColor = RGBColor(179, 38, 30);
const INK: RGBColor = RGBColor(40, 40, 38);
const RULE: RGBColor = RGBColor(214, 211, 203);

/// Width of the picture, height of the strip above each panel and below the last, pixels.
const WIDTH: u32 = 1200;
const CAPTION: u32 = 34;
const FOOT: u32 = 52;
/// Room for the numbers beside a panel.
const LEFT: u32 = 96;
const RIGHT: u32 = 24;
const FONT: u32 = 15;
/// Height of a panel of share 1.
const HEIGHT: u32 = 90;

/// One set of points.
#[derive(Clone, Debug)]
pub enum Mark {
    /// Joined by a line; a point that is not finite interrupts it.
    Line(Vec<(f64, f64)>),
    /// Each for itself.
    Dots(Vec<(f64, f64)>),
    /// Dots drawn as rings, which are seen among full ones.
    Rings(Vec<(f64, f64)>),
    /// The area between two curves over the same places: place, lower, upper.
    Band(Vec<(f64, f64, f64)>),
    /// A level line across the panel.
    Level(f64),
}

/// One diagram.
#[derive(Clone, Debug)]
pub struct Panel {
    /// What stands above it.
    pub caption: String,
    /// What its ordinate is, with its unit.
    pub y_text: String,
    /// Its height, in units of 90 pixels.
    pub share: u32,
    /// Back to front.
    pub marks: Vec<(Mark, RGBColor)>,
}

type Chart<'a, 'b> = ChartContext<'a, SVGBackend<'b>, Cartesian2d<RangedCoordf64, RangedCoordf64>>;
type Drawn = Result<(), Box<dyn Error>>;

impl Mark {
    /// Places and heights of everything in it.
    fn extent(&self) -> Box<dyn Iterator<Item = f64> + '_> {
        match self {
            Mark::Line(points) | Mark::Dots(points) | Mark::Rings(points) => {
                Box::new(points.iter().map(|point| point.1))
            }
            Mark::Band(points) => Box::new(points.iter().flat_map(|point| [point.1, point.2])),
            Mark::Level(height) => Box::new(std::iter::once(*height)),
        }
    }

    fn draw(&self, chart: &mut Chart<'_, '_>, colour: RGBColor, x: &Range<f64>) -> Drawn {
        match self {
            Mark::Line(points) => {
                for run in points.split(|point| !point.1.is_finite()).filter(|run| !run.is_empty()) {
                    chart.draw_series([PathElement::new(run.to_vec(), colour.stroke_width(2))])?;
                }
            }
            Mark::Dots(points) => {
                let finite = points.iter().filter(|point| point.1.is_finite());
                chart.draw_series(finite.map(|&point| Circle::new(point, 2, colour.filled())))?;
            }
            Mark::Rings(points) => {
                chart.draw_series(points.iter().map(|&point| Circle::new(point, 6, colour.stroke_width(2))))?;
            }
            Mark::Band(points) => {
                let there = points.iter().map(|&(x, low, _)| (x, low));
                let back = points.iter().rev().map(|&(x, _, high)| (x, high));
                chart.draw_series([Polygon::new(there.chain(back).collect::<Vec<_>>(), colour.mix(0.22).filled())])?;
            }
            Mark::Level(height) => {
                let ends = vec![(x.start, *height), (x.end, *height)];
                chart.draw_series([PathElement::new(ends, colour.stroke_width(1))])?;
            }
        }
        Ok(())
    }
}

/// The picture: `x` is the range of the common axis, whose text stands below the last panel.
///
/// # Errors
/// What the drawing library refuses, as text: nothing that is known of.
pub fn svg(x: Range<f64>, x_text: &str, panels: &[Panel]) -> Result<String, String> {
    let mut text = String::new();
    draw(&mut text, &x, x_text, panels).map_err(|error| format!("the plot cannot be drawn: {error}"))?;
    Ok(text)
}

fn draw(text: &mut String, x: &Range<f64>, x_text: &str, panels: &[Panel]) -> Drawn {
    let height: u32 = panels.iter().map(|panel| panel.share * HEIGHT + CAPTION).sum();
    let root = SVGBackend::with_string(text, (WIDTH, height + FOOT)).into_drawing_area();
    root.fill(&WHITE)?;
    let mut top = 0;
    for (index, panel) in panels.iter().enumerate() {
        let is_last = index + 1 == panels.len();
        let foot = if is_last { FOOT } else { 0 };
        let bottom = top + CAPTION + panel.share * HEIGHT;
        let area = root.clone().shrink((0, top), (WIDTH, bottom + foot - top));
        area.draw(&Text::new(panel.caption.as_str(), (LEFT as i32, 11), font()))?;
        let y = range(panel.marks.iter().flat_map(|(mark, _)| mark.extent()));
        let mut chart = ChartBuilder::on(&area)
            .margin_top(CAPTION)
            .margin_right(RIGHT)
            .x_label_area_size(foot)
            .y_label_area_size(LEFT)
            .build_cartesian_2d(x.clone(), y.clone())?;
        let digits = digits(&y);
        let (x_labels, y_labels) = (12, (panel.share as usize + 2).min(8));
        let x_digits = self::digits(x);
        let x_format = |value: &f64| plain(*value, x_digits);
        let y_format = |value: &f64| plain(*value, digits);
        let mut mesh = chart.configure_mesh();
        mesh.max_light_lines(0)
            .bold_line_style(RULE.stroke_width(1))
            .axis_style(INK.stroke_width(1))
            .x_labels(x_labels)
            .y_labels(y_labels)
            .label_style(font())
            .axis_desc_style(font())
            .x_label_formatter(&x_format)
            .y_label_formatter(&y_format)
            .y_desc(panel.y_text.as_str());
        if is_last {
            mesh.x_desc(x_text);
        }
        mesh.draw()?;
        for (mark, colour) in &panel.marks {
            mark.draw(&mut chart, *colour, x)?;
        }
        top = bottom;
    }
    root.present()?;
    Ok(())
}

fn font() -> TextStyle<'static> {
    ("sans-serif", FONT).into_font().color(&INK)
}

/// Share of themselves by which numbers differ that are one but for rounding.
const LEVEL: f64 = 1e-9;

/// What holds all finite values, with some room.
fn range(values: impl Iterator<Item = f64>) -> Range<f64> {
    let finite = values.filter(|value| value.is_finite());
    let (low, high) = finite.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)));
    if low > high {
        return -1.0..1.0;
    }
    // A level line far from 0 still needs a height that short numbers show: what differs by less than its digits say is level.
    let most = low.abs().max(high.abs());
    let room = if high - low > LEVEL * most { 0.06 * (high - low) } else { 0.05 * most };
    let room = room.max(1e-12);
    low - room..high + room
}

/// Decimals that tell a tenth of the range apart.
fn digits(range: &Range<f64>) -> usize {
    let tenth = (range.end - range.start) / 10.0;
    if tenth > 0.0 && tenth.is_finite() { (-tenth.log10()).ceil().clamp(0.0, 12.0) as usize } else { 3 }
}

/// A tick's number without zeros that say nothing.
fn plain(value: f64, digits: usize) -> String {
    let text = format!("{value:.digits$}");
    let text = if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { &text };
    if text == "-0" { "0".to_owned() } else { text.replace('-', "\u{2212}") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn panels_stand_below_each_other_and_ranges_hold_what_is_drawn() {
        let line = Mark::Line(vec![(0.0, 1.0), (1.0, f64::NAN), (2.0, 3.0), (3.0, 4.0)]);
        let panel = Panel { caption: "one".into(), y_text: "height (m)".into(), share: 2, marks: vec![(line, FITTED)] };
        let level = Panel { caption: "two".into(), marks: vec![(Mark::Level(7.0), MEASURED)], ..panel.clone() };
        let text = svg(0.0..3.0, "time (s)", &[panel, level]).unwrap();
        assert!(text.starts_with("<svg width=\"1200\" height=\"480\""), "{}", &text[..80]);
        assert!(["one", "two", "time (s)", "height (m)"].iter().all(|word| text.contains(word)));
        assert_eq!(range([1.0, f64::NAN, 3.0].into_iter()), 1.0 - 0.12..3.0 + 0.12);
        assert_eq!(range([].into_iter()), -1.0..1.0);
    }

    #[test]
    fn numbers_are_short() {
        let told = |value, range: Range<f64>| plain(value, digits(&range));
        assert_eq!(told(0.30000000004, 0.0..1.0), "0.3");
        assert_eq!(told(-20.0, -30.0..0.0), "\u{2212}20");
        // A level line, but for rounding.
        let level = range([0.270_632_938_7, 0.270_632_938_700_1].into_iter());
        assert_eq!(told(0.26, level.clone()), "0.26");
        assert!(level.start < 0.26 && level.end > 0.28, "{level:?}");
        assert_eq!([told(-1e-12, -1.0..1.0), told(500.0, 0.0..1e3)], ["0", "500"]);
    }
}
