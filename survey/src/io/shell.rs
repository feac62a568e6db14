//! Words of a shell's line, for messages that say what to type.

use std::path::Path;

/// A word of a shell's line.
#[must_use]
pub fn quoted(word: &str) -> String {
    let is_plain = !word.is_empty() && word.chars().all(|c| c.is_alphanumeric() || "/._-+:,@".contains(c));
    if is_plain { word.to_owned() } else { format!("'{}'", word.replace('\'', r"'\''")) }
}

/// Names of two files as words of a shell's line, with what stands between them.
pub(crate) fn files(both: [&Path; 2], between: &str) -> String {
    both.map(|path| quoted(&path.display().to_string())).join(between)
}

/// The file's name and one for what is made of it, as words of a shell's line.
pub(crate) fn names(path: &Path, suffix: &str) -> String {
    let made = format!("{}_{suffix}.tif", path.with_extension("").display());
    format!("{} {}", quoted(&path.display().to_string()), quoted(&made))
}

/// A file beside another one, as a word of a shell's line: what a table names from its folder on is found from there alone.
#[must_use]
pub fn beside(name: &str, made: &str) -> String {
    quoted(&Path::new(name).with_file_name(made).display().to_string())
}

#[cfg(test)]
mod tests {
    use super::beside;

    #[test]
    fn what_is_made_of_a_table_lies_beside_it() {
        let words = [beside("a.csv", "b.csv"), beside("my flight/a.csv", "b.csv"), beside("/x/a.csv", "b.csv")];
        assert_eq!(words, ["b.csv", "'my flight/b.csv'", "/x/b.csv"]);
    }
}
