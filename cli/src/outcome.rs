//! How a command ends: what it found, on standard output, or why it did not, on standard error.

use plumbline_survey::error::InputError;
use serde::Serialize;
use std::fmt;
use std::io::{ErrorKind, Write};
use std::process::ExitCode;

/// What a verb found, as it goes to standard output, and whether its work failed all the same.
#[derive(Debug, Default)]
pub struct Outcome {
    text: String,
    failure: Option<String>,
}

impl Outcome {
    /// `document` as the one JSON document of `--json`, or else `text`, which ends with a line's end.
    pub fn new(as_json: bool, document: &impl Serialize, text: impl FnOnce() -> String) -> Result<Self, Failure> {
        let text = if as_json { line(document)? } else { text() };
        Ok(Outcome { text, failure: None })
    }

    /// A JSON document a line.
    pub fn lines(documents: &[impl Serialize]) -> Result<Self, Failure> {
        Ok(Outcome { text: documents.iter().map(line).collect::<Result<_, _>>()?, failure: None })
    }

    /// What was found is printed, and the command fails nevertheless for this reason.
    pub fn failed(self, why: Option<String>) -> Self {
        Outcome { failure: why, ..self }
    }

    /// Prints it, and says how the process is to end.
    pub fn end(self) -> Result<ExitCode, Failure> {
        print(&self.text)?;
        self.failure.map_or(Ok(ExitCode::SUCCESS), |why| Err(Failure::Work(why)))
    }
}

fn line(document: &impl Serialize) -> Result<String, Failure> {
    let text = serde_json::to_string(document).map_err(|error| Failure::Work(format!("JSON: {error}")))?;
    Ok(text + "\n")
}

/// Why a command ended without doing its work.
#[derive(Debug)]
pub enum Failure {
    /// Bad input: exit code 2.
    Input(InputError),
    /// It ran, but the work failed: exit code 1.
    Work(String),
}

impl Failure {
    /// What the process ends with.
    pub fn code(&self) -> ExitCode {
        match self {
            Failure::Input(_) => ExitCode::from(2),
            Failure::Work(_) => ExitCode::from(1),
        }
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Failure::Input(error) => write!(f, "plumbline: {}", readable(&error.to_string())),
            Failure::Work(why) => write!(f, "plumbline: {}", readable(why)),
        }
    }
}

/// Digits of a number from which it is written with an exponent.
const DIGITS_MAX: usize = 20;

/// A sentence whose numbers are short enough to be read: 1e300 is not written out.
fn readable(sentence: &str) -> String {
    let is_part = |c: char| c.is_ascii_digit() || c == '.';
    // Digits in a file's name are its own.
    let is_of_word = |c: char| c.is_alphanumeric() || matches!(c, '_' | '/' | '-');
    let (mut text, mut rest, mut before) = (String::new(), sentence, ' ');
    while let Some(first) = rest.chars().next() {
        let run = rest.find(|c| is_part(c) != is_part(first)).map_or(rest, |end| &rest[..end]);
        rest = &rest[run.len()..];
        let is_free = !is_of_word(before) && !rest.starts_with(is_of_word);
        match run.parse::<f64>() {
            Ok(number) if is_free && run.len() > DIGITS_MAX => text.push_str(&format!("{number:e}")),
            _ => text.push_str(run),
        }
        before = run.chars().last().filter(|last| *last != '-').unwrap_or(' ');
    }
    text
}

impl From<InputError> for Failure {
    fn from(error: InputError) -> Self {
        if error.is_failed_work() { Failure::Work(error.to_string()) } else { Failure::Input(error) }
    }
}

/// Writes to standard output. A reader who has gone has read enough: that is a quiet end, not a failure.
pub fn print(text: &str) -> Result<(), Failure> {
    let mut stdout = std::io::stdout().lock();
    match stdout.write_all(text.as_bytes()).and_then(|()| stdout.flush()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => {
            Err(Failure::Work(format!("cannot write to stdout: {error}")))
        }
        _ => Ok(()),
    }
}

/// Writes a line to standard error. Where nobody can read it, it is lost, and the exit code has to do.
pub fn note(line: &str) {
    let _ = writeln!(std::io::stderr(), "{line}");
}

#[cfg(test)]
mod tests {
    use super::readable;

    #[test]
    fn numbers_of_hundreds_of_digits_have_an_exponent() {
        for (number, wanted) in [(1e300, "1e300"), (-2.5e40, "-2.5e40"), (3e-200, "3e-200"), (1234.5, "1234.5")] {
            assert_eq!(
                readable(&format!("a.toml: ü = {number} (`{number}`), or {number}")),
                format!("a.toml: ü = {wanted} (`{wanted}`), or {wanted}")
            );
        }
        let name = "cannot read flight/20260102030405060708090.tif: 20260102030405060708090_a";
        assert_eq!(readable(name), name);
    }
}
