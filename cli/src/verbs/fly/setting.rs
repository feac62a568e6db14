//! The scenario: a file, a built-in one or the default, and what the options change in it.

use super::Args;
use crate::outcome::Failure;
use plumbline_sim::scenario::{BUILT_IN, Ground, Instead, LIVE, Replay, Scenario};
use plumbline_sim::setup::{PlanToFly, Setup};
use plumbline_survey::error::{InputError, counted};
use plumbline_survey::io::data::shared_data;
use plumbline_survey::io::input;
use plumbline_survey::misspelt::meant;
use std::path::Path;

/// What is to be flown, made ready.
pub fn setup(args: &Args) -> Result<Setup, Failure> {
    let (scenario, has_resolution) = scenario(args)?;
    Ok(match args.plan.clone() {
        // Under a plan there is always an elevation model.
        Some(file) => Setup::along_plan(scenario, &PlanToFly { file, dem: args.dem.clone(), has_resolution })?,
        None => Setup::prepare(scenario)?,
    })
}

/// What of the faults that were asked for never happens.
pub fn late_faults(scenario: &Scenario) -> Vec<String> {
    let end_us = scenario.run.duration_us();
    let late = scenario.faults.timed.all().iter().filter(|fault| fault.from_us() >= end_us);
    let says = |fault| {
        format!(
            "the fault {fault} never happens: the flight of {} is over after {:.1} s",
            counted(scenario.run.frames as usize, "frame"),
            1e-6 * end_us as f64
        )
    };
    late.map(says).collect()
}

/// What is to be flown, and whether it says a resolution.
pub fn scenario(args: &Args) -> Result<(Scenario, bool), Failure> {
    let (mut scenario, has_resolution) = load(args)?;
    args.faults.iter().for_each(|fault| scenario.faults.timed.push(*fault));
    scenario.check()?;
    if let Some(frames) = args.frames {
        scenario.run.frames = frames;
    }
    if let Some(seed) = args.seed {
        scenario.run.seed = seed;
    }
    if let Some(log) = &args.replay {
        scenario.run.replay = Some(Replay { att: log.clone(), start_s: None, time_scale: 1.0 });
    }
    ground(args, &mut scenario.world.ground)?;
    Ok((scenario, has_resolution))
}

/// A file of that name, or else a built-in scenario; with a plan over what plans are flown with, with a real autopilot over what
/// live flights are flown with; and whether it says a resolution.
fn load(args: &Args) -> Result<(Scenario, bool), Failure> {
    let data = shared_data();
    let instead = Instead {
        ground: args.ground.is_some(),
        dem: args.dem.is_some() && args.plan.is_none(),
        reference: args.reference.is_some(),
        replay: args.replay.is_some(),
    };
    let parse = |text: &str, file: &str, folder: &Path| {
        let text = Scenario::instead(text, file, instead)?;
        let (text, file) = Scenario::set(&text, file, &args.settings)?;
        match (&args.plan, &args.autopilot) {
            (Some(_), _) => Ok(Scenario::parse_planned(&text, &file, folder, data.as_deref())?),
            (None, Some(_)) => Ok((Scenario::parse_over(LIVE, &text, &file, folder, data.as_deref())?, true)),
            (None, None) => Ok((Scenario::parse(&text, &file, folder, data.as_deref())?, true)),
        }
    };
    let Some(path) = &args.scenario else {
        return match (&args.plan, &args.autopilot) {
            (Some(_), _) => parse("", "survey", Path::new("")),
            (None, Some(_)) => parse("", "live", Path::new("")),
            (None, None) if args.settings.is_empty() => Ok((Scenario::default(), true)),
            (None, None) => parse("", "the default scene", Path::new("")),
        };
    };
    match BUILT_IN.iter().find(|(name, _)| Path::new(name) == path) {
        Some((name, text)) if !path.is_file() => parse(text, &format!("scenario {name}"), Path::new("")),
        None if !path.exists() => {
            let names = BUILT_IN.map(|(name, _)| name).join(", ");
            Err(Failure::Input(InputError::new(format!(
                "--scenario {}: there is no such file, and the built-in ones are {names}{}",
                path.display(),
                meant(&path.to_string_lossy(), BUILT_IN.map(|(name, _)| name))
                    .map_or(String::new(), |name| format!("; a similar one exists: '{name}'"))
            ))))
        }
        _ => parse(&input::text(path)?, &path.display().to_string(), path.parent().unwrap_or(Path::new(""))),
    }
}

/// `--ground` replaces the scenario's ground; `--dem` and `--reference` belong to an orthophoto, whoever named it.
fn ground(args: &Args, ground: &mut Ground) -> Result<(), Failure> {
    if let Some(ortho) = &args.ground {
        *ground = Ground::Ortho { ortho: ortho.clone(), dem: None, reference: None };
    }
    let of_ground = args.dem.as_ref().filter(|_| args.plan.is_none());
    match ground {
        Ground::Ortho { dem, reference, .. } => {
            *dem = of_ground.cloned().or(dem.take());
            *reference = args.reference.clone().or(reference.take());
            Ok(())
        }
        Ground::Procedural => {
            let given = [("--dem", of_ground), ("--reference", args.reference.as_ref())];
            match given.iter().find(|(_, path)| path.is_some()) {
                Some((option, _)) => {
                    Err(Failure::Input(InputError::new(format!("{option} needs an orthophoto to fly over: --ground"))))
                }
                None => Ok(()),
            }
        }
    }
}
