//! Accuracy against cost: which kernels are worth their instructions.
//!
//! A kernel is on the front when no other is both cheaper and nearer to the exact average. Costs are instructions on the
//! Cortex-M7 for each pixel of the frame, reduction included, 512 x 512 to 64 x 64: of this core the worst pose in the
//! table of exact counts, of others as they were published.

use super::Failure;
use super::case::Purpose;
use super::cases::{LIMITED_CELLS, PROTOTYPE, VIENNA};
use super::ours::Way;
use super::run::Comparison;
use super::tell::largest;
use super::view::View;
use serde_json::Value;
use std::fmt::Write;
use std::fs;

/// Exact counts by workload.
const COUNTS: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/expected/budget.json");
/// Pixels of the frame.
const SOURCE_PX: f64 = 512.0 * 512.0;

/// Whose kernel it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Whose {
    /// This core's.
    Ours,
    /// What this core flew before.
    Former,
    /// A prototype by the paper's equation or a peer's algorithm.
    Theirs,
}

/// A kernel.
#[derive(Clone, Debug, PartialEq)]
pub struct Candidate {
    /// Its name.
    pub name: String,
    /// Whose it is.
    pub whose: Whose,
    /// Instructions a pixel of the frame.
    pub instructions: f64,
    /// Root mean square against the exact average, prototypes' texture, grey levels.
    pub rms: f64,
    /// That over Vienna, where it is known.
    pub rms_vienna: Option<f64>,
    /// Bytes kept of the frame, or before the patch.
    pub bytes: Option<usize>,
}

/// Published figures: instructions, errors on the prototypes' texture and over Vienna, bytes. Pitch 8, roll 10, V = 40°,
/// one heading; by exact counts of the same emulator.
type Published = (&'static str, Whose, u32, f64, Option<f64>, Option<usize>);
const OTHERS: [Published; 7] = [
    ("boxes of 6, four readings", Whose::Former, 881_212, 2.7, Some(4.4), Some(85 * 85)),
    ("grid", Whose::Theirs, 1_252_610, 1.62, None, Some(17_944)),
    ("grid of row pairs", Whose::Theirs, 822_970, 2.37, None, None),
    ("boxes of 8 and eq. 7", Whose::Theirs, 1_552_912, 3.25, None, Some(64 * 64)),
    ("boxes by SIMD, fast bilinear", Whose::Theirs, 617_644, 4.53, None, Some(64 * 64)),
    ("eq. 7, 8 x 8 readings a cell", Whose::Theirs, 16_997_998, 0.45, None, Some(512 * 512)),
    ("nearest at full size, then boxes", Whose::Theirs, 10_450_670, 2.04, None, Some(2 * 512 * 512)),
];

/// All candidates, cheapest first.
///
/// # Errors
/// A sentence on a count or an outcome that is missing.
pub fn candidates(comparison: &Comparison, counts: &Value) -> Result<Vec<Candidate>, Failure> {
    let others = OTHERS.map(|(name, whose, instructions, rms, rms_vienna, bytes)| Candidate {
        name: name.to_owned(),
        whose,
        instructions: f64::from(instructions) / SOURCE_PX,
        rms,
        rms_vienna,
        bytes,
    });
    let mut all = others.to_vec();
    let timed =
        || comparison.outcomes.iter().filter(|o| o.purpose == Purpose::Timed && o.ground.cells.0 == LIMITED_CELLS);
    for way in Way::ALL {
        let name = way.name();
        let of = |picture: &str| {
            let rows = timed().filter(|outcome| outcome.picture == picture).flat_map(|outcome| &outcome.rows);
            largest(rows.filter(|row| row.kernel == name).map(|row| row.score.rms))
        };
        let first = timed().next().ok_or("the comparison has no frame of the front's size")?;
        let view = View::new(first.frame, first.ground, first.pose)?;
        let count = counts["instructions"][way.workload()].as_f64();
        let count = count.ok_or_else(|| {
            format!("{} is not in {COUNTS}: `cargo xtask budget --overwrite` puts it there", way.workload())
        })?;
        let reduction = way.reduction(&view).map_err(|why| format!("{name}: refused, {why:?}"))?;
        let boxes = format!("boxes of {0} x {0}, as on board", reduction.factor());
        all.push(Candidate {
            name: if way == Way::OnBoard { boxes } else { name.trim_start_matches("core, ").to_owned() },
            whose: Whose::Ours,
            instructions: count / SOURCE_PX,
            rms: of(PROTOTYPE),
            rms_vienna: Some(of(VIENNA)).filter(|rms| rms.is_finite()),
            bytes: Some(reduction.bytes()),
        });
    }
    all.sort_by(|a, b| a.instructions.total_cmp(&b.instructions));
    Ok(all)
}

/// Whether no other candidate is both as cheap and as near, and better in one of them.
pub fn is_on_front(candidate: &Candidate, all: &[Candidate]) -> bool {
    !all.iter().any(|other| {
        other.instructions <= candidate.instructions
            && other.rms <= candidate.rms
            && (other.instructions < candidate.instructions || other.rms < candidate.rms)
    })
}

/// The front, cheapest first if `all` are.
pub fn front(all: &[Candidate]) -> impl Iterator<Item = &Candidate> {
    all.iter().filter(|candidate| is_on_front(candidate, all))
}

/// The table, one line a candidate.
pub fn table(all: &[Candidate]) -> String {
    let mut text = String::from(
        "\
# Accuracy against cost of the rectifying kernels

512 x 512 to 64 x 64 at V = 40°, pitch 8°, roll 10°; made by `cargo xtask compare --front docs`, drawn in
[kernels.svg](kernels.svg). Instructions are exact counts of an emulated Cortex-M7 for each pixel of the frame, reduction
included; of this core those of the worst of 192 poses. Errors are root mean squares in grey levels against the exact area
average, of this core those of the worst of four attitudes. Memory is what is kept of a frame until its pose is known. The
former kernel and the prototypes are gone; their figures are those of their time, at one attitude: the prototypes are
plain C renderings of the paper's equation (eq. 7), a grid followed in fixed point, and the algorithm of a camera
library (nearest neighbours at full size, then averages), counted in the same emulator. On the front is what nothing else
is both cheaper and nearer than.

| kernel | whose | instructions a frame pixel | RMS, prototypes' texture | RMS, Vienna | memory, bytes | on the front |
|---|---|---|---|---|---|---|
",
    );
    for candidate in all {
        let whose = match candidate.whose {
            Whose::Ours => "this core",
            Whose::Former => "this core, formerly",
            Whose::Theirs => "prototype",
        };
        let known = |value: Option<String>| value.unwrap_or_else(|| "not known".into());
        let _ = writeln!(
            text,
            "| {} | {whose} | {:.2} | {:.2} | {} | {} | {} |",
            candidate.name,
            candidate.instructions,
            candidate.rms,
            known(candidate.rms_vienna.map(|rms| format!("{rms:.2}"))),
            known(candidate.bytes.map(|bytes| bytes.to_string())),
            if is_on_front(candidate, all) { "yes" } else { "no" },
        );
    }
    text
}

/// The table of exact counts.
///
/// # Errors
/// A sentence where it cannot be read.
pub fn counts() -> Result<Value, Failure> {
    let text = fs::read_to_string(COUNTS).map_err(|error| format!("{COUNTS}: {error}"))?;
    serde_json::from_str(&text).map_err(|error| format!("{COUNTS}: {error}"))
}
