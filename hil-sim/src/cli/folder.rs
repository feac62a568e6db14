//! Where a command writes: files that are not those it reads, a folder looked at before the work and created after it.

use plumbline_survey::error::InputError;
use plumbline_survey::output::check_file;
use std::path::Path;

/// Refuses a folder that could not be written to: `option` is how the user named it, `files` are those the command will
/// put there. Nothing is created yet: work that fails leaves nothing behind.
///
/// # Errors
/// It is a file, its parent does not exist, or one of the files cannot be replaced.
pub fn check(option: &str, folder: &Path, files: &[&str]) -> Result<(), InputError> {
    let refuse = |sentence: String| Err(InputError::new(sentence));
    if folder.exists() && !folder.is_dir() {
        return refuse(format!("{option} {} is not a folder", folder.display()));
    }
    let parent = folder.parent().filter(|parent| !parent.as_os_str().is_empty()).unwrap_or(Path::new("."));
    if !folder.exists() && !parent.is_dir() {
        return refuse(format!("{option} {}: the folder {} does not exist", folder.display(), parent.display()));
    }
    if folder.is_dir() {
        files.iter().try_for_each(|name| check_file(&folder.join(name)).map(|_| ()))?;
    }
    Ok(())
}

/// Creates the folder if need be, but no parent.
///
/// # Errors
/// The system refuses.
pub fn create(folder: &Path) -> Result<(), InputError> {
    if folder.is_dir() {
        return Ok(());
    }
    std::fs::create_dir(folder).map_err(|error| InputError::new(format!("cannot create {}: {error}", folder.display())))
}

/// Refuses an `--out` that is one of the files that are read, each with the option that names it.
///
/// # Errors
/// It is.
pub fn apart(out: &Path, read: &[(&str, &Path)]) -> Result<(), InputError> {
    match read.iter().find(|(_, path)| is_same(path, out)) {
        Some((option, path)) => {
            Err(InputError::new(format!("--out and {option} are the same file: {}", path.display())))
        }
        None => Ok(()),
    }
}

/// Whether two paths lead to one file.
pub fn is_same(a: &Path, b: &Path) -> bool {
    a == b || a.canonicalize().is_ok_and(|a| b.canonicalize().is_ok_and(|b| a == b))
}
