//! The three plots: where the vehicle was, how far off each fix was, how the matching errors are spread.

mod histogram;
mod timeline;
mod track;

use super::{Report, ReportError};
use maud::{Markup, PreEscaped, html};
use plotters::chart::{ChartBuilder, ChartContext};
use plotters::coord::cartesian::Cartesian2d;
use plotters::coord::types::RangedCoordf64;
use plotters::drawing::IntoDrawingArea;
use plotters::element::Rectangle;
use plotters::prelude::SVGBackend;
use plotters::style::{Color, IntoFont, RGBColor, TextStyle};
use std::error::Error;
use std::ops::Range;

/// Drawing units of a plot, width and height: twice what is shown, as plotters rounds to whole units. With the margins
/// below the inside is a square.
const SIZE: (u32, u32) = (960, 922);
const LEFT: u32 = 124;
const BOTTOM: u32 = 96;
const TOP: u32 = 24;
const RIGHT: u32 = 34;
/// Font size of axes, drawing units.
const FONT: u32 = 36;
/// Most frames that are drawn one by one.
const FRAMES_MAX: usize = 2000;

pub(crate) const INK: RGBColor = RGBColor(40, 40, 38);
const RULE: RGBColor = RGBColor(214, 211, 203);
pub(crate) const RECTIFIED: RGBColor = RGBColor(31, 90, 140);
pub(crate) const UNRECTIFIED: RGBColor = RGBColor(150, 145, 133);
pub(crate) const REFUSED: RGBColor = RGBColor(179, 38, 30);
pub(crate) const PAPER: RGBColor = RGBColor(176, 106, 0);

pub(crate) type Chart<'a, 'b> = ChartContext<'a, SVGBackend<'b>, Cartesian2d<RangedCoordf64, RangedCoordf64>>;
pub(crate) type Drawn = Result<(), Box<dyn Error>>;

/// Axes of a plot.
pub(crate) struct Axes<'a> {
    pub(crate) x: Range<f64>,
    pub(crate) y: Range<f64>,
    pub(crate) x_text: &'a str,
    pub(crate) y_text: &'a str,
    pub(crate) x_label: &'a dyn Fn(&f64) -> String,
}

impl Report<'_> {
    /// All plots with their captions.
    pub(super) fn plots(&self) -> Result<Markup, ReportError> {
        let (track, timeline, histogram) = (self.track()?, self.timeline()?, self.histogram()?);
        let step = self.step();
        Ok(html! {
            section {
                h2 { "The flight" }
                div class="plots" {
                    figure { (track) figcaption {
                        b { "Track. " }
                        span class="key line" style="--c:#969185" {} "true track, "
                        span class="key dot" style="--c:#1f5a8c" {} "fixes, "
                        span class="key ring" style="--c:#b3261e" {} "frames refused, where they truly were. "
                        "Metres from the reference tile’s centre, grid north up, equal axes."
                    } }
                    figure { (timeline) figcaption {
                        b { "Ground error. " }
                        span class="key dot" style="--c:#1f5a8c" {} "fix minus true position, horizontal; "
                        span class="key line" style="--c:#b06a00" {} "one sigma as the firmware states it, √(σ²" sub { "E" } " + σ²" sub { "N" } "); "
                        span class="key tick" style="--c:#b3261e" {} "frames refused."
                    } }
                    figure { (histogram) figcaption {
                        b { "Matching error. " }
                        span class="key box" style="--c:#969185" {} "unrectified, whole-pixel peak, all frames; "
                        span class="key box" style="--c:#1f5a8c" {} "rectified, sub-pixel, accepted frames. "
                        span class="key line" style="--c:#b06a00" {} "The paper’s means (Table 3)."
                    } }
                }
                @if step > 1 {
                    p class="note" { "Track and ground error show every " (step) "th frame." }
                }
            }
        })
    }

    /// Of so many frames one is drawn.
    fn step(&self) -> usize {
        self.scored.len().div_ceil(FRAMES_MAX).max(1)
    }
}

/// Draws a plot; `label` is what those who cannot see it are told.
pub(crate) fn plot(
    label: &str,
    axes: &Axes<'_>,
    draw: impl FnOnce(&mut Chart<'_, '_>) -> Drawn,
) -> Result<Markup, ReportError> {
    let mut text = String::new();
    draw_into(&mut text, axes, draw).map_err(|error| ReportError(format!("{label} ({error})")))?;
    // The page's own opening tag: inside HTML no namespace is needed, and the style sheet sets the size.
    let inside = text.split_once('>').map_or("", |(_, inside)| inside);
    Ok(html! {
        (PreEscaped(format!("<svg viewBox=\"0 0 {} {}\" role=\"img\" aria-label=\"{label}\">{inside}", SIZE.0, SIZE.1)))
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
        .y_label_formatter(&|value| plain(*value))
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
pub(crate) fn bars(
    chart: &mut Chart<'_, '_>,
    bars: impl Iterator<Item = [(f64, f64); 2]> + Clone,
    colour: RGBColor,
) -> Drawn {
    chart.draw_series(bars.clone().map(|corners| Rectangle::new(corners, colour.mix(0.55).filled())))?;
    chart.draw_series(bars.map(|corners| Rectangle::new(corners, colour.stroke_width(3))))?;
    Ok(())
}

/// A tick's number without the tail that binary fractions have.
pub(crate) fn plain(value: f64) -> String {
    let rounded = (value * 1e4).round() / 1e4;
    // Adding zero takes the sign off a negative one.
    (rounded + 0.0).to_string().replace('-', "−")
}

/// A range from 0 that holds `values`, with room above them.
pub(crate) fn from_zero(values: impl Iterator<Item = f64>) -> Range<f64> {
    let largest = values.fold(0.0, f64::max);
    0.0..if largest > 0.0 { 1.08 * largest } else { 1.0 }
}
