//! The front as a picture: instructions across, error upwards, both logarithmic.

use super::Failure;
use super::front::{Candidate, Whose, candidates, counts, front, table};
use super::run::Comparison;
use std::fmt::Write;
use std::fs;
use std::path::Path;

/// Leaves table and picture in `folder`.
///
/// # Errors
/// A sentence on what is missing or cannot be written.
pub fn write(comparison: &Comparison, folder: &Path) -> Result<(), Failure> {
    let all = candidates(comparison, &counts()?)?;
    for (name, text) in [("kernels.md", table(&all)), ("kernels.svg", svg(&all))] {
        let path = folder.join(name);
        fs::write(&path, text).map_err(|error| format!("{}: {error}", path.display()))?;
    }
    Ok(())
}

/// The picture and the field within its axes, pixels: left, top, right, bottom.
const SIZE: (f64, f64) = (860.0, 560.0);
const FIELD: [f64; 4] = [80.0, 60.0, 830.0, 490.0];
/// What the axes show: instructions, grey levels.
const SHOWN: [(f64, f64); 2] = [(0.8, 100.0), (0.2, 20.0)];
/// Height of a label and width of its letters, about.
const LABEL: (f64, f64) = (15.0, 6.5);
const RADIUS: f64 = 5.5;

/// Places on the axes that are named.
const TICKS: [f64; 9] = [0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0];

/// How far along an axis.
fn along(value: f64, (least, most): (f64, f64), (from, to): (f64, f64)) -> f64 {
    from + (value.clamp(least, most) / least).ln() / (most / least).ln() * (to - from)
}

fn place(instructions: f64, rms: f64) -> (f64, f64) {
    let [left, top, right, bottom] = FIELD;
    (along(instructions, SHOWN[0], (left, right)), along(rms, SHOWN[1], (bottom, top)))
}

/// Left, top, right, bottom.
type Box = [f64; 4];

fn overlap(a: &Box, b: &Box) -> bool {
    a[0] < b[2] && b[0] < a[2] && a[1] < b[3] && b[1] < a[3]
}

/// The picture.
pub fn svg(all: &[Candidate]) -> String {
    let mut text = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {} {}\" font-family=\"sans-serif\" font-size=\"12\">\n\
         <title>Accuracy against cost of the rectifying kernels</title>\n\
         <rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>\n",
        SIZE.0, SIZE.1
    );
    axes(&mut text);
    line(&mut text, all);
    points(&mut text, all);
    legend(&mut text);
    text.push_str("</svg>\n");
    text
}

fn axes(text: &mut String) {
    let [left, top, right, bottom] = FIELD;
    for tick in TICKS {
        if (SHOWN[0].0..=SHOWN[0].1).contains(&tick) {
            let (x, _) = place(tick, 1.0);
            let _ = writeln!(text, "<path d=\"M{x:.1} {top}V{bottom}\" stroke=\"#e4e4e4\"/>");
            let _ = writeln!(text, "<text x=\"{x:.1}\" y=\"{}\" text-anchor=\"middle\">{tick}</text>", bottom + 18.0);
        }
        if (SHOWN[1].0..=SHOWN[1].1).contains(&tick) {
            let (_, y) = place(1.0, tick);
            let _ = writeln!(text, "<path d=\"M{left} {y:.1}H{right}\" stroke=\"#e4e4e4\"/>");
            let _ = writeln!(text, "<text x=\"{}\" y=\"{:.1}\" text-anchor=\"end\">{tick}</text>", left - 8.0, y + 4.0);
        }
    }
    let _ = writeln!(text, "<path d=\"M{left} {top}V{bottom}H{right}\" fill=\"none\" stroke=\"#222\"/>");
    let middle = (0.5 * (left + right), 0.5 * (top + bottom));
    let _ = writeln!(
        text,
        "<text x=\"{}\" y=\"{}\" text-anchor=\"middle\" font-size=\"14\">instructions on a Cortex-M7 for each pixel of the frame, \
         512 x 512 to 64 x 64</text>",
        middle.0,
        bottom + 46.0
    );
    let _ = writeln!(
        text,
        "<text transform=\"translate(30 {}) rotate(-90)\" text-anchor=\"middle\" font-size=\"14\">RMS error against the exact \
         area average, grey levels</text>",
        middle.1
    );
    let _ =
        writeln!(text, "<text x=\"{left}\" y=\"34\" font-size=\"17\">Rectifying kernels: accuracy against cost</text>");
}

/// Corners of the steps from each candidate of the front to the next: between two, nothing is nearer than the cheaper one.
fn steps(all: &[Candidate]) -> Vec<(f64, f64)> {
    let mut corners: Vec<(f64, f64)> = Vec::new();
    for (x, y) in front(all).map(|candidate| place(candidate.instructions, candidate.rms)) {
        corners.extend(corners.last().map(|last| (x, last.1)));
        corners.push((x, y));
    }
    corners
}

fn line(text: &mut String, all: &[Candidate]) {
    let corners: Vec<String> = steps(all).iter().map(|(x, y)| format!("{x:.1},{y:.1}")).collect();
    let _ = writeln!(
        text,
        "<polyline points=\"{}\" fill=\"none\" stroke=\"#0b5fa5\" stroke-width=\"2\" stroke-opacity=\"0.55\"/>",
        corners.join(" ")
    );
}

fn mark(text: &mut String, whose: Whose, (x, y): (f64, f64)) {
    let _ = match whose {
        Whose::Ours => writeln!(text, "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"{RADIUS}\" fill=\"#0b5fa5\"/>"),
        Whose::Former => writeln!(
            text,
            "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"{RADIUS}\" fill=\"#fff\" stroke=\"#0b5fa5\" stroke-width=\"2\"/>"
        ),
        Whose::Theirs => writeln!(
            text,
            "<rect x=\"{:.1}\" y=\"{:.1}\" width=\"10\" height=\"10\" fill=\"#c2571a\"/>",
            x - 5.0,
            y - 5.0
        ),
    };
}

/// Marks, and labels where they cover no mark, no other label and no piece of the front.
fn points(text: &mut String, all: &[Candidate]) {
    let at = |candidate: &Candidate| place(candidate.instructions, candidate.rms);
    let around = |(x, y): (f64, f64), by: f64| [x - by, y - by, x + by, y + by];
    let mut taken: Vec<Box> = all.iter().map(|candidate| around(at(candidate), RADIUS)).collect();
    taken.extend(steps(all).windows(2).map(|ends| {
        let (a, b) = (ends[0], ends[1]);
        [a.0.min(b.0) - 2.0, a.1.min(b.1) - 2.0, a.0.max(b.0) + 2.0, a.1.max(b.1) + 2.0]
    }));
    taken.push([FIELD[2] - 300.0, FIELD[1], FIELD[2], FIELD[1] + 84.0]);
    for candidate in all {
        let (x, y) = at(candidate);
        mark(text, candidate.whose, (x, y));
        let label = format!("{} ({:.2}, {:.2})", candidate.name, candidate.instructions, candidate.rms);
        let width = LABEL.1 * label.chars().count() as f64;
        let places = [0.0, -11.0, 11.0, -22.0, 22.0, -33.0, 33.0].into_iter().flat_map(|down| {
            [(x + 11.0, "start", 0.0), (x - 11.0, "end", width)]
                .map(|(x, anchor, before)| (x, anchor, before, y + down))
        });
        let boxed = |&(x, _, before, y): &(f64, &str, f64, f64)| -> Box {
            [x - before, y - 0.5 * LABEL.0, x - before + width, y + 0.5 * LABEL.0]
        };
        let is_free = |spot: &(f64, &str, f64, f64)| {
            let spot = boxed(spot);
            let inside = spot[0] > FIELD[0] && spot[2] < SIZE.0 && spot[1] > FIELD[1] && spot[3] < FIELD[3];
            inside && !taken.iter().any(|other| overlap(&spot, other))
        };
        let chosen = places.clone().find(is_free).or_else(|| places.clone().next());
        if let Some(spot) = chosen {
            taken.push(boxed(&spot));
            let _ = writeln!(
                text,
                "<text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"{}\">{label}</text>",
                spot.0,
                spot.3 + 4.0,
                spot.1
            );
        }
    }
}

fn legend(text: &mut String) {
    let kinds = [
        (Whose::Ours, "this core"),
        (Whose::Former, "this core, formerly"),
        (Whose::Theirs, "prototypes of the paper's and others' kernels"),
    ];
    for (n, (whose, name)) in kinds.into_iter().enumerate() {
        let y = FIELD[1] + 14.0 + 20.0 * n as f64;
        mark(text, whose, (FIELD[2] - 290.0, y));
        let _ = writeln!(text, "<text x=\"{}\" y=\"{}\">{name}</text>", FIELD[2] - 278.0, y + 4.0);
    }
    let y = FIELD[1] + 74.0;
    let _ = writeln!(
        text,
        "<path d=\"M{} {y}h18\" stroke=\"#0b5fa5\" stroke-width=\"2\" stroke-opacity=\"0.55\"/>\n\
         <text x=\"{}\" y=\"{}\">the front: nothing is both cheaper and nearer</text>",
        FIELD[2] - 299.0,
        FIELD[2] - 278.0,
        y + 4.0
    );
}
