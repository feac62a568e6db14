//! `plumbline calibrate`: a camera of several heads from its flight.

use super::{Failure, folder, note, print, print_json};
use indicatif::ProgressBar;
use plumbline_sim::calibration;
use plumbline_survey::adjust::rig::{HEAD, LENS, TIME};
use plumbline_survey::calibrate::{Block, Calibration, Observations, camera_file};
use plumbline_survey::error::InputError;
use plumbline_survey::output::{check_file, write_file};
use serde::Serialize;
use std::path::PathBuf;

#[derive(Debug, clap::Args)]
pub struct Args {
    /// Block: the camera's design, start values, known points, what is known beforehand (JSON)
    #[arg(long, value_name = "FILE")]
    block: PathBuf,
    /// Image points: station,head,point,x_px,y_px, x right and y up from the frame's middle (CSV)
    #[arg(long, value_name = "FILE")]
    observations: PathBuf,
    /// The camera file to write
    #[arg(long, value_name = "FILE")]
    out: PathBuf,
    /// Folder for the report, report.html
    #[arg(long, value_name = "DIR")]
    report: Option<PathBuf>,
    /// Print one JSON document
    #[arg(long)]
    json: bool,
}

/// The report's file.
const REPORT: &str = "report.html";
/// Outliers that are named.
const NAMED: usize = 100;
const ARCSEC: f64 = 3600.0;

#[derive(Debug, Serialize)]
struct Told {
    sigma0_px: f64,
    iterations: usize,
    equations: usize,
    unknowns: usize,
    heads_rad: Vec<[f64; 3]>,
    head_sd_arcsec: Vec<f64>,
    heads_d_m: Vec<[f64; 3]>,
    heads_dt_s: Vec<f64>,
    heads_interior: Vec<Vec<f64>>,
    stations: Vec<[f64; 6]>,
    outliers: Vec<Outlier>,
    outlier_count: usize,
    notes: Vec<String>,
}

#[derive(Debug, Serialize)]
struct Outlier {
    line: usize,
    station: usize,
    head: usize,
    point: usize,
    v_px: [f64; 2],
    standardised: f64,
}

pub fn run(args: &Args) -> Result<(), Failure> {
    check_files(args)?;
    let block = Block::read(&args.block)?;
    let observations = Observations::read(&args.observations, &block)?;
    let bar = ProgressBar::new_spinner();
    let adjusted = Calibration::new(&block, &observations, &mut |iteration, cost| {
        bar.set_message(format!("iteration {iteration}: sum of squares {:.6e}", 2.0 * cost));
        bar.tick();
    });
    bar.finish_and_clear();
    let adjusted = adjusted?;
    let file = camera_file(&block, &observations, &adjusted)?;
    let mut notes = file.assumed;
    notes.extend(block.ignored.iter().map(|key| format!("{}: {key} means nothing here", args.block.display())));
    let text = file.camera.checked_toml_string(&args.out)?;
    if let Some(report) = &args.report {
        let page = calibration::page(&block, &observations, &adjusted);
        folder::create(report)?;
        write_file(&report.join(REPORT), page.as_bytes())?;
    }
    write_file(&args.out, text.as_bytes())?;
    let told = told(&block, &observations, &adjusted, notes);
    told.notes.iter().for_each(|line| note(line));
    if args.json {
        return print_json(&told);
    }
    print(&text_of(&told))
}

/// Files that can be written, and that are not those that are read.
fn check_files(args: &Args) -> Result<(), InputError> {
    check_file(&args.out)?;
    if let Some(report) = &args.report {
        folder::check("--report", report, &[REPORT])?;
    }
    if args.report.as_ref().is_some_and(|report| report.join(REPORT) == args.out) {
        return Err(InputError::new(format!("--out and the report are the same file: {}", args.out.display())));
    }
    folder::apart(&args.out, &[("--block", &args.block), ("--observations", &args.observations)])
}

fn told(block: &Block, observations: &Observations, calibration: &Calibration, notes: Vec<String>) -> Told {
    let outlier = |&index: &usize| {
        let (seen, residual) = (&observations.seen[index], &calibration.residuals[index]);
        Outlier {
            line: observations.lines[index],
            station: seen.station,
            head: seen.head,
            point: seen.point,
            v_px: residual.v_px,
            standardised: residual.worst(),
        }
    };
    let of = |places: std::ops::Range<usize>| -> Vec<Vec<f64>> {
        calibration.heads.iter().map(|head| head[places.clone()].to_vec()).collect()
    };
    let triples =
        |from: usize| calibration.heads.iter().map(|head| [head[from], head[from + 1], head[from + 2]]).collect();
    Told {
        sigma0_px: calibration.sigma0_px,
        iterations: calibration.iterations,
        equations: calibration.size.0,
        unknowns: calibration.size.1,
        heads_rad: triples(0),
        head_sd_arcsec: (1..block.heads.len())
            .flat_map(|head| (0..3).map(move |angle| (head, angle)))
            .map(|(head, angle)| calibration.sigma(head, angle).unwrap_or(0.0).to_degrees() * ARCSEC)
            .collect(),
        heads_d_m: triples(3),
        heads_dt_s: calibration.heads.iter().map(|head| head[TIME]).collect(),
        heads_interior: of(LENS..HEAD),
        stations: calibration.stations.clone(),
        outliers: calibration.outliers.iter().take(NAMED).map(outlier).collect(),
        outlier_count: calibration.outliers.len(),
        notes,
    }
}

fn text_of(told: &Told) -> String {
    let mut text = format!(
        "sigma0 {:.4} px after {} iterations, {} equations for {} unknowns, {} outliers\n\n\
         head     phi deg    omega deg    kappa deg    sd arcsec\n",
        told.sigma0_px, told.iterations, told.equations, told.unknowns, told.outlier_count
    );
    for (index, angles) in told.heads_rad.iter().enumerate() {
        let [phi, omega, kappa] = angles.map(f64::to_degrees);
        let sd = match index.checked_sub(1).and_then(|place| told.head_sd_arcsec.get(3 * place..3 * place + 3)) {
            Some([a, b, c]) => format!("{a:.2} {b:.2} {c:.2}"),
            _ => "held".to_owned(),
        };
        text.push_str(&format!("{index:4} {phi:11.6} {omega:12.6} {kappa:12.6}    {sd}\n"));
    }
    for outlier in &told.outliers {
        text.push_str(&format!(
            "outlier: line {}, point {} at station {}, head {}: residual {:.2}, {:.2} px, {:.1} sigmas\n",
            outlier.line,
            outlier.point,
            outlier.station,
            outlier.head,
            outlier.v_px[0],
            outlier.v_px[1],
            outlier.standardised
        ));
    }
    text
}
