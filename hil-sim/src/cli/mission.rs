//! `plumbline mission`: camera, calibration and settings for the board's flash.

use super::{Failure, print, print_json};
use plumbline_firmware::boot::BootError;
use plumbline_firmware::stores::framing::checksum;
use plumbline_firmware::stores::mission::{KIND, STORE_MAX};
use plumbline_sim::mission::settings::mission;
use plumbline_survey::error::InputError;
use plumbline_survey::output::{check_file, write_file};
use serde::Serialize;
use std::path::PathBuf;

#[derive(Debug, clap::Args)]
pub struct Args {
    /// Camera file (TOML)
    #[arg(long, value_name = "FILE")]
    camera: PathBuf,
    /// Which head of the camera file flies, counted from 1; a file of several needs it, here or in the settings
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u8).range(1..), allow_negative_numbers = true)]
    head: Option<u8>,
    /// Settings file (TOML): mount, sensors, shutter, search, with the keys of a scenario; the default scene's unless given
    #[arg(long, value_name = "FILE")]
    settings: Option<PathBuf>,
    /// The mission store to write
    #[arg(long, value_name = "FILE")]
    out: PathBuf,
    /// Print what it is as one JSON document
    #[arg(long)]
    json: bool,
}

#[derive(Serialize)]
struct Told {
    cols: u16,
    rows: u16,
    search_px: u16,
    version: u16,
    bytes: usize,
    crc32: String,
}

pub fn run(args: &Args) -> Result<(), Failure> {
    check_file(&args.out)?;
    let name = args.settings.as_ref().map(|path| path.display().to_string()).unwrap_or_default();
    let text = args.settings.as_ref().map(std::fs::read_to_string).transpose();
    let text = text.map_err(|error| InputError::new(format!("cannot read {name}: {error}")))?;
    let mission = mission(&args.camera, args.head, text.as_deref().map(|text| (text, name.as_str())))?;
    let refuse = |error| InputError::new(format!("the firmware would refuse it: {}", BootError::Mission(error)));
    mission.settings().map_err(refuse)?;
    mission.stamp_settings().map_err(refuse)?;
    let mut buffer = [0; STORE_MAX];
    let store = mission.store(&mut buffer).map_err(refuse)?;
    write_file(&args.out, store)?;
    let told = Told {
        cols: mission.frame.0,
        rows: mission.frame.1,
        search_px: mission.search_px,
        version: KIND.version,
        bytes: store.len(),
        crc32: format!("{:08x}", checksum(store)),
    };
    if args.json {
        return print_json(&told);
    }
    let out = args.out.display();
    print(&format!(
        "{:<14}{} x {} pixels\n{:<14}{} px\n{:<14}{out}, {} bytes, CRC-32 {}\n",
        "camera", told.cols, told.rows, "search", told.search_px, "store", told.bytes, told.crc32
    ))
}
