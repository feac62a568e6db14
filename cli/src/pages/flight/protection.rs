//! What the board promises of its own position: errors against protection levels.

use super::Report;
use maud::{Markup, html};
use plotters::element::Circle;
use plotters::series::LineSeries;
use plotters::style::Color;
use plumbline_charts::format::{maybe, number, whole};
use plumbline_charts::plot::{Axes, INK, PAPER, PlotError, RECTIFIED, REFUSED, from_zero, plain, plot};
use plumbline_sim::score::kept::{Kept, Navigated};
use plumbline_sim::score::protection::{Placed, Protection};
use std::ops::Range;

/// Decades of the diagram; what is smaller is drawn at its edge. Chosen: from decimetres to a lost vehicle's hundred metres.
const DECADES: f64 = 3.0;

impl Report<'_> {
    /// Nothing of a flight without places.
    pub(super) fn protection(&self) -> Result<Markup, PlotError> {
        let Some(all) = &self.summary.protection else { return Ok(html! {}) };
        let kept = self.summary.navigation.as_ref().and_then(Navigated::kept);
        let drawn = shown(self.scored.iter().map(|scored| scored.place), self.step());
        let places: Vec<Placed> = drawn.iter().flatten().copied().collect();
        let stanford = stanford(&places)?;
        let timeline = kept.map(|kept| timeline(kept, &drawn)).transpose()?;
        Ok(html! {
            section {
                h2 { "The board’s own position" }
                p class="note" {
                    "Where the firmware’s filter has the vehicle, frame by frame, also of frames without a fix. The protection level is the radius around it that is left with a risk of 10⁻⁵."
                }
                div class="two" {
                    figure { (stanford) figcaption {
                        b { "Stanford diagram. " }
                        "Horizontal error over protection level: "
                        span class="key dot k-ours" {} "frames whose error was within it, "
                        span class="key dot k-bad" {} "those beyond it, above the "
                        span class="key line k-ink" {} "diagonal. Logarithmic; what is smaller lies on the edge."
                    } }
                    @if let Some(timeline) = timeline {
                        figure { (timeline) figcaption {
                            b { "Horizontal error of the board’s position, " }
                            span class="key line k-ours" {} "error and "
                            span class="key line k-paper" {} "protection level. "
                            @if kept.is_some_and(|kept| kept.gnss_lost_s.is_some()) {
                                span class="key line k-bad" {} "satellite navigation lost. "
                            }
                            "Seconds of the simulated time."
                        } }
                    } @else {
                        div { (figures(all)) }
                    }
                }
                @if self.step() > 1 {
                    p class="note" { "Of each " (self.step()) " frames the one with the least left between error and protection level." }
                }
                @if let Some(kept) = kept { div class="two" { div { (figures(all)) } div { (figures_kept(kept)) } } }
            }
        })
    }
}

/// Of each `step` frames the place that is nearest to leaving its protection level, or furthest beyond it; none where none of them
/// has a place that can be drawn.
fn shown(places: impl Iterator<Item = Option<Placed>>, step: usize) -> Vec<Option<Placed>> {
    let places: Vec<Option<Placed>> = places.collect();
    let left_m = |place: &Placed| place.protection_m - place.error_m();
    let drawn = |frames: &[Option<Placed>]| {
        let finite = frames.iter().flatten().filter(|place| left_m(place).is_finite());
        finite.copied().min_by(|a, b| left_m(a).total_cmp(&left_m(b)))
    };
    places.chunks(step.max(1)).map(drawn).collect()
}

/// Error over protection level, both logarithmic: some levels are tens of metres and most are few.
fn stanford(places: &[Placed]) -> Result<Markup, PlotError> {
    let (held, beyond): (Vec<&Placed>, Vec<&Placed>) = places.iter().partition(|place| place.is_held());
    let side = decades(places.iter().flat_map(|place| [place.protection_m, place.error_m()]));
    let power = |metres: f64| metres.log10().max(side.start);
    let axes = Axes {
        x: side.clone(),
        y: side.clone(),
        x_text: "protection level (m)",
        y_text: "error (m)",
        x_label: &|power| plain(10f64.powf(*power)),
        y_label: &|power| plain(10f64.powf(*power)),
    };
    plot("Horizontal error of the board's position over its protection level, metres", &axes, |chart| {
        let diagonal = [(side.start, side.start), (side.end, side.end)];
        chart.draw_series(LineSeries::new(diagonal, INK.stroke_width(3)))?;
        for (places, colour) in [(&held, RECTIFIED), (&beyond, REFUSED)] {
            let dots = places.iter().map(|place| (power(place.protection_m), power(place.error_m())));
            chart.draw_series(dots.map(|at| Circle::new(at, 7, colour.filled())))?;
        }
        Ok(())
    })
}

/// Powers of ten from three decades below the one that holds all values.
fn decades(values: impl Iterator<Item = f64>) -> Range<f64> {
    let highest = values.filter(|value| value.is_normal()).fold(1.0, f64::max).log10().ceil();
    highest - DECADES..highest
}

/// Error and protection level over time; frames without a place interrupt both lines.
fn timeline(kept: &Kept, drawn: &[Option<Placed>]) -> Result<Markup, PlotError> {
    let places = || drawn.iter().flatten();
    let axes = Axes {
        x: from_zero(places().map(|place| place.at_s)),
        y: from_zero(places().flat_map(|place| [place.protection_m, place.error_m()])),
        x_text: "time (s)",
        y_text: "error, protection level (m)",
        x_label: &|seconds| plain(*seconds),
        y_label: &|value| plain(*value),
    };
    plot("Horizontal error of the board's position and its protection level over time, metres", &axes, |chart| {
        if let Some(lost_s) = kept.gnss_lost_s {
            chart.draw_series(LineSeries::new([(lost_s, 0.0), (lost_s, axes.y.end)], REFUSED.stroke_width(3)))?;
        }
        for run in drawn.split(Option::is_none) {
            let of = |pick: fn(&Placed) -> f64| run.iter().flatten().map(move |place| (place.at_s, pick(place)));
            chart.draw_series(LineSeries::new(of(|place| place.protection_m), PAPER.stroke_width(4)))?;
            chart.draw_series(LineSeries::new(of(Placed::error_m), RECTIFIED.stroke_width(4)))?;
        }
        Ok(())
    })
}

fn row(name: &str, what: &str, value: &str) -> Markup {
    html! { tr { th { (name) small { (what) } } td class="n" { (value) } } }
}

fn figures(all: &Protection) -> Markup {
    html! {
        table {
            thead { tr { th { "The whole flight" } th class="r" { "Value" } } }
            tbody {
                (row("Frames with a place", "", &whole(all.frames as u64)))
                (row("Within the protection level", "All but one in 100,000 expected.", &number(100.0 * all.held, 3, "%")))
                (row("Protection level, median", "", &number(all.median_m, 2, "m")))
                (row("Error, RMS", "Horizontal.", &number(all.rms_m, 2, "m")))
                (row("NEES a degree of freedom", "1 expected; above, the filter is surer than it may be.", &number(all.nees, 2, "")))
            }
        }
    }
}

fn figures_kept(kept: &Kept) -> Markup {
    let share = |share: Option<f64>, digits| maybe(share.map(|share| 100.0 * share), digits, "%");
    let span = match kept.gnss_lost_s {
        Some(_) => "From 20 s after satellite navigation was lost",
        None => "From 20 s on",
    };
    html! {
        table {
            thead { tr { th { (span) } th class="r" { "Value" } } }
            tbody {
                (row("Within the protection level", "", &share(kept.protection_held, 3)))
                (row("Protection level, median", "", &maybe(kept.protection_median_m, 2, "m")))
                (row("Within 95, 99 and 99.9 % of normal errors", "By the stated sigmas.", &format!("{}, {}, {}", share(kept.protection_95_held, 1), share(kept.protection_99_held, 1), share(kept.protection_999_held, 1))))
                (row("Radius of 95 %, median", "", &maybe(kept.protection_95_median_m, 2, "m")))
                (row("Error, RMS", "Horizontal.", &maybe(kept.rms_m, 2, "m")))
                (row("Error, largest", "", &maybe(kept.max_m, 2, "m")))
                (row("NEES a degree of freedom", "1 expected.", &maybe(kept.nees, 2, "")))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn place(error_m: f64, protection_m: f64) -> Placed {
        Placed { at_s: 1.0, off_m: [error_m, 0.0], sigma_m: [1.0; 2], protection_m }
    }

    #[test]
    fn frames_beyond_their_protection_level_are_drawn_in_the_colour_of_warnings() {
        let page = |places: &[Placed]| stanford(places).expect("a plot").into_string().to_uppercase();
        let dots = |page: &str, colour: &str| {
            page.split("<CIRCLE")
                .skip(1)
                .filter(|dot| dot.split('>').next().is_some_and(|dot| dot.contains(colour)))
                .count()
        };
        // A place without an error is on no logarithmic axis, and drawn at the edge.
        let page = page(&[place(1.0, 5.0), place(0.0, 5.0), place(4.9, 5.0), place(5.1, 5.0)]);
        assert_eq!((dots(&page, "#1F5A8C"), dots(&page, "#B3261E")), (3, 1));
    }

    #[test]
    fn the_axes_end_at_powers_of_ten() {
        let of = |values: &[f64]| decades(values.iter().copied());
        assert_eq!((of(&[0.3, 38.0, f64::NAN]), of(&[0.2]), of(&[])), (-1.0..2.0, -3.0..0.0, -3.0..0.0));
    }

    #[test]
    fn of_many_frames_the_worst_is_shown_and_none_that_cannot_be_drawn() {
        let frames =
            [Some(place(1.0, 5.0)), Some(place(6.0, 5.0)), None, Some(place(0.0, f64::NAN)), Some(place(2.0, 9.0))];
        assert_eq!(shown(frames.into_iter(), 2), [frames[1], None, frames[4]]);
        assert_eq!(shown(frames.into_iter(), 1), [frames[0], frames[1], None, None, frames[4]]);
        assert!(shown([].into_iter(), 1).is_empty());
    }
}
