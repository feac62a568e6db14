//! `plumbline stitch`: the virtual image of a camera of several heads.

use super::positive;
use crate::files::{Files, check_extension};
use crate::outcome::{Failure, Outcome};
use crate::progress;
use plumbline_sim::camera::heads::Rig;
use plumbline_sim::camera::stitch::{Mismatch, Mosaic, SEARCH_PX, Seam, mismatches, pairs, pieces, stitch};
use plumbline_survey::camera_file::CameraFile;
use plumbline_survey::error::InputError;
use plumbline_survey::io::picture::{Bands, Picture, read_bands, write_grey_png, write_rgb_png};
use serde::Serialize;
use std::path::{Path, PathBuf};

#[derive(Debug, clap::Args)]
pub struct Args {
    /// Camera file (TOML) with heads
    #[arg(long)]
    camera: PathBuf,
    /// One frame a head, in the file's order: PNG, TIFF or JPEG, row 0 forward
    #[arg(long, num_args = 1.., required = true, value_name = "FRAME")]
    frames: Vec<PathBuf>,
    /// The virtual image, PNG
    #[arg(long)]
    out: PathBuf,
    /// Vertical distance from the virtual projection centre to a plane square to its axis, metres, for which the parallax
    /// of the heads' places is taken off; far away unless given
    #[arg(long, value_parser = positive, allow_negative_numbers = true)]
    height_m: Option<f64>,
    /// Where heads overlap: feather blends, hard takes the head whose axis is nearest
    #[arg(long, default_value = "feather", value_parser = seam)]
    seam: Seam,
    /// Print one JSON document
    #[arg(long)]
    json: bool,
}

fn seam(text: &str) -> Result<Seam, String> {
    match text {
        "feather" => Ok(Seam::Feather),
        "hard" => Ok(Seam::Hard),
        _ => Err("neither feather nor hard".to_owned()),
    }
}

#[derive(Serialize)]
struct Summary {
    cols: usize,
    rows: usize,
    seams: Vec<SeamLine>,
    coverage: f64,
}

/// A pair of heads that overlap, counted from 1.
#[derive(Serialize)]
struct SeamLine {
    heads: [usize; 2],
    /// Matched, of so many that both heads see.
    windows: usize,
    tried: usize,
    rms_px: Option<f64>,
    max_px: Option<f64>,
}

impl From<Mismatch> for SeamLine {
    fn from(seam: Mismatch) -> Self {
        let Mismatch { heads, windows, tried, rms_px, max_px } = seam;
        SeamLine { heads: heads.map(|head| head + 1), windows, tried, rms_px, max_px }
    }
}

pub fn run(args: &Args) -> Result<Outcome, Failure> {
    let files = Files::default().reads("--camera", &args.camera).writes("--out", &args.out);
    args.frames.iter().fold(files, |files, frame| files.reads("--frames", frame)).check()?;
    check_extension("--out", &args.out, "png")?;
    let camera = args.camera.display();
    let refuse = |why: String| Failure::Input(InputError::new(why));
    let file = CameraFile::read(&args.camera)?;
    let rig = Rig::new(&file, args.height_m).map_err(|error| refuse(format!("{camera}: {error}")))?;
    if args.frames.len() != file.heads.len() {
        let (heads, frames) = (file.heads.len(), args.frames.len());
        return Err(refuse(format!("{camera} has heads: {heads}, but --frames names pictures: {frames}")));
    }
    let frames = args.frames.iter().map(|path| read_bands(path)).collect::<Result<Vec<Bands>, _>>()?;
    for ((path, frame), (index, head)) in args.frames.iter().zip(&frames).zip(file.heads.iter().enumerate()) {
        let (cols, rows) = frame.size();
        if (cols, rows) != (head.cols as usize, head.rows as usize) {
            let (path, number) = (path.display(), index + 1);
            return Err(refuse(format!(
                "{path} has {cols} x {rows} pixels, but head {number} of {camera} has {} x {}",
                head.cols, head.rows
            )));
        }
        if frame.0.len() != frames[0].0.len() {
            let (first, path) = (args.frames[0].display(), path.display());
            return Err(refuse(format!("{first} and {path} are not both grey or both in colour")));
        }
    }
    let pairs = pairs(&rig);
    let bar = progress::bar((pieces(&rig) + pairs.len()) as u64, "piece");
    let step = || bar.inc(1);
    let mosaic = stitch(&rig, &frames, args.seam, &step)?;
    let seams = mismatches(&rig, &frames, &pairs, &step)?;
    bar.finish_and_clear();
    let Mosaic { size: (cols, rows), bands, samples, coverage } = mosaic;
    if bands == 1 {
        write_grey_png(&args.out, &Picture { cols, rows, pixels: samples })?;
    } else {
        write_rgb_png(&args.out, cols, rows, &samples)?;
    }
    let summary = Summary { cols, rows, seams: seams.into_iter().map(SeamLine::from).collect(), coverage };
    Outcome::new(args.json, &summary, || text_of(&summary, &args.out))
}

fn text_of(summary: &Summary, out: &Path) -> String {
    let Summary { cols, rows, coverage, .. } = summary;
    let mut text = format!("{cols} x {rows} pixels, {:.2} % seen by a head: {}\n", 100.0 * coverage, out.display());
    for SeamLine { heads: [one, other], windows, tried, rms_px, max_px } in &summary.seams {
        let found = match rms_px.zip(*max_px) {
            Some((rms, max)) => format!("{rms:.3} px RMS, {max:.3} px at most, in {windows} of {tried} windows"),
            None => format!("none of {tried} windows has texture and its like within {SEARCH_PX} px"),
        };
        text.push_str(&format!("heads {one} and {other}: {found}\n"));
    }
    text
}
