//! `report.html`: a flight on one page that needs nothing but itself.
//!
//! Everything on it is computed from the flight; given are the paper's figures alone, in `paper`. There is no script
//! and no request: pictures are data URIs, plots are inline SVG, the style stands in the page. The same flight gives
//! the same bytes, so no date stands on it.

mod board;
mod errors;
pub(crate) mod format;
mod head;
mod instants;
mod overlay;
mod paper;
mod parameters;
mod plan;
pub(crate) mod plots;
pub(crate) mod png;
mod provenance;
mod strip;
#[cfg(test)]
pub(crate) mod tests;

use crate::fly::Flight;
use crate::score::{Scored, Summary, length};
use crate::stage::Stage;
use maud::{DOCTYPE, Markup, PreEscaped, html};
use std::fmt;

/// Distance from the truth at which a match counts as right, pixels: that of `match_rate`.
const RIGHT_PX: f64 = 1.5;

/// What a report is made of.
#[derive(Clone, Copy, Debug)]
pub struct Report<'a> {
    /// What was flown over, and with what.
    pub stage: &'a Stage,
    /// What came of it.
    pub flight: &'a Flight,
    /// Every frame against the truth, in the flight's order.
    pub scored: &'a [Scored],
    /// The figures of `report.json`.
    pub summary: &'a Summary,
}

/// Why there is no report: a plot that could not be drawn.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ReportError(String);

impl fmt::Display for ReportError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "the report cannot be drawn: {}", self.0)
    }
}

impl std::error::Error for ReportError {}

impl Report<'_> {
    /// Whether a frame became a fix that is wrong.
    fn is_wrong(scored: &Scored) -> bool {
        scored.accepted && scored.error_px.is_none_or(|error| length(error) > RIGHT_PX)
    }

    /// The page.
    ///
    /// # Errors
    /// [`ReportError`].
    pub fn html(&self) -> Result<String, ReportError> {
        let title = format!("Plumbline flight: {}", self.summary.scenario);
        let plots = self.plots()?;
        let plan = self.plan()?;
        let body = html! {
            (self.head())
            (self.against_the_paper())
            (plots)
            (self.error_parts())
            (self.instants())
            (plan)
            (self.strip())
            (self.board())
            (self.parameters())
            (self.provenance())
        };
        Ok(page(&title, &body))
    }
}

/// A page with its style and nothing from outside.
pub(crate) fn page(title: &str, body: &Markup) -> String {
    let page = html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                title { (title) }
                style { (PreEscaped(include_str!("report/style.css"))) }
            }
            body { main { (body) } }
        }
    };
    page.into_string()
}

/// A figure of the strip below the verdict: its value, and what it is.
pub(crate) fn key(value: &str, name: &str) -> Markup {
    html! { div { b { (value) } span { (name) } } }
}
