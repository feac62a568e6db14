//! Tables from CSV files: a header, then a row a line, with the line kept for messages.

use super::input;
use super::shell::files;
use crate::error::InputError;
use std::path::Path;

/// A file's rows, each with its line, and the names of its columns.
#[derive(Debug)]
pub struct Table<'a> {
    /// What messages call the file.
    pub name: String,
    /// Names of the columns.
    pub header: Vec<&'a str>,
    /// Line, counted from 1, and fields.
    pub rows: Vec<(usize, Vec<&'a str>)>,
}

impl<'a> Table<'a> {
    /// Takes a text apart; `name` is what messages call it. Empty lines, blanks and quotation marks around fields are passed
    /// over.
    ///
    /// # Errors
    /// There is no header, or a row has more or fewer fields than it.
    pub fn parse(text: &'a str, name: String) -> Result<Self, InputError> {
        let fields = |line: &'a str| line.split(',').map(|field| unquoted(field.trim())).collect::<Vec<_>>();
        let mut lines = text.trim_start_matches('\u{feff}').lines().enumerate();
        let mut lines = lines.by_ref().filter(|(_, line)| !line.trim().is_empty());
        let Some((_, header)) = lines.next() else {
            return Err(InputError::new(format!("{name} is empty")));
        };
        if let Some(line) =
            no_table(text, header, &name).or_else(|| commented(text, &name)).or_else(|| with_commas(header, &name))
        {
            return Err(InputError::new(line));
        }
        let header = fields(header);
        let rows: Vec<_> = lines.map(|(index, line)| (index + 1, fields(line))).collect();
        if let Some((line, row)) = rows.iter().find(|(_, row)| row.len() != header.len()) {
            return Err(InputError::new(format!(
                "{name}, line {line}: {} fields, but the header has {}",
                row.len(),
                header.len()
            )));
        }
        Ok(Table { name, header, rows })
    }

    /// Index of the one column of that name.
    ///
    /// # Errors
    /// There is none, or more than one.
    pub fn column(&self, wanted: &str) -> Result<usize, InputError> {
        self.columns([wanted]).map(|[column]| column)
    }

    /// The indices of several columns.
    ///
    /// # Errors
    /// Some are missing, all of which are named, or one is there twice.
    pub fn columns<const N: usize>(&self, names: [&str; N]) -> Result<[usize; N], InputError> {
        self.columns_that(names, |name, wanted| name == wanted)
    }

    /// The indices of several columns, each the one whose name `is` the wanted one.
    ///
    /// # Errors
    /// As [`Self::columns`].
    pub fn columns_that<const N: usize>(
        &self,
        names: [&str; N],
        is: impl Fn(&str, &str) -> bool,
    ) -> Result<[usize; N], InputError> {
        let mut columns = [0; N];
        columns.copy_from_slice(&self.found(&names, is)?);
        Ok(columns)
    }

    /// As [`Self::columns_that`], of as many as there are.
    ///
    /// # Errors
    /// As [`Self::columns`].
    pub fn found(&self, names: &[&str], is: impl Fn(&str, &str) -> bool) -> Result<Vec<usize>, InputError> {
        let places = |wanted: &&str| (0..self.header.len()).filter(|column| is(self.header[*column], wanted)).collect();
        let found: Vec<Vec<usize>> = names.iter().map(places).collect();
        let that = |is: fn(usize) -> bool| {
            let those = names.iter().zip(&found).filter(move |(_, found)| is(found.len()));
            those.map(|(name, _)| *name).collect::<Vec<_>>()
        };
        let (missing, twice) = (that(|count| count == 0), that(|count| count > 1));
        let columns = |names: &[&str]| format!("column{} {}", if names.len() > 1 { "s" } else { "" }, names.join(", "));
        if !missing.is_empty() {
            let (missing, header) = (columns(&missing), self.header.join(", "));
            return Err(InputError::new(format!("{} has no {missing}, only {header}", self.name)));
        }
        if !twice.is_empty() {
            return Err(InputError::new(format!("{}: more than one {}", self.name, columns(&twice))));
        }
        Ok(found.into_iter().flatten().collect())
    }

    /// The finite number in a row and column.
    ///
    /// # Errors
    /// It is none.
    pub fn number(&self, row: usize, column: usize) -> Result<f64, InputError> {
        match self.rows[row].1[column].parse::<f64>() {
            Ok(value) if value.is_finite() => Ok(value),
            _ => Err(self.wrong(row, column, "not a finite number")),
        }
    }

    /// The numbers of several columns in a row.
    ///
    /// # Errors
    /// As [`Self::number`].
    pub fn numbers_of<const N: usize>(&self, row: usize, columns: [usize; N]) -> Result<[f64; N], InputError> {
        let mut numbers = [0.0; N];
        for (number, column) in numbers.iter_mut().zip(columns) {
            *number = self.number(row, column)?;
        }
        Ok(numbers)
    }

    /// An error about a field: `what` it is instead of what it should be.
    #[must_use]
    pub fn wrong(&self, row: usize, column: usize, what: &str) -> InputError {
        let (line, fields) = &self.rows[row];
        InputError::new(format!(
            "{}, line {line}: {} = \"{}\" is {what}",
            self.name, self.header[column], fields[column]
        ))
    }

    /// A whole column of numbers.
    ///
    /// # Errors
    /// As [`Self::number`].
    pub fn numbers(&self, column: usize) -> Result<Vec<f64>, InputError> {
        (0..self.rows.len()).map(|row| self.number(row, column)).collect()
    }
}

/// A file's text, and what messages call the file.
///
/// # Errors
/// As [`input::text`].
pub fn text_of(path: &Path) -> Result<(String, String), InputError> {
    let name = path.display().to_string();
    Ok((input::text(path)?, name))
}

/// Why a text is no table: its lines end as no other program's do any more, or it is JSON, XML or the like.
fn no_table(text: &str, header: &str, name: &str) -> Option<String> {
    if text.contains('\r') && !text.contains('\n') {
        let (from, made) = (Path::new(name), Path::new(name).with_extension("lines.csv"));
        let words = files([from, &made], " > ");
        return Some(format!("{name}: its lines end with carriage returns alone: tr '\\r' '\\n' < {words}"));
    }
    let start: String = header.trim().chars().take(30).collect();
    start.starts_with(['{', '[', '<']).then(|| format!("{name}: it is no table (CSV), as it begins with {start}"))
}

/// What to type where a text begins with comments, of which the last may be the header: above numbers alone it is.
fn commented(text: &str, name: &str) -> Option<String> {
    let lines = || text.trim_start_matches('\u{feff}').lines().enumerate().filter(|(_, line)| !line.trim().is_empty());
    let (at, last) = lines().take_while(|(_, line)| is_comment(line)).last()?;
    let is_number = |field: &str| unquoted(field.trim()).parse::<f64>().is_ok();
    let is_header = |first: &str| first.split(',').all(is_number) && last.contains(',') == first.contains(',');
    let (from, made) = (Path::new(name), Path::new(name).with_extension("plain.csv"));
    let words = files([from, &made], " > ");
    let line = at + 1;
    Some(match lines().find(|(_, line)| !is_comment(line)) {
        Some((_, first)) if is_header(first) => {
            format!("{name}, line {line}: its header stands behind a #: sed '{line}s/^ *# *//; /^ *#/d' {words}")
        }
        _ => format!("{name}, line {line}: comments stand before its header: sed '/^ *#/d' {words}"),
    })
}

fn is_comment(line: &str) -> bool {
    line.trim_start().starts_with('#')
}

/// A field without the quotation marks around it.
fn unquoted(field: &str) -> &str {
    field.strip_prefix('"').and_then(|field| field.strip_suffix('"')).unwrap_or(field)
}

/// What to type where fields stand between other marks than commas: between semicolons numbers have decimal commas.
fn with_commas(header: &str, name: &str) -> Option<String> {
    let (_, what, line) = [
        (';', "semicolons", "sed 's/,/./g; s/;/,/g'"),
        ('\t', "tabs", "sed 's/,/./g; s/\\t/,/g'"),
        ('|', "upright strokes", "sed 's/,/./g; s/|/,/g'"),
        (' ', "blanks", "sed 's/,/./g; s/^ *//; s/  */,/g'"),
    ]
    .into_iter()
    .find(|(mark, ..)| header.trim().contains(*mark) && !header.contains(','))?;
    let (from, made) = (Path::new(name), Path::new(name).with_extension("commas.csv"));
    let words = files([from, &made], " > ");
    Some(format!("{name}: its columns are separated by {what}, and commas are read: {line} {words}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn other_marks_than_commas_are_told_and_quotation_marks_passed_over() {
        for (text, what) in
            [("a;b\n1;2\n", "semicolons"), ("a\tb\n", "tabs"), ("a|b\n", "strokes"), (" a  b \n", "blanks")]
        {
            let error = Table::parse(text, "t.csv".to_owned()).expect_err(what).to_string();
            assert!(error.contains(what) && error.contains("t.csv > t.commas.csv"), "{error}");
        }
        let table = Table::parse("\"a\", \"b c\"\n\"1\",2\n", "t.csv".to_owned()).expect("a table");
        assert_eq!((table.header.as_slice(), table.number(0, 0)), (&["a", "b c"][..], Ok(1.0)));
    }

    #[test]
    fn comments_before_the_header_are_told() {
        let refused = |text: &str| Table::parse(text, "my t.csv".to_owned()).expect_err(text).to_string();
        let deleted = "comments stand before its header: sed '/^ *#/d' 'my t.csv' > 'my t.plain.csv'";
        assert_eq!(refused("# by a logger\na,b\n1,2\n"), format!("my t.csv, line 1: {deleted}"));
        assert_eq!(refused("\u{feff}# by, a logger\n\n#\na,b\n1,2\n"), format!("my t.csv, line 3: {deleted}"));
        // As numpy.savetxt writes it.
        assert_eq!(
            refused("# by a logger\n# a,b\n1,2\n"),
            "my t.csv, line 2: its header stands behind a #: sed '2s/^ *# *//; /^ *#/d' 'my t.csv' > 'my t.plain.csv'"
        );
        assert!(Table::parse("a,#\n1,2\n", "t.csv".to_owned()).is_ok());
    }

    #[test]
    fn columns_that_are_missing_or_there_twice_are_all_named() {
        let table = Table::parse("a,b,b\n1,2,3\n", "t.csv".to_owned()).expect("a table");
        let refused = |names: [&str; 3]| table.columns(names).map_err(|error| error.to_string()).expect_err("refused");
        assert_eq!(refused(["c", "a", "d"]), "t.csv has no columns c, d, only a, b, b");
        assert_eq!(refused(["c", "a", "b"]), "t.csv has no column c, only a, b, b");
        assert_eq!(refused(["a", "a", "b"]), "t.csv: more than one column b");
        assert_eq!(table.column("a").expect("there"), 0);
    }
}
