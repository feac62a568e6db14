//! A flight that is kept by its fixes: where it was to go, where it went and where its autopilot believed to be.

use super::Report;
use maud::{Markup, html};
use plotters::series::LineSeries;
use plotters::style::Color;
use plumbline_charts::format::{maybe, number, whole};
use plumbline_charts::plot::{Axes, PAPER, PlotError, RECTIFIED, REFUSED, from_zero, plain, plot};
use plumbline_sim::score::kept::{Kept, Navigated};
use plumbline_sim::vehicle::aloft::moment::Moment;

/// Points of a curve at most: more than the page has pixels.
const POINTS_MAX: usize = 2000;

impl Report<'_> {
    /// Nothing of other flights.
    pub(super) fn kept(&self) -> Result<Markup, PlotError> {
        let Some(kept) = self.summary.navigation.as_ref().and_then(Navigated::kept) else { return Ok(html! {}) };
        let every = kept.track.moments.len().div_ceil(POINTS_MAX).max(1);
        let moments: Vec<&Moment> = kept.track.moments.iter().step_by(every).collect();
        let errors = errors(kept, &moments, true)?;
        let close = errors_with_fixes(kept, &moments)?;
        Ok(html! {
            section {
                h2 { "Kept by its fixes" }
                p class="note" {
                    "The aeroplane flew where its autopilot believed to be: by inertial sensors, barometer, compass, satellite navigation until it was lost, and what the firmware sent. Without fixes: the same filter on the same flight, which got none since."
                }
                div class="two" {
                    figure { (close) figcaption {
                        b { "Horizontal error of the autopilot’s position " } "with fixes. "
                        (lost_key(kept))
                        "Seconds of the simulated time."
                    } }
                    figure { (errors) figcaption {
                        b { "The same " }
                        span class="key line k-ours" {} "with fixes and "
                        span class="key line k-paper" {} "without. "
                        (lost_key(kept))
                    } }
                }
                (figures(kept))
            }
        })
    }
}

fn lost_key(kept: &Kept) -> Markup {
    html! {
        @if kept.gnss_lost_s.is_some() {
            span class="key line k-bad" {} "satellite navigation lost. "
        }
    }
}

fn errors_with_fixes(kept: &Kept, moments: &[&Moment]) -> Result<Markup, PlotError> {
    errors(kept, moments, false)
}

/// The error over time, and that without fixes where it is wanted.
fn errors(kept: &Kept, moments: &[&Moment], has_free: bool) -> Result<Markup, PlotError> {
    let own: Vec<(f64, f64)> = moments.iter().map(|moment| (moment.at_s, moment.error_m())).collect();
    let free: Vec<(f64, f64)> =
        moments.iter().filter(|_| has_free).filter_map(|moment| Some((moment.at_s, moment.free_error_m()?))).collect();
    let axes = Axes {
        x: from_zero(own.iter().map(|point| point.0)),
        y: from_zero(own.iter().chain(&free).map(|point| point.1)),
        x_text: "time (s)",
        y_text: "error (m)",
        x_label: &|seconds| plain(*seconds),
        y_label: &|value| plain(*value),
    };
    let label = if has_free { "with fixes and without" } else { "with fixes" };
    plot(&format!("Horizontal error of the autopilot's position {label} over time, metres"), &axes, |chart| {
        if let Some(lost_s) = kept.gnss_lost_s {
            chart.draw_series(LineSeries::new([(lost_s, 0.0), (lost_s, axes.y.end)], REFUSED.stroke_width(3)))?;
        }
        chart.draw_series(LineSeries::new(free.iter().copied(), PAPER.stroke_width(4)))?;
        chart.draw_series(LineSeries::new(own.iter().copied(), RECTIFIED.stroke_width(4)))?;
        Ok(())
    })
}

fn figures(kept: &Kept) -> Markup {
    let row = |name: &str, what: &str, value: String| {
        html! { tr { th { (name) small { (what) } } td class="n" { (value) } } }
    };
    let Kept { fixes, autopilot, gnss, .. } = kept;
    let span = match kept.gnss_lost_s {
        Some(lost_s) => format!("Horizontal, from 20 s after satellite navigation was lost at {lost_s} s."),
        None => "Horizontal, from 20 s on; satellite navigation was not lost.".to_owned(),
    };
    html! {
        div class="two" {
            table {
                thead { tr { th { "The autopilot’s own position" } th class="r" { "Value" } } }
                tbody {
                    (row("Error, RMS", &span, maybe(autopilot.rms_m, 2, "m")))
                    (row("Error, largest", "", maybe(autopilot.max_m, 2, "m")))
                    (row("NEES a degree of freedom", "1 expected; below, its filter is more careful than it has to be.", maybe(autopilot.nees, 2, "")))
                    (row("Drift", "What the error grew by.", maybe(kept.drift_m_min, 2, "m/min")))
                    (row("Velocity error, RMS", "", maybe(kept.velocity_rms_m_s, 2, "m/s")))
                    (row("Heading error, RMS", "", maybe(kept.heading_rms_deg, 2, "°")))
                }
            }
            table {
                thead { tr { th { "The flight" } th class="r" { "Value" } } }
                tbody {
                    (row("Beside its legs, RMS", "True place, turns onto them left out.", maybe(kept.across_rms_m, 1, "m")))
                    (row("Beside its legs, largest", "", maybe(kept.across_max_m, 1, "m")))
                    (row("Fixes taken", "By the autopilot’s filter.", whole(fixes.fused.into())))
                    (row("Fixes rejected", "Beyond its gate.", whole(fixes.rejected.into())))
                    (row("Jumps to a fix", "", whole(fixes.resets.into())))
                    @if let Some(at_s) = gnss.disagreed_at_s {
                        (row("Satellites disagree with the map", "Told first, seconds of the simulated time.", maybe(Some(at_s), 1, "s")))
                        (row("By", "Told then.", maybe(gnss.offset_m, 0, "m")))
                    }
                    @if let Some(free) = kept.without_fixes {
                        (row("Without fixes: error, RMS", "", maybe(free.rms_m, 1, "m")))
                        (row("Without fixes: error, largest", "", maybe(free.max_m, 1, "m")))
                        (row("Without fixes: drift", "", free.drift_m_min.map_or_else(|| maybe(None, 1, ""), |drift| number(drift, 1, "m/min"))))
                    }
                }
            }
        }
    }
}
