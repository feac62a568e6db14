//! The host program behind `cargo xtask compare`.
//!
//! Without `--frame` it runs the built-in cases and holds them to their limits (exit code 1 where one fails); with it, one
//! picture at one attitude, told and not judged. The folder keeps frames, OpenCV's patches and the exact averages
//! (`exact-VIEW.f64`, little-endian, NaN where a cell is not wholly in the frame).

use clap::Parser;
use clap::error::ErrorKind;
use plumbline_tests::compare::case::{Case, Purpose};
use plumbline_tests::compare::cases;
use plumbline_tests::compare::theirs::Script;
use plumbline_tests::compare::view::{Ground, Pose, View};
use plumbline_tests::compare::{Failure, drawing, pictures, run, tell};
use std::path::PathBuf;
use std::process::ExitCode;

#[derive(Debug, Parser)]
#[command(
    name = "cargo xtask compare",
    about = "The core's kernels beside OpenCV's: error and time",
    override_usage = "cargo xtask compare [OPTIONS]"
)]
struct Options {
    /// One JSON document instead of the table
    #[arg(long)]
    json: bool,
    /// Also write accuracy against cost to this folder, kernels.svg and kernels.md; costs are those of the table of exact
    /// counts, tests/expected/budget.json
    #[arg(long, conflicts_with = "frame")]
    front: Option<PathBuf>,
    /// Rectify this picture instead of the built-in cases
    #[arg(long)]
    frame: Option<PathBuf>,
    /// Full field of view over the frame's larger side, degrees
    #[arg(long, default_value_t = 40.0, requires = "frame")]
    fov_deg: f64,
    /// Height above ground, metres
    #[arg(long, default_value_t = 439.6, requires = "frame")]
    height_m: f64,
    /// A cell, metres
    #[arg(long, default_value_t = 5.0, requires = "frame")]
    resolution_m: f64,
    /// Cells across and along
    #[arg(long, default_value_t = 64, requires = "frame", value_parser = clap::value_parser!(u16).range(1..=4096))]
    cells: u16,
    /// Heading, degrees clockwise from north
    #[arg(long, default_value_t = 0.0, requires = "frame", allow_negative_numbers = true)]
    heading_deg: f64,
    /// Pitch, degrees, nose up positive
    #[arg(long, default_value_t = 8.0, requires = "frame", allow_negative_numbers = true)]
    pitch_deg: f64,
    /// Roll, degrees, right wing down positive
    #[arg(long, default_value_t = 10.0, requires = "frame", allow_negative_numbers = true)]
    roll_deg: f64,
    /// The camera follows, instead of being fixed to the body
    #[arg(long, requires = "frame")]
    followed: bool,
    #[arg(long, hide = true)]
    python: PathBuf,
    #[arg(long, hide = true)]
    script: PathBuf,
    #[arg(long, hide = true)]
    folder: PathBuf,
}

fn main() -> ExitCode {
    let options = match Options::try_parse() {
        Ok(options) => options,
        Err(error) if error.kind() == ErrorKind::DisplayHelp => {
            let _ = error.print();
            return ExitCode::SUCCESS;
        }
        Err(error) => {
            // What is wrong, without the usage lines.
            let text = error.render().to_string();
            let lines = text.lines().map(str::trim).take_while(|line| !line.is_empty() && !line.starts_with("Usage"));
            let sentence = lines.collect::<Vec<_>>().join(" ");
            eprintln!("{}", sentence.strip_prefix("error: ").unwrap_or(&sentence));
            return ExitCode::from(2);
        }
    };
    let (cases, skipped) = match prepare(&options) {
        Ok(prepared) => prepared,
        Err(sentence) => {
            eprintln!("{sentence}");
            return ExitCode::from(2);
        }
    };
    for picture in &skipped {
        eprintln!("skipped: {picture}: its orthophoto is not in the real data (set PLUMBLINE_DATA)");
    }
    match compare(&options, &cases, &skipped) {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::FAILURE,
        Err(sentence) => {
            eprintln!("{sentence}");
            ExitCode::FAILURE
        }
    }
}

/// The cases, and what had to be left out.
fn prepare(options: &Options) -> Result<(Vec<Case>, Vec<&'static str>), Failure> {
    let Some(path) = &options.frame else { return cases::all() };
    let frame = pictures::file(path)?;
    let ground = Ground {
        fov_deg: options.fov_deg,
        height_m: options.height_m,
        resolution_m: options.resolution_m,
        cells: (options.cells, options.cells),
    };
    let pose = Pose {
        heading_deg: options.heading_deg,
        pitch_deg: options.pitch_deg,
        roll_deg: options.roll_deg,
        is_followed: options.followed,
    };
    View::new(frame.size, ground, pose)?;
    let case = Case {
        picture: "picture",
        frame,
        ground,
        poses: vec![pose],
        limits: None,
        purpose: Purpose::Timed,
        reference: None,
    };
    Ok((vec![case], Vec::new()))
}

/// Whether every limit holds.
fn compare(options: &Options, cases: &[Case], skipped: &[&str]) -> Result<bool, Failure> {
    let script =
        Script { python: options.python.clone(), script: options.script.clone(), folder: options.folder.clone() };
    let comparison = run::run(cases, &script)?;
    print!("{}", if options.json { tell::json(&comparison, skipped) + "\n" } else { tell::table(&comparison) });
    if let Some(folder) = &options.front {
        drawing::write(&comparison, folder)?;
    }
    let mut is_good = true;
    for gate in tell::gates(&comparison).iter().filter(|gate| !gate.holds()) {
        eprintln!("{} is {:.3}, more than {}", gate.name, gate.value, gate.must);
        is_good = false;
    }
    Ok(is_good)
}
