//! `cargo xtask budget`: what a frame costs, beside what it may cost.
//!
//! The bench image runs in QEMU with a plugin that counts, region by region ([`mod@bench`]); the worst pose of each
//! workload ([`workloads`]) becomes figures with limits ([`figures`]). Instructions are held to the committed table
//! ([`expected`]) or to another revision ([`against`]); memory is read from the images ([`map`], [`memory`]).

mod against;
mod bench;
mod expected;
mod figures;
pub mod map;
mod memory;
mod tell;
mod workloads;

use crate::set_up::Compiler;
use crate::steps::Outcome;
use crate::{Failure, build, failed, set_up};
use expected::Expected;
use figures::Figure;
use std::process::ExitCode;

/// What was asked for.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
struct Options {
    json: bool,
    overwrite: bool,
    against: Option<String>,
}

impl Options {
    fn parse(arguments: &[String]) -> Result<Self, Failure> {
        let mut options = Options::default();
        let mut arguments = arguments.iter();
        while let Some(argument) = arguments.next() {
            match argument.as_str() {
                "--json" => options.json = true,
                "--overwrite" => options.overwrite = true,
                "--against" => {
                    let revision = arguments.next().filter(|revision| !revision.starts_with('-'));
                    options.against = Some(revision.ok_or("--against needs a revision")?.clone());
                }
                unknown => {
                    return Err(format!("budget knows no {unknown:?}; it knows --json, --overwrite and --against"));
                }
            }
        }
        if options.overwrite && options.against.is_some() {
            return Err("--overwrite renews the table, which --against does not read: one of them at a time".into());
        }
        Ok(options)
    }
}

/// Measures and judges: exit code 1 where a gate fails.
///
/// # Errors
/// A sentence on what cannot be asked for.
pub fn budget(arguments: &[String]) -> Result<ExitCode, Failure> {
    let options = Options::parse(arguments)?;
    let judged = match &options.against {
        Some(revision) => {
            let commit = against::commit(revision)?;
            compared(&options, revision, &commit)
        }
        None => measured(&options),
    };
    Ok(judged.map_or_else(failed, |is_good| if is_good { ExitCode::SUCCESS } else { ExitCode::FAILURE }))
}

/// Whether every gate holds of what `compiler` has just built, with the table told. Left out where the counts are of another
/// compiler, under which the narrow gates say nothing.
pub fn holds(compiler: &Compiler) -> Outcome {
    let judged = || {
        let (of, here) = (Expected::read()?.compiler, compiler.version()?);
        if of != here {
            return Ok(Outcome::Skipped(format!("the counts are of {of}, this is {here}")));
        }
        let failed = || Outcome::Failed("a gate fails, see above".to_owned());
        judged(&Options::default(), compiler).map(|holds| if holds { Outcome::Passed } else { failed() })
    };
    judged().unwrap_or_else(Outcome::Failed)
}

/// The working tree by itself; whether every gate holds.
fn measured(options: &Options) -> Result<bool, Failure> {
    set_up::emulator()?;
    judged(options, &built()?)
}

/// Builds what is measured and what measures.
fn built() -> Result<Compiler, Failure> {
    let compiler = set_up::compiler()?;
    build::images(&compiler)?;
    build::host().map(|()| compiler)
}

/// What `compiler` has built; whether every gate holds.
fn judged(options: &Options, compiler: &Compiler) -> Result<bool, Failure> {
    let workloads = workloads::workloads(&bench::here(compiler)?)?;
    let mut figures = figures::of_workloads(&workloads);
    figures.extend(memory::figures()?);

    let version = compiler.version()?;
    if options.overwrite {
        Expected::of(&version, &figures).write()?;
    }
    let expected = Expected::read()?;
    let is_comparable = expected.compiler == version;
    if is_comparable {
        expected.limit(&mut figures);
    } else {
        eprintln!(
            "the table of exact counts is of {}, this is {version}: its gate is left out, the others decide",
            expected.compiler
        );
    }
    let mut failures = figures::failures(&figures);
    if is_comparable {
        failures.extend(expected.missing(&figures));
        expected.tell_falls(&figures);
    }
    finish(options, &workloads, &figures, &failures)
}

/// Against another revision, with the same compiler; whether nothing has grown.
fn compared(options: &Options, revision: &str, commit: &str) -> Result<bool, Failure> {
    set_up::emulator()?;
    let compiler = built()?;
    let before = against::regions((revision, commit), &compiler)?;
    let before = figures::of_workloads(&workloads::workloads(&before)?);
    let workloads = workloads::workloads(&bench::here(&compiler)?)?;
    let mut figures = figures::of_workloads(&workloads);
    against::limit(&mut figures, &before);
    let failures = figures::grown(&figures, &before, revision);
    finish(options, &workloads, &figures, &failures)
}

fn finish(
    options: &Options,
    workloads: &[workloads::Workload],
    figures: &[Figure],
    failures: &[Failure],
) -> Result<bool, Failure> {
    if options.json {
        println!("{}", tell::json(figures));
    } else {
        print!("{}", tell::table(workloads, figures));
    }
    failures.iter().for_each(|sentence| eprintln!("{sentence}"));
    Ok(failures.is_empty())
}

#[cfg(test)]
mod tests {
    use super::Options;

    fn parse(line: &str) -> Result<Options, String> {
        Options::parse(&line.split_whitespace().map(str::to_owned).collect::<Vec<_>>())
    }

    #[test]
    fn options_are_read_and_others_refused() {
        assert_eq!(parse(""), Ok(Options::default()));
        let json = Options { json: true, against: Some("HEAD~1".into()), ..Options::default() };
        assert_eq!(parse("--json --against HEAD~1"), Ok(json));
        for line in ["--jsn", "--against", "--against --json", "--overwrite --against HEAD"] {
            assert!(parse(line).is_err(), "{line}");
        }
    }
}
