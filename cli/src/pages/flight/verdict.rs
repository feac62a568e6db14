//! What came of the flight, in a sentence or two in the colour of what they say.

use super::errors::expected_nees;
use crate::pages::refusals::{FEW, explained};
use maud::{Markup, html};
use plumbline_charts::format::{maybe, number, percent};
use plumbline_sim::score::Summary;

/// Reasons that are explained then.
const REASONS_MAX: usize = 3;
/// Sigmas off by less than this factor are told of, but not warned of, where they lie outside the range of rightly stated ones. Chosen: errors of neighbours are alike, and few are many less.
const SURE: f64 = 1.25;

/// What the errors say of the stated sigmas: the class of its colour, and a sentence.
pub(super) fn sigmas(summary: &Summary) -> Option<(&'static str, String)> {
    let nees = summary.nees_mean.filter(|nees| nees.is_finite() && *nees > 0.0)?;
    let (low, high) = expected_nees(summary.accepted)?;
    // Of two degrees of freedom two are expected; sigmas go by the root.
    let factor = (0.5 * nees).sqrt();
    let times = |factor: f64| number(factor, 1, "");
    Some(if nees > high && factor >= SURE {
        ("bad", format!("The stated sigmas are {} times too small.", times(factor)))
    } else if nees < low && factor <= 1.0 / SURE {
        ("warn", format!("The stated sigmas are {} times larger than they need to be.", times(1.0 / factor)))
    } else if nees > high {
        ("", "The stated sigmas are a little smaller than the errors.".to_owned())
    } else if nees < low {
        ("", "The stated sigmas are a little larger than the errors.".to_owned())
    } else {
        ("good", "The stated sigmas are as large as the errors.".to_owned())
    })
}

/// What came out.
pub(super) fn verdict(summary: &Summary) -> Markup {
    let share = summary.accepted as f64 / summary.frames.max(1) as f64;
    let ground = &summary.ground_error_m;
    html! {
        @if summary.accepted == 0 {
            p class="verdict bad" { "None of the " (summary.frames) " frames became a fix." }
        } @else {
            p class="verdict" {
                span class=(if share < FEW { "bad" } else { "good" }) { (percent(share)) " of the frames became fixes" }
                ", " (maybe(ground.mean, 2, "m")) " from the true position on average, 95 % of them within " (maybe(ground.p95, 2, "m")) ". "
                @if let Some((class, sentence)) = sigmas(summary) { span class=(class) { (sentence) } }
            }
        }
        @if share < FEW { (remedies(summary)) }
    }
}

/// The most frequent reasons for no fix, each with what it means and what helps.
fn remedies(summary: &Summary) -> Markup {
    let mut reasons: Vec<(&String, usize)> = summary.refused.iter().map(|(why, count)| (why, *count)).collect();
    // The map is sorted by name, and the sort is stable.
    reasons.sort_by_key(|(_, count)| std::cmp::Reverse(*count));
    html! {
        ul class="remedies" {
            @for (why, count) in reasons.into_iter().take(REASONS_MAX) {
                li { b { (why.replace('_', " ")) ", " (count) @if count == 1 { " frame. " } @else { " frames. " } } (explained(why)) }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pages::flight::tests::flown;

    fn of(accepted: usize, nees: f64) -> Option<(&'static str, String)> {
        sigmas(&Summary { accepted, nees_mean: Some(nees), ..flown().summary.clone() })
    }

    #[test]
    fn sigmas_are_judged_by_the_errors() {
        let class = |accepted, nees| of(accepted, nees).map(|(class, _)| class);
        assert_eq!(class(100, 2.1), Some("good"));
        let (class_of_small, sentence) = of(100, 7.2).expect("a verdict");
        assert_eq!((class_of_small, sentence.as_str()), ("bad", "The stated sigmas are 1.9 times too small."));
        assert_eq!(class(100, 0.5), Some("warn"));
        // Outside the range that the table beside it states, if not by much.
        let (class_of_near, sentence) = of(60, 1.41).expect("a verdict");
        assert_eq!((class_of_near, sentence.as_str()), ("", "The stated sigmas are a little larger than the errors."));
        assert!(of(60, 2.6).expect("a verdict").1.contains("a little smaller"));
        // Of four fixes this may be chance.
        assert_eq!((class(4, 3.5), class(0, f64::NAN)), (Some("good"), None));
    }

    #[test]
    fn few_fixes_have_their_reasons_and_remedies_first() {
        let summary = &flown().summary;
        let refused = [("tilt", 1), ("no_range", 4), ("low_score", 2), ("overrun", 3)];
        let refused = refused.map(|(why, count)| (why.to_owned(), count)).into_iter().collect();
        let page = verdict(&Summary { accepted: 2, frames: 12, refused, ..summary.clone() }).into_string();
        let place = |text: &str| page.find(text);
        assert!(place("no range, 4 frames") < place("overrun, 3 frames"), "{page}");
        assert!(place("overrun") < place("low score") && page.contains("another season") && !page.contains("tilt"));
        let page = verdict(&Summary { accepted: 11, frames: 12, ..summary.clone() }).into_string();
        assert!(!page.contains("remedies") && page.contains("class=\"good\""), "{page}");
    }
}
