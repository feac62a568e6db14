//! `plumbline reproduce`: a paper's tables by this project's own code.

use crate::files::{Files, create_folder};
use crate::outcome::{Failure, Outcome, note};
use crate::pages::reproduction::{self, Figure};
use crate::progress;
use plumbline_papers::{
    Reproduction, Row, paper_000, paper_001, paper_002, paper_004, table_3, text, write_figures, write_figures_000,
};
use plumbline_survey::error::InputError;
use plumbline_survey::io::output::write_file;
use serde::Serialize;
use std::path::PathBuf;

#[derive(Debug, clap::Args)]
pub struct Args {
    /// Which paper: 000, 001, 002, 003 or 004
    #[arg(value_parser = ["000", "001", "002", "003", "004"])]
    paper: String,
    /// Print one JSON document
    #[arg(long)]
    json: bool,
    /// Folder for a page, report.html, and the figures of 000, 001 or 003; nothing is written unless given
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Frames of the flight behind Table 3
    #[arg(long, default_value_t = 300, value_parser = clap::value_parser!(u32).range(1..=1_000_000), allow_negative_numbers = true)]
    frames: u32,
}

/// The page's file.
const PAGE: &str = "report.html";

/// The files of a paper's figures; of the other papers there are only tables.
fn figures(paper: &str) -> &'static [&'static str] {
    match paper {
        "000" => &["figure_3.svg", "figure_4.svg", "figure_5.svg"],
        "001" => &["figure_1.svg", "figure_2.svg", "figure_3.svg", "figure_4.svg"],
        "003" => &["figure_1.svg", "figure_3a.png", "figure_3b.png", "figure_3c.png", "figure_3d.png"],
        _ => &[],
    }
}

pub fn run(args: &Args) -> Result<Outcome, Failure> {
    let files = [figures(&args.paper), &[PAGE]].concat();
    Files::default().may_write_into("--out", args.out.as_ref(), &files).check()?;
    // Before the work, so that nobody waits for a refusal.
    args.out.iter().try_for_each(|folder| create_folder(folder))?;
    match args.paper.as_str() {
        "000" => of_000(args),
        "001" => of_001(args),
        "002" => of_002(args),
        "003" => of_003(args),
        _ => of_004(args),
    }
}

/// The page, with the figures that lie in the folder by now.
fn write_page(args: &Args, head: &str, rows: &[Row], decimals: usize) -> Result<(), Failure> {
    let Some(folder) = &args.out else { return Ok(()) };
    let read = |name: &'static str| {
        let path = folder.join(name);
        let bytes = std::fs::read(&path)
            .map_err(|error| InputError::because(format!("cannot read {}", path.display()), error))?;
        Ok((name, bytes))
    };
    let figures: Vec<Figure> = figures(&args.paper).iter().map(|name| read(name)).collect::<Result<_, InputError>>()?;
    let page = reproduction::page(&args.paper, head, rows, decimals, &figures);
    Ok(write_file(&folder.join(PAGE), page.as_bytes())?)
}

/// Writes the page, and says the same in words.
fn tell(args: &Args, document: &impl Serialize, head: String, rows: &[Row]) -> Result<Outcome, Failure> {
    write_page(args, &head, rows, text::DECIMALS)?;
    Outcome::new(args.json, document, || text::table(head, rows))
}

fn of_000(args: &Args) -> Result<Outcome, Failure> {
    let reproduction = paper_000::Reproduction::new();
    if let Some(folder) = &args.out {
        write_figures_000(folder, &reproduction)?;
    }
    write_page(args, &reproduction.head(), &reproduction.rows, paper_000::DECIMALS)?;
    Outcome::new(args.json, &reproduction, || reproduction.text())
}

fn of_001(args: &Args) -> Result<Outcome, Failure> {
    let reproduction = paper_001::reproduction().map_err(|error| Failure::Work(error.to_string()))?;
    if let Some(folder) = &args.out {
        for (name, picture) in paper_001::figures::pictures().map_err(Failure::Work)? {
            write_file(&folder.join(format!("{name}.svg")), picture.as_bytes())?;
        }
    }
    let head = format!("Paper 001: means over noise of {} seeds.", reproduction.seeds.len());
    tell(args, &reproduction, head, &reproduction.rows)
}

fn of_002(args: &Args) -> Result<Outcome, Failure> {
    let bar = progress::bar(paper_002::adjustments(), "adjustment");
    let reproduction = paper_002::Reproduction::new(&|| bar.inc(1));
    bar.finish_and_clear();
    let reproduction = reproduction.map_err(|error| Failure::Work(format!("a simulated block: {error:?}")))?;
    let (seeds, noise_px) = (reproduction.seeds.len(), paper_002::world::NOISE_PX);
    let head = format!("Paper 002: blocks of {seeds} seeds, image noise {noise_px} px.");
    tell(args, &reproduction, head, &reproduction.rows)
}

fn of_003(args: &Args) -> Result<Outcome, Failure> {
    let bar = progress::bar(args.frames.into(), "frame");
    let flown = table_3::flown(args.frames, &mut |frame| bar.set_position(u64::from(frame) + 1));
    bar.finish_and_clear();
    let flown = flown?;
    let reproduction = Reproduction::of_003(&flown)?;
    if let Some(folder) = &args.out {
        write_figures(folder, &flown)?;
    }
    tell(args, &reproduction, text::head(&reproduction), &reproduction.rows)
}

fn of_004(args: &Args) -> Result<Outcome, Failure> {
    let reproduction = paper_004::Reproduction::new()?;
    if !reproduction.has_terrain {
        note(
            "paper 004: tests 1 and 2 are skipped, the folder of real data (PLUMBLINE_DATA) has no dem/jacksboro_3arcsec.tif",
        );
    }
    let head = "Paper 004: plans over terrain, simulated noise of seed 1.".to_owned();
    tell(args, &reproduction, head, &reproduction.rows)
}
