//! `plumbline reproduce`: a paper's tables by this project's own code.

use super::{Failure, folder, note, print, print_json};
use indicatif::{ProgressBar, ProgressStyle};
use plumbline_sim::reproduce::{
    Reproduction, paper_000, paper_001, paper_002, paper_004, table_3, text, write_figures, write_figures_000,
};
use plumbline_survey::error::InputError;
use plumbline_survey::output::{check_file, write_file};
use std::path::{Path, PathBuf};

#[derive(Debug, clap::Args)]
pub struct Args {
    /// Which paper: 000, 001, 002, 003 or 004
    #[arg(value_parser = ["000", "001", "002", "003", "004"])]
    paper: String,
    /// Print one JSON document
    #[arg(long)]
    json: bool,
    /// Folder for the figures; none are made unless given
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Frames of the flight behind Table 3
    #[arg(long, default_value_t = 300, value_parser = clap::value_parser!(u32).range(1..=1_000_000), allow_negative_numbers = true)]
    frames: u32,
}

pub fn run(args: &Args) -> Result<(), Failure> {
    match args.paper.as_str() {
        "000" => of_000(args),
        "001" => of_001(args),
        "002" => of_002(args),
        "003" => of_003(args),
        _ => of_004(args),
    }
}

fn of_001(args: &Args) -> Result<(), Failure> {
    if let Some(folder) = &args.out {
        create(folder)?;
    }
    let reproduction = paper_001::reproduction().map_err(|error| Failure::Work(error.to_string()))?;
    if let Some(folder) = &args.out {
        let pictures = paper_001::figures::pictures().map_err(Failure::Work)?;
        let path = |name: &str| folder.join(format!("{name}.svg"));
        // All or none.
        for (name, _) in &pictures {
            check_file(&path(name))?;
        }
        for (name, picture) in &pictures {
            write_file(&path(name), picture.as_bytes())?;
        }
    }
    if args.json {
        return print_json(&reproduction);
    }
    let head = format!("Paper 001: means over noise of {} seeds.", reproduction.seeds.len());
    print(&text::table(head, &reproduction.rows))
}

fn of_000(args: &Args) -> Result<(), Failure> {
    if let Some(folder) = &args.out {
        create(folder)?;
    }
    let reproduction = paper_000::Reproduction::new();
    if let Some(folder) = &args.out {
        write_figures_000(folder, &reproduction)?;
    }
    if args.json { print_json(&reproduction) } else { print(&reproduction.text()) }
}

fn of_002(args: &Args) -> Result<(), Failure> {
    if let Some(folder) = &args.out {
        create(folder)?;
    }
    let bar = progress_bar(paper_002::adjustments(), "adjustment");
    let reproduction = paper_002::Reproduction::new(&|| bar.inc(1));
    bar.finish_and_clear();
    let reproduction = reproduction.map_err(|error| Failure::Work(format!("a simulated block: {error:?}")))?;
    if args.json {
        return print_json(&reproduction);
    }
    let head = format!(
        "Paper 002: blocks of {} seeds, image noise {} px.",
        reproduction.seeds.len(),
        paper_002::world::NOISE_PX
    );
    print(&text::table(head, &reproduction.rows))
}

fn of_004(args: &Args) -> Result<(), Failure> {
    if let Some(folder) = &args.out {
        create(folder)?;
    }
    let reproduction = paper_004::Reproduction::new()?;
    if !reproduction.has_terrain {
        note(
            "paper 004: tests 1 and 2 are skipped, the folder of real data (PLUMBLINE_DATA) has no dem/jacksboro_3arcsec.tif",
        );
    }
    if args.json {
        return print_json(&reproduction);
    }
    print(&text::table("Paper 004: plans over terrain, made-up noise of seed 1.".to_owned(), &reproduction.rows))
}

fn of_003(args: &Args) -> Result<(), Failure> {
    if let Some(folder) = &args.out {
        create(folder)?;
    }
    let bar = progress_bar(args.frames.into(), "frame");
    let flown = table_3::flown(args.frames, &mut |frame| bar.set_position(u64::from(frame) + 1));
    bar.finish_and_clear();
    let flown = flown?;
    let reproduction = Reproduction::of_003(&flown)?;
    if let Some(folder) = &args.out {
        write_figures(folder, &flown)?;
    }
    if args.json {
        return print_json(&reproduction);
    }
    print(&text::text(&reproduction))
}

/// Creates the folder before the work, so that nobody waits for a refusal.
fn create(out: &Path) -> Result<(), InputError> {
    folder::check("--out", out, &[])?;
    folder::create(out)
}

/// On stderr, and only where somebody sees it.
fn progress_bar(count: u64, what: &str) -> ProgressBar {
    let bar = ProgressBar::new(count);
    match ProgressStyle::with_template(&format!("{what} {{pos}} of {{len}} {{wide_bar}} {{eta}} left")) {
        Ok(style) => bar.with_style(style),
        Err(_) => bar,
    }
}
