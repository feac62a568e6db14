//! Where the real data lies that tests and trials run on. It is not part of the repository.

use std::io::Write;
use std::path::{Path, PathBuf};

/// The folder of the shared real data, or `None` where there is none.
///
/// `PLUMBLINE_DATA` names it; without that variable it is `../shared/data` beside the workspace root, as the source
/// tree stood when this crate was built. A variable that names no folder gives `None`: it is not overruled.
#[must_use]
pub fn shared_data() -> Option<PathBuf> {
    let folder = match std::env::var_os("PLUMBLINE_DATA") {
        Some(named) => PathBuf::from(named),
        None => Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/data"),
    };
    folder.is_dir().then_some(folder)
}

/// `path` in the shared real data, for `test`. Where it is missing, a line that shows without `--nocapture` says that the
/// test is skipped.
///
/// # Panics
/// Instead of that where `PLUMBLINE_REQUIRE_DATA` is 1: there the data is known to be present, and its absence a fault.
#[must_use]
pub fn for_test(test: &str, path: &str) -> Option<PathBuf> {
    let found = shared_data().map(|folder| folder.join(path)).filter(|path| path.exists());
    if found.is_none() {
        let why = format!("{test}: the real data has no {path} (set PLUMBLINE_DATA)");
        assert!(std::env::var_os("PLUMBLINE_REQUIRE_DATA").is_none_or(|required| required != "1"), "{why}");
        // A closed standard error is no reason to fail.
        let _ = writeln!(std::io::stderr(), "skipped: {why}");
    }
    found
}
