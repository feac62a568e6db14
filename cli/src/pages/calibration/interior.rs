//! Interior orientation of every head.

use super::Page;
use maud::{Markup, html};
use plumbline_charts::format::{NONE, number};
use plumbline_survey::adjust::INTERIOR_NAMES;
use plumbline_survey::adjust::rig::{HEAD, LENS, TIME};

/// How many of an interior orientation's numbers are pixels; the others have no unit.
const IN_PIXELS: usize = 3;

impl Page<'_> {
    pub(super) fn interiors(&self) -> Markup {
        let is_estimated = self.calibration.unknowns.iter().any(|unknown| unknown.number >= LENS);
        html! {
            section {
                h2 { "Interior orientation" }
                @if is_estimated {
                    div class="two" { @for (index, head) in self.calibration.heads.iter().enumerate() { div { (self.interior(index, head)) } } }
                    p class="note" { "c principal distance, xp and yp principal point (right, up), k and p Brown’s coefficients on normalised coordinates with y down; those that are not there are 0." }
                } @else {
                    table {
                        thead { tr { th { "As given" } @for name in &INTERIOR_NAMES[..IN_PIXELS] { th class="r" { (name) } } th { "Distortion" } } }
                        tbody {
                            @for (index, head) in self.calibration.heads.iter().enumerate() {
                                tr {
                                    th { "Head " (index + 1) }
                                    @for k in 0..IN_PIXELS { td class="n" { (written(k, head[LENS + k])) } }
                                    td { (distortion(head)) }
                                }
                            }
                        }
                    }
                    p class="note" { "Nothing of it was estimated: an error of the heads’ own calibration goes into the seams unseen." }
                }
                (self.times())
            }
        }
    }

    fn interior(&self, index: usize, head: &[f64; HEAD]) -> Markup {
        // A coefficient that is 0 and stays so is none.
        let is_there =
            |k: usize| k < IN_PIXELS || head[LENS + k] != 0.0 || self.calibration.sigma(index, LENS + k).is_some();
        html! {
            table {
                thead { tr { th { "Head " (index + 1) } th class="r" { "Start" } th class="r" { "Calibrated" } th class="r" { "Sigma" } } }
                tbody {
                    @for (k, name) in INTERIOR_NAMES.iter().enumerate().filter(|(k, _)| is_there(*k)) {
                        tr {
                            th { (name) }
                            td class="n" { (written(k, self.block.heads[index].values[LENS + k])) }
                            td class="n" { (written(k, head[LENS + k])) }
                            td class="n" { (self.calibration.sigma(index, LENS + k).map_or_else(|| "given".to_owned(), |sigma| written(k, sigma))) }
                        }
                    }
                }
            }
        }
    }

    /// Time offsets, where they were estimated.
    fn times(&self) -> Markup {
        let of: Vec<_> = self.calibration.unknowns.iter().filter(|unknown| unknown.number == TIME).collect();
        html! {
            @if !of.is_empty() {
                table {
                    thead { tr { th { "Exposed later than the station’s instant" } th class="r" { "By" } th class="r" { "Sigma" } } }
                    tbody {
                        @for unknown in of {
                            tr { th { "Head " (unknown.head + 1) } td class="n" { (number(1e3 * unknown.value, 3, "ms")) } td class="n" { (number(1e3 * unknown.sigma, 3, "ms")) } }
                        }
                    }
                }
            }
        }
    }
}

/// A number of the interior orientation.
fn written(k: usize, value: f64) -> String {
    match value {
        value if k < IN_PIXELS => number(value, 3, "px"),
        0.0 => "0".to_owned(),
        value => format!("{value:.3e}").replace('-', "−"),
    }
}

/// The coefficients that are not 0.
fn distortion(head: &[f64; HEAD]) -> String {
    let names = INTERIOR_NAMES.iter().enumerate().skip(IN_PIXELS);
    let some: Vec<String> = names
        .filter(|(k, _)| head[LENS + k] != 0.0)
        .map(|(k, name)| format!("{name} {}", written(k, head[LENS + k])))
        .collect();
    if some.is_empty() { NONE.to_owned() } else { some.join(", ") }
}
