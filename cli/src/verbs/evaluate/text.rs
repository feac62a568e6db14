//! What `evaluate` prints for a person.

use plumbline_charts::format::{number, percent};
use plumbline_sim::evaluate::Summary;
use plumbline_sim::evaluate::judge::Figures;
use std::path::Path;

pub fn text(summary: &Summary, out: &Path) -> String {
    let knows_truth = summary.judged_against == "truth";
    let mut text = line("", &summary.figures, knows_truth);
    let refused: Vec<String> = summary.figures.refused.iter().map(|(why, count)| format!("{count} {why}")).collect();
    if !refused.is_empty() {
        text.push_str(&format!("refused: {}\n", refused.join(", ")));
    }
    for says in summary.heights.iter().chain(&summary.headings).chain([&summary.platform.says]) {
        text.push_str(&format!("{says}\n"));
    }
    if let Some(figures) = &summary.corrected {
        text.push_str(&line("with the camera as it is found to sit: ", figures, knows_truth));
    }
    text.push_str(&format!("{}\n", out.join("report.html").display()));
    text
}

fn line(before: &str, figures: &Figures, knows_truth: bool) -> String {
    let share = percent(figures.accepted as f64 / figures.frames.max(1) as f64);
    let offset = figures.median_distance_m.map_or_else(String::new, |distance_m| {
        format!("; median distance from the navigation {}", number(distance_m, 1, "m"))
    });
    let error = figures.median_error_m.map_or_else(String::new, |error_m| {
        let zero = if knows_truth { "the truth" } else { "their median offset" };
        format!(", from {zero} {}", number(error_m, 1, "m"))
    });
    let nees =
        figures.nees_mean.map_or_else(String::new, |nees| format!("; NEES {} (2 expected)", number(nees, 1, "")));
    format!(
        "{before}{} frames, {} fixed ({share}), {} right, {} wrong{offset}{error}{nees}\n",
        figures.frames, figures.accepted, figures.right, figures.wrong
    )
}
