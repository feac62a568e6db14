//! What paper 003 reports, beside what this flight gave. Its figures are the only ones on the page that are not
//! computed.

use super::{RIGHT_PX, Report};
use maud::{Markup, html};
use plumbline_charts::format::{NONE, NOT_MEASURED, bytes, maybe, number, percent, whole};
use plumbline_core::budget::{PAPER_MEMORY_BYTES, PAPER_TIME_MS};

/// Ground error of the automatic model, metres (Table 2).
pub const GROUND_M: f64 = 2.7;
/// Mean matching error without rectification, pixels (Table 3).
pub const RAW_PX: f64 = 3.7;
/// Mean matching error with rectification, pixels (Table 3).
pub const RECTIFIED_PX: f64 = 1.3;
/// What rectification adds to the matching rate, percent (section 5).
const RATE_PERCENT: f64 = 3.0;

impl Report<'_> {
    /// The table paper against ours.
    pub(super) fn against_the_paper(&self) -> Markup {
        let summary = self.summary;
        let (matching, ground, rate) = (&summary.matching_error_px, &summary.ground_error_m, &summary.match_rate);
        let time = summary.cost().map_or_else(
            || NOT_MEASURED.to_owned(),
            |(mean, max, _, name)| format!("{} {name} a frame, at most {}", whole(mean.round() as u64), whole(max)),
        );
        let px = |value| maybe(value, 2, "px");
        html! {
            section {
                h2 { "Against the paper" }
                table class="wide" {
                    thead { tr { th { "Quantity" } th class="r" { "Paper" } th class="r" { "This flight" } } }
                    tbody {
                        tr {
                            th { "Time for one frame" small { "Table 2, one rectification on a TMS320C6701. Ours: the whole frame from edge to fix, matching included. An instruction count is no time: no milliseconds are claimed. Cycles are those of the board’s own counter." } }
                            td class="n" { (number(f64::from(PAPER_TIME_MS), 0, "ms")) }
                            td class="n" { (time) }
                        }
                        tr {
                            th { "Memory" small { "Table 2, program and data of the rectification. Ours: static memory and the stack’s high-water mark of the whole application, without the program in flash." } }
                            td class="n" { (number(PAPER_MEMORY_BYTES as f64 / 1024.0, 0, "KB")) }
                            td class="n" { (summary.ram_bytes.map_or_else(|| NOT_MEASURED.to_owned(), bytes)) }
                        }
                        tr {
                            th { "Ground error" small { "Table 2, of the rectified picture. Ours: fix minus true position, mean of the accepted frames." } }
                            td class="n" { (number(GROUND_M, 1, "m")) }
                            td class="n" { (maybe(ground.mean, 2, "m")) }
                        }
                        tr {
                            th { "Matching error, unrectified" small { "Table 3. Ours: whole-pixel peak, mean of all frames." } }
                            td class="n" { (number(RAW_PX, 1, "px")) }
                            td class="n" { (px(matching.unrectified_mean)) }
                        }
                        tr {
                            th { "Matching error, rectified" small { "Table 3. Ours: whole-pixel peak, mean of the accepted frames." } }
                            td class="n" { (number(RECTIFIED_PX, 1, "px")) }
                            td class="n" { (px(matching.rectified_integer_mean)) }
                        }
                        tr {
                            th { "… sub-pixel" small { "Mean of the accepted frames." } }
                            td class="n" { (NONE) }
                            td class="n strong" { (px(matching.rectified_mean)) }
                        }
                        tr {
                            th { "… sub-pixel, 95th percentile; largest" small { "Of the accepted frames." } }
                            td class="n" { (NONE) }
                            td class="n" { (px(matching.rectified_p95)) "; " (px(matching.accepted_max)) }
                        }
                        tr {
                            th { "Matching rate" small { "Section 5: what rectification adds. Ours: share of all frames within " (RIGHT_PX) " px of the truth, without and with it." } }
                            td class="n" { "+" (number(RATE_PERCENT, 0, "%")) }
                            td class="n" { (percent(rate.unrectified)) " → " (percent(rate.rectified)) }
                        }
                    }
                }
            }
        }
    }
}
