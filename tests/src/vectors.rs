//! The golden tables as numbers. Angles in the tables are degrees.

use serde_json::Value;

const GOLDEN_000: &str = include_str!("../vectors/golden_000.json");
const GOLDEN_001: &str = include_str!("../vectors/golden_001.json");
const GOLDEN_003: &str = include_str!("../vectors/golden_003.json");

/// A table of paper `"000"`, `"001"` or `"003"`, whatever its shape.
pub fn table(paper: &str, name: &str) -> Value {
    let text = match paper {
        "000" => GOLDEN_000,
        "001" => GOLDEN_001,
        "003" => GOLDEN_003,
        other => panic!("no golden values of paper {other}"),
    };
    let mut all: Value = serde_json::from_str(text).expect("the vector file is JSON");
    all[name].take()
}

/// The rows of a table; at least two, else it proves nothing.
pub fn rows(paper: &str, name: &str) -> Vec<Value> {
    let Value::Array(rows) = table(paper, name) else { panic!("no table {name} for paper {paper}") };
    assert!(rows.len() >= 2, "table {name} of paper {paper} is too short to prove anything");
    rows
}

/// A number of a row.
pub fn number(row: &Value, key: &str) -> f64 {
    row[key].as_f64().unwrap_or_else(|| panic!("{key} is no number in {row}"))
}

/// A whole number of 32 bits.
pub fn tick(row: &Value, key: &str) -> u32 {
    row[key].as_u64().and_then(|v| u32::try_from(v).ok()).unwrap_or_else(|| panic!("{key} is no tick in {row}"))
}

/// N numbers of a row.
pub fn list<const N: usize>(row: &Value, key: &str) -> [f64; N] {
    std::array::from_fn(|i| row[key][i].as_f64().unwrap_or_else(|| panic!("{key}[{i}] is no number in {row}")))
}

/// The largest difference; infinite when a number is not finite, so that it can never pass for a hit.
pub fn miss<const N: usize>(a: [f64; N], b: [f64; N]) -> f64 {
    let differences = (0..N).map(|i| (a[i] - b[i]).abs());
    differences.fold(0.0, |worst: f64, d| if d.is_finite() { worst.max(d) } else { f64::INFINITY })
}

/// `angle` − `reference` the short way round, degrees.
pub fn turn_deg(angle: f64, reference: f64) -> f64 {
    (angle - reference + 180.0).rem_euclid(360.0) - 180.0
}
