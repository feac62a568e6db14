//! Bad input, told to a person.

use std::fmt;

/// Input that cannot be used: a file, an option or a value. The command line ends with exit code 2 on it.
///
/// The text is one sentence without a full stop. It says what is wrong and where: the path, the key, the value.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct InputError(String);

impl InputError {
    /// Wraps the sentence that the user will read. Line breaks become spaces, so that it stays one line.
    pub fn new(sentence: impl Into<String>) -> Self {
        let sentence: String = sentence.into();
        if sentence.contains(['\n', '\r']) {
            return Self(sentence.split_whitespace().collect::<Vec<_>>().join(" "));
        }
        Self(sentence)
    }
}

impl fmt::Display for InputError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for InputError {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_error_is_one_line() {
        assert_eq!(InputError::new("a\n  b").to_string(), "a b");
        assert_eq!(InputError::new(String::from("a  b")).to_string(), "a  b");
    }
}
