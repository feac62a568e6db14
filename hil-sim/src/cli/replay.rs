//! `plumbline replay`: the application run again on a flight's log.

use super::{Failure, note, print, print_json};
use plumbline_firmware::log::block::{BLOCK, MAGIC};
use plumbline_sim::replay::read::read;
use plumbline_sim::replay::{End, Replayed, fixes_csv, replay};
use plumbline_survey::error::InputError;
use plumbline_survey::output::{check_file, write_file};
use std::io::Read;
use std::path::{Path, PathBuf};

#[derive(Debug, clap::Args)]
pub struct Args {
    /// Log: what `plumbline fly --log` wrote, a card's image, or the card itself (/dev/sdX)
    log: PathBuf,
    /// Which log of a card with several, from 0; the last unless given
    #[arg(long, value_name = "N")]
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

pub fn run(args: &Args) -> Result<(), Failure> {
    let bytes = log_file(&args.log)?;
    let name = args.log.display();
    if let Some(folder) = &args.out {
        if folder.exists() && !folder.is_dir() {
            return Err(InputError::new(format!("--out {} is not a folder", folder.display())).into());
        }
        if folder.is_dir() {
            check_file(&folder.join("fixes.csv"))?;
        }
    }
    let log = read(&bytes, args.number).map_err(|error| InputError::new(format!("{name}: {error}")))?;
    let tiles = args.tiles.as_deref().map(file).transpose()?;
    let replayed = replay(&log, tiles.as_deref()).map_err(|error| InputError::new(format!("{name}: {error}")))?;
    if let Some(folder) = &args.out {
        let csv = fixes_csv(&log, tiles.as_deref(), &replayed)?;
        super::folder::create(folder)?;
        write_file(&folder.join("fixes.csv"), csv.as_bytes())?;
    }
    if args.json {
        print_json(&replayed)?;
    } else {
        print(&table(&replayed))?;
    }
    if replayed.gaps > 0 {
        note(&format!(
            "plumbline: {name}: something is missing behind record {}, and what follows is not replayed",
            replayed.replayed
        ));
    }
    match &replayed.first_difference {
        None if replayed.frames == 0 && replayed.frames_logged > 0 => {
            Err(Failure::Work(format!("{name}: none of its {} frames could be run again", replayed.frames_logged)))
        }
        None if replayed.gaps == 0 && replayed.end == End::Closed && replayed.frames < replayed.frames_logged => {
            Err(Failure::Work(format!("{name}: the replay ends before the flight does")))
        }
        None => Ok(()),
        Some(what) => Err(Failure::Work(format!("{name}: the replay is not the flight: {what}"))),
    }
}

fn file(path: &Path) -> Result<Vec<u8>, InputError> {
    std::fs::read(path).map_err(|error| InputError::new(format!("cannot read {}: {error}", path.display())))
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
