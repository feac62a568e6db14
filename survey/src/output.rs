//! Output files that appear whole or not at all.

use std::fs::{self, OpenOptions};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};

use crate::error::InputError;

/// Keeps the temporary names of one process apart.
static COUNTER: AtomicU64 = AtomicU64::new(0);

/// Writes `bytes` to `path`, replacing a regular file of that name.
///
/// The bytes go to a temporary file in the same folder, which is renamed once it is complete: a reader never meets
/// half a file, and a failure leaves an older file as it was.
///
/// # Errors
/// The parent folder does not exist (none is created), `path` is a folder or a device, is write-protected, or the
/// disk refuses.
pub fn write_file(path: &Path, bytes: &[u8]) -> Result<(), InputError> {
    let folder = check_file(path)?;
    let refuse = |why: &str| Err(InputError::new(format!("cannot write {}: {why}", path.display())));
    let name = path.file_name().unwrap_or_default();
    let temporary = folder.join(format!(
        ".{}.{}.{}.part",
        name.to_string_lossy(),
        std::process::id(),
        COUNTER.fetch_add(1, Ordering::Relaxed)
    ));
    write_then_rename(&temporary, path, bytes).or_else(|error| {
        // Best effort: the sentence about the write itself matters more than a left-over.
        let _ = fs::remove_file(&temporary);
        refuse(&error.to_string())
    })
}

/// What [`write_file`] would refuse before it writes, for work whose several files are to be written all or none; the
/// folder of the file.
///
/// # Errors
/// As [`write_file`].
pub fn check_file(path: &Path) -> Result<&Path, InputError> {
    let refuse = |why: &str| Err(InputError::new(format!("cannot write {}: {why}", path.display())));
    if path.file_name().is_none() {
        return refuse("it names no file");
    }
    let folder = match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    };
    if !folder.is_dir() {
        return refuse(&format!("the folder {} does not exist", folder.display()));
    }
    if let Ok(existing) = fs::metadata(path) {
        if !existing.is_file() {
            return refuse("it exists and is not a regular file");
        }
        if existing.permissions().readonly() {
            return refuse("it exists and is write-protected");
        }
    }
    Ok(folder)
}

fn write_then_rename(temporary: &PathBuf, path: &Path, bytes: &[u8]) -> io::Result<()> {
    let mut file = OpenOptions::new().write(true).create_new(true).open(temporary)?;
    file.write_all(bytes)?;
    file.sync_all()?;
    drop(file);
    fs::rename(temporary, path)
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    /// A folder of its own for one test, empty, under the system's temporary folder.
    pub(crate) fn scratch(name: &str) -> PathBuf {
        let folder = std::env::temp_dir().join(format!("plumbline-survey-{}-{name}", std::process::id()));
        let _ = fs::remove_dir_all(&folder);
        fs::create_dir_all(&folder).expect("a scratch folder can be made");
        folder
    }

    #[test]
    fn a_file_is_written_and_replaced_and_nothing_is_left_over() {
        let folder = scratch("output");
        let path = folder.join("a.bin");
        write_file(&path, b"one").expect("new");
        write_file(&path, b"two").expect("replaced");
        assert_eq!(fs::read(&path).expect("readable"), b"two");
        assert_eq!(fs::read_dir(&folder).expect("listed").count(), 1);
    }

    #[test]
    fn a_missing_folder_is_refused_and_not_created() {
        let folder = scratch("output-missing");
        let path = folder.join("none").join("a.bin");
        let error = write_file(&path, b"x").expect_err("refused").to_string();
        assert!(error.contains("none does not exist"), "{error}");
        assert!(!folder.join("none").exists());
    }

    #[test]
    fn folders_devices_and_protected_files_are_refused() {
        let folder = scratch("output-refused");
        assert!(write_file(&folder, b"x").is_err());
        assert!(write_file(Path::new(".."), b"x").is_err());
        if cfg!(unix) {
            assert!(write_file(Path::new("/dev/null"), b"x").is_err());
        }
        let path = folder.join("locked");
        fs::write(&path, b"old").expect("written");
        let mut permissions = fs::metadata(&path).expect("there").permissions();
        permissions.set_readonly(true);
        fs::set_permissions(&path, permissions).expect("set");
        assert!(write_file(&path, b"new").is_err());
        assert_eq!(fs::read(&path).expect("readable"), b"old");
    }
}
