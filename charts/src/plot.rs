//! A plot with axes, as an SVG element of a page.

use maud::{Markup, PreEscaped, html};
use plotters::chart::{ChartBuilder, ChartContext};
use plotters::coord::cartesian::Cartesian2d;
use plotters::coord::types::RangedCoordf64;
use plotters::drawing::IntoDrawingArea;
use plotters::element::Rectangle;
use plotters::prelude::SVGBackend;
use plotters::style::{Color, IntoFont, RGBColor, TextStyle};
use std::error::Error;
use std::fmt;
use std::ops::Range;

/// Drawing units of a plot, width and height: twice what is shown, as plotters rounds to whole units. With the margins
/// below the inside is a square.
const SIZE: (u32, u32) = (960, 922);
const LEFT: u32 = 124;
const BOTTOM: u32 = 96;
const TOP: u32 = 24;
const RIGHT: u32 = 34;
/// Font size of axes, drawing units.
pub const FONT: u32 = 36;

/// Text and axes.
pub const INK: RGBColor = RGBColor(40, 40, 38);
const RULE: RGBColor = RGBColor(214, 211, 203);
/// Matches of rectified frames.
pub const RECTIFIED: RGBColor = RGBColor(31, 90, 140);
/// Matches of frames as they were taken.
pub const UNRECTIFIED: RGBColor = RGBColor(150, 145, 133);
/// What was refused.
pub const REFUSED: RGBColor = RGBColor(179, 38, 30);
/// Where something was believed to be.
pub const ESTIMATED: RGBColor = RGBColor(43, 107, 63);
/// Figures of a paper, plans, limits.
pub const PAPER: RGBColor = RGBColor(176, 106, 0);

/// A chart with linear axes.
pub type Chart<'a, 'b> = ChartContext<'a, SVGBackend<'b>, Cartesian2d<RangedCoordf64, RangedCoordf64>>;
/// What drawing into a chart comes to.
pub type Drawn = Result<(), Box<dyn Error>>;

/// Axes of a plot.
#[expect(missing_debug_implementations, reason = "holds a function")]
pub struct Axes<'a> {
    /// Range of the abscissa.
    pub x: Range<f64>,
    /// Range of the ordinate.
    pub y: Range<f64>,
    /// Label of the abscissa, with its unit.
    pub x_text: &'a str,
    /// Label of the ordinate, with its unit.
    pub y_text: &'a str,
    /// How a tick of the abscissa is written.
    pub x_label: &'a dyn Fn(&f64) -> String,
    /// How one of the ordinate is.
    pub y_label: &'a dyn Fn(&f64) -> String,
}

/// A plot that could not be drawn: its label, and what the drawing library says.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PlotError(String);

impl fmt::Display for PlotError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "the report cannot be drawn: {}", self.0)
    }
}

impl std::error::Error for PlotError {}

/// Draws a plot; `label` is what those who cannot see it are told.
///
/// # Errors
/// [`PlotError`].
pub fn plot(label: &str, axes: &Axes<'_>, draw: impl FnOnce(&mut Chart<'_, '_>) -> Drawn) -> Result<Markup, PlotError> {
    plot_over(label, "", axes, draw)
}

/// As [`plot`], over a picture that fills the inside: its address, `data:...`; none where that is empty.
///
/// # Errors
/// [`PlotError`].
pub fn plot_over(
    label: &str,
    picture: &str,
    axes: &Axes<'_>,
    draw: impl FnOnce(&mut Chart<'_, '_>) -> Drawn,
) -> Result<Markup, PlotError> {
    let mut text = String::new();
    draw_into(&mut text, axes, draw).map_err(|error| PlotError(format!("{label} ({error})")))?;
    // The page's own opening tag: inside HTML no namespace is needed, and the style sheet sets the size. A script that marks a
    // place is told where the inside lies and what it ranges over.
    let inside = text.split_once('>').map_or("", |(_, inside)| inside);
    let (cols, rows) = (SIZE.0 - LEFT - RIGHT, SIZE.1 - TOP - BOTTOM);
    let under = if picture.is_empty() {
        String::new()
    } else {
        format!(
            "<image class=\"under\" x=\"{LEFT}\" y=\"{TOP}\" width=\"{cols}\" height=\"{rows}\" preserveAspectRatio=\"none\" href=\"{picture}\"/>"
        )
    };
    let ranges = format!("{} {} {} {}", axes.x.start, axes.x.end, axes.y.start, axes.y.end);
    Ok(html! {
        (PreEscaped(format!(
            "<svg viewBox=\"0 0 {} {}\" role=\"img\" aria-label=\"{label}\" data-inside=\"{LEFT} {TOP} {cols} {rows}\" data-ranges=\"{ranges}\">{under}{inside}",
            SIZE.0, SIZE.1
        )))
    })
}

fn draw_into(text: &mut String, axes: &Axes<'_>, draw: impl FnOnce(&mut Chart<'_, '_>) -> Drawn) -> Drawn {
    let root = SVGBackend::with_string(text, SIZE).into_drawing_area();
    let mut chart = ChartBuilder::on(&root)
        .margin_top(TOP)
        .margin_right(RIGHT)
        .x_label_area_size(BOTTOM)
        .y_label_area_size(LEFT)
        .build_cartesian_2d(axes.x.clone(), axes.y.clone())?;
    chart
        .configure_mesh()
        .max_light_lines(0)
        .bold_line_style(RULE.stroke_width(2))
        .axis_style(INK.stroke_width(2))
        .set_all_tick_mark_size(12)
        .x_labels(5)
        .y_labels(6)
        .x_desc(axes.x_text)
        .y_desc(axes.y_text)
        .label_style(font())
        .axis_desc_style(font())
        .x_label_formatter(axes.x_label)
        .y_label_formatter(axes.y_label)
        .draw()?;
    draw(&mut chart)?;
    drop(chart);
    root.present()?;
    Ok(())
}

fn font() -> TextStyle<'static> {
    ("sans-serif", FONT).into_font().color(&INK)
}

/// Filled bars, each from its lower left corner to its upper right one.
///
/// # Errors
/// What the drawing library says.
pub fn bars(chart: &mut Chart<'_, '_>, bars: impl Iterator<Item = [(f64, f64); 2]> + Clone, colour: RGBColor) -> Drawn {
    chart.draw_series(bars.clone().map(|corners| Rectangle::new(corners, colour.mix(0.55).filled())))?;
    chart.draw_series(bars.map(|corners| Rectangle::new(corners, colour.stroke_width(3))))?;
    Ok(())
}

/// A tick's number without the tail that binary fractions have.
pub fn plain(value: f64) -> String {
    let rounded = (value * 1e4).round() / 1e4;
    // Adding zero takes the sign off a negative one.
    (rounded + 0.0).to_string().replace('-', "−")
}

/// A range from 0 that holds `values`, with room above them.
pub fn from_zero(values: impl Iterator<Item = f64>) -> Range<f64> {
    let largest = values.fold(0.0, f64::max);
    0.0..if largest > 0.0 { 1.08 * largest } else { 1.0 }
}
