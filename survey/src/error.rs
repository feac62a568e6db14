//! What stops a command: bad input, or work that failed.

use std::error::Error;
use std::fmt;
use std::sync::Arc;

/// Why there is no result, as one sentence for a person, with the error below it where there is one.
///
/// The sentence has no full stop. It says what is wrong and where: the path, the key, the value. Nearly always the input is
/// to blame (exit code 2); a full disk, or an iteration that does not converge, is work that failed ([`Self::failed`], exit
/// code 1).
#[derive(Debug, Clone)]
pub struct InputError {
    sentence: String,
    is_failed_work: bool,
    source: Option<Arc<dyn Error + Send + Sync>>,
}

impl InputError {
    /// Bad input. Line breaks become spaces, so that the sentence stays one line.
    pub fn new(sentence: impl Into<String>) -> Self {
        let sentence: String = sentence.into();
        let is_one_line = !sentence.contains(['\n', '\r']);
        let sentence = if is_one_line { sentence } else { sentence.split_whitespace().collect::<Vec<_>>().join(" ") };
        Self { sentence, is_failed_work: false, source: None }
    }

    /// Work that failed although nothing is wrong with the input as such.
    pub fn failed(sentence: impl Into<String>) -> Self {
        Self { is_failed_work: true, ..Self::new(sentence) }
    }

    /// Bad input by an error below, which is kept: `what` could not be done, and why.
    pub fn because(what: impl fmt::Display, source: impl Error + Send + Sync + 'static) -> Self {
        let error = Self::new(format!("{what}: {source}"));
        Self { source: Some(Arc::new(source)), ..error }
    }

    /// With `place` before the sentence: a file, a key.
    #[must_use]
    pub fn at(self, place: impl fmt::Display) -> Self {
        Self { sentence: format!("{place}: {}", self.sentence), ..self }
    }

    /// With `more` behind the sentence.
    #[must_use]
    pub fn with(self, more: impl fmt::Display) -> Self {
        Self { sentence: format!("{}; {more}", self.sentence), ..self }
    }

    /// Whether work failed; else the input is bad.
    #[must_use]
    pub fn is_failed_work(&self) -> bool {
        self.is_failed_work
    }
}

impl PartialEq for InputError {
    /// By what a user sees: the sentence and the exit code.
    fn eq(&self, other: &Self) -> bool {
        (&self.sentence, self.is_failed_work) == (&other.sentence, other.is_failed_work)
    }
}

impl Eq for InputError {}

impl fmt::Display for InputError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.sentence)
    }
}

impl Error for InputError {
    fn source(&self) -> Option<&(dyn Error + 'static)> {
        self.source.as_deref().map(|source| source as &(dyn Error + 'static))
    }
}

/// A number of things: `1 row`, `2 rows`.
#[must_use]
pub fn counted(number: usize, what: &str) -> String {
    if number == 1 { format!("1 {what}") } else { format!("{number} {what}s") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_error_is_one_line() {
        assert_eq!(InputError::new("a\n  b").to_string(), "a b");
        assert_eq!(InputError::new(String::from("a  b")).to_string(), "a  b");
    }

    #[test]
    fn the_error_below_is_kept() {
        let below = std::fs::read("/nonexistent").expect_err("missing");
        let why = below.to_string();
        let error = InputError::because("cannot read x", below).at("--in");
        assert_eq!(error.to_string(), format!("--in: cannot read x: {why}"));
        assert_eq!(error.source().map(ToString::to_string), Some(why));
        assert!(!error.is_failed_work() && InputError::failed("full").at("x").is_failed_work());
    }
}
