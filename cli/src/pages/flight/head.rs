//! Title, verdict and the four figures that matter.

use super::paper::{RAW_PX, RECTIFIED_PX};
use super::{RIGHT_PX, Report};
use maud::{Markup, html};
use plumbline_charts::format::{maybe, number, percent};
use plumbline_charts::page::key;
use plumbline_sim::scenario::Ground;
use plumbline_sim::score::Summary;

impl Report<'_> {
    pub(super) fn head(&self) -> Markup {
        let summary = self.summary;
        let wrong = self.scored.iter().filter(|scored| Self::is_wrong(scored)).count();
        let share = summary.accepted as f64 / summary.frames.max(1) as f64;
        html! {
            header {
                p class="kicker" { "Plumbline " (env!("CARGO_PKG_VERSION")) " · flight report" }
                h1 { "Flight “" (summary.name()) "”" }
                p class="note" { (summary.frames) " frames over " (self.ground()) " · " (link_name(&summary.link)) " · seed " (summary.seed) }
                p class="verdict" { (verdict(summary)) }
                @if let Some(why) = &summary.aborted {
                    p class="verdict bad" { "The flight ended early: " (why) "." }
                }
                @if wrong > 0 {
                    p class="verdict bad" { "Wrong fixes: " (wrong) ", more than " (RIGHT_PX) " px from the truth." }
                }
                div class="keys" {
                    (key(&format!("{} of {}", summary.accepted, summary.frames), &format!("frames fixed ({})", percent(share))))
                    (key(&maybe(summary.matching_error_px.rectified_mean, 2, "px"), "mean matching error, rectified"))
                    (key(&maybe(summary.ground_error_m.mean, 2, "m"), "mean ground error"))
                    (key(&maybe(summary.nees_mean, 2, ""), "NEES (2 expected)"))
                }
            }
        }
    }
}

impl Report<'_> {
    /// What was flown over, without the folders it lies in.
    fn ground(&self) -> String {
        match &self.setup.scenario.world.ground {
            Ground::Procedural => "procedural ground".to_owned(),
            Ground::Ortho { ortho, .. } => {
                ortho.file_name().map_or_else(|| "an orthophoto".to_owned(), |name| name.to_string_lossy().into_owned())
            }
        }
    }
}

/// A link as a person would call it.
pub fn link_name(link: &str) -> &str {
    match link {
        "inproc" => "firmware in this process",
        "qemu" => "firmware on an emulated Cortex-M7 (QEMU)",
        "serial" => "firmware on a board, over a serial line",
        other => other,
    }
}

/// One line: what came out, and on which side of the paper.
fn verdict(summary: &Summary) -> String {
    let matching = &summary.matching_error_px;
    let (Some(rectified), Some(ground)) = (matching.rectified_mean, summary.ground_error_m.mean) else {
        return format!("None of the {} frames became a fix.", summary.frames);
    };
    let against = if rectified < RECTIFIED_PX { "below" } else { "not below" };
    let from = matching.unrectified_mean.map_or_else(String::new, |raw| format!("from {} ", number(raw, 2, "px")));
    format!(
        "Rectification brings the matching error {from}down to {}, {against} the paper’s {} (from {}); fixes lie {} \
         from the true position on average.",
        number(rectified, 2, "px"),
        number(RECTIFIED_PX, 1, "px"),
        number(RAW_PX, 1, "px"),
        number(ground, 2, "m"),
    )
}
