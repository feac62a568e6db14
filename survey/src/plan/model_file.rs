//! The elevation model that a plan was made over, found again by name, path and hash.

use super::file::PlanFile;
use crate::error::InputError;
use crate::io::input::sha256;
use std::path::{Path, PathBuf};

/// A file as a plan names it.
#[derive(Debug, Clone, PartialEq)]
pub struct ModelFile {
    /// As it was named.
    pub name: String,
    /// Its absolute path.
    pub path: String,
    /// SHA-256 of its bytes, hexadecimal.
    pub sha256: String,
}

impl ModelFile {
    /// The file at a path.
    ///
    /// # Errors
    /// It cannot be read.
    pub fn of(path: &Path) -> Result<Self, InputError> {
        let absolute = path.canonicalize().unwrap_or_else(|_| path.to_owned());
        Ok(ModelFile { name: path.display().to_string(), path: absolute.display().to_string(), sha256: sha256(path)? })
    }
}

impl PlanFile {
    /// The plan's own elevation model: at its absolute path, else beside the plan, else as it was named. Where the plan has
    /// a hash the file has to have it: another model of the same name is none of the plan's.
    ///
    /// # Errors
    /// No such file, or only such as have another hash.
    pub fn model_path(&self, plan: &Path) -> Result<PathBuf, InputError> {
        let named = Path::new(&self.dem);
        let folder = plan.parent().unwrap_or(Path::new(""));
        let beside = named.file_name().map(|name| folder.join(name));
        let candidates =
            [self.dem_path.as_ref().map(PathBuf::from), Some(folder.join(named)), beside, Some(named.to_owned())];
        let found: Vec<PathBuf> = candidates.into_iter().flatten().filter(|path| path.is_file()).collect();
        let refuse = |why: String| {
            Err(InputError::new(format!(
                "{}: its elevation model {} {why}; --dem names another",
                plan.display(),
                self.dem
            )))
        };
        let Some(first) = found.first() else { return refuse("is not there".to_owned()) };
        let Some(wanted) = &self.dem_sha256 else { return Ok(first.clone()) };
        for path in &found {
            if sha256(path)? == *wanted {
                return Ok(path.clone());
            }
        }
        refuse(format!("has another content than when the plan was made (SHA-256 of {})", first.display()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::io::output::tests::scratch;

    #[test]
    fn the_model_is_told_by_its_hash_and_the_place_beside_the_plan_comes_first() {
        let folder = scratch("model-file");
        let (here, there) = (folder.join("here"), folder.join("there"));
        for (folder, heights) in [(&here, "1 2"), (&there, "3 4")] {
            std::fs::create_dir(folder).expect("made");
            std::fs::write(folder.join("dem.asc"), heights).expect("written");
        }
        let of = ModelFile::of(&here.join("dem.asc")).expect("readable");
        // sha256sum of "1 2".
        assert_eq!(of.sha256, "f71998fe363b9c29116c80b5eecf33a2fedca3b6159724384485804b71651029");
        let mut plan = crate::plan::file::tests::plan();
        plan.dem = here.join("dem.asc").display().to_string();
        let found = |plan: &PlanFile| plan.model_path(&there.join("plan.json"));
        // A plan of an older version: what lies beside it is its own.
        (plan.dem_path, plan.dem_sha256) = (None, None);
        plan.dem = "dem.asc".to_owned();
        assert_eq!(found(&plan), Ok(there.join("dem.asc")));
        (plan.dem_path, plan.dem_sha256) = (Some(of.path.clone()), Some(of.sha256));
        assert_eq!(found(&plan), Ok(PathBuf::from(&of.path)));
        std::fs::write(here.join("dem.asc"), "5 6").expect("written");
        let error = found(&plan).expect_err("changed").to_string();
        assert!(error.contains("another content") && error.contains("--dem"), "{error}");
        plan.dem = "none.asc".to_owned();
        plan.dem_path = None;
        assert!(found(&plan).expect_err("missing").to_string().contains("is not there"));
    }
}
