//! A row of every reproduced table.

use serde::Serialize;

/// One figure of the paper beside ours.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Row {
    /// Table of the paper.
    pub table: &'static str,
    /// What it is, with its unit.
    pub quantity: String,
    /// What the paper says; `None` where it says nothing.
    pub paper: Option<f64>,
    /// What this project gets; `None` where a host command cannot know.
    pub ours: Option<f64>,
    /// Why the two differ; `None` where they agree.
    pub difference: Option<String>,
    /// Decimals that the paper prints, where ours are compared and shown with as many.
    #[serde(skip)]
    pub decimals: Option<usize>,
}

impl Row {
    /// The row without its reason where both are the same at the digits that the paper prints.
    pub fn met(self) -> Self {
        let is_met = self
            .decimals
            .zip(self.paper)
            .zip(self.ours)
            .is_some_and(|((decimals, paper), ours)| format!("{paper:.decimals$}") == format!("{ours:.decimals$}"));
        Row { difference: self.difference.filter(|_| !is_met), ..self }
    }

    /// Both numbers as text: with the paper's decimals where those are known and leave two digits of ours, else with up to `most`.
    pub fn shown(&self, most: usize) -> [String; 2] {
        let of = |value: Option<f64>| match (value, self.decimals) {
            (Some(value), Some(decimals)) if is_seen(value, decimals) || self.difference.is_none() => {
                format!("{value:.decimals$}")
            }
            (value, _) => number(value, most),
        };
        [of(self.paper), of(self.ours)]
    }
}

/// So many decimals at most, none that says nothing; a dash where there is no number.
fn number(value: Option<f64>, decimals: usize) -> String {
    value.map_or_else(
        || "-".to_owned(),
        |value| {
            let text = format!("{value:.decimals$}");
            text.trim_end_matches('0').trim_end_matches('.').to_owned()
        },
    )
}

/// Whether a number has two digits that count, or is none, with so many decimals.
fn is_seen(value: f64, decimals: usize) -> bool {
    value.abs() * 10f64.powi(decimals as i32) >= 9.5
}

/// Whether `ours` prints as the paper's figure, which has one decimal.
pub fn same_digit(paper: f64, ours: f64) -> bool {
    ((10.0 * ours).round() - 10.0 * paper).abs() < 1e-6
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(paper: f64, decimals: usize, ours: f64) -> Row {
        let row = Row {
            table: "Table 9",
            quantity: "a".to_owned(),
            paper: Some(paper),
            ours: Some(ours),
            difference: Some("another wind".to_owned()),
            decimals: Some(decimals),
        };
        row.met()
    }

    #[test]
    fn what_agrees_at_the_printed_digits_does_not_differ() {
        let of = |row: Row| (row.difference.is_some(), row.shown(6).join(" | "));
        assert_eq!(of(row(0.0031, 4, 0.003_092)), (false, "0.0031 | 0.0031".to_owned()));
        assert_eq!(of(row(0.444, 3, 0.443_774)), (false, "0.444 | 0.444".to_owned()));
        assert_eq!(of(row(0.444, 4, 0.443_774)), (true, "0.4440 | 0.4438".to_owned()));
        assert_eq!(of(row(0.01, 2, 0.012_9)), (false, "0.01 | 0.01".to_owned()));
        // With the paper's decimals nothing would be left of it.
        assert_eq!(of(row(0.12, 2, 0.000_78)), (true, "0.12 | 0.00078".to_owned()));
    }
}
