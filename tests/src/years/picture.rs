//! The table as a picture: coverage of both matchers against the share of wrong ones, and stated against observed risk.

use super::reliability::Bin;
use super::table::coverage;
use super::{Answer, Outcome};
use plumbline_charts::panels::{FITTED, LEFT_OUT, MEASURED, Mark, Panel, svg};

/// Shares of wrong ones that are shown, as logarithms to the base 10, and steps a decade.
const SHOWN: std::ops::Range<f64> = -4.0..0.0;
const STEPS: usize = 8;

/// The picture as SVG.
///
/// # Errors
/// What the drawing library refuses.
pub fn picture(outcomes: &[Outcome], bins: &[Bin]) -> Result<String, String> {
    let of = |matcher: fn(&Outcome) -> Answer| outcomes.iter().map(matcher).collect::<Vec<Answer>>();
    let curve = |answers: Vec<Answer>| {
        let decades = (SHOWN.end - SHOWN.start) as usize;
        let at = |step: usize| SHOWN.start + step as f64 / STEPS as f64;
        Mark::Line((0..=decades * STEPS).map(at).map(|log| (log, coverage(&answers, 10f64.powf(log)))).collect())
    };
    let log = |share: f64| share.log10().max(SHOWN.start);
    let shown = || bins.iter().filter(|bin| bin.mean.log10() >= SHOWN.start);
    let stated: Vec<(f64, f64)> =
        shown().filter(|bin| bin.wrong > 0).map(|bin| (bin.mean.log10(), log(bin.observed()))).collect();
    let interval = |bin: &Bin| Mark::Line(bin.interval.map(|share| (bin.mean.log10(), log(share))).to_vec());
    let mut reliability = vec![(Mark::Line(vec![(SHOWN.start, SHOWN.start), (SHOWN.end, SHOWN.end)]), LEFT_OUT)];
    reliability.extend(shown().map(|bin| (interval(bin), FITTED)));
    reliability.push((Mark::Rings(stated), FITTED));
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
            caption: "Observed share of wrong ones (rings, where any was) and its interval by scenes, 19 times of 20; below the red line stated risks are too high"
                .into(),
            y_text: "share of wrong ones (log 10)".into(),
            share: 4,
            marks: reliability,
        },
    ];
    svg(SHOWN, "share of wrong ones that is allowed; risk that is stated (log 10)", &panels)
}
