//! Title, verdict and the figures that matter.

use super::Page;
use maud::{Markup, html};
use plumbline_charts::format::{maybe, minus, percent, short};
use plumbline_charts::page::{key, said};
use plumbline_sim::evaluate::judge::{Figures, RIGHT_PX};

impl Page<'_> {
    pub(super) fn head(&self) -> Markup {
        let figures = &self.summary.figures;
        html! {
            header {
                p class="kicker" { "Plumbline " (env!("CARGO_PKG_VERSION")) " · evaluation of real frames" }
                h1 { (figures.frames) " frames through the board’s own chain" }
                p class="note" {
                    (self.table.name) " · EPSG:" (self.summary.epsg) " · " (short(self.summary.resolution_m)) " m a pixel · search ±"
                    (self.setup.scenario.vehicle.search_px) " px"
                }
                @let (class, words) = verdict(figures);
                p class="verdict" { span class=(class) { (words) } " " (minus(&sentence(&self.summary.platform.says))) }
                @for says in self.summary.heights.iter().chain(&self.summary.headings) {
                    p class="verdict bad" { (said(says)) }
                }
                @if figures.wrong > 0 {
                    p class="verdict bad" { "Wrong fixes: " (figures.wrong) ", more than " (RIGHT_PX) " px from " (self.middle()) "." }
                }
                @if !self.table.knows_truth() {
                    p class="note" { "No truth is known: what all fixes have in common, of the navigation, the camera or the map, is not counted as an error." }
                }
                (keys(figures))
                @if let Some(corrected) = self.corrected {
                    p class="verdict" { "With the camera as it is found to sit:" }
                    (keys(&corrected.figures()))
                }
            }
        }
    }

    fn middle(&self) -> &'static str {
        if self.table.knows_truth() { "the true position" } else { "the flight’s median offset" }
    }
}

fn keys(figures: &Figures) -> Markup {
    let share = percent(figures.accepted as f64 / figures.frames.max(1) as f64);
    html! {
        div class="keys" {
            (key(&format!("{} of {}", figures.accepted, figures.frames), &format!("frames fixed ({share})")))
            (key(&format!("{} right, {} wrong", figures.right, figures.wrong), "of those"))
            (key(&maybe(figures.median_distance_m, 1, "m"), "median distance from the navigation"))
            (key(&maybe(figures.nees_mean, 1, ""), "NEES (2 expected)"))
        }
    }
}

/// The class of the verdict's colour, and the verdict.
fn verdict(figures: &Figures) -> (&'static str, String) {
    match (figures.accepted, figures.nees_mean) {
        (0, _) | (_, None) => ("bad", "None of the frames became a fix.".to_owned()),
        (_, Some(nees)) if nees > 4.0 => {
            ("bad", format!("The stated sigmas are {:.1} times too small on this flight.", (0.5 * nees).sqrt()))
        }
        (_, Some(nees)) if nees < 1.0 => {
            ("warn", format!("The stated sigmas are {:.1} times larger than they need to be.", (2.0 / nees).sqrt()))
        }
        _ => ("good", "The fixes are as good as they say.".to_owned()),
    }
}

/// With a capital, and an end.
fn sentence(says: &str) -> String {
    let mut letters = says.chars();
    letters.next().map_or_else(String::new, |first| format!("{}{}.", first.to_uppercase(), letters.as_str()))
}
