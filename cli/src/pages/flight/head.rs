//! Title, verdict and the four figures that matter.

use super::Report;
use super::verdict::{sigmas, verdict};
use maud::{Markup, html};
use plumbline_charts::format::{maybe, percent};
use plumbline_charts::page::{key, key_as};
use plumbline_sim::scenario::Ground;
use plumbline_sim::score::wrong;

impl Report<'_> {
    pub(super) fn head(&self) -> Markup {
        let summary = self.summary;
        let count = self.scored.iter().filter(|scored| self.is_wrong(scored)).count();
        let share = summary.accepted as f64 / summary.frames.max(1) as f64;
        let class = sigmas(summary).map_or("", |(class, _)| class);
        html! {
            header {
                p class="kicker" { "Plumbline " (env!("CARGO_PKG_VERSION")) " · flight report" }
                h1 { "Flight “" (summary.name()) "”" }
                p class="note" { (summary.frames) " frames over " (self.ground()) " · " (link_name(&summary.link)) " · seed " (summary.seed) }
                (verdict(summary))
                @if let Some(why) = &summary.aborted {
                    p class="verdict bad" { "The flight ended early: " (why) "." }
                }
                @if count > 0 {
                    p class="verdict bad" { "Wrong fixes: " (count) ", off by " (wrong::meaning()) "." }
                }
                div class="keys" {
                    (key(&format!("{} of {}", summary.accepted, summary.frames), &format!("frames fixed ({})", percent(share))))
                    (key(&maybe(summary.matching_error_px.rectified_mean, 2, "px"), "mean matching error, rectified"))
                    (key(&maybe(summary.ground_error_m.mean, 2, "m"), "mean ground error"))
                    (key_as(class, &maybe(summary.nees_mean, 2, ""), "NEES (2 expected)"))
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
