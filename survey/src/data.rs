//! Where the real data lies that tests and trials run on. It is not part of the repository.

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
