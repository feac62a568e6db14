//! `plumbline configuration`: camera, calibration and settings for the board's flash; or where photos are to be taken; or what
//! messages are signed with.

use crate::files::Files;
use crate::outcome::{Failure, Outcome};
use plumbline_firmware::boot::BootError;
use plumbline_firmware::stores::configuration::{KIND, STORE_MAX};
use plumbline_firmware::stores::framing::checksum;
use plumbline_firmware::stores::{key, plan};
use plumbline_sim::configuration::key::{key_of_file, store_of};
use plumbline_sim::configuration::settings::configuration;
use plumbline_sim::link::why;
use plumbline_sim::setup::planned::limits;
use plumbline_sim::setup::planned::store::of_file;
use plumbline_survey::camera_file::CameraFile;
use plumbline_survey::error::InputError;
use plumbline_survey::io::input;
use plumbline_survey::io::output::{write_file, write_secret};
use plumbline_survey::plan::PlanFile;
use serde::Serialize;
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime, UNIX_EPOCH};

#[derive(Debug, clap::Args)]
pub struct Args {
    /// Camera file (TOML)
    #[arg(long, value_name = "FILE", required_unless_present_any = ["plan", "signing_key"])]
    camera: Option<PathBuf>,
    /// Plan (plan.json) of which the plan store is made, instead of a configuration store
    #[arg(long, value_name = "PLAN", conflicts_with_all = ["camera", "head", "settings"])]
    plan: Option<PathBuf>,
    /// Make a store of a plan whose checks failed
    #[arg(long, requires = "plan")]
    force: bool,
    /// Key that messages are signed with (64 hexadecimal digits), of which the key store is made, instead of a configuration store
    ///
    /// What this key signed before now is not taken: the store holds the time at which it was made. It is as secret as the key: its owner
    /// alone may read the file, and nothing of either is printed.
    #[arg(long, value_name = "FILE", conflicts_with_all = ["camera", "head", "settings", "plan"])]
    signing_key: Option<PathBuf>,
    /// Which head of the camera file flies, counted from 1; a file of several needs it, here or in the settings
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u8).range(1..), allow_negative_numbers = true)]
    head: Option<u8>,
    /// Settings file (TOML): mount, sensors, shutter, search, with the keys of a scenario; the default scene's unless given
    #[arg(long, value_name = "FILE")]
    settings: Option<PathBuf>,
    /// The store to write
    #[arg(long, value_name = "FILE")]
    out: PathBuf,
    /// Print what it is as one JSON document
    #[arg(long)]
    json: bool,
}

#[derive(Serialize)]
struct Summary {
    cols: u16,
    rows: u16,
    search_px: u16,
    version: u16,
    bytes: usize,
    crc32: String,
}

#[derive(Serialize)]
struct PlanSummary {
    strips: usize,
    photos: usize,
    interval_s: f64,
    across_m: f64,
    version: u16,
    bytes: usize,
    crc32: String,
}

#[derive(Serialize)]
struct KeySummary {
    version: u16,
    bytes: usize,
}

/// Flash of the flight computer for a plan: region PLAN of `memory.x`.
const PLAN_BYTES: usize = 64 * 1024;

/// The plan store.
fn plan(path: &Path, args: &Args) -> Result<Outcome, Failure> {
    let file = PlanFile::read(path)?;
    if let Some(danger) = file.checks.unsafe_because().filter(|_| !args.force) {
        return Err(Failure::Input(InputError::new(format!(
            "{}: its checks failed, {danger}; plan it anew, or --force accepts it",
            path.display()
        ))));
    }
    let store = of_file(&file).map_err(|error| InputError::new(format!("{}: {error}", path.display())))?;
    if store.len() > PLAN_BYTES {
        return Err(Failure::Input(InputError::new(format!(
            "{}: its {} photos take {} bytes of the {PLAN_BYTES} that a board has for a plan: plan parts of the area, or fewer photos",
            path.display(),
            file.photo_count,
            store.len()
        ))));
    }
    write_file(&args.out, &store)?;
    let limits = limits(&file);
    let summary = PlanSummary {
        strips: file.strips.len(),
        photos: file.photo_count,
        interval_s: f64::from(limits.interval_us) * 1e-6,
        across_m: limits.across_m.into(),
        version: plan::KIND.version,
        bytes: store.len(),
        crc32: format!("{:08x}", checksum(&store)),
    };
    let text = || {
        let out = args.out.display();
        format!(
            "{:<14}{} photos in {} strips\n{:<14}{} s between photos, {:.1} m off the line at most\n{:<14}{out}, {} bytes, CRC-32 {}\n",
            "plan",
            summary.photos,
            summary.strips,
            "limits",
            summary.interval_s,
            summary.across_m,
            "store",
            summary.bytes,
            summary.crc32
        )
    };
    Outcome::new(args.json, &summary, text)
}

/// The key store. No checksum is told: it would be of the key.
fn key(path: &Path, args: &Args) -> Result<Outcome, Failure> {
    let store = store_of(key_of_file(path)?, now()?);
    write_secret(&args.out, &store)?;
    let summary = KeySummary { version: key::KIND.version, bytes: store.len() };
    let text = || format!("{:<14}{}, {} bytes, as secret as the key\n", "key store", args.out.display(), summary.bytes);
    Outcome::new(args.json, &summary, text)
}

/// The time in signatures now: units of 10 us since 2015-01-01.
fn now() -> Result<u64, Failure> {
    /// From 1970 to 2015: 45 years, 11 of them leap years.
    const SINCE_S: u64 = (45 * 365 + 11) * 86_400;
    let since_1970 = SystemTime::now().duration_since(UNIX_EPOCH).map_err(|_| clock_is_wrong())?;
    let us = since_1970.checked_sub(Duration::from_secs(SINCE_S)).ok_or_else(clock_is_wrong)?.as_micros();
    Ok((us / 10) as u64)
}

fn clock_is_wrong() -> Failure {
    Failure::Input(InputError::new("this machine's clock is before 2015: a key needs the time at which it was made"))
}

pub fn run(args: &Args) -> Result<Outcome, Failure> {
    Files::default()
        .may_read("--camera", args.camera.as_ref())
        .may_read("--settings", args.settings.as_ref())
        .may_read("--plan", args.plan.as_ref())
        .may_read("--signing-key", args.signing_key.as_ref())
        .writes("--out", &args.out)
        .check()?;
    if let Some(path) = &args.signing_key {
        return key(path, args);
    }
    let camera = match (&args.camera, &args.plan) {
        (_, Some(path)) => return plan(path, args),
        (Some(camera), None) => camera,
        (None, None) => return Err(Failure::Input(InputError::new("--camera, --plan or --signing-key is missing"))),
    };
    super::ask(&CameraFile::read(camera)?);
    let name = args.settings.as_ref().map(|path| path.display().to_string()).unwrap_or_default();
    let text = args.settings.as_ref().map(|path| input::text(path)).transpose()?;
    let configuration = configuration(camera, args.head, text.as_deref().map(|text| (text, name.as_str())))?;
    let refuse = |error| {
        let why = why(BootError::Configuration(error), &configuration);
        InputError::new(format!("the firmware would refuse it: {why}"))
    };
    configuration.settings().map_err(refuse)?;
    configuration.stamp_settings().map_err(refuse)?;
    let mut buffer = [0; STORE_MAX];
    let store = configuration.store(&mut buffer).map_err(refuse)?;
    write_file(&args.out, store)?;
    let summary = Summary {
        cols: configuration.frame.0,
        rows: configuration.frame.1,
        search_px: configuration.search_px,
        version: KIND.version,
        bytes: store.len(),
        crc32: format!("{:08x}", checksum(store)),
    };
    let text = || {
        let out = args.out.display();
        format!(
            "{:<14}{} x {} pixels\n{:<14}{} px\n{:<14}{out}, {} bytes, CRC-32 {}\n",
            "camera", summary.cols, summary.rows, "search", summary.search_px, "store", summary.bytes, summary.crc32
        )
    };
    Outcome::new(args.json, &summary, text)
}

#[cfg(test)]
mod tests {
    use super::PLAN_BYTES;

    #[test]
    fn a_plan_has_the_room_that_the_memory_map_gives_it() {
        let map = include_str!("../../../memory.x");
        let region = map.lines().find(|line| line.trim().starts_with("PLAN ")).expect("a region");
        let length = region.split("LENGTH = ").nth(1).and_then(|length| length.trim().strip_suffix('K'));
        assert_eq!(length.and_then(|length| length.parse().ok()), Some(PLAN_BYTES / 1024), "{region}");
    }
}
