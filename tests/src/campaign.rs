//! Many flights and their fixes pooled: what a change does to flights that nobody looks at one by one.
//!
//! A case is a scenario and faults. Every case is flown with the same seeds, so that cases differ by what they are alone; where maps of several years are
//! given, every ordered pair of them is ground and reference of flights of its own.

pub mod flight;
pub mod kinds;
pub mod pooled;
pub mod table;

use plumbline_sim::scenario::{BUILT_IN, Fault, Ground, Instead, Scenario, Setting};
use plumbline_survey::error::InputError;
use plumbline_survey::io::data::shared_data;
use std::path::{Path, PathBuf};

/// What is flown, but for the seed.
#[derive(Clone, Debug)]
pub struct Case {
    /// Name of a built-in scenario.
    pub scenario: String,
    /// All faults of the flight at once.
    pub faults: Vec<Fault>,
}

/// What all cases have in common.
#[derive(Clone, Debug, Default)]
pub struct Common {
    /// Frames of a flight; as many as the scenario says without.
    pub frames: Option<u32>,
    /// Keys laid over the scenario.
    pub keys: Vec<Setting>,
    /// Orthophotos of one area: each is the ground, and every other one its reference. None: as the scenario says.
    pub orthos: Vec<PathBuf>,
}

impl Case {
    /// Scenario and faults, as a user would write them.
    #[must_use]
    pub fn name(&self) -> String {
        let faults = self.faults.iter().map(|fault| format!(" {fault}"));
        self.scenario.clone() + &faults.collect::<String>()
    }

    /// The scenario of a seed, over a pair of orthophotos where that is given.
    ///
    /// # Errors
    /// No such scenario is built in, or a key is wrong.
    pub fn scenario(&self, common: &Common, pair: Option<[&Path; 2]>, seed: u64) -> Result<Scenario, InputError> {
        let name = self.scenario.as_str();
        let built_in = BUILT_IN.iter().find(|(built_in, _)| *built_in == name);
        let (_, text) = built_in.ok_or_else(|| InputError::new(format!("no scenario {name:?} is built in")))?;
        let given = pair.is_some();
        let text = Scenario::instead(
            text,
            name,
            Instead { ground: given, dem: given, reference: given, ..Instead::default() },
        )?;
        let (text, called) = Scenario::set(&text, name, &common.keys)?;
        let mut scenario = Scenario::parse(&text, &called, Path::new(""), shared_data().as_deref())?;
        if let Some([ground, reference]) = pair {
            let (ortho, reference) = (ground.to_owned(), Some(reference.to_owned()));
            scenario.world.ground = Ground::Ortho { ortho, dem: None, reference };
        }
        (scenario.run.seed, scenario.vehicle.send_patches) = (seed, false);
        scenario.run.frames = common.frames.unwrap_or(scenario.run.frames);
        for fault in &self.faults {
            scenario.faults.timed.push(*fault);
        }
        // Again, with what was not in the text.
        scenario.check()?;
        Ok(scenario)
    }
}

/// Every ordered pair of files; one of nothing where there are no files.
///
/// # Errors
/// A file is named twice or is not there.
pub fn pairs(orthos: &[PathBuf]) -> Result<Vec<Option<[&Path; 2]>>, String> {
    for (number, ortho) in orthos.iter().enumerate() {
        if orthos[..number].contains(ortho) {
            return Err(format!("{} is named twice; give each orthophoto once", ortho.display()));
        }
        std::fs::File::open(ortho).map_err(|error| format!("{}: {error}", ortho.display()))?;
    }
    Ok(all_pairs(orthos))
}

fn all_pairs(orthos: &[PathBuf]) -> Vec<Option<[&Path; 2]>> {
    let all =
        orthos.iter().flat_map(|ground| orthos.iter().map(move |reference| [ground.as_path(), reference.as_path()]));
    let pairs: Vec<_> = all.filter(|[ground, reference]| ground != reference).map(Some).collect();
    if pairs.is_empty() { vec![None] } else { pairs }
}

/// Both files without their folders.
#[must_use]
pub fn pair_name(pair: [&Path; 2]) -> String {
    let [ground, reference] = pair.map(|path| path.file_name().unwrap_or_default().to_string_lossy());
    format!("{ground} over {reference}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_year_over_every_other() {
        let files = ["a", "b", "c"].map(PathBuf::from);
        let names: Vec<_> = all_pairs(&files)
            .into_iter()
            .flatten()
            .map(|pair| pair.map(|path| path.display().to_string()).concat())
            .collect();
        assert_eq!(names, ["ab", "ac", "ba", "bc", "ca", "cb"]);
        assert_eq!(all_pairs(&[]), [None]);
        let twice = [files[0].clone(), files[0].clone()];
        assert!(pairs(&twice).unwrap_err().contains('a'));
    }

    #[test]
    fn a_case_is_a_scenario_with_keys_faults_and_a_pair() {
        let faults = ["range.off", "baro.bias=15@20..55"].map(|fault| fault.parse().expect("a fault"));
        let case = Case { scenario: "naip".into(), faults: faults.to_vec() };
        assert_eq!(case.name(), "naip range.off@0.. baro.bias=15@20..55");
        let keys = ["camera.cols=128", "camera.rows=128"].map(|key| key.parse().expect("a key")).to_vec();
        let common = Common { frames: Some(7), keys, orthos: Vec::new() };
        let pair = [Path::new("2012.tif"), Path::new("2019.tif")];
        let scenario = case.scenario(&common, Some(pair), 93).expect("sound");
        assert_eq!((scenario.run.seed, scenario.run.frames, scenario.faults.timed.all().len()), (93, 7, 2));
        let Ground::Ortho { ortho, dem: None, reference: Some(reference) } = scenario.world.ground else {
            panic!("another ground")
        };
        assert_eq!([ortho.as_path(), reference.as_path()], pair);
        let encoder = Case { faults: vec!["encoder.off".parse().expect("a fault")], ..case.clone() };
        assert!(encoder.scenario(&common, None, 1).unwrap_err().to_string().contains("encoder"));
        let unknown = Case { scenario: "nowhere".into(), faults: Vec::new() };
        assert!(unknown.scenario(&common, None, 1).unwrap_err().to_string().contains("nowhere"));
    }
}
