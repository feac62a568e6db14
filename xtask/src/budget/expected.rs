//! The committed table of exact counts, `tests/expected/budget.json`.
//!
//! Counts are exact for one compiler: the table names it, and under another one it decides nothing.

use super::figures::{Figure, INSTRUCTIONS, TOLERANCE, tolerated};
use crate::{Failure, places};
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::fs;
use std::path::PathBuf;

/// The table.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Expected {
    /// What `rustc --version` says.
    pub compiler: String,
    /// Instructions by workload.
    instructions: BTreeMap<String, u64>,
}

fn path() -> PathBuf {
    places::root().join("tests").join("expected").join("budget.json")
}

impl Expected {
    /// The table that `figures` make.
    pub fn of(compiler: &str, figures: &[Figure]) -> Self {
        let counts = figures.iter().filter(|figure| figure.metric == INSTRUCTIONS);
        let instructions = counts.map(|figure| (figure.workload.clone(), figure.value as u64)).collect();
        Expected { compiler: compiler.to_owned(), instructions }
    }

    /// Reads it.
    pub fn read() -> Result<Self, Failure> {
        let path = path();
        let text = fs::read_to_string(&path)
            .map_err(|error| format!("{}: {error}; `cargo xtask budget --overwrite` makes it", path.display()))?;
        Expected::parse(&text).ok_or_else(|| format!("{} is no table of counts", path.display()))
    }

    /// Renews it.
    pub fn write(&self) -> Result<(), Failure> {
        let path = path();
        let folder = path.parent().map_or(Ok(()), fs::create_dir_all);
        folder.and_then(|()| fs::write(&path, self.text())).map_err(|error| format!("{}: {error}", path.display()))
    }

    fn parse(text: &str) -> Option<Self> {
        let table: Value = serde_json::from_str(text).ok()?;
        let counts = table.get("instructions")?.as_object()?.iter();
        let instructions = counts.map(|(name, count)| Some((name.clone(), count.as_u64()?))).collect::<Option<_>>()?;
        Some(Expected { compiler: table.get("compiler")?.as_str()?.to_owned(), instructions })
    }

    fn text(&self) -> String {
        format!("{:#}\n", json!({"compiler": self.compiler, "instructions": self.instructions}))
    }

    /// Sets the limit of every count.
    pub fn limit(&self, figures: &mut [Figure]) {
        for figure in figures.iter_mut().filter(|figure| figure.metric == INSTRUCTIONS) {
            figure.limit = self.instructions.get(&figure.workload).map(|&count| tolerated(count as f64));
        }
    }

    /// A sentence for every workload that only one of the two has.
    pub fn missing(&self, figures: &[Figure]) -> Vec<Failure> {
        let counted = |name: &str| figures.iter().any(|f| f.metric == INSTRUCTIONS && f.workload == name);
        let lost =
            self.instructions.keys().filter(|name| !counted(name)).map(|name| format!("{name}: no longer counted"));
        let new = figures.iter().filter(|f| f.metric == INSTRUCTIONS && !self.instructions.contains_key(&f.workload));
        lost.chain(new.map(|f| format!("{}: not in the table yet; `--overwrite` puts it there", f.workload))).collect()
    }

    /// Says which counts have fallen, so that the table is renewed before they rise again unseen.
    pub fn tell_falls(&self, figures: &[Figure]) {
        for figure in figures.iter().filter(|figure| self.has_fallen(figure)) {
            let (workload, value) = (&figure.workload, figure.value);
            eprintln!("{workload}: fallen to {value:.0} instructions; renew the table by --overwrite");
        }
    }

    fn has_fallen(&self, figure: &Figure) -> bool {
        let count = self.instructions.get(&figure.workload).filter(|_| figure.metric == INSTRUCTIONS);
        count.is_some_and(|&count| figure.value < count as f64 * (1.0 - TOLERANCE))
    }
}

#[cfg(test)]
mod tests {
    use super::Expected;
    use crate::budget::figures::{Figure, INSTRUCTIONS, SERIAL};

    fn figures(count: f64) -> Vec<Figure> {
        vec![Figure::new("frame", INSTRUCTIONS, count), Figure::new("frame", SERIAL, 2.0 * count)]
    }

    #[test]
    fn the_table_is_read_as_it_is_written() {
        let table = Expected::of("rustc 1.2.3", &figures(1000.0));
        assert_eq!(Expected::parse(&table.text()), Some(table));
        assert_eq!(Expected::parse("{\"compiler\": \"rustc\", \"instructions\": {\"frame\": -1}}"), None);
        assert_eq!(Expected::parse("[]"), None);
    }

    #[test]
    fn half_a_percent_is_allowed() {
        let table = Expected::of("rustc 1.2.3", &figures(1000.0));
        for (count, fails, falls) in
            [(1005.0, false, false), (1006.0, true, false), (995.0, false, false), (994.0, false, true)]
        {
            let mut figures = figures(count);
            table.limit(&mut figures);
            assert_eq!((figures[0].fails(), table.has_fallen(&figures[0])), (fails, falls), "{count}");
            assert_eq!(figures[1].limit, None);
        }
    }

    #[test]
    fn what_only_one_side_has_is_told() {
        let table = Expected::of("rustc 1.2.3", &figures(1000.0));
        assert_eq!(table.missing(&figures(1.0)).len(), 0);
        let other = [Figure::new("other", INSTRUCTIONS, 1.0)];
        assert_eq!(table.missing(&other).len(), 2);
    }
}
