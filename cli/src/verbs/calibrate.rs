//! `plumbline calibrate`: a camera of several heads from its flight.

use crate::files::{Files, create_folder};
use crate::outcome::{Failure, Outcome, note};
use crate::pages::calibration;
use crate::progress;
use plumbline_survey::adjust::rig::{HEAD, LENS, TIME};
use plumbline_survey::calibrate::{Block, Calibration, Observations, camera_file};
use plumbline_survey::io::output::write_file;
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
struct Summary {
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

/// An observation that was left out: heads count from 1; stations and points from 0, as in the observations.
#[derive(Debug, Serialize)]
struct Outlier {
    line: usize,
    station: usize,
    head: usize,
    point: usize,
    v_px: [f64; 2],
    standardised: f64,
}

pub fn run(args: &Args) -> Result<Outcome, Failure> {
    Files::default()
        .reads("--block", &args.block)
        .reads("--observations", &args.observations)
        .may_write_into("--report", args.report.as_ref(), &[REPORT])
        .writes("--out", &args.out)
        .check()?;
    let block = Block::read(&args.block)?;
    let observations = Observations::read(&args.observations, &block)?;
    let bar = progress::spinner();
    let adjusted = Calibration::new(&block, &observations, &mut |iteration, cost| {
        bar.set_message(format!("iteration {iteration}: sum of squares {:.6e}", 2.0 * cost));
        bar.tick();
    });
    bar.finish_and_clear();
    let adjusted = adjusted?;
    let file = camera_file(&block, &observations, &adjusted)?;
    let text = file.camera.checked_toml_string(&args.out)?;
    if let Some(report) = &args.report {
        let page = calibration::page(&block, &observations, &adjusted);
        create_folder(report)?;
        write_file(&report.join(REPORT), page.as_bytes())?;
    }
    write_file(&args.out, text.as_bytes())?;
    let summary = summary(&block, &observations, &adjusted, file.assumed);
    summary.notes.iter().for_each(|line| note(line));
    let report = args.report.as_ref().map(|folder| format!(", report {}", folder.join(REPORT).display()));
    let written = format!("camera file {}{}\n", args.out.display(), report.unwrap_or_default());
    Outcome::new(args.json, &summary, || text_of(&summary) + &written)
}

fn summary(block: &Block, observations: &Observations, calibration: &Calibration, notes: Vec<String>) -> Summary {
    let outlier = |&index: &usize| {
        let (seen, residual) = (&observations.seen[index], &calibration.residuals[index]);
        Outlier {
            line: observations.lines[index],
            station: seen.station,
            head: seen.head + 1,
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
    Summary {
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

fn text_of(summary: &Summary) -> String {
    let mut text = format!(
        "sigma0 {:.4} px after {} iterations, {} equations for {} unknowns, {} outliers\n\n\
         head     phi deg    omega deg    kappa deg    sd arcsec\n",
        summary.sigma0_px, summary.iterations, summary.equations, summary.unknowns, summary.outlier_count
    );
    for (index, angles) in summary.heads_rad.iter().enumerate() {
        let [phi, omega, kappa] = angles.map(f64::to_degrees);
        let sd = match index.checked_sub(1).and_then(|place| summary.head_sd_arcsec.get(3 * place..3 * place + 3)) {
            Some([a, b, c]) => format!("{a:.2} {b:.2} {c:.2}"),
            _ => "held".to_owned(),
        };
        text.push_str(&format!("{:4} {phi:11.6} {omega:12.6} {kappa:12.6}    {sd}\n", index + 1));
    }
    for outlier in &summary.outliers {
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
