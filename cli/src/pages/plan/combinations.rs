//! The combinations of overlaps that were looked at, as a table of side by forward overlap.

use super::Page;
use maud::{Markup, html};
use plumbline_charts::format::{NONE, number, whole};
use plumbline_survey::plan::file::{Combination, Limit};

impl Page<'_> {
    pub(super) fn combinations(&self) -> Markup {
        let all = &self.outputs.file.combinations;
        if all.is_empty() {
            return html! {};
        }
        let forwards = distinct(all.iter().map(|one| one.forward));
        let sides = distinct(all.iter().map(|one| one.side));
        let of = |side: f64, forward: f64| all.iter().find(|one| one.side == side && one.forward == forward);
        let percent = |share: f64| number(100.0 * share, 0, "%");
        html! {
            section {
                h2 { "The choice" }
                div class="scroll" {
                    table class="cells" {
                        thead {
                            tr {
                                th { "Side ↓ forward →" }
                                @for forward in &forwards { th class="r" { (percent(*forward)) } }
                            }
                        }
                        tbody {
                            @for side in &sides {
                                tr {
                                    th { (percent(*side)) }
                                    @for forward in &forwards {
                                        @match of(*side, *forward) { Some(one) => (cell(one)), None => td {} }
                                    }
                                }
                            }
                        }
                    }
                }
                p class="note" {
                    "Photos, and predicted errors in plan and height (RMS). Of all " (whole(all.len() as u64)) " combinations the first that "
                    "nothing rules out is chosen (framed), side overlap before forward overlap, ascending. Ruled out (grey) by the first "
                    "that applies: gaps (cells that fewer than two photos of one strip see), the interval between exposures, the limits of "
                    "accuracy. Accuracy is looked at on fewer cells here than above."
                }
            }
        }
    }
}

fn cell(one: &Combination) -> Markup {
    let out = match one.ruled_out {
        None => None,
        Some(Limit::Gap) => Some(format!("{} gaps", whole(one.gaps as u64))),
        Some(Limit::Interval) => Some(format!("every {}", number(one.interval_min_s, 2, "s"))),
        Some(Limit::Accuracy) => Some("too coarse".to_owned()),
        Some(Limit::Photos) => Some("too many photos".to_owned()),
    };
    let class = match (one.chosen, &out) {
        (true, _) => "n chosen",
        (false, Some(_)) => "n out",
        (false, None) => "n",
    };
    let accuracy = one.plan_m.zip(one.height_m);
    html! {
        td class=(class) {
            @if one.chosen { b { (whole(one.photos as u64)) } } @else { (whole(one.photos as u64)) }
            small {
                @match accuracy {
                    Some((plan_m, height_m)) => { (number(plan_m, 3, "")) " / " (number(height_m, 3, "m")) },
                    None => (NONE),
                }
            }
            @if let Some(out) = out { small { (out) } }
        }
    }
}

/// Values in their order, each once.
fn distinct(values: impl Iterator<Item = f64>) -> Vec<f64> {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    values.dedup();
    values
}
