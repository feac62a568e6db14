//! A flight with a real autopilot: what its own position was worth, and how well the times are known.

use super::Report;
use maud::{Markup, html};
use plotters::series::LineSeries;
use plotters::style::Color;
use plumbline_charts::format::{maybe, number, whole};
use plumbline_charts::plot::{Axes, PlotError, RECTIFIED, REFUSED, from_zero, plain, plot};
use plumbline_sim::live::navigation::Navigation;
use plumbline_sim::live::report::Live;
use plumbline_sim::score::kept::Navigated;

/// Points of the curve at most: more than the page has pixels.
const POINTS_MAX: usize = 2000;

impl Report<'_> {
    /// Nothing of other flights.
    pub(super) fn live(&self) -> Result<Markup, PlotError> {
        let Some(live) = &self.summary.live else { return Ok(html! {}) };
        let navigation = self.summary.navigation.as_ref().and_then(Navigated::live);
        let curve = navigation.map(curve).transpose()?;
        Ok(html! {
            section {
                h2 { "With a real autopilot" }
                p class="note" {
                    "The autopilot flew in its own simulator, whose truth the frames were rendered at. What is compared here is the autopilot’s own position, GLOBAL_POSITION_INT, with that truth."
                }
                @if let Some(curve) = curve {
                    figure { (curve) figcaption {
                        b { "The autopilot’s horizontal error. " }
                        @if navigation.is_some_and(|navigation| navigation.gnss_lost_at_s.is_some()) {
                            span class="key line k-bad" {} "satellite navigation lost. "
                        }
                        "Seconds from the first exposure."
                    } }
                }
                (figures(live, navigation))
            }
        })
    }
}

fn curve(navigation: &Navigation) -> Result<Markup, PlotError> {
    let every = navigation.errors.len().div_ceil(POINTS_MAX).max(1);
    let points: Vec<(f64, f64)> =
        navigation.errors.iter().step_by(every).map(|error| (error.at_s, error.error_m)).collect();
    let axes = Axes {
        x: from_zero(points.iter().map(|point| point.0)),
        y: from_zero(points.iter().map(|point| point.1)),
        x_text: "time (s)",
        y_text: "error (m)",
        x_label: &|seconds| plain(*seconds),
        y_label: &|value| plain(*value),
    };
    plot("The autopilot's horizontal error over time, metres", &axes, |chart| {
        if let Some(lost_s) = navigation.gnss_lost_at_s {
            let line = [(lost_s, 0.0), (lost_s, axes.y.end)];
            chart.draw_series(LineSeries::new(line, REFUSED.stroke_width(3)))?;
        }
        chart.draw_series(LineSeries::new(points.iter().copied(), RECTIFIED.stroke_width(4)))?;
        Ok(())
    })
}

fn figures(live: &Live, navigation: Option<&Navigation>) -> Markup {
    let row = |name: &str, what: &str, value: String| {
        html! { tr { th { (name) small { (what) } } td class="n" { (value) } } }
    };
    let (truth, clock, exposures) = (&live.truth, &live.clock, &live.exposures);
    let delay = truth.attitude_delay_ms.map(|[delay_ms, _]| delay_ms);
    let missing = exposures.dropped + exposures.beyond_ground + exposures.without_truth;
    html! {
        div class="two" {
            @if let Some(navigation) = navigation {
                table {
                    thead { tr { th { "The autopilot’s own position" } th class="r" { "Value" } } }
                    tbody {
                        (row("Error, RMS", "From the first exposure to the end, horizontal.", number(navigation.rms_m, 2, "m")))
                        (row("Velocity error, RMS", "Likewise.", number(navigation.velocity_rms_m_s, 2, "m/s")))
                        @if let Some(lost_s) = navigation.gnss_lost_s {
                            (row("Without satellite navigation", "Until the end.", number(lost_s, 0, "s")))
                            @for (mark, error) in &navigation.error_after_loss_m {
                                (row(&format!("Error after {mark} s"), "", number(*error, 2, "m")))
                            }
                            (row("Error, RMS of 20 to 90 s", "After the loss.", maybe(navigation.rms_20_90_s_m, 2, "m")))
                        }
                    }
                }
            }
            table {
                thead { tr { th { "Times and frames" } th class="r" { "Value" } } }
                tbody {
                    (row("Truth, error of its instants", &format!("{} true states at {} Hz.", whole(truth.samples), truth.rate_hz), number(truth.error_ms, 2, "ms")))
                    (row("Age of the autopilot’s attitude", "Beyond its stamp, found in turns.", maybe(delay, 1, "ms")))
                    (row("Clock, scatter of its relation", &format!("{} exchanges; it stood still or jumped {} times.", whole(clock.exchanges), clock.jumps), number(clock.scatter_ms, 2, "ms")))
                    (row("… less the firmware’s exchanges", "Mean; what the firmware cannot know.", maybe(clock.firmware_offset_ms.map(|offset| offset[0]), 2, "ms")))
                    (row("Delivery after mid-exposure", &format!("Mean; at most {}.", number(exposures.delivery_ms[1], 0, "ms")), number(exposures.delivery_ms[0], 0, "ms")))
                    (row("Exposures without a frame", &format!("{} not made in time, {} saw beyond the ground, {} without truth.", exposures.dropped, exposures.beyond_ground, exposures.without_truth), whole(missing.into())))
                }
            }
        }
    }
}
