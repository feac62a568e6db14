//! `plumbline replay`: the application run again on a flight's log.

use crate::files::{Files, create_folder};
use crate::outcome::{Failure, Outcome, note};
use plumbline_firmware::log::block::{BLOCK, MAGIC};
use plumbline_sim::replay::read::read;
use plumbline_sim::replay::{End, Replayed, fixes_csv, replay};
use plumbline_survey::error::InputError;
use plumbline_survey::io::input;
use plumbline_survey::io::output::write_file;
use std::io::Read;
use std::path::{Path, PathBuf};

#[derive(Debug, clap::Args)]
pub struct Args {
    /// Log: what `plumbline fly --log` wrote, a card's image, or the card itself (/dev/sdX)
    log: PathBuf,
    /// Which log of a card with several, from 0; the last unless given
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    number: Option<usize>,
    /// The flight's tile store, for a log that was cut before it held it
    #[arg(long, value_name = "FILE")]
    tiles: Option<PathBuf>,
    /// Folder for fixes.csv; nothing is written unless given
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Print the figures as one JSON document
    #[arg(long)]
    json: bool,
}

pub fn run(args: &Args) -> Result<Outcome, Failure> {
    Files::default()
        .reads("the log", &args.log)
        .may_read("--tiles", args.tiles.as_ref())
        .may_write_into("--out", args.out.as_ref(), &["fixes.csv"])
        .check()?;
    let bytes = log_file(&args.log)?;
    let name = args.log.display();
    let log = read(&bytes, args.number).map_err(|error| InputError::new(format!("{name}: {error}")))?;
    let tiles = args.tiles.as_deref().map(input::bytes).transpose()?;
    let replayed = replay(&log, tiles.as_deref()).map_err(|error| InputError::new(format!("{name}: {error}")))?;
    if let Some(folder) = &args.out {
        let csv = fixes_csv(&log, tiles.as_deref(), &replayed)?;
        create_folder(folder)?;
        write_file(&folder.join("fixes.csv"), csv.as_bytes())?;
    }
    if replayed.gaps > 0 {
        note(&format!(
            "plumbline: {name}: something is missing behind record {}, and what follows is not replayed",
            replayed.replayed
        ));
    }
    Ok(Outcome::new(args.json, &replayed, || table(&replayed))?
        .failed(failure(&replayed).map(|why| format!("{name}: {why}"))))
}

/// Why the replay does not confirm the flight.
fn failure(replayed: &Replayed) -> Option<String> {
    match &replayed.first_difference {
        None if replayed.frames == 0 && replayed.frames_logged > 0 => {
            Some(format!("none of its {} frames could be run again", replayed.frames_logged))
        }
        None if replayed.gaps == 0 && replayed.end == End::Closed && replayed.frames < replayed.frames_logged => {
            Some("the replay ends before the flight does".to_owned())
        }
        None => None,
        Some(what) => Some(format!("the replay is not the flight: {what}")),
    }
}

/// A log's file, or a card: as far as there are logs on it. They lie behind each other from its beginning.
fn log_file(path: &Path) -> Result<Vec<u8>, InputError> {
    const CHUNK: usize = 1 << 20;
    let refuse = |error| InputError::new(format!("cannot read {}: {error}", path.display()));
    let mut file = std::fs::File::open(path).map_err(refuse)?;
    let (mut bytes, mut has_block) = (Vec::new(), true);
    while has_block {
        let from = bytes.len();
        file.by_ref().take(CHUNK as u64).read_to_end(&mut bytes).map_err(refuse)?;
        has_block = bytes.get(from..).unwrap_or(&[]).chunks(BLOCK).any(|block| block.starts_with(&MAGIC));
    }
    Ok(bytes)
}

fn table(r: &Replayed) -> String {
    let end = match r.end {
        End::Closed => "closed".to_owned(),
        End::Cut => "cut: the power went, or the flight goes on elsewhere".to_owned(),
    };
    let rows = [
        ("records", format!("{} of {} replayed", r.replayed, r.records)),
        ("frames", format!("{} of {} replayed, {} accepted", r.frames, r.frames_logged, r.accepted)),
        ("same", r.same.to_string()),
        ("different", r.different.to_string()),
        ("gaps", format!("{}, {} records and {} blocks lost", r.gaps, r.lost_records, r.damaged_blocks)),
        ("end", end),
    ];
    rows.iter().map(|(name, value)| format!("{name:<14}{value}\n")).collect()
}
