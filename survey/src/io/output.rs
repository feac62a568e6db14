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
/// # Errors
/// As [`write_files`].
pub fn write_file(path: &Path, bytes: &[u8]) -> Result<(), InputError> {
    write_files(&[(path, bytes)])
}

/// [`write_file`] of what nobody but the file's owner is to read, where the system knows owners.
///
/// # Errors
/// As [`write_files`].
pub fn write_secret(path: &Path, bytes: &[u8]) -> Result<(), InputError> {
    write_by(&[(path, bytes)], &secret())
}

/// Writes files that belong together, replacing regular files of their names.
///
/// The bytes go to temporary files in the same folders, which are renamed once all of them are complete: a reader never
/// meets half a file, and where the disk is full all older files stay as they were.
///
/// # Errors
/// A parent folder does not exist (none is created), a path is a folder or a device, or is write-protected. Where the
/// system refuses otherwise, a full disk for instance, it is work that failed.
pub fn write_files(files: &[(&Path, &[u8])]) -> Result<(), InputError> {
    write_by(files, &new())
}

/// How a file is opened that is not there yet.
fn new() -> OpenOptions {
    let mut options = OpenOptions::new();
    options.write(true).create_new(true);
    options
}

/// [`new`], of a file that its owner alone reads and writes.
fn secret() -> OpenOptions {
    let mut options = new();
    #[cfg(unix)]
    std::os::unix::fs::OpenOptionsExt::mode(&mut options, 0o600);
    options
}

/// [`write_files`], each opened so.
fn write_by(files: &[(&Path, &[u8])], options: &OpenOptions) -> Result<(), InputError> {
    let mut temporaries: Vec<PathBuf> = Vec::new();
    let written = files.iter().try_for_each(|(path, bytes)| {
        let temporary = check_file(path)?.join(temporary_name(path));
        temporaries.push(temporary.clone());
        write_new(&temporary, bytes, options).map_err(|error| refused(path, error))
    });
    let renamed = written.and_then(|()| {
        let mut pairs = temporaries.iter().zip(files);
        pairs.try_for_each(|(from, (path, _))| fs::rename(from, path).map_err(|error| refused(path, error)))
    });
    if renamed.is_err() {
        for temporary in &temporaries {
            // Best effort: the sentence about the write itself matters more than a left-over.
            let _ = fs::remove_file(temporary);
        }
    }
    renamed
}

/// A name in the file's folder that no other write of this or another process has.
fn temporary_name(path: &Path) -> String {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    format!(".{name}.{}.{}.part", std::process::id(), COUNTER.fetch_add(1, Ordering::Relaxed))
}

/// Missing permission counts as bad input (exit 2), and a folder that takes no files, as those under /proc, where the folder is
/// there and the file is said not to be; any other failure is failed work (exit 1).
fn refused(path: &Path, error: io::Error) -> InputError {
    let what = format!("cannot write {}", path.display());
    match error.kind() {
        io::ErrorKind::PermissionDenied | io::ErrorKind::ReadOnlyFilesystem => InputError::because(what, error),
        io::ErrorKind::NotFound | io::ErrorKind::Unsupported => {
            InputError::new(format!("{what}: its folder takes no files"))
        }
        io::ErrorKind::InvalidFilename => InputError::new(format!("{what}: its name is too long")),
        _ => InputError::failed(format!("{what}: {error}")),
    }
}

/// What [`check_file`] refuses, a folder that takes no files, and a name that is too long for them: only a file tells that is made there
/// as [`write_file`] makes it, and removed. The system lets everybody write under /proc, and there is nothing to write to.
///
/// # Errors
/// As [`write_file`].
pub fn try_file(path: &Path) -> Result<(), InputError> {
    try_in(check_file(path)?, path, path)
}

/// Likewise of a folder that does not exist yet: whether it can be made.
///
/// # Errors
/// As [`write_file`].
pub fn try_folder(path: &Path) -> Result<(), InputError> {
    try_in(check_file(path)?, Path::new("trial"), path)
}

fn try_in(folder: &Path, name: &Path, path: &Path) -> Result<(), InputError> {
    let trial = folder.join(temporary_name(name));
    match write_new(&trial, b"", &new()).and_then(|()| fs::remove_file(&trial)) {
        // Left by another process of that number: the folder takes files.
        Err(error) if error.kind() == io::ErrorKind::AlreadyExists => Ok(()),
        made => made.map_err(|error| refused(path, error)),
    }
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
    match fs::metadata(path) {
        Ok(existing) if !existing.is_file() => refuse("it exists and is not a regular file"),
        Ok(existing) if existing.permissions().readonly() => refuse("it exists and is write-protected"),
        Err(error) if error.kind() == io::ErrorKind::InvalidFilename => refuse("its name is too long"),
        _ => Ok(folder),
    }
}

fn write_new(path: &Path, bytes: &[u8], options: &OpenOptions) -> io::Result<()> {
    let mut file = options.open(path)?;
    file.write_all(bytes)?;
    file.sync_all()
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

    /// Also where a file of that name could be read by all.
    #[test]
    #[cfg(unix)]
    fn a_secret_is_its_owners_alone() {
        use std::os::unix::fs::PermissionsExt;
        let path = scratch("output-secret").join("key.bin");
        write_file(&path, b"one").expect("new");
        fs::set_permissions(&path, fs::Permissions::from_mode(0o644)).expect("set");
        write_secret(&path, b"two").expect("replaced");
        assert_eq!(fs::read(&path).expect("readable"), b"two");
        assert_eq!(fs::metadata(&path).expect("there").permissions().mode() & 0o777, 0o600);
    }

    /// The second name is as long as names may be, so that its temporary file cannot be made.
    #[test]
    fn of_several_files_all_or_none_are_replaced() {
        let folder = scratch("output-several");
        let (first, last) = (folder.join("a"), folder.join("b".repeat(250)));
        for path in [&first, &last] {
            fs::write(path, "old").expect("written");
        }
        let error = write_files(&[(&first, b"new"), (&last, b"new")]).expect_err("the name is too long");
        assert!(!error.is_failed_work() && error.to_string().contains("bbb"), "{error}");
        assert_eq!(
            (fs::read(&first).expect("there"), fs::read_dir(&folder).expect("listed").count()),
            (b"old".to_vec(), 2)
        );
        write_files(&[(&first, b"new"), (&folder.join("b"), b"new")]).expect("written");
        assert_eq!(fs::read(&first).expect("there"), b"new");
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
    fn a_file_that_can_be_made_is_not_made() {
        let folder = scratch("output-tried");
        let path = folder.join("a");
        try_file(&path).expect("it can");
        assert_eq!(fs::read_dir(&folder).expect("listed").count(), 0);
        fs::write(&path, "old").expect("written");
        try_file(&path).expect("it can be replaced");
        assert_eq!(
            (fs::read(&path).expect("there"), fs::read_dir(&folder).expect("listed").count()),
            (b"old".to_vec(), 1)
        );
        // Of 250 letters it is too long beside its temporary name.
        for letters in [250, 300] {
            let error = try_file(&folder.join("a".repeat(letters))).expect_err("no name");
            assert!(error.to_string().ends_with("too long") && !error.is_failed_work(), "{error}");
        }
        try_folder(&folder.join("a".repeat(250))).expect("a folder has none");
        if cfg!(target_os = "linux") {
            let error = try_file(Path::new("/proc/a")).expect_err("no files");
            assert!(!error.is_failed_work() && error.to_string().contains("takes no files"), "{error}");
        }
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
