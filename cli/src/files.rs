//! The files of one command: none that is written may be one that is read, or that another option names.
//!
//! Every verb lists what it reads and writes before it begins. What could not be written after the work is refused before
//! it, and nothing is left there yet.

use plumbline_survey::error::InputError;
use plumbline_survey::io::output::{check_file, try_file, try_folder};
use std::fs;
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};

/// What a command reads and writes, each with the option that names it.
#[derive(Debug, Default)]
pub struct Files<'a> {
    read: Vec<(&'a str, &'a Path)>,
    written: Vec<(&'a str, PathBuf)>,
    folders: Vec<(&'a str, &'a Path)>,
}

impl<'a> Files<'a> {
    /// A file that is read.
    pub fn reads(mut self, option: &'a str, path: &'a Path) -> Self {
        self.read.push((option, path));
        self
    }

    /// A file that is read if it is given.
    pub fn may_read(self, option: &'a str, path: Option<&'a PathBuf>) -> Self {
        path.into_iter().fold(self, |files, path| files.reads(option, path))
    }

    /// An area, if it is given: four numbers, or a file that is read.
    pub fn may_read_area(self, area: Option<&'a str>) -> Self {
        let file = area.filter(|area| area.split(',').count() != 4).map(Path::new);
        file.into_iter().fold(self, |files, file| files.reads("--area", file))
    }

    /// A file that is written.
    pub fn writes(mut self, option: &'a str, path: &Path) -> Self {
        self.written.push((option, path.to_owned()));
        self
    }

    /// A file that is written if it is given.
    pub fn may_write(self, option: &'a str, path: Option<&PathBuf>) -> Self {
        path.into_iter().fold(self, |files, path| files.writes(option, path))
    }

    /// A folder that is created if need be, but no parent of it, and the files that are written into it.
    pub fn writes_into(mut self, option: &'a str, folder: &'a Path, names: &[&str]) -> Self {
        self.folders.push((option, folder));
        self.written.extend(names.iter().map(|name| (option, folder.join(name))));
        self
    }

    /// A folder of files that is written if it is given.
    pub fn may_write_into(self, option: &'a str, folder: Option<&'a PathBuf>, names: &[&str]) -> Self {
        folder.into_iter().fold(self, |files, folder| files.writes_into(option, folder, names))
    }

    /// Refuses what is read as well, what two options name, and what cannot be written: of a folder that is not there yet, the
    /// folder itself.
    ///
    /// # Errors
    /// One sentence with the options and the path.
    pub fn check(&self) -> Result<(), InputError> {
        self.folders.iter().try_for_each(|(option, folder)| check_folder(option, folder))?;
        let is_created =
            |path: &Path| self.folders.iter().any(|(_, folder)| path.parent() == Some(folder) && !folder.exists());
        for (index, (option, path)) in self.written.iter().enumerate() {
            if !is_created(path) {
                check_file(path)?;
            }
            let identity = Identity::of(path);
            let read = self.read.iter().map(|(other, path)| (*other, *path));
            let written = self.written[..index].iter().map(|(other, path)| (*other, path.as_path()));
            if let Some((other, _)) = read.chain(written).find(|(_, other)| Identity::of(other) == identity) {
                return Err(InputError::new(format!("{option} and {other} are the same file: {}", path.display())));
            }
        }
        // Nothing is made before all of the paths are known to be right.
        let mut made = self.written.iter().map(|(_, path)| path.as_path()).filter(|path| !is_created(path));
        let mut folders = self.folders.iter().map(|(_, folder)| *folder).filter(|folder| !folder.exists());
        made.try_for_each(try_file)?;
        folders.try_for_each(try_folder)
    }
}

/// What makes two paths one file: the place on the disk where there is one, or else its folder and its name.
#[derive(Debug, PartialEq, Eq)]
enum Identity {
    Existing { device: u64, inode: u64 },
    Missing(PathBuf),
}

impl Identity {
    fn of(path: &Path) -> Self {
        if let Ok(metadata) = fs::metadata(path) {
            return Identity::Existing { device: metadata.dev(), inode: metadata.ino() };
        }
        let absolute = std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
        let folder = absolute.parent().map(|parent| parent.canonicalize().unwrap_or_else(|_| parent.to_owned()));
        Identity::Missing(folder.unwrap_or_default().join(absolute.file_name().unwrap_or_default()))
    }
}

/// Refuses a folder that could not be written to.
fn check_folder(option: &str, folder: &Path) -> Result<(), InputError> {
    let refuse = |sentence: String| Err(InputError::new(sentence));
    // A link that leads nowhere stands in the way as well.
    if folder.symlink_metadata().is_ok() && !folder.is_dir() {
        return refuse(format!("{option} {} is not a folder", folder.display()));
    }
    let parent = folder.parent().filter(|parent| !parent.as_os_str().is_empty()).unwrap_or(Path::new("."));
    if !folder.exists() && !parent.is_dir() {
        return refuse(format!("{option} {}: the folder {} does not exist", folder.display(), parent.display()));
    }
    Ok(())
}

/// Creates the folder if need be, but no parent.
///
/// # Errors
/// The system refuses.
pub fn create_folder(folder: &Path) -> Result<(), InputError> {
    if folder.is_dir() {
        return Ok(());
    }
    fs::create_dir(folder).map_err(|error| InputError::because(format!("cannot create {}", folder.display()), error))
}

/// Refuses a name that promises another format than the one written.
///
/// # Errors
/// One sentence with the option, the path and the extension wanted.
pub fn check_extension(option: &str, path: &Path, wanted: &str) -> Result<(), InputError> {
    match path.extension() {
        Some(extension) if extension.eq_ignore_ascii_case(wanted) => Ok(()),
        _ => Err(InputError::new(format!(
            "{option} {}: what is written is {}, so its name must end in .{wanted}",
            path.display(),
            wanted.to_uppercase()
        ))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scratch(name: &str) -> PathBuf {
        let folder = std::env::temp_dir().join(format!("plumbline-files-{}-{name}", std::process::id()));
        let _ = fs::remove_dir_all(&folder);
        fs::create_dir_all(&folder).expect("a scratch folder can be made");
        folder
    }

    #[test]
    fn an_input_is_known_through_links_and_detours() {
        let folder = scratch("links");
        let input = folder.join("a.png");
        fs::write(&input, b"x").expect("written");
        std::os::unix::fs::symlink(&input, folder.join("soft.png")).expect("linked");
        fs::hard_link(&input, folder.join("hard.png")).expect("linked");
        for name in ["a.png", "./a.png", "soft.png", "hard.png"] {
            let out = folder.join(name);
            let error = Files::default().reads("--frame", &input).writes("--out", &out).check().expect_err(name);
            assert!(error.to_string().contains("--out and --frame are the same file"), "{error}");
        }
        let other = folder.join("b.png");
        Files::default().reads("--frame", &input).writes("--out", &other).check().expect("two files");
    }

    #[test]
    fn two_outputs_that_are_not_there_yet_are_told_apart() {
        let folder = scratch("missing");
        let (one, again) = (folder.join("p.png"), folder.join(".").join("p.png"));
        let error = Files::default().writes("--out", &one).writes("--mask", &again).check().expect_err("one file");
        assert!(error.to_string().contains("--mask and --out are the same file"), "{error}");
        let report = folder.join("d");
        let inside = report.join("report.html");
        let files = Files::default().writes_into("--report", &report, &["report.html"]).writes("--out", &inside);
        assert!(files.check().is_err());
    }

    #[test]
    fn a_folder_needs_its_parent_and_is_not_created() {
        let folder = scratch("folders");
        let (new, deep) = (folder.join("new"), folder.join("none").join("deep"));
        Files::default().writes_into("--out", &new, &["a.csv"]).check().expect("it can be created");
        assert!(!new.exists());
        let error = Files::default().writes_into("--out", &deep, &["a.csv"]).check().expect_err("no parent");
        assert!(error.to_string().contains("does not exist"), "{error}");
    }

    #[test]
    fn a_name_promises_its_format() {
        check_extension("--out", Path::new("a.PNG"), "png").expect("the case does not matter");
        let error = check_extension("--out", Path::new("a.jpg"), "png").expect_err("another format");
        assert_eq!(error.to_string(), "--out a.jpg: what is written is PNG, so its name must end in .png");
    }
}
