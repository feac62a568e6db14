//! How far the observations control each other, and which fit worst.

use super::Page;
use maud::{Markup, html};
use plumbline_charts::format::{maybe, number, percent, whole};
use plumbline_survey::calibrate::OUTLIER_SIGMAS;

/// Redundancy below which a mistake is hardly seen.
const WEAK: f64 = 0.1;
/// Worst observations shown.
const SHOWN: usize = 12;

impl Page<'_> {
    pub(super) fn control(&self) -> Markup {
        html! {
            section {
                h2 { "Observations" }
                div class="plots" {
                    figure { (self.redundancy_histogram()) figcaption {
                        b { "Redundancy numbers. " } "Part of a mistake in an image coordinate that its own residual shows: 0 is uncontrolled, 1 wholly controlled."
                    } }
                    figure { (self.standardised_histogram()) figcaption {
                        b { "Standardised residuals. " }
                        span class="key box k-ours" {} "residuals over their standard deviations, beyond ±5 in the outer classes; "
                        span class="key line k-paper" {} "the normal distribution."
                    } }
                    div { (self.control_table()) }
                }
            }
            section class="two tall" {
                div { h2 { "Worst observations" } (self.worst()) }
                div { h2 { "Block" } (self.counts()) }
            }
        }
    }

    fn control_table(&self) -> Markup {
        let redundancies = || self.calibration.residuals.iter().flat_map(|residual| residual.redundancy);
        let count = redundancies().count();
        let mean = redundancies().sum::<f64>() / count.max(1) as f64;
        let weak =
            self.calibration.residuals.iter().filter(|residual| residual.redundancy.iter().any(|part| *part < WEAK));
        let (squares, standardised) =
            self.standardised().fold((0.0, 0), |(sum, n), value| (sum + value * value, n + 1));
        let spread = (standardised > 0).then(|| (squares / f64::from(standardised)).sqrt());
        let beyond =
            self.standardised().filter(|value| value.abs() > 3.0).count() as f64 / f64::from(standardised.max(1));
        let row = |name: &str, what: &str, value: String| html! { tr { th { (name) small { (what) } } td class="n" { (value) } } };
        html! {
            table {
                thead { tr { th { "All observations" } th class="r" { "Value" } } }
                tbody {
                    (row("Redundancy, mean", "Of an image coordinate.", number(mean, 3, "")))
                    (row(&format!("Observations below {WEAK}"), "In x or in y: a mistake there is hardly seen.", whole(weak.count() as u64)))
                    (row("Standardised residuals, RMS", "1 where the model holds.", maybe(spread, 3, "")))
                    (row("… beyond 3", "0.3 % of good ones.", percent(beyond)))
                    (row(&format!("Observations beyond {OUTLIER_SIGMAS}"), "Reported as outliers; all stay in the adjustment.", whole(self.calibration.outliers.len() as u64)))
                }
            }
        }
    }

    fn worst(&self) -> Markup {
        let residuals = &self.calibration.residuals;
        let mut order: Vec<usize> = (0..residuals.len()).collect();
        order.sort_by(|a, b| residuals[*b].worst().total_cmp(&residuals[*a].worst()));
        let pair = |values: [f64; 2]| format!("{}, {}", number(values[0], 2, ""), number(values[1], 2, ""));
        html! {
            table class="wide" {
                thead { tr { th { "Where" } th class="n" { "Residual x, y (px)" } th class="n" { "Redun­dancy x, y" } th class="n" { "Standard­ised x, y" } } }
                tbody {
                    @for (index, seen) in order.iter().take(SHOWN).map(|index| (*index, &self.observations.seen[*index])) {
                        tr {
                            th { "Line " (self.observations.lines[index]) small { "station " (seen.station) ", head " (seen.head + 1) ", point " (seen.point) } }
                            td class="n" { (pair(residuals[index].v_px)) }
                            td class="n" { (pair(residuals[index].redundancy)) }
                            td class=(if residuals[index].worst() > OUTLIER_SIGMAS { "n bad" } else { "n" }) { (pair(residuals[index].standardised)) }
                        }
                    }
                }
            }
            p class="note" { "Lines of " (file_name(&self.observations.name)) ", by their larger standardised residual. Beyond " (OUTLIER_SIGMAS) " is red." }
        }
    }
}

/// A file without the folders it lies in.
fn file_name(path: &str) -> String {
    let name = std::path::Path::new(path).file_name();
    name.map_or_else(|| path.to_owned(), |name| name.to_string_lossy().into_owned())
}
