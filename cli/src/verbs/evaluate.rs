//! `plumbline evaluate`: frames of a real flight through the board's own chain.

mod text;

use super::positive;
use crate::files::{Files, create_folder};
use crate::interrupt;
use crate::outcome::{Failure, Outcome, note};
use crate::pages::evaluation::Page;
use crate::progress;
use plumbline_sim::evaluate::judge::{Figures, Verdict, judge};
use plumbline_sim::evaluate::meant::{Meant, best};
use plumbline_sim::evaluate::refined::refined;
use plumbline_sim::evaluate::{Evaluation, Summary, flown};
use plumbline_sim::run::Observer;
use plumbline_sim::setup::Setup;
use plumbline_sim::setup::frames::table::Table;
use plumbline_survey::camera_file::CameraFile;
use plumbline_survey::error::InputError;
use plumbline_survey::io::output::write_files;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

const WRITTEN: [&str; 3] = ["frames.csv", "report.json", "report.html"];

#[derive(Debug, clap::Args)]
pub struct Args {
    /// The frames: CSV with file,east_m,north_m,height_m,heading_deg,pitch_deg,roll_deg and, where the truth is known,
    /// true_east_m,true_north_m
    ///
    /// file is a PNG, TIFF or JPEG picture, from the table's folder on. east_m and north_m are where the navigation had the camera, on
    /// the reference's grid; height_m is above the ground; the attitude is the camera's: heading from grid north, pitch nose up, roll
    /// right side down, all 0 for a camera that looks straight down with row 0 to the north. A gimbal's pitch of -90 is 0 here.
    #[arg(long, value_name = "CSV")]
    frames: PathBuf,
    /// Camera file (TOML)
    #[arg(long, value_name = "TOML")]
    camera: PathBuf,
    /// Orthophoto that the reference tile is made of (GeoTIFF, a projected grid in metres)
    #[arg(long, value_name = "TIF")]
    reference: PathBuf,
    /// Elevation model of the ground, in the orthophoto's reference system; level unless given
    #[arg(long)]
    dem: Option<PathBuf>,
    /// Settings of the board, as of `configuration`; over those of the built-in scenario live
    #[arg(long, value_name = "TOML")]
    settings: Option<PathBuf>,
    /// Metres a pixel of reference and patches; unless given the settings', or what suits the height
    #[arg(long, value_parser = positive, allow_negative_numbers = true)]
    resolution_m: Option<f64>,
    /// Search radius, pixels of the reference; the settings' unless given
    ///
    /// Beyond 10 the board searches from coarse to fine, and of a map of another year next to nothing is fixed: take a coarser
    /// resolution rather than a wider search.
    #[arg(long, allow_negative_numbers = true, value_parser = clap::value_parser!(u16).range(1..=32))]
    search_px: Option<u16>,
    /// Seconds from one frame to the next; unless given, so many that no way between two frames is faster than 40 m/s
    #[arg(long, value_parser = interval, allow_negative_numbers = true)]
    interval_s: Option<f64>,
    /// Folder for frames.csv, report.json and report.html
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Print report.json on stdout
    #[arg(long)]
    json: bool,
}

/// The attitude is sampled some fifty times a second and smoothed over some tenths of one.
fn interval(text: &str) -> Result<f64, String> {
    positive(text).and_then(|value| {
        if (0.5..=600.0).contains(&value) { Ok(value) } else { Err("not between 0.5 and 600".to_owned()) }
    })
}

pub fn run(args: &Args) -> Result<Outcome, Failure> {
    let table = Table::read(&args.frames)?;
    check(args, &table)?;
    table.doubt.iter().for_each(|line| note(line));
    let camera = CameraFile::read(&args.camera)?;
    super::ask(&camera);
    if !camera.heads.is_empty() {
        let what = "a camera with heads: the frames must be those of an ordinary one";
        return Err(Failure::Input(InputError::new(format!("{}: {what}", args.camera.display()))));
    }
    let evaluation = Evaluation {
        camera: args.camera.clone(),
        reference: args.reference.clone(),
        dem: args.dem.clone(),
        settings: args.settings.clone(),
        resolution_m: args.resolution_m,
        search_px: args.search_px,
        interval_s: args.interval_s,
    };
    let mut watch =
        Watch { bar: progress::bar(2 * table.rows.len() as u64, "frame"), interrupted: interrupt::listen()? };
    let setup = evaluation.prepare(&table, None)?;
    setup.notes.iter().for_each(|line| note(line));
    let verdict = judge(&setup, &table, &flown(&setup, &mut watch)?);
    let mut again = |deg| corrected(&evaluation, &table, deg, &mut watch);
    let (platform, corrected) = refined((&table, &camera), &verdict, &mut again)?;
    let believed = corrected.as_ref().unwrap_or(&verdict).figures();
    let (headings, heights) = meant(&evaluation, &table, (&setup, &believed), &mut watch)?;
    watch.bar.finish_and_clear();
    let summary =
        Summary { heights, headings, ..Summary::new(&setup, &table, (&verdict, corrected.as_ref()), platform) };
    write(
        args,
        &Page { setup: &setup, table: &table, verdict: &verdict, corrected: corrected.as_ref(), summary: &summary },
    )?;
    if !table.knows_truth() && summary.figures.accepted > 0 {
        note(
            "no truth is known: what all fixes have in common, of the navigation, the camera or the map, is not counted as an error",
        );
    }
    Outcome::new(args.json, &summary, || text::text(&summary, &args.out))
}

fn check(args: &Args, table: &Table) -> Result<(), InputError> {
    let files = Files::default()
        .reads("--frames", &args.frames)
        .reads("--camera", &args.camera)
        .reads("--reference", &args.reference)
        .may_read("--dem", args.dem.as_ref())
        .may_read("--settings", args.settings.as_ref())
        .writes_into("--out", &args.out, &WRITTEN);
    table.rows.iter().fold(files, |files, row| files.reads("--frames", &row.file)).check()
}

/// The flight with the camera as it is found to sit, judged likewise.
fn corrected(
    evaluation: &Evaluation,
    table: &Table,
    boresight_deg: [f64; 3],
    watch: &mut Watch,
) -> Result<Verdict, Failure> {
    let setup = evaluation.prepare(table, Some(boresight_deg))?;
    Ok(judge(&setup, table, &flown(&setup, watch)?))
}

/// What the attitude of a flight with hardly a right fix or many wrong ones seems to be, or its heights.
fn meant(
    evaluation: &Evaluation,
    table: &Table,
    (setup, believed): (&Setup, &Figures),
    watch: &mut Watch,
) -> Result<(Option<String>, Option<String>), Failure> {
    let mut all = Vec::new();
    for meant in Meant::of(believed, evaluation.dem.is_some()) {
        let Some(table) = meant.table(table, setup) else { continue };
        // What cannot be flown is not meant.
        let Ok(setup) = evaluation.prepare(&table, None) else { continue };
        all.push((meant, judge(&setup, &table, &flown(&setup, watch)?)));
    }
    let best = best(believed, all);
    let Some(((meant, verdict), others)) = best.split_first() else { return Ok((None, None)) };
    let others: Vec<Meant> = others.iter().map(|(other, _)| *other).collect();
    let says = Some(meant.says(table, verdict, &others));
    Ok(if meant.is_attitude() { (says, None) } else { (None, says) })
}

fn write(args: &Args, page: &Page<'_>) -> Result<(), Failure> {
    let json = serde_json::to_string_pretty(page.summary).map_err(|error| Failure::Work(format!("JSON: {error}")))?;
    let texts = [page.csv(), json + "\n", page.html()?];
    create_folder(&args.out)?;
    let paths = WRITTEN.map(|name| args.out.join(name));
    let files: Vec<_> = paths.iter().map(PathBuf::as_path).zip(texts.iter().map(String::as_bytes)).collect();
    Ok(write_files(&files)?)
}

/// Shows how far it is, and ends it at an interrupt.
struct Watch {
    bar: progress::Bar,
    interrupted: Arc<AtomicBool>,
}

impl Observer for Watch {
    fn exposed(&mut self, _: u32) {
        self.bar.inc(1);
    }

    fn finished(&mut self, _: &Setup, _: &plumbline_sim::run::FrameRecord) {}

    fn is_interrupted(&self) -> bool {
        self.interrupted.load(Ordering::Relaxed)
    }
}
