//! `report.html` and `frames.csv` of `evaluate`: what a board would have made of a real flight's frames.

mod head;
mod map;
mod offsets;

use super::refusals::{FEW, every, explained};
use maud::{Markup, html};
use plumbline_charts::page::page;
use plumbline_charts::plot::PlotError;
use plumbline_sim::evaluate::Summary;
use plumbline_sim::evaluate::judge::Verdict;
use plumbline_sim::setup::Setup;
use plumbline_sim::setup::frames::table::Table;
use std::fmt::Write;

/// What the page is made of.
#[derive(Clone, Copy, Debug)]
pub struct Page<'a> {
    pub setup: &'a Setup,
    pub table: &'a Table,
    pub verdict: &'a Verdict,
    /// With the camera as it is found to sit.
    pub corrected: Option<&'a Verdict>,
    pub summary: &'a Summary,
}

impl Page<'_> {
    /// The page.
    ///
    /// # Errors
    /// [`PlotError`].
    pub fn html(&self) -> Result<String, PlotError> {
        let map = self.map()?;
        let offsets = self.offsets()?;
        let figures = &self.summary.figures;
        let are_few = (figures.accepted as f64) < FEW * figures.frames as f64;
        let body = html! {
            (self.head())
            @if are_few { (self.refusals()) }
            section {
                h2 { "Where, and how far off" }
                p class="note" {
                    "Offset of each fix from the " (self.zero()) ". A camera that sits otherwise than its file says moves fixes along with the heading: "
                    "along the camera’s axes they gather beside the middle. A map that is shifted as a whole moves all alike: along the map’s axes they do."
                }
                div class="plots" { (map) (offsets) }
            }
            @if !are_few { (self.refusals()) }
            (self.frames())
        };
        Ok(page("Plumbline evaluation", &body))
    }

    /// What offsets are counted from.
    fn zero(&self) -> &'static str {
        if self.table.knows_truth() { "true position" } else { "navigation’s position" }
    }

    /// A row a frame.
    pub fn csv(&self) -> String {
        let mut csv = String::from(
            "file,accepted,reason,east_m,north_m,sigma_east_m,sigma_north_m,offset_east_m,offset_north_m,error_m,right,risk\n",
        );
        for (row, frame) in self.table.rows.iter().zip(&self.verdict.frames) {
            let file = row.file.display();
            // Writing to a string cannot fail.
            let _ = match &frame.fix {
                Err(why) => writeln!(csv, "{file},0,{why},,,,,,,,,"),
                Ok(fix) => {
                    let ([east, north], [sigma_east, sigma_north]) = (fix.place_m, fix.sigma_m());
                    let [off_east, off_north] = fix.offset_m;
                    let right = u8::from(self.verdict.is_right(fix));
                    writeln!(
                        csv,
                        "{file},1,,{east},{north},{sigma_east},{sigma_north},{off_east},{off_north},{},{right},{}",
                        fix.off_m(),
                        fix.risk
                    )
                }
            };
        }
        csv
    }

    fn refusals(&self) -> Markup {
        let refused = &self.summary.figures.refused;
        html! {
            @if !refused.is_empty() {
                section {
                    h2 { "Frames without a fix" }
                    table {
                        thead { tr { th { "Reason" } th class="r" { "Frames" } } }
                        tbody { @for (why, count) in refused {
                            tr { th { (why) small { (explained(why)) } } td class="n" { (count) } }
                        } }
                    }
                    (every())
                }
            }
        }
    }

    fn frames(&self) -> Markup {
        let metres = |value: f64| plumbline_charts::format::number(value, 2, "");
        html! {
            section {
                h2 { "Frames" }
                div class="scroll" { table {
                    thead { tr { th { "Frame" } th { "Outcome" } th class="r" { "Offset east (m)" } th class="r" { "north (m)" } th class="r" { "Error (m)" } th class="r" { "Sigma east (m)" } th class="r" { "north (m)" } th class="r" { "Risk" } } }
                    tbody { @for (row, frame) in self.table.rows.iter().zip(&self.verdict.frames) {
                        tr {
                            td { (row.file.file_name().unwrap_or_default().to_string_lossy()) }
                            @match &frame.fix {
                                Err(why) => { td { (why) } @for _ in 0..6 { td {} } }
                                Ok(fix) => {
                                    @if self.verdict.is_right(fix) { td { "fixed" } } @else { td class="bad" { "wrong" } }
                                    td class="n" { (metres(fix.offset_m[0])) }
                                    td class="n" { (metres(fix.offset_m[1])) }
                                    td class="n" { (metres(fix.off_m())) }
                                    td class="n" { (metres(fix.sigma_m()[0])) }
                                    td class="n" { (metres(fix.sigma_m()[1])) }
                                    td class="n" { (format!("{:.0e}", fix.risk)) }
                                }
                            }
                        }
                    } }
                } }
            }
        }
    }
}
