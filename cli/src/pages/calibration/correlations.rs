//! Which unknowns can hardly be told apart.

use super::Page;
use maud::{Markup, html};
use plumbline_charts::format::number;
use plumbline_survey::calibrate::{Correlation, unknown_name};

/// How many are shown.
const SHOWN: usize = 8;

impl Page<'_> {
    pub(super) fn correlations(&self) -> Markup {
        let among = self.among_heads();
        html! {
            section class="two" {
                div {
                    h2 { "Angles against line elements" }
                    (table(&self.calibration.correlations))
                    p class="note" { "Of the first unknown station, with itself and with the heads, largest first: the correlation for which the paper constrains the heads’ centres." }
                }
                div {
                    h2 { "Correlations among the heads" }
                    (table(&among))
                    p class="note" {
                        "Unknowns of the heads, largest first. Smallest eigenvalue of the equations scaled to a diagonal of ones: "
                        (format!("{:.1e}", self.calibration.eigenvalue_min).replace('-', "−")) "; 0 would be undetermined."
                    }
                }
            }
        }
    }

    fn among_heads(&self) -> Vec<Correlation> {
        let (unknowns, covariance) = (&self.calibration.unknowns, &self.calibration.covariance);
        let mut all = Vec::new();
        for (i, a) in unknowns.iter().enumerate() {
            for (j, b) in unknowns.iter().enumerate().skip(i + 1) {
                let value = covariance[i][j] / (a.sigma * b.sigma);
                // Observations without noise leave no sigma.
                if value.is_finite() {
                    all.push(Correlation { a: unknown_name(a), b: unknown_name(b), value });
                }
            }
        }
        all.sort_by(|a, b| b.value.abs().total_cmp(&a.value.abs()));
        all
    }
}

fn table(correlations: &[Correlation]) -> Markup {
    html! {
        table {
            thead { tr { th { "Unknown" } th { "with" } th class="r" { "Correlation" } } }
            tbody {
                @for of in correlations.iter().take(SHOWN) {
                    tr { th { (of.a) } td { (of.b) } td class="n" { (number(of.value, 3, "")) } }
                }
                @if correlations.is_empty() { tr { th { "Too few unknowns" } td { "–" } td class="n" { "–" } } }
            }
        }
    }
}
