//! `plumbline fly`: a flight of the firmware.

mod output;
mod setting;
mod tell;

use super::{Failure, print_json};
use indicatif::{ProgressBar, ProgressStyle};
use output::Output;
use plumbline_sim::fly::{Keep, fly};
use plumbline_sim::link::inproc::InProcess;
use plumbline_sim::link::pace::Patience;
use plumbline_sim::link::qemu::{Qemu, default_image};
use plumbline_sim::link::serial::Serial;
use plumbline_sim::link::{Account, Link, LinkError};
use plumbline_sim::report::{Report, ReportError};
use plumbline_sim::score::{self, Linked};
use plumbline_sim::stage::Stage;
use plumbline_survey::error::InputError;
use plumbline_survey::output::{check_file, write_file};
use sha2::{Digest, Sha256};
use std::io::Write;
use std::path::PathBuf;

/// Frames shown in the report, spread over the flight.
const PICTURED: u32 = 6;

#[derive(Debug, clap::Args)]
pub struct Args {
    /// Scenario file (TOML) or the name of a built-in one; the default scene unless given
    #[arg(long, value_name = "FILE")]
    scenario: Option<PathBuf>,
    /// Where the firmware runs: inproc, qemu or serial:PATH
    ///
    /// serial:PATH is a board on a serial port (set to 921600 baud where it has a rate), or whatever serves a UNIX socket
    /// or a pseudo-terminal, as `plumbline serve` does. Mission and reference tile are uploaded first. Requests that are
    /// not answered are sent again; a line may be unplugged for ten seconds, and a board that boots in mid-flight is
    /// loaded anew: report.json counts all of it under link_faults, and the frames a reboot took as lost.
    #[arg(long, default_value = "inproc", value_parser = reach)]
    link: Reach,
    /// Firmware image for --link qemu; the one `cargo xtask build` makes unless given
    #[arg(long, value_name = "ELF")]
    firmware: Option<PathBuf>,
    /// Frames to take
    #[arg(long, allow_negative_numbers = true)]
    frames: Option<u32>,
    /// What every random number comes from
    #[arg(long, allow_negative_numbers = true)]
    seed: Option<u64>,
    /// Orthophoto to fly over (GeoTIFF)
    #[arg(long, value_name = "ORTHO")]
    ground: Option<PathBuf>,
    /// Surface or terrain model under it; flat at height 0 unless given
    #[arg(long)]
    dem: Option<PathBuf>,
    /// Orthophoto that the reference is made of; the one flown over unless given
    #[arg(long, value_name = "ORTHO2")]
    reference: Option<PathBuf>,
    /// Attitude log to fly (CSV with t_s, roll_deg, pitch_deg, yaw_deg), from its first row
    #[arg(long, value_name = "CSV")]
    replay: Option<PathBuf>,
    /// Plan to fly: plan.json, as `plumbline plan` writes it
    ///
    /// Its strips are flown one after the other over its elevation model (or --dem), with its camera; the firmware has the plan
    /// in flash and decides when a photo is due. The scenario's keys apply as far as the plan leaves them open; without one the
    /// platform is calm and the camera fixed to it. --frames N ends after N photos.
    #[arg(long, value_name = "PLAN", conflicts_with = "replay")]
    plan: Option<PathBuf>,
    /// Folder for fixes.csv, poses.csv, report.json and report.html; nothing is written unless given
    ///
    /// poses.csv is the truth: where the antenna was on the grid of fixes.csv, how high the camera above the ground, heading
    /// from grid north, pitch, roll and follow-up angle at each stamp, as a navigation without error would log them for
    /// `plumbline boresight`.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Write the flight's log, for `plumbline replay`; with --link inproc
    #[arg(long, value_name = "FILE")]
    log: Option<PathBuf>,
    /// Write frame, patch, mask and reference of the first N frames as PNG
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    dump: Option<u32>,
    /// Print report.json on stdout
    #[arg(long)]
    json: bool,
}

/// Where the firmware runs.
#[derive(Clone, Debug, PartialEq, Eq)]
enum Reach {
    InProcess,
    Qemu,
    Serial(PathBuf),
}

fn reach(text: &str) -> Result<Reach, String> {
    match text {
        "inproc" => Ok(Reach::InProcess),
        "qemu" => Ok(Reach::Qemu),
        _ => match text.strip_prefix("serial:") {
            Some("") => Err("serial: lacks the path of a serial port or a socket".to_owned()),
            Some(path) => Ok(Reach::Serial(PathBuf::from(path))),
            None => Err("not one of inproc, qemu and serial:PATH".to_owned()),
        },
    }
}

pub fn run(args: &Args) -> Result<(), Failure> {
    let scenario = setting::scenario(args)?;
    let output = Output::check(args)?;
    if args.firmware.is_some() && args.link != Reach::Qemu {
        return Err(Failure::Input(InputError::new("--firmware is an image for --link qemu, which is not given")));
    }
    if let Some(log) = &args.log {
        if args.link != Reach::InProcess {
            return Err(Failure::Input(InputError::new("--log is for --link inproc; a board keeps its log itself")));
        }
        check_file(log)?;
    }
    let stage = Stage::prepare(scenario)?;
    let frames = stage.scenario.frames;
    for note in stage.plan.iter().flat_map(|plan| &plan.notes) {
        say(note);
    }
    let (mut link, mut linked) = link(args, &stage)?;
    let keep = Keep { first: args.dump.unwrap_or(0), every: frames.div_ceil(PICTURED).max(1) };
    let bar = progress_bar(frames);
    let flight = fly(&stage, link.as_mut(), keep, &mut |frame| bar.set_position(u64::from(frame) + 1));
    bar.finish_and_clear();
    let flight = flight?;
    if let Some(path) = &args.log {
        write_file(path, &link.close_log())?;
    }
    linked.account = link.account();
    // A board on a line is free for the next one.
    drop(link);
    let scored: Vec<_> = flight.frames.iter().map(|record| score::score(&stage, record)).collect();
    let summary = score::summarise(&stage, &flight, &scored, &linked);
    let report = Report { stage: &stage, flight: &flight, scored: &scored, summary: &summary };
    if let Some(output) = &output {
        output.write(&report)?;
    }
    if args.json {
        return print_json(&summary);
    }
    tell::tell(&summary, args.out.as_deref())
}

/// What was decided for the flight, a line on stderr. Nobody to read it is no reason not to fly.
fn say(note: &str) {
    let _ = writeln!(std::io::stderr(), "{note}");
}

/// On stderr, and only where somebody sees it.
fn progress_bar(frames: u32) -> ProgressBar {
    let bar = ProgressBar::new(frames.into());
    match ProgressStyle::with_template("frame {pos} of {len} {wide_bar} {eta} left") {
        Ok(style) => bar.with_style(style),
        Err(_) => bar,
    }
}

impl From<LinkError> for Failure {
    fn from(error: LinkError) -> Self {
        match error {
            LinkError::Input(error) => Failure::Input(error),
            lost => Failure::Work(lost.to_string()),
        }
    }
}

impl From<ReportError> for Failure {
    fn from(error: ReportError) -> Self {
        Failure::Work(error.to_string())
    }
}

/// The firmware, booted, and what the report calls it.
fn link(args: &Args, stage: &Stage) -> Result<(Box<dyn Link>, Linked), Failure> {
    let linked =
        |name: &str, firmware_sha256| Linked { name: name.to_owned(), firmware_sha256, account: Account::default() };
    match &args.link {
        Reach::InProcess => {
            let link =
                if args.log.is_some() { InProcess::logged(&stage.flash)? } else { InProcess::new(&stage.flash)? };
            Ok((Box::new(link), linked("inproc", None)))
        }
        Reach::Serial(path) => {
            let link = Serial::open(&stage.flash, path, Patience::default())?;
            Ok((Box::new(link), linked("serial", None)))
        }
        Reach::Qemu => {
            let image = args.firmware.clone().unwrap_or_else(default_image);
            let link = Qemu::launch(&stage.flash, &image)?;
            let bytes = std::fs::read(&image)
                .map_err(|error| InputError::new(format!("cannot read {}: {error}", image.display())))?;
            let digest = Sha256::digest(bytes).iter().map(|byte| format!("{byte:02x}")).collect();
            Ok((Box::new(link), linked("qemu", Some(digest))))
        }
    }
}
