//! The host program behind `cargo xtask campaign`: many flights in the process itself, as many at once as there are cores.

use clap::Parser;
use indicatif::{ProgressBar, ProgressStyle};
use plumbline_sim::scenario::{Fault, Setting};
use plumbline_survey::io::output::{try_file, write_file};
use plumbline_tests::campaign::flight::{Flown, flown};
use plumbline_tests::campaign::{Case, Common, kinds, pair_name, pairs, table};
use rayon::prelude::*;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

#[derive(Debug, Parser)]
#[command(
    name = "cargo xtask campaign",
    about = "Many flights and what their fixes are worth: wrong ones, coverage, covariance, recovery from faults",
    override_usage = "cargo xtask campaign [OPTIONS]"
)]
struct Options {
    /// Built-in scenario; several are flown one after the other
    #[arg(long = "scenario", default_value = "default")]
    scenarios: Vec<String>,
    /// Flights of each case, or, with --between, of each pair
    #[arg(long, default_value_t = 8, value_parser = clap::value_parser!(u64).range(1..=1_000_000))]
    seeds: u64,
    /// The first flight's seed; every next flight of a case has the next one
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u64).range(..=1 << 48))]
    seed: u64,
    /// Frames of a flight, instead of what the scenario says
    #[arg(long)]
    frames: Option<u32>,
    /// A key of the scenario, as for plumbline fly
    #[arg(long = "set", value_name = "KEY=VALUE")]
    keys: Vec<Setting>,
    /// Faults of one case, separated by blanks, each as for plumbline fly; several --fault are several cases
    #[arg(long = "fault", value_name = "UNIT.TYPE[=VALUE][@FROM..[TO]] ...")]
    faults: Vec<String>,
    /// A case with a fault of each kind in that interval, seconds
    #[arg(long, value_name = "FROM..TO")]
    each_fault: Option<String>,
    /// Only those of --each-fault that begin so
    #[arg(long, value_name = "WORD", requires = "each_fault")]
    kind: Vec<String>,
    /// Also without a fault
    #[arg(long)]
    sound: bool,
    /// Orthophotos of one area: each as ground with every other one as reference
    #[arg(long, num_args = 2.., value_name = "ORTHO")]
    between: Vec<PathBuf>,
    /// Also a row for every frame of every flight
    #[arg(long, value_name = "FILE.csv")]
    frames_csv: Option<PathBuf>,
}

fn main() -> ExitCode {
    match campaign(Options::parse()) {
        Ok(text) => {
            print!("{text}");
            ExitCode::SUCCESS
        }
        Err(sentence) => {
            eprintln!("cargo xtask campaign: {sentence}");
            ExitCode::from(2)
        }
    }
}

fn campaign(options: Options) -> Result<String, String> {
    if let Some(path) = &options.frames_csv {
        try_file(path).map_err(|error| error.to_string())?;
    }
    let common = Common { frames: options.frames, keys: options.keys.clone(), orthos: options.between.clone() };
    let pairs = pairs(&common.orthos)?;
    let cases = cases(&options, &common, pairs[0])?;
    let own = options.seeds * pairs.len() as u64;
    let flights: Vec<(&Case, u64)> = cases.iter().flat_map(|case| (0..own).map(move |flight| (case, flight))).collect();
    let progress = ProgressBar::new(flights.len() as u64).with_style(style());
    let fly = |&(case, flight): &(&Case, u64)| {
        let (pair, seed) = (pairs[flight as usize % pairs.len()], options.seed + flight);
        let scenario = case.scenario(&common, pair, seed).map_err(|error| error.to_string())?;
        let pair_name = pair.map(pair_name).unwrap_or_default();
        let flown = flown(scenario, pair_name).map_err(|error| format!("{} seed {seed}: {error}", case.name()))?;
        progress.inc(1);
        Ok(flown)
    };
    // One at a time from the list: flights differ in length.
    let all: Vec<Flown> = flights.par_iter().with_max_len(1).map(fly).collect::<Result<_, String>>()?;
    progress.finish_and_clear();
    let named =
        cases.iter().zip(all.chunks(own as usize)).map(|(case, flights)| (case.name(), flights.iter().collect()));
    let named: Vec<table::Named<'_>> = named.collect();
    if let Some(path) = &options.frames_csv {
        write_file(path, table::csv(&named).as_bytes()).map_err(|error| error.to_string())?;
    }
    Ok(table::text(&named))
}

/// Scenarios times faults, all of which can be flown. Faults of all kinds that a scenario has no place for are left out, and named.
fn cases(options: &Options, common: &Common, pair: Option<[&Path; 2]>) -> Result<Vec<Case>, String> {
    let together = |faults: &String| faults.split_whitespace().map(str::parse).collect::<Result<Vec<Fault>, String>>();
    let mut faults: Vec<Vec<Fault>> = options.faults.iter().map(together).collect::<Result<_, _>>()?;
    if options.sound || faults.is_empty() && options.each_fault.is_none() {
        faults.insert(0, Vec::new());
    }
    let named = faults.len();
    if let Some(interval) = &options.each_fault {
        faults.extend(kinds::faults(&options.kind, interval)?.into_iter().map(|fault| vec![fault]));
    }
    let mut cases = Vec::new();
    for scenario in &options.scenarios {
        for (number, faults) in faults.iter().enumerate() {
            let case = Case { scenario: scenario.clone(), faults: faults.clone() };
            match case.scenario(common, pair, options.seed) {
                Ok(_) => cases.push(case),
                Err(why) if number >= named => eprintln!("{} is left out: {why}", case.name()),
                Err(why) => return Err(why.to_string()),
            }
        }
    }
    if cases.is_empty() { Err("nothing is left to fly".into()) } else { Ok(cases) }
}

fn style() -> ProgressStyle {
    let style = ProgressStyle::with_template("{wide_bar} {pos} of {len} flights, {eta} left");
    style.unwrap_or_else(|_| ProgressStyle::default_bar())
}
