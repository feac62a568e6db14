//! The table as a picture: coverage of both matchers against the share of wrong ones, and stated against observed risk.

use super::table::{coverage, reliability, stated};
use super::{Answer, Outcome};
use plumbline_charts::panels::{FITTED, LEFT_OUT, MEASURED, Mark, Panel, svg};

/// Shares of wrong ones that are shown, as logarithms to the base 10, and steps a decade.
const SHOWN: std::ops::Range<f64> = -4.0..0.0;
const STEPS: usize = 8;

/// The picture as SVG.
///
/// # Errors
/// What the drawing library refuses.
pub fn picture(outcomes: &[Outcome]) -> Result<String, String> {
    let of = |matcher: fn(&Outcome) -> Answer| outcomes.iter().map(matcher).collect::<Vec<Answer>>();
    let curve = |answers: Vec<Answer>| {
        let decades = (SHOWN.end - SHOWN.start) as usize;
        let at = |step: usize| SHOWN.start + step as f64 / STEPS as f64;
        Mark::Line((0..=decades * STEPS).map(at).map(|log| (log, coverage(&answers, 10f64.powf(log)))).collect())
    };
    let stated: Vec<(f64, f64)> = reliability(stated(outcomes))
        .into_iter()
        .filter(|&(_, wrong, _)| wrong > 0)
        .map(|(mean, wrong, count)| (mean.log10(), (wrong as f64 / count as f64).log10()))
        .collect();
    let panels = [
        Panel {
            caption: "Coverage: share of all patches that can be taken, surest first (blue: directions, grey: high-pass)".into(),
            y_text: "share of the patches".into(),
            share: 4,
            marks: vec![
                (curve(of(|outcome| outcome.high_pass)), MEASURED),
                (curve(of(|outcome| outcome.directions)), FITTED),
            ],
        },
        Panel {
            caption: "Observed share of wrong ones, log 10 (rings), where any was; on the red line stated risks are true, below they are too high"
                .into(),
            y_text: "share of wrong ones (log 10)".into(),
            share: 4,
            marks: vec![
                (Mark::Line(vec![(SHOWN.start, SHOWN.start), (SHOWN.end, SHOWN.end)]), LEFT_OUT),
                (Mark::Rings(stated), FITTED),
            ],
        },
    ];
    svg(SHOWN, "share of wrong ones that is allowed; risk that is stated (log 10)", &panels)
}
