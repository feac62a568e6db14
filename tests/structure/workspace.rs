//! The source files and the crates of the repository.

use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::{env, fs};

/// The repository's folder.
pub fn root() -> PathBuf {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    here.ancestors().nth(2).expect("the package lies two folders below the repository's").to_owned()
}

/// A target of a package: a library, a program or a test.
#[derive(Clone, Debug)]
pub struct Target {
    /// Its first source file, relative to [`root`].
    pub file: PathBuf,
}

/// Every target of every member of the workspace.
///
/// # Panics
/// Where cargo cannot be run: then nothing can be checked.
pub fn targets() -> Vec<Target> {
    let cargo = env::var("CARGO").unwrap_or_else(|_| "cargo".to_owned());
    let arguments = ["metadata", "--no-deps", "--offline", "--format-version", "1"];
    let output = Command::new(cargo).args(arguments).current_dir(root()).output().expect("cargo metadata runs");
    let metadata: Value = serde_json::from_slice(&output.stdout).expect("cargo metadata prints JSON");
    let list = |value: &Value, key: &str| value[key].as_array().cloned().unwrap_or_default();
    let packages = list(&metadata, "packages");
    let targets = packages.iter().flat_map(|package| list(package, "targets"));
    let file = |target: Value| PathBuf::from(target["src_path"].as_str().unwrap_or_default());
    let mut targets: Vec<_> =
        targets.map(file).filter_map(|file| relative(&file)).map(|file| Target { file }).collect();
    targets.sort_by(|a, b| a.file.cmp(&b.file));
    targets.dedup_by(|a, b| a.file == b.file);
    targets
}

/// A file's place from [`root`] on; `None` outside.
pub fn relative(file: &Path) -> Option<PathBuf> {
    file.strip_prefix(root()).ok().map(Path::to_owned)
}

/// Every Rust source file of the repository, relative to [`root`].
pub fn sources() -> Vec<PathBuf> {
    let mut found = Vec::new();
    collect(&root(), &mut found);
    found.sort();
    found
}

fn collect(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        let (path, name) = (entry.path(), entry.file_name());
        let is_hidden = name.to_string_lossy().starts_with('.');
        if path.is_dir() && !is_hidden && name != "target" {
            collect(&path, found);
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            found.extend(relative(&path));
        }
    }
}
