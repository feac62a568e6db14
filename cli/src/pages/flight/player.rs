//! What the page's script needs: a slider over the frames, and their figures.
//!
//! The script (`player.js`) marks the frame that is chosen on the track, on the curve of errors and in a table, and shows its
//! pictures. Without it the page shows all of that but the marks and the table.

use super::Report;
use super::plots::track::local;
use maud::{Markup, PreEscaped, html};
use plumbline_sim::score::{length, reason};
use serde::Serialize;

/// A column a figure, a row a frame. Metres relative to the tile's centre, seconds of the simulated time.
#[derive(Debug, Default, Serialize)]
struct Rows {
    frame: Vec<u32>,
    s: Vec<f64>,
    /// True place.
    truth: Vec<[f64; 2]>,
    /// Place of the fix.
    fix: Vec<Option<[f64; 2]>>,
    /// Its distance from the true one.
    off: Vec<Option<f64>>,
    /// As it is stated: the root of the sum of both variances.
    sigma: Vec<Option<f64>>,
    score: Vec<Option<f64>>,
    is_wrong: Vec<bool>,
    /// Why there is no fix; empty where there is one.
    why: Vec<&'static str>,
}

impl Report<'_> {
    /// Slider, table and script.
    pub(super) fn player(&self, pictured: &[usize]) -> Markup {
        let rows = self.rows(pictured);
        let last = rows.frame.len().saturating_sub(1);
        // Inside a script only the end of the element has a meaning, and it has a "<".
        let data = serde_json::to_string(&rows).unwrap_or_default().replace('<', "\\u003c");
        html! {
            div id="player" class="player" hidden {
                div class="transport" {
                    button type="button" data-step="-1" aria-label="previous frame" { "◀" }
                    input type="range" min="0" max=(last) value="0" step="1" aria-label="frame" list="pictured";
                    button type="button" data-step="1" aria-label="next frame" { "▶" }
                    datalist id="pictured" { @for index in pictured { @if let Ok(place) = rows.frame.binary_search(&self.scored[*index].frame) { option value=(place) {} } } }
                    output {}
                }
            }
            script id="rows" type="application/json" { (PreEscaped(data)) }
        }
    }

    /// Where the script puts its table, and the script itself, which needs everything above it.
    pub(super) fn table(&self) -> Markup {
        html! {
            p class="note" id="rows-note" { "Correlation: of patch and reference at the place found, 1 at most. A frame is decided by the risk of being wrong, not by this alone." }
            div id="table" class="rows" hidden tabindex="-1" aria-label="frames" {}
            div id="tip" class="tip" role="status" hidden {}
            script { (PreEscaped(include_str!("player.js"))) }
        }
    }

    /// Of many frames those that are drawn and those with pictures.
    fn rows(&self, pictured: &[usize]) -> Rows {
        let mut rows = Rows::default();
        let mut shown = [&self.drawn()[..], pictured].concat();
        shown.sort_unstable();
        shown.dedup();
        for (record, scored) in shown.into_iter().map(|index| (&self.flight.frames[index], &self.scored[index])) {
            let fix = record.report.and_then(|report| report.fix);
            let cm = |metres: f64| (100.0 * metres).round() / 100.0;
            let sigma = fix.map(|fix| f64::from(fix.variance_east_m2 + fix.variance_north_m2).sqrt());
            let (east, north) = local(self.setup, [record.truth.east_m, record.truth.north_m]);
            rows.frame.push(scored.frame);
            rows.s.push((1e-4 * record.exposure.mid_us() as f64).round() / 100.0);
            rows.truth.push([cm(east), cm(north)]);
            rows.fix.push(fix.map(|fix| [fix.east_m, fix.north_m].map(|metres| cm(metres.into()))));
            rows.off.push(scored.error_m.map(|error| cm(length(error))));
            rows.sigma.push(sigma.filter(|sigma| sigma.is_finite()).map(cm));
            let score = record.report.and_then(|report| report.matched).map(|matched| f64::from(matched.correlation));
            rows.score.push(score.map(|score| (1000.0 * score).round() / 1000.0));
            rows.is_wrong.push(self.is_wrong(scored));
            rows.why.push(reason(record).unwrap_or_default());
        }
        rows
    }
}
