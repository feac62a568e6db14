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
}

/// Whether `ours` prints as the paper's figure, which has one decimal.
pub fn same_digit(paper: f64, ours: f64) -> bool {
    ((10.0 * ours).round() - 10.0 * paper).abs() < 1e-6
}
