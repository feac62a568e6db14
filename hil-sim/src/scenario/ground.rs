//! What is flown over, and where the files lie.

use super::{Camera, Scenario};
use plumbline_survey::error::InputError;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// What is flown over.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize, Serialize)]
#[serde(try_from = "Keys", into = "Keys")]
pub enum Ground {
    /// Synthetic, from the seed: texture, fields, roads; level at height 0 but for the houses.
    Procedural,
    /// An orthophoto.
    Ortho {
        /// What the camera sees.
        ortho: PathBuf,
        /// Heights; flat at 0 without it.
        dem: Option<PathBuf>,
        /// What the reference is made of; the same orthophoto without it.
        reference: Option<PathBuf>,
    },
}

#[derive(Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
struct Keys {
    kind: Option<Kind>,
    ortho: Option<PathBuf>,
    dem: Option<PathBuf>,
    reference: Option<PathBuf>,
}

#[derive(Deserialize, Serialize)]
#[serde(rename_all = "lowercase")]
enum Kind {
    Procedural,
}

impl TryFrom<Keys> for Ground {
    type Error = &'static str;

    fn try_from(keys: Keys) -> Result<Self, Self::Error> {
        match (keys.kind, keys.ortho) {
            (None, Some(ortho)) => Ok(Ground::Ortho { ortho, dem: keys.dem, reference: keys.reference }),
            (Some(Kind::Procedural), None) if keys.dem.is_none() && keys.reference.is_none() => Ok(Ground::Procedural),
            (Some(Kind::Procedural), _) => Err("a procedural ground takes no ortho, dem or reference"),
            (None, None) => Err("ground needs either kind = \"procedural\" or an ortho"),
        }
    }
}

impl From<Ground> for Keys {
    fn from(ground: Ground) -> Self {
        match ground {
            Ground::Procedural => Keys { kind: Some(Kind::Procedural), ortho: None, dem: None, reference: None },
            Ground::Ortho { ortho, dem, reference } => Keys { kind: None, ortho: Some(ortho), dem, reference },
        }
    }
}

impl Scenario {
    /// Makes every path ready to open.
    pub(super) fn resolve_paths(&mut self, folder: &Path, data: Option<&Path>) -> Result<(), InputError> {
        let mut paths: Vec<(&str, &mut PathBuf)> = Vec::new();
        if let Camera::File(camera) = &mut self.camera {
            paths.push(("camera_file", camera));
        }
        if let Ground::Ortho { ortho, dem, reference } = &mut self.world.ground {
            paths.push(("ground.ortho", ortho));
            paths.extend(dem.as_mut().map(|path| ("ground.dem", path)));
            paths.extend(reference.as_mut().map(|path| ("ground.reference", path)));
        }
        if let Some(replay) = &mut self.run.replay {
            paths.push(("replay.att", &mut replay.att));
        }
        if let Some(key) = &mut self.run.link.signing_key_path {
            paths.push(("link.signing_key_path", key));
        }
        for (key, path) in paths {
            *path = resolved(path, folder, data).ok_or_else(|| {
                InputError::new(format!(
                    "{}: {key} = \"{}\" needs the folder of real data, which PLUMBLINE_DATA does not name",
                    self.file,
                    path.display()
                ))
            })?;
        }
        Ok(())
    }
}

/// `None` when the data folder is needed and there is none.
fn resolved(path: &Path, folder: &Path, data: Option<&Path>) -> Option<PathBuf> {
    match path.to_str().and_then(|text| text.strip_prefix("data:")) {
        Some(inside) => data.map(|data| data.join(inside)),
        None => Some(folder.join(path)),
    }
}
