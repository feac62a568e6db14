//! A folder of its own for each test, with what the command needs.

use crate::command::{Run, plumbline};
use crate::pictures;
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

/// Six keys, which are a whole camera file: 96 x 96 pixels, 60 degrees both ways.
pub const CAMERA: &str =
    "cols = 96\nrows = 96\nfov_h_deg = 60.0\nfov_v_deg = 60.0\noffset_m_px = 0.0\noffset_n_px = 0.0\n";

/// A flight over [`Folder::with_ground`].
pub const FLY: &str = "fly --ground ground.tif";

/// A folder that is empty when the test starts. It stays afterwards, to be looked at.
#[derive(Debug)]
pub struct Folder(PathBuf);

impl Folder {
    /// An empty one. `name` must be the test's own.
    pub fn new(name: &str) -> Self {
        let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join("cli").join(name);
        let _ = fs::remove_dir_all(&path);
        fs::create_dir_all(&path).expect("a scratch folder can be made");
        Folder(path)
    }

    /// One with `camera.toml`, the `frame.png` it took, a `patch.png` of 34 x 34 pixels and its `reference.png` of
    /// 74 x 74.
    pub fn with_scene(name: &str) -> Self {
        let folder = Folder::new(name);
        folder.write("camera.toml", CAMERA);
        pictures::grey_8_png(&folder.path("frame.png"), &pictures::texture((96, 96), (0.0, 0.0)));
        pictures::grey_8_png(&folder.path("patch.png"), &pictures::texture((34, 34), (2.0, 1.0)));
        pictures::grey_8_png(&folder.path("reference.png"), &pictures::texture((74, 74), (0.0, 0.0)));
        folder
    }

    /// One with `ground.tif`, 256 x 256 pixels of 5 m: read in no time, and enough for a short flight.
    pub fn with_ground(name: &str) -> Self {
        let folder = Folder::new(name);
        pictures::geotiff(
            &folder.path("ground.tif"),
            &pictures::texture((256, 256), (0.0, 0.0)),
            5.0,
            pictures::Crs::Projected(32633),
        );
        folder
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.0.join(name)
    }

    pub fn write(&self, name: &str, content: impl AsRef<[u8]>) {
        fs::write(self.path(name), content).expect("written");
    }

    pub fn read(&self, name: &str) -> Vec<u8> {
        fs::read(self.path(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
    }

    pub fn text(&self, name: &str) -> String {
        String::from_utf8(self.read(name)).expect("UTF-8")
    }

    pub fn make(&self, name: &str) {
        fs::create_dir(self.path(name)).expect("a folder can be made");
    }

    /// Runs the command here, with stdout and stderr caught.
    pub fn run(&self, arguments: &str) -> Run {
        plumbline(&self.0, arguments).output().expect("the command starts").into()
    }

    /// Puts everything back as it was; what had to be put back.
    pub fn restore(&self, before: &BTreeMap<PathBuf, Option<Vec<u8>>>) -> Vec<PathBuf> {
        let after = self.content();
        let touched = |path: &&PathBuf| before.get(*path) != after.get(*path);
        let mut new: Vec<PathBuf> = after.keys().filter(|path| !before.contains_key(*path)).cloned().collect();
        let mut restored: Vec<PathBuf> = before.keys().filter(touched).cloned().collect();
        for path in &restored {
            match &before[path] {
                Some(bytes) => fs::write(path, bytes).expect("written back"),
                None => fs::create_dir_all(path).expect("made again"),
            }
        }
        // A folder's own files come after it.
        for path in new.iter().rev() {
            let removed = if path.is_dir() { fs::remove_dir(path) } else { fs::remove_file(path) };
            removed.expect("removed");
        }
        restored.append(&mut new);
        restored
    }

    /// Everything below: files with their bytes, folders with none.
    pub fn content(&self) -> BTreeMap<PathBuf, Option<Vec<u8>>> {
        let mut content = BTreeMap::new();
        let mut open = vec![self.0.clone()];
        while let Some(folder) = open.pop() {
            for entry in fs::read_dir(folder).expect("listed") {
                let path = entry.expect("an entry").path();
                if path.is_dir() {
                    open.push(path.clone());
                    content.insert(path, None);
                } else {
                    content.insert(path.clone(), Some(fs::read(path).expect("readable")));
                }
            }
        }
        content
    }
}

/// `arguments` with another value for `option`, which must be among them.
pub fn with(arguments: &str, option: &str, value: &str) -> String {
    let mut words: Vec<&str> = arguments.split_whitespace().collect();
    let place = words.iter().position(|word| *word == option).unwrap_or_else(|| panic!("{option} in {arguments}"));
    words[place + 1] = value;
    words.join(" ")
}

/// `arguments` without `option` and its value.
pub fn without(arguments: &str, option: &str) -> String {
    let words: Vec<&str> = arguments.split_whitespace().collect();
    let place = words.iter().position(|word| *word == option).unwrap_or_else(|| panic!("{option} in {arguments}"));
    [&words[..place], &words[place + 2..]].concat().join(" ")
}
