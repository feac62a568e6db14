//! `plumbline fly`: a flight of the firmware.

use super::{Failure, print_json};
use clap::ValueEnum;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use plumbline_sim::fly::{Keep, fly};
use plumbline_sim::link::inproc::InProcess;
use plumbline_sim::link::{Link, LinkError};
use plumbline_sim::scenario::{Ground, Replay, Scenario};
use plumbline_sim::score::{self, Linked, Summary};
use plumbline_sim::stage::Stage;
use plumbline_survey::data::shared_data;
use plumbline_survey::error::InputError;
use std::path::PathBuf;

#[derive(Debug, clap::Args)]
pub struct Args {
    /// Scenario file (TOML), or the name of a built-in one; the default scene unless given
    #[arg(long)]
    scenario: Option<PathBuf>,
    /// How to reach the firmware: inproc, qemu or serial:PATH
    #[arg(long, default_value = "inproc")]
    link: String,
    /// Firmware image for the emulator
    #[arg(long)]
    firmware: Option<PathBuf>,
    /// Frames to take
    #[arg(long, value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    frames: Option<u32>,
    /// What every random number comes from
    #[arg(long)]
    seed: Option<u64>,
    /// Orthophoto to fly over (GeoTIFF)
    #[arg(long)]
    ground: Option<PathBuf>,
    /// Surface or terrain model under it (GeoTIFF); flat at height 0 without
    #[arg(long, requires = "ground")]
    dem: Option<PathBuf>,
    /// Orthophoto that the reference is made of; the same one without
    #[arg(long, requires = "ground")]
    reference: Option<PathBuf>,
    /// Attitude log to fly (CSV with t_s, roll_deg, pitch_deg, yaw_deg)
    #[arg(long)]
    replay: Option<PathBuf>,
    /// Folder for fixes.csv, report.json and report.html
    #[arg(long)]
    out: Option<PathBuf>,
    /// Write frame, patch, mask and reference of the first N frames as PNG
    #[arg(long, default_value_t = 0)]
    dump: u32,
    /// Print report.json on stdout
    #[arg(long)]
    json: bool,
}

pub fn run(args: &Args) -> Result<(), Failure> {
    let scenario = scenario(args)?;
    let stage = Stage::prepare(scenario)?;
    let bar = progress_bar(stage.scenario.frames);
    let (mut link, linked) = link(args, &stage)?;
    let keep = Keep { first: args.dump.max(4), every: stage.scenario.frames.div_ceil(8).max(1) };
    let flight = fly(&stage, link.as_mut(), keep, &mut |frame| bar.set_position(u64::from(frame) + 1))?;
    bar.finish_and_clear();
    let scored: Vec<_> = flight.frames.iter().map(|record| score::score(&stage, record)).collect();
    let summary = score::summarise(&stage, &flight, &scored, &linked);
    if let Some(out) = &args.out {
        create_folder(out)?;
        score::write(out, &stage, &flight, &scored, &summary)?;
    }
    if args.json {
        return print_json(&summary);
    }
    tell(&summary);
    Ok(())
}
fn create_folder(_: &std::path::Path) -> Result<(), Failure> { Ok(()) }
fn progress_bar(n: u32) -> ProgressBar { ProgressBar::with_draw_target(Some(n.into()), ProgressDrawTarget::stderr()).with_style(ProgressStyle::default_bar()) }
fn link(_args: &Args, stage: &Stage) -> Result<(Box<dyn Link>, Linked), Failure> {
    Ok((Box::new(InProcess::new(&stage.flash)?), Linked { name: "inproc".into(), firmware_sha256: None }))
}
fn tell(s: &Summary) { println!("{}", serde_json::to_string_pretty(s).unwrap_or_default()); }
fn scenario(args: &Args) -> Result<Scenario, Failure> {
    let data = shared_data();
    let mut s = match &args.scenario { None => Scenario::default_scene(), Some(p) => Scenario::load(p, data.as_deref()).map_err(|e| InputError::new(e.to_string()))? };
    if let Some(f) = args.frames { s.frames = f; }
    if let Some(f) = args.seed { s.seed = f; }
    if let Some(g) = &args.ground { s.ground = Ground::Ortho { ortho: g.clone(), dem: args.dem.clone(), reference: args.reference.clone() }; }
    if let Some(r) = &args.replay { s.replay = Some(Replay { att: r.clone(), start_s: None, time_scale: 1.0 }); }
    Ok(s)
}
impl From<LinkError> for Failure {
    fn from(error: LinkError) -> Self {
        match error { LinkError::Input(e) => Failure::Input(e), lost => Failure::Work(lost.to_string()) }
    }
}
