//! From a file's text to the parts of a scenario. Each part takes its keys of the one text, so that a file keeps a sensor's
//! keys in one table; a key that no part takes is refused.

use plumbline_survey::error::InputError;
use serde::de::DeserializeOwned;
use toml::Spanned;
use toml::de::{DeTable, DeValue, Deserializer};

/// A file's text and its name, and the keys that no part has taken yet.
#[derive(Debug)]
pub struct Reader<'a> {
    text: &'a str,
    file: &'a str,
    /// Whether messages say the line.
    has_lines: bool,
    /// What each part left, dotted; a table stands for all its keys.
    left: Vec<Vec<String>>,
}

impl<'a> Reader<'a> {
    /// A reader of `text`; `file` is its name for messages.
    #[must_use]
    pub fn new(text: &'a str, file: &'a str) -> Self {
        Reader { text, file, has_lines: true, left: Vec::new() }
    }

    /// As it is, of a text whose lines nobody has written.
    #[must_use]
    pub fn unlined(self) -> Self {
        Reader { has_lines: false, ..self }
    }

    /// The keys of one part.
    ///
    /// # Errors
    /// [`InputError`]: the text is no TOML, or a value of another type.
    pub fn part<T: DeserializeOwned>(&mut self) -> Result<T, InputError> {
        let mut left = Vec::new();
        let source = Deserializer::parse(self.text).map_err(|error| self.sentence(&error))?;
        let part = serde_ignored::deserialize(source, |path| left.push(path.to_string()));
        self.left.push(left);
        part.map_err(|error| self.sentence(&error))
    }

    /// Refuses the first key that no part has taken. `what` follows its name, and is asked only then.
    ///
    /// # Errors
    /// [`InputError`].
    pub fn finish(self, what: impl FnOnce() -> &'static str) -> Result<(), InputError> {
        let is_left = |key: &str, by: &[String]| {
            by.iter().any(|left| {
                key.strip_prefix(left.as_str()).is_some_and(|rest| rest.is_empty() || rest.starts_with('.'))
            })
        };
        let mut keys = self.left.iter().flatten();
        let Some(key) = keys.find(|key| self.left.iter().all(|by| is_left(key, by))) else { return Ok(()) };
        let line = at(self.text, key).map(|at| self.line_of(at)).unwrap_or_default();
        let why = match key.as_str() {
            "mount.boresight_deg" | "mount.true_boresight_deg" => {
                let table = key.trim_end_matches("_deg");
                format!(
                    "{key} (heading, pitch, roll) is no key any more: [{table}] has phi_deg, omega_deg and kappa_deg as a \
                     camera file's boresight, which of small angles are minus roll, pitch and minus heading"
                )
            }
            "cols" | "rows" | "fov_h_deg" | "fov_v_deg" => {
                format!(
                    "{key} {}: this is a camera file, which --camera takes, and a scenario names in camera_file",
                    what()
                )
            }
            _ => format!("{key} {}", what()),
        };
        Err(InputError::new(format!("{}{line}: {why}", self.file)))
    }

    /// What the TOML reader found, as one sentence with the line it stands in.
    fn sentence(&self, error: &toml::de::Error) -> InputError {
        let message = error.message().split_whitespace().collect::<Vec<_>>().join(" ");
        let line = error.span().map(|span| self.line_of(span.start)).unwrap_or_default();
        InputError::new(format!("{}{line}: {message}", self.file))
    }

    /// The line in which byte `at` stands, to follow the file's name.
    fn line_of(&self, at: usize) -> String {
        if !self.has_lines {
            return String::new();
        }
        let number = self.text.get(..at).map_or(0, |before| before.matches('\n').count()) + 1;
        let line = self.text.lines().nth(number - 1).unwrap_or_default().trim();
        format!(", line {number} (`{line}`)")
    }
}

/// Where the text has a dotted key.
fn at(text: &str, key: &str) -> Option<usize> {
    fn find(table: &DeTable<'_>, key: &str) -> Option<usize> {
        table.iter().find_map(|(own, value): (&Spanned<_>, &Spanned<DeValue<'_>>)| {
            let rest = key.strip_prefix(own.get_ref().as_ref())?;
            match (rest.strip_prefix('.'), value.get_ref()) {
                (None, _) if rest.is_empty() => Some(own.span().start),
                (Some(inner), DeValue::Table(table)) => find(table, inner),
                _ => None,
            }
        })
    }
    find(DeTable::parse(text).ok()?.get_ref(), key)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The answer may take a second reading of the text.
    #[test]
    fn what_a_strange_key_is_not_is_asked_of_one_alone() {
        let finish = |text: &str, what: &dyn Fn() -> &'static str| {
            let mut reader = Reader::new(text, "a.toml");
            reader.part::<crate::scenario::Vehicle>().expect("TOML");
            reader.finish(what)
        };
        finish("search_px = 8\n", &|| panic!("nothing is strange")).expect("a vehicle's key");
        let error = finish("serach_px = 8\n", &|| "is none").expect_err("misspelt");
        assert_eq!(error.to_string(), "a.toml, line 1 (`serach_px = 8`): serach_px is none");
    }
}
