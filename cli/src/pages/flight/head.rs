//! Title, verdict and the four figures that matter.

use super::verdict::{sigmas, verdict};
use super::{RIGHT_PX, Report};
use maud::{Markup, html};
use plumbline_charts::format::{maybe, percent};
use plumbline_charts::page::key;
use plumbline_sim::scenario::Ground;

impl Report<'_> {
    pub(super) fn head(&self) -> Markup {
        let summary = self.summary;
        let wrong = self.scored.iter().filter(|scored| Self::is_wrong(scored)).count();
        let share = summary.accepted as f64 / summary.frames.max(1) as f64;
        let nees = key(&maybe(summary.nees_mean, 2, ""), "NEES (2 expected)");
        html! {
            header {
                p class="kicker" { "Plumbline " (env!("CARGO_PKG_VERSION")) " · flight report" }
                h1 { "Flight “" (summary.name()) "”" }
                p class="note" { (summary.frames) " frames over " (self.ground()) " · " (link_name(&summary.link)) " · seed " (summary.seed) }
                (verdict(summary))
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
                    @if let Some((class, _)) = sigmas(summary) { div class=(class) { (nees) } } @else { (nees) }
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
