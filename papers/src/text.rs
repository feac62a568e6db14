//! The rows for a person: columns, and below a row why it differs.

use super::{Reproduction, Row};
use std::fmt::Write;

/// Decimals of most papers' numbers.
pub const DECIMALS: usize = 3;
/// Characters of a line at most.
const WIDTH: usize = 110;
const INDENT: &str = "      ";
const LABEL: &str = "DIFFERENCE  ";

/// What paper 003 is reproduced by.
pub fn head(reproduction: &Reproduction) -> String {
    format!(
        "Paper {}: Table 2 by {} trials of seed {}, Table 3 by {} frames of seed {}.",
        reproduction.paper, reproduction.trials, reproduction.seed, reproduction.frames, reproduction.flight_seed
    )
}

/// A line, then the rows with up to [`DECIMALS`].
pub fn table(head: String, rows: &[Row]) -> String {
    let mut text = lines(&[head]);
    rows_into(&mut text, rows, DECIMALS);
    text
}

/// Lines of a heading, each closed by a line break.
pub fn lines(lines: &[String]) -> String {
    lines.iter().map(|line| format!("{line}\n")).collect()
}

/// The rows, table by table, with up to `decimals` decimals.
pub fn rows_into(text: &mut String, rows: &[Row], decimals: usize) {
    let quantity_width = rows.iter().map(|row| row.quantity.chars().count()).max().unwrap_or(0).max(8);
    let width = decimals + 5;
    let (mut table, mut above) = ("", None);
    for row in rows {
        // Writing to a string cannot fail.
        if row.table != table {
            table = row.table;
            let _ = writeln!(text, "\n{table:<quantity_width$}      {:>width$}  {:>width$}", "paper", "ours");
        }
        let [paper, ours] = row.shown(decimals);
        let _ = writeln!(text, "  {:<quantity_width$}    {paper:>width$}  {ours:>width$}", row.quantity);
        if let Some(difference) = &row.difference {
            wrap(text, if above == Some(difference) { "as above" } else { difference });
        }
        above = row.difference.as_ref();
    }
}

fn wrap(text: &mut String, words: &str) {
    let mut line = format!("{INDENT}{LABEL}");
    let mut started = false;
    for word in words.split_whitespace() {
        if started && line.chars().count() + 1 + word.chars().count() > WIDTH {
            let _ = writeln!(text, "{line}");
            line = format!("{INDENT}{:width$}", "", width = LABEL.len());
            started = false;
        }
        if started {
            line.push(' ');
        }
        line.push_str(word);
        started = true;
    }
    let _ = writeln!(text, "{line}");
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_are_aligned_and_reasons_stand_below() {
        let row = |quantity: &str, ours: Option<f64>, difference: Option<&str>| Row {
            decimals: None,
            table: "Table 9",
            quantity: quantity.to_owned(),
            paper: Some(1.25),
            ours,
            difference: difference.map(str::to_owned),
        };
        let long = "word ".repeat(40);
        let rows = vec![row("a", Some(2.0), None), row("longer", None, Some(&long))];
        let reproduction = Reproduction { paper: "003", seed: 1, trials: 2, flight_seed: 3, frames: 4, rows };
        let text = table(head(&reproduction), &reproduction.rows);
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(lines[2].len(), lines[3].len());
        assert_eq!(lines[3], "  a               1.25         2");
        assert_eq!(lines[4], "  longer          1.25         -");
        assert!(lines[5].trim_start().starts_with("DIFFERENCE  word"));
        assert!(lines[6].trim_start().starts_with("word") && lines.iter().all(|line| line.len() <= WIDTH));
    }
}
