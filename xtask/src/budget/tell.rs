//! The table that people read, and the one that programs do.

use super::figures::{CYCLES_PER_LINE, Figure, number};
use super::workloads::Workload;
use serde_json::{Value, json};
use std::fmt::Write;

/// What the figures are, before anyone takes them for more.
const HEAD: &str = "\
Instructions are exact counts of the emulated Cortex-M7. The serial estimate prices them one at a time, every result waited
for; it is an estimate: interrupts, DMA and instruction fetch are outside it, its floating-point part is uncalibrated, and
nothing was measured on silicon. Each figure is the largest over all headings, tilts to 30 degrees, beta followed and 0.
The paper's 38 ms at 167 MHz are 6.3 million cycles.
";

/// Workloads first, then every limit with what it needs.
pub fn table(workloads: &[Workload], figures: &[Figure]) -> String {
    let mut text = format!("{HEAD}\n");
    let width = workloads.iter().map(|workload| workload.name.len()).max().unwrap_or(0);
    let _ = writeln!(
        text,
        "{:width$} {:>12} {:>10} {:>10} {:>8} {:>8} {:>6} {:>8}  pose of the largest estimate",
        "workload", "instructions", "floor", "serial", "480 MHz", "400 MHz", "lines", "+ memory"
    );
    for Workload { name, worst, pose } in workloads {
        let ms = |cycles: u64, mhz: f64| cycles as f64 / (mhz * 1000.0);
        let _ = writeln!(
            text,
            "{name:width$} {:>12} {:>10} {:>10} {:>8.3} {:>8.3} {:>6} {:>8.3}  {pose}",
            worst.instructions,
            worst.floor,
            worst.serial,
            ms(worst.serial, 480.0),
            ms(worst.serial, 400.0),
            worst.lines,
            ms(worst.serial + CYCLES_PER_LINE * worst.lines, 480.0),
        );
    }
    let _ = writeln!(
        text,
        "floor and serial in cycles, times in ms; + memory: 480 MHz and {CYCLES_PER_LINE} cycles a line\n"
    );
    let limited = figures.iter().filter_map(|figure| figure.limit.map(|limit| (figure, limit)));
    let width = limited.clone().map(|(figure, _)| figure.workload.len() + figure.metric.len() + 2).max().unwrap_or(0);
    let _ = writeln!(text, "{:width$} {:>14} {:>14}", "gate", "need", "limit");
    for (figure, limit) in limited {
        let name = format!("{}: {}", figure.workload, figure.metric);
        let verdict = if figure.fails() { "FAILS" } else { "holds" };
        let _ = writeln!(text, "{name:width$} {:>14} {:>14}  {verdict}", number(figure.value), number(limit));
    }
    text
}

/// One array of all figures.
pub fn json(figures: &[Figure]) -> String {
    let rows = figures.iter().map(|figure| {
        let limit = figure.limit.map_or(Value::Null, value);
        json!({"workload": figure.workload, "metric": figure.metric, "value": value(figure.value), "limit": limit})
    });
    format!("{:#}", Value::Array(rows.collect()))
}

/// A whole number without a decimal point.
fn value(number: f64) -> Value {
    if number.fract() == 0.0 { json!(number as i64) } else { json!(number) }
}

#[cfg(test)]
mod tests {
    use super::{json, table};
    use crate::budget::figures::Figure;

    #[test]
    fn need_and_limit_stand_side_by_side() {
        let figures = [Figure::new("application", "RAM, bytes", 40000.0), Figure::new("x", "instructions", 1.0)];
        let text = table(&[], &figures);
        let line = text.lines().find(|line| line.starts_with("application: RAM")).expect("a line");
        assert!(line.contains("40000") && line.contains("32768") && line.ends_with("FAILS"), "{line}");
        assert!(!text.contains("x: instructions"));
    }

    #[test]
    fn json_is_an_array_of_rows() {
        let figures = [Figure::new("application", "RAM, bytes", 30000.0), Figure::new("x", "serial", 1.5)];
        let expected = r#"[{"limit":32768,"metric":"RAM, bytes","value":30000,"workload":"application"},{"limit":null,"metric":"serial","value":1.5,"workload":"x"}]"#;
        let parsed: serde_json::Value = serde_json::from_str(&json(&figures)).expect("JSON");
        assert_eq!(parsed.to_string(), expected);
    }
}
