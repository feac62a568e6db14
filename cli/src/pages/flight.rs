//! `report.html`: a flight on one page that needs nothing but itself.
//!
//! Everything on it is computed from the flight; given are the paper's figures alone, in `paper`. There is no request: pictures
//! are data URIs, plots are inline SVG, style and script (`player`) stand in the page. The same flight gives the same bytes, so no
//! date stands on it.

mod board;
mod errors;
mod faults;
mod head;
mod instants;
mod kept;
mod live;
mod overlay;
mod paper;
mod parameters;
mod plan;
mod player;
mod plots;
mod protection;
mod provenance;
mod strip;
mod surface;
mod verdict;
#[cfg(test)]
pub(crate) mod tests;

pub use strip::REFUSED_MAX;

use maud::html;
use plumbline_charts::page::page;
use plumbline_charts::plot::PlotError;
use plumbline_sim::run::Flight;
use plumbline_sim::score::{Scored, Summary};
use plumbline_sim::setup::Setup;

/// Distance from the truth at which a match counts as right, pixels: that of `match_rate`.
const RIGHT_PX: f64 = 1.5;

/// What a report is made of.
#[derive(Clone, Copy, Debug)]
pub struct Report<'a> {
    /// What was flown over, and with what.
    pub setup: &'a Setup,
    /// What came of it.
    pub flight: &'a Flight,
    /// Every frame against the truth, in the flight's order.
    pub scored: &'a [Scored],
    /// The figures of `report.json`.
    pub summary: &'a Summary,
}

impl Report<'_> {
    /// Whether a frame became a fix that is wrong, as `wrong_fixes` of `report.json` counts them.
    fn is_wrong(&self, scored: &Scored) -> bool {
        scored.accepted && scored.is_wrong(self.setup.scenario.vehicle.resolution_m)
    }

    /// The page.
    ///
    /// # Errors
    /// [`PlotError`].
    pub fn html(&self) -> Result<String, PlotError> {
        let title = format!("Plumbline flight: {}", self.summary.name());
        let plots = self.plots()?;
        let plan = self.plan()?;
        let live = self.live()?;
        let kept = self.kept()?;
        let protection = self.protection()?;
        let body = html! {
            (self.head())
            (plots)
            (self.faults())
            (live)
            (kept)
            (protection)
            (plan)
            (self.error_parts())
            (self.instants())
            (self.board())
            (self.parameters())
            (self.against_the_paper())
            (self.provenance())
        };
        Ok(page(&title, &body))
    }
}
