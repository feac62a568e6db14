//! The table that people read, its JSON, and what must hold.

use super::case::Purpose;
use super::run::{Comparison, EXACT, Outcome, Row};
use serde_json::{Value, json};
use std::fmt::Write;

/// Shift on the smooth picture beyond which kernels do not mean the same place, frame pixels: half of what another
/// convention of pixel centres would do.
const SHIFT_PX: f64 = 0.25;

/// Something that must hold.
#[derive(Clone, Debug, PartialEq)]
pub struct Gate {
    /// What.
    pub name: String,
    /// The largest over attitudes.
    pub value: f64,
    /// It must not be larger.
    pub must: f64,
    /// What is wished for.
    pub goal: Option<f64>,
}

impl Gate {
    /// Whether it holds; nothing that is not a number does.
    pub fn holds(&self) -> bool {
        self.value <= self.must
    }
}

/// Largest of some numbers, and NaN if there is one or if there are none.
pub(super) fn largest(numbers: impl Iterator<Item = f64>) -> f64 {
    numbers.reduce(|a, b| if a.is_nan() || b.is_nan() { f64::NAN } else { a.max(b) }).unwrap_or(f64::NAN)
}

/// Outcomes that differ in attitude only.
fn groups(comparison: &Comparison) -> Vec<&[Outcome]> {
    comparison.outcomes.chunk_by(|a, b| (a.picture, a.ground, a.purpose) == (b.picture, b.ground, b.purpose)).collect()
}

fn title(outcome: &Outcome) -> String {
    let (frame, cells) = (outcome.frame, outcome.ground.cells);
    format!("{}x{} to {}x{}, {}", frame.0, frame.1, cells.0, cells.1, outcome.picture)
}

/// What must hold.
pub fn gates(comparison: &Comparison) -> Vec<Gate> {
    let mut gates = Vec::new();
    for group in groups(comparison) {
        let Some(first) = group.first() else { continue };
        if let Some(limits) = first.limits {
            let of = |value: fn(&Outcome, &Row) -> f64| {
                largest(group.iter().map(|outcome| outcome.ours().map_or(f64::NAN, |row| value(outcome, row))))
            };
            let gate = |what: &str, value, (must, goal)| Gate {
                name: format!("{}: {what}", title(first)),
                value,
                must,
                goal: Some(goal),
            };
            gates.push(gate("RMS, grey levels", of(|_, row| row.score.rms), limits.rms));
            gates.push(gate("time over OpenCV warp + INTER_AREA", of(Outcome::time_ratio), limits.time));
        }
        if first.purpose == Purpose::Smooth {
            let shifts = group.iter().flat_map(|outcome| &outcome.rows).map(|row| row.shift_px.unwrap_or(f64::NAN));
            let name = format!("{}: largest shift of a kernel, frame pixels", title(first));
            gates.push(Gate { name, value: largest(shifts), must: SHIFT_PX, goal: None });
        }
    }
    gates
}

/// One line a kernel, one block a picture and size, one column an attitude.
pub fn table(comparison: &Comparison) -> String {
    let mut text = format!(
        "\
The core's kernels beside OpenCV {} on one thread of this machine, same frames, one run.
Errors: root mean square in grey levels against the exact area average (the frame as piecewise constant pixels, cut by
each cell's projected outline, in f64), over the cells that all of the core's kernels give. On the smooth picture:
how far the patch is shifted against that average, frame pixels. Largest: of any cell, grey levels. Matching: root mean
square of the distance from the truth, and its excess over what the exact average itself leaves.
Times: the shortest of this run, from the frame to the patch; ratio: over OpenCV warp + INTER_AREA at the same attitude;
of both the largest over attitudes. remap's positions are made beforehand. The core runs its portable code, compiled for
any machine of this architecture; OpenCV chooses its vector unit as it runs.
",
        comparison.version
    );
    if comparison.area_is_linear {
        let _ = writeln!(text, "OpenCV's warp by INTER_AREA gave the pixels of INTER_LINEAR: it averages nothing.");
    }
    for group in groups(comparison) {
        match group.first().map(|outcome| outcome.purpose) {
            Some(Purpose::Matched) => matching(&mut text, group),
            _ => block(&mut text, group),
        }
    }
    summary(&mut text, comparison);
    let gates = gates(comparison);
    let width = gates.iter().map(|gate| gate.name.len()).max().unwrap_or(0);
    if !gates.is_empty() {
        let _ = writeln!(text, "\n{:width$} {:>8} {:>8} {:>8}", "must hold", "value", "limit", "goal");
    }
    for gate in &gates {
        let goal = gate.goal.map_or_else(|| "-".to_owned(), |goal| format!("{goal:.2}"));
        let verdict = if gate.holds() { "holds" } else { "FAILS" };
        let _ = writeln!(text, "{:width$} {:>8.3} {:>8.2} {goal:>8}  {verdict}", gate.name, gate.value, gate.must);
    }
    text
}

fn block(text: &mut String, group: &[Outcome]) {
    let Some(first) = group.first() else { return };
    let _ = writeln!(
        text,
        "\n{}, pitch {}, roll {}, V {}, {} cells",
        title(first),
        first.pose.pitch_deg,
        first.pose.roll_deg,
        first.ground.fov_deg,
        group
            .iter()
            .filter_map(|o| o.rows.first())
            .map(|row| row.score.cells.to_string())
            .collect::<Vec<_>>()
            .join(", ")
    );
    let is_smooth = first.purpose == Purpose::Smooth;
    let what = if is_smooth { "  shift at heading" } else { "  RMS at heading" };
    let _ = write!(text, "{what:30}");
    for outcome in group {
        let camera = if outcome.pose.is_followed { "f" } else { "" };
        let _ = write!(text, " {:>7}", format!("{}{camera}", outcome.pose.heading_deg));
    }
    let followed = if group.iter().any(|outcome| outcome.pose.is_followed) { "  (f: the camera follows)" } else { "" };
    let times = if is_smooth { String::new() } else { format!(" {:>8} {:>7}", "µs", "ratio") };
    let _ = writeln!(text, " {:>8}{times}{followed}", "largest");
    for (i, row) in first.rows.iter().enumerate() {
        let _ = write!(text, "  {:28}", row.kernel);
        let rows = || group.iter().filter_map(|outcome| outcome.rows.get(i).map(|row| (outcome, row)));
        for (_, row) in rows() {
            let _ = match row.shift_px {
                Some(shift) => write!(text, " {shift:7.3}"),
                None => write!(text, " {:7.2}", row.score.rms),
            };
        }
        let _ = write!(text, " {:8.1}", largest(rows().map(|(_, row)| row.score.worst)));
        if !is_smooth {
            let micros = largest(rows().map(|(_, row)| row.seconds)) * 1e6;
            let ratio = largest(rows().map(|(outcome, row)| outcome.time_ratio(row)));
            let _ = write!(text, " {micros:8.0} {ratio:7.2}");
        }
        let _ = writeln!(text);
    }
}

/// A block of matching errors: one line a kernel, over all frames.
fn matching(text: &mut String, group: &[Outcome]) {
    let Some(first) = group.first() else { return };
    let all: Vec<&Outcome> = group.iter().collect();
    let rms = |values: &dyn Fn(&Row) -> f64, kernel: &str| rms(&all, kernel, values);
    let off = |kernel: &str| rms(&|row| row.match_px.unwrap_or(f64::NAN), kernel);
    let _ = writeln!(text, "\n{}: matched to its own area averages, {} frames", title(first), group.len());
    let _ = writeln!(text, "{:30} {:>9} {:>9} {:>9}", "  patch pixels", "error", "excess", "RMS grey");
    for row in &first.rows {
        let (error, grey) = (off(&row.kernel), rms(&|row| row.score.rms, &row.kernel));
        let _ = writeln!(text, "  {:28} {error:9.4} {:9.4} {grey:9.2}", row.kernel, error - off(EXACT));
    }
}

/// Mean square of a figure of one kernel, as a root, over outcomes.
fn rms(group: &[&Outcome], kernel: &str, value: &dyn Fn(&Row) -> f64) -> f64 {
    let rows = group.iter().filter_map(|outcome| outcome.rows.iter().find(|row| row.kernel == kernel));
    let (sum, count) = rows.map(value).fold((0.0, 0), |(sum, count), value| (sum + value * value, count + 1));
    (sum / f64::from(count)).sqrt()
}

/// Everything of the case that has limits in one block: one line a kernel, the largest over attitudes.
fn summary(text: &mut String, comparison: &Comparison) {
    let Some(limited) = comparison.outcomes.iter().find(|outcome| outcome.limits.is_some()) else { return };
    let same: Vec<&Outcome> = comparison.outcomes.iter().filter(|outcome| outcome.ground == limited.ground).collect();
    let groups = |purpose: Purpose| {
        let of_it: Vec<&Outcome> = same.iter().copied().filter(|outcome| outcome.purpose == purpose).collect();
        of_it.chunk_by(|a, b| a.picture == b.picture).map(<[&Outcome]>::to_vec).collect::<Vec<_>>()
    };
    let (timed, smooth, matched) = (groups(Purpose::Timed), groups(Purpose::Smooth), groups(Purpose::Matched));
    let (frame, cells) = (limited.frame, limited.ground.cells);
    let _ = write!(text, "\n{}x{} to {}x{}, largest over attitudes\n{:30}", frame.0, frame.1, cells.0, cells.1, "");
    for group in &timed {
        let _ = write!(text, " {:>22}", format!("RMS, {}", group[0].picture));
    }
    let _ = write!(text, " {:>8} {:>9}", "largest", "shift, px");
    for group in &matched {
        let _ = write!(text, " {:>23}", format!("excess, {}", group[0].picture));
    }
    let _ = writeln!(text, " {:>10}", "time ratio");
    for row in &limited.rows {
        let of = |group: &[&Outcome], value: &dyn Fn(&Outcome, &Row) -> f64| {
            let rows = group.iter().flat_map(|outcome| outcome.rows.iter().map(move |row| (*outcome, row)));
            largest(rows.filter(|(_, other)| other.kernel == row.kernel).map(|(outcome, row)| value(outcome, row)))
        };
        let _ = write!(text, "  {:28}", row.kernel);
        for group in &timed {
            let _ = write!(text, " {:22.2}", of(group, &|_, row| row.score.rms));
        }
        let all_timed: Vec<&Outcome> = timed.concat();
        let all_smooth: Vec<&Outcome> = smooth.concat();
        let shift = of(&all_smooth, &|_, row| row.shift_px.unwrap_or(f64::NAN));
        let _ = write!(text, " {:8.1} {shift:9.3}", of(&all_timed, &|_, row| row.score.worst));
        for group in &matched {
            let off = |kernel: &str| rms(group, kernel, &|row| row.match_px.unwrap_or(f64::NAN));
            let _ = write!(text, " {:23.4}", off(&row.kernel) - off(EXACT));
        }
        let _ = writeln!(text, " {:10.2}", of(&all_timed, &Outcome::time_ratio));
    }
}

/// Everything, as one document.
pub fn json(comparison: &Comparison, skipped: &[&str]) -> String {
    let row = |outcome: &Outcome, row: &Row| {
        let is_timed = outcome.purpose == Purpose::Timed;
        json!({
            "picture": outcome.picture,
            "frame": [outcome.frame.0, outcome.frame.1],
            "cells": [outcome.ground.cells.0, outcome.ground.cells.1],
            "fov_deg": outcome.ground.fov_deg,
            "height_m": outcome.ground.height_m,
            "resolution_m": outcome.ground.resolution_m,
            "heading_deg": outcome.pose.heading_deg,
            "pitch_deg": outcome.pose.pitch_deg,
            "roll_deg": outcome.pose.roll_deg,
            "is_followed": outcome.pose.is_followed,
            "kernel": row.kernel,
            "rms": row.score.rms,
            "largest": row.score.worst,
            "cells_compared": row.score.cells,
            "shift_px": row.shift_px,
            "match_px": row.match_px,
            "time_us": if is_timed { json!(row.seconds * 1e6) } else { Value::Null },
            "time_ratio": if is_timed { json!(outcome.time_ratio(row)) } else { Value::Null },
        })
    };
    let rows: Vec<Value> = comparison.outcomes.iter().flat_map(|o| o.rows.iter().map(move |r| row(o, r))).collect();
    let gate = |gate: &Gate| json!({"name": gate.name, "value": gate.value, "limit": gate.must, "goal": gate.goal, "holds": gate.holds()});
    let gates: Vec<Value> = gates(comparison).iter().map(gate).collect();
    let opencv = json!({"version": comparison.version, "area_is_linear": comparison.area_is_linear});
    format!("{:#}", json!({"opencv": opencv, "skipped": skipped, "rows": rows, "gates": gates}))
}
