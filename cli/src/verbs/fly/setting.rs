//! The scenario: a file, a built-in one or the default, and what the options change in it.

use super::Args;
use crate::outcome::Failure;
use plumbline_sim::scenario::{BUILT_IN, Ground, Replay, Scenario, ScenarioError};
use plumbline_survey::error::InputError;
use plumbline_survey::io::data::shared_data;
use std::path::Path;

/// What is to be flown. Each option's value is checked under its own name.
pub fn scenario(args: &Args) -> Result<Scenario, Failure> {
    let mut scenario = match (&args.scenario, &args.plan) {
        (None, None) => Scenario::default_scene(),
        (None, Some(plan)) => Scenario::parse_planned(plan, "", "survey", Path::new(""), None).map_err(refuse)?,
        (Some(path), plan) => load(path, plan.as_deref())?,
    };
    let check = |scenario: &Scenario, option: &str| scenario.check(option).map_err(refuse);
    if let Some(frames) = args.frames {
        scenario.frames = frames;
        check(&scenario, "--frames")?;
    }
    if let Some(seed) = args.seed {
        scenario.seed = seed;
    }
    ground(args, &mut scenario)?;
    if let Some(log) = &args.replay {
        scenario.replay = Some(Replay { att: log.clone(), start_s: None, time_scale: 1.0 });
        check(&scenario, "--replay")?;
    }
    Ok(scenario)
}

/// A file of that name, or else a built-in scenario; with a plan over what plans are flown with.
fn load(path: &Path, plan: Option<&Path>) -> Result<Scenario, Failure> {
    let data = shared_data();
    let built_in = BUILT_IN.iter().find(|(name, _)| Path::new(name) == path);
    let parse = |text: &str, file: &str, folder: &Path| match plan {
        Some(plan) => Scenario::parse_planned(plan, text, file, folder, data.as_deref()).map_err(refuse),
        None => Scenario::parse(text, file, folder, data.as_deref()).map_err(refuse),
    };
    match built_in {
        Some((name, text)) if !path.is_file() => parse(text, &format!("scenario {name}"), Path::new("")),
        None if !path.exists() => {
            let names = BUILT_IN.map(|(name, _)| name).join(", ");
            Err(Failure::Input(InputError::new(format!(
                "--scenario {}: there is no such file, and the built-in ones are {names}",
                path.display()
            ))))
        }
        _ => {
            let file = path.display().to_string();
            let text = std::fs::read_to_string(path)
                .map_err(|error| InputError::new(format!("{file}: cannot read the scenario ({error})")))?;
            parse(&text, &file, path.parent().unwrap_or(Path::new("")))
        }
    }
}

/// `--ground` replaces the scenario's ground; `--dem` and `--reference` belong to an orthophoto, whoever named it.
fn ground(args: &Args, scenario: &mut Scenario) -> Result<(), Failure> {
    if let Some(ortho) = &args.ground {
        scenario.ground = Ground::Ortho { ortho: ortho.clone(), dem: None, reference: None };
    }
    if args.plan.is_some() {
        // Under a plan there is always an elevation model.
        scenario.plan.dem.clone_from(&args.dem);
        if let (Ground::Ortho { reference, .. }, Some(other)) = (&mut scenario.ground, &args.reference) {
            *reference = Some(other.clone());
        }
        return match (&scenario.ground, &args.reference) {
            (Ground::Procedural, Some(_)) => {
                Err(Failure::Input(InputError::new("--reference needs an orthophoto to fly over: --ground")))
            }
            _ => Ok(()),
        };
    }
    match &mut scenario.ground {
        Ground::Ortho { dem, reference, .. } => {
            *dem = args.dem.clone().or(dem.take());
            *reference = args.reference.clone().or(reference.take());
            Ok(())
        }
        Ground::Procedural => {
            let given = [("--dem", &args.dem), ("--reference", &args.reference)];
            match given.iter().find(|(_, path)| path.is_some()) {
                Some((option, _)) => {
                    Err(Failure::Input(InputError::new(format!("{option} needs an orthophoto to fly over: --ground"))))
                }
                None => Ok(()),
            }
        }
    }
}

fn refuse(error: ScenarioError) -> Failure {
    Failure::Input(InputError::new(error.to_string()))
}
