//! One file a verb: parses, checks, dispatches.

mod adjust;
mod attitude;
mod boresight;
mod calibrate;
mod exterior;
mod fly;
mod folder;
mod intersect;
mod map;
mod match_;
mod mission;
mod motion;
mod mounts;
mod plan;
mod rectify;
mod replay;
mod reproduce;
mod serve;
mod smooth;
mod stitch;
mod tiles;

use clap::{Parser, Subcommand};
use plumbline_survey::error::InputError;
use std::fmt;
use std::io::{ErrorKind, Write};

/// Real-time rectification and scene matching: simulated flights of the firmware, and its algorithms on single
/// pictures.
#[derive(Debug, Parser)]
#[command(name = "plumbline", version, disable_help_subcommand = false, max_term_width = 100)]
pub struct Cli {
    #[command(subcommand)]
    verb: Verb,
}

#[derive(Debug, Subcommand)]
enum Verb {
    /// Fly the firmware over real or procedural ground and judge its fixes
    Fly(fly::Args),
    /// Run the application again on a flight's log and compare, bit for bit
    Replay(replay::Args),
    /// Be a board for `fly --link serial:PATH`, without one: the application behind a socket or a pseudo-terminal, until it
    /// is interrupted
    Serve(serve::Args),
    /// Make a reference tile for the board's flash from an orthophoto
    Tiles(tiles::Args),
    /// Make the mission store for the board's flash: camera, calibration, settings
    Mission(mission::Args),
    /// Map undistorted pixels to frame pixels (eq. 3 and 7)
    Map(map::Args),
    /// Rectify one frame onto the ground plane
    Rectify(rectify::Args),
    /// Make the virtual image of a camera of several heads from one frame of each (paper 002)
    ///
    /// The frames, taken at one instant, become what the virtual camera of the file would have seen: an image of its size, 8
    /// bits, grey or RGB as the frames are, 0 where no head sees anything. It is made in pieces and held in memory, a byte a
    /// pixel and band; frames have at most 8192 pixels a side, the image 65,535. How far neighbouring heads are off each other
    /// is measured by matching windows of both where they overlap.
    Stitch(stitch::Args),
    /// Find a rectified patch in a reference
    Match(match_::Args),
    /// Image motion during an exposure: exact, to first order (eq. 21), and the centroid of its track
    Motion(motion::Args),
    /// Intersect points of two photos on the ground, with the exterior orientation at a stamp
    Intersect(intersect::Args),
    /// Smooth the columns of a log: value, rate and sigma at its times or at others (paper 001)
    Smooth(smooth::Args),
    /// Calibrate a camera of several heads by constrained bundle adjustment (paper 002)
    Calibrate(calibrate::Args),
    /// How heads sit to each other, from exterior orientations of their pictures or from resections on a test field
    Mounts(mounts::Args),
    /// Estimate how a camera of one head sits in its vehicle, from a flight's fixes and an independent navigation
    ///
    /// The fixes of a board that was told the boresight of --camera are held against positions that are known otherwise, GNSS
    /// while it lasts. An angle that they show worse than to 0.2 degrees keeps its value; kappa shows by tilts alone. The file
    /// that is written has [boresight] replaced and all else kept but comments.
    Boresight(boresight::Args),
    /// Plan flight lines over terrain, so that the overlap on the ground holds everywhere (paper 004)
    ///
    /// Bases and the distances of strips follow the terrain; overlaps are given or chosen among 77 by simulated adjustment. The
    /// plan is flown by `plumbline fly --plan`.
    Plan(plan::Args),
    /// Adjust a problem of Bundle Adjustment in the Large
    Adjust(adjust::Args),
    /// Reproduce a paper's tables and say where and why they differ
    Reproduce(reproduce::Args),
}

/// Why a command ended without doing its work.
#[derive(Debug)]
pub enum Failure {
    /// Bad input: exit code 2.
    Input(InputError),
    /// It ran, but the work failed: exit code 1.
    Work(String),
}

impl Failure {
    pub fn code(&self) -> u8 {
        match self {
            Failure::Input(_) => 2,
            Failure::Work(_) => 1,
        }
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Failure::Input(error) => write!(f, "plumbline: {error}"),
            Failure::Work(why) => write!(f, "plumbline: {why}"),
        }
    }
}

impl From<InputError> for Failure {
    fn from(error: InputError) -> Self {
        Failure::Input(error)
    }
}

pub fn run(cli: Cli) -> Result<(), Failure> {
    match cli.verb {
        Verb::Fly(args) => fly::run(&args),
        Verb::Replay(args) => replay::run(&args),
        Verb::Serve(args) => serve::run(&args),
        Verb::Tiles(args) => tiles::run(&args),
        Verb::Mission(args) => mission::run(&args),
        Verb::Map(args) => map::run(&args),
        Verb::Rectify(args) => rectify::run(&args),
        Verb::Stitch(args) => stitch::run(&args),
        Verb::Match(args) => match_::run(&args),
        Verb::Motion(args) => motion::run(&args),
        Verb::Intersect(args) => intersect::run(&args),
        Verb::Smooth(args) => smooth::run(&args),
        Verb::Calibrate(args) => calibrate::run(&args),
        Verb::Mounts(args) => mounts::run(&args),
        Verb::Boresight(args) => boresight::run(&args),
        Verb::Plan(args) => plan::run(&args),
        Verb::Adjust(args) => adjust::run(&args),
        Verb::Reproduce(args) => reproduce::run(&args),
    }
}

/// clap's complaint without its usage lines: what is wrong and where, in one sentence.
pub fn one_sentence(error: &clap::Error) -> String {
    let text = error.render().to_string();
    let lines = text.lines().map(str::trim).take_while(|line| !line.is_empty() && !line.starts_with("Usage"));
    let sentence = lines.collect::<Vec<_>>().join(" ");
    format!("plumbline: {}", sentence.strip_prefix("error: ").unwrap_or(&sentence))
}

/// A finite number.
fn finite(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value.is_finite() => Ok(value),
        Ok(_) => Err("not a finite number".to_owned()),
        Err(_) => Err("not a number".to_owned()),
    }
}

/// A finite number above zero.
fn positive(text: &str) -> Result<f64, String> {
    finite(text).and_then(|value| if value > 0.0 { Ok(value) } else { Err("must be above 0".to_owned()) })
}

/// The one JSON document on stdout.
fn print_json(value: &impl serde::Serialize) -> Result<(), Failure> {
    let text = serde_json::to_string(value).map_err(|error| Failure::Work(format!("JSON: {error}")))?;
    print(&format!("{text}\n"))
}

/// Writes to stdout. A reader who has gone has read enough: that is a quiet end, not a failure.
fn print(text: &str) -> Result<(), Failure> {
    let mut stdout = std::io::stdout().lock();
    match stdout.write_all(text.as_bytes()).and_then(|()| stdout.flush()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => {
            Err(Failure::Work(format!("cannot write to stdout: {error}")))
        }
        _ => Ok(()),
    }
}

/// Writes a line to stderr. Where nobody can read it, it is lost, and the exit code has to do.
pub fn note(line: &str) {
    let _ = writeln!(std::io::stderr(), "{line}");
}
