//! Where the error comes from, and whether the firmware knows how large it is.

use super::Report;
use maud::{Markup, html};
use plumbline_charts::format::{NONE, maybe, number};

impl Report<'_> {
    pub(super) fn error_parts(&self) -> Markup {
        let summary = self.summary;
        let errors = &summary.matching_error_px;
        let resolution_m = self.setup.scenario.vehicle.resolution_m;
        let row = |name: &str, what: &str, px: Option<f64>| {
            html! {
                tr {
                    th { (name) small { (what) } }
                    td class="n" { (maybe(px, 3, "px")) }
                    td class="n" { (maybe(px.map(|px| px * resolution_m), 2, "m")) }
                }
            }
        };
        html! {
            section class="two" {
                div {
                    h2 { "Where the error comes from" }
                    table {
                        thead { tr { th { "Part, mean length" } th class="r" { "Reference" } th class="r" { "Ground" } } }
                        tbody {
                            (row("Attitude", "What the error of the pose used does to the nadir: about height × tilt error.", errors.attitude_mean))
                            (row("Matching", "What is left without it.", errors.matching_mean))
                            (row("Together", "Accepted frames, sub-pixel.", errors.rectified_mean))
                        }
                    }
                    p class="note" { "Both parts are vectors: their mean lengths do not add up." }
                }
                div {
                    h2 { "Stated against actual accuracy" }
                    table {
                        thead { tr { th { "Accepted frames" } th class="r" { "Value" } } }
                        tbody {
                            tr { th { "Ground error, mean" } td class="n" { (maybe(summary.ground_error_m.mean, 2, "m")) } }
                            tr { th { "Ground error, 95th percentile" } td class="n" { (maybe(summary.ground_error_m.p95, 2, "m")) } }
                            tr {
                                th { "NEES, mean" small { "Error squared in units of the stated covariance, 2 degrees of freedom." } }
                                td class="n" { (maybe(summary.nees_mean, 2, "")) }
                            }
                            tr {
                                th { "… where it should lie" small { "95 % of flights with this many independent, rightly stated errors." } }
                                td class="n" { (expected_nees(summary.accepted).map_or_else(|| NONE.to_owned(), range)) }
                            }
                        }
                    }
                    p class="note" { "Above the range the stated covariance is too small, below it too large. An attitude that drifts makes neighbouring errors alike and the range wider." }
                }
            }
        }
    }
}

/// Where the mean of `count` draws of χ² with 2 degrees of freedom, which has mean 2 and variance 4, lies in 95 % of cases; `None`
/// of none.
pub(super) fn expected_nees(count: usize) -> Option<(f64, f64)> {
    let reach = 1.96 * 2.0 / (count as f64).sqrt();
    (count > 0).then(|| ((2.0 - reach).max(0.0), 2.0 + reach))
}

fn range((low, high): (f64, f64)) -> String {
    format!("{} to {}", number(low, 2, ""), number(high, 2, ""))
}
