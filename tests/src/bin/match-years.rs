//! The host program behind `cargo xtask compare --matching`: every orthophoto of an area as ground, every other as reference,
//! patches of both found by both of the core's matchers.

use clap::Parser;
use indicatif::ProgressBar;
use plumbline_survey::io::output::{check_file, write_file};
use plumbline_tests::years::picture::picture;
use plumbline_tests::years::table::{HEAD, line, reliability};
use plumbline_tests::years::{Answer, Outcome, Trial, years};
use rayon::prelude::*;
use std::io::Write;
use std::path::PathBuf;
use std::process::ExitCode;

#[derive(Debug, Parser)]
#[command(
    name = "cargo xtask compare --matching",
    about = "Both matchers over orthophotos of several years: coverage, wrong ones, stated against observed risk",
    override_usage = "cargo xtask compare --matching [OPTIONS] ORTHO ORTHO ..."
)]
struct Options {
    /// Orthophotos of one area, of the same reference system and pixel size
    #[arg(required = true, num_args = 1..)]
    orthos: Vec<PathBuf>,
    /// Pixels along a side of a patch
    #[arg(long, default_value_t = 65, value_parser = clap::value_parser!(u16).range(9..=255))]
    side: u16,
    /// Pixels of the search to each side
    #[arg(long, default_value_t = 16, value_parser = clap::value_parser!(u16).range(4..=64))]
    radius: u16,
    /// Pixels between patches
    #[arg(long, default_value_t = 40, value_parser = clap::value_parser!(u16).range(1..))]
    step: u16,
    /// One sigma of the patch's turn, degrees
    #[arg(long, default_value_t = 0.5)]
    turn_deg: f64,
    /// One sigma of its scale, percent
    #[arg(long, default_value_t = 0.5)]
    scale_percent: f64,
    /// One sigma of its noise, grey levels
    #[arg(long, default_value_t = 2.0)]
    noise: f64,
    /// Each in itself instead of in the others
    #[arg(long)]
    same: bool,
    /// Also draw coverage and stated against observed risk into this SVG file
    #[arg(long)]
    picture: Option<PathBuf>,
    /// Seed of shifts, turns, scales and noise
    #[arg(long, default_value_t = 1)]
    seed: u64,
}

fn main() -> ExitCode {
    match compared(&Options::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("cargo xtask compare --matching: {error}");
            ExitCode::from(2)
        }
    }
}

fn compared(options: &Options) -> Result<(), String> {
    if let Some(path) = &options.picture {
        check_file(path).map_err(|error| error.to_string())?;
    }
    let years = years(&options.orthos).map_err(|error| error.to_string())?;
    if years.len() < 2 && !options.same {
        return Err("one orthophoto alone has no other to be looked for in; give two, or --same".into());
    }
    let trial = Trial {
        side: options.side,
        radius: options.radius,
        turn_rad: options.turn_deg.to_radians(),
        scale: options.scale_percent / 100.0,
        noise: options.noise,
    };
    let margin = usize::from(options.side / 2 + 2 * options.radius);
    let size = years.first().map_or((0, 0), |year| (year.cols, year.rows));
    if size.0.min(size.1) <= 2 * margin {
        return Err(format!(
            "what all have in common, {} x {} pixels, is less than a patch and its search",
            size.0, size.1
        ));
    }
    let step = usize::from(options.step);
    let rows = (margin..size.1 - margin).step_by(step);
    let places: Vec<_> =
        rows.flat_map(|row| (margin..size.0 - margin).step_by(step).map(move |col| [col, row])).collect();
    let pairs: Vec<_> = (0..years.len())
        .flat_map(|i| (0..years.len()).map(move |j| (i, j)))
        .filter(|(i, j)| (i == j) == options.same)
        .collect();
    let progress = ProgressBar::new(pairs.len() as u64);
    let mut outcomes: Vec<Outcome> = Vec::new();
    for (i, j) in pairs {
        let seed =
            |[col, row]: [usize; 2]| options.seed << 56 ^ ((i * 97 + j) as u64) << 40 ^ (col as u64) << 20 ^ row as u64;
        outcomes.par_extend(places.par_iter().filter_map(|&at| trial.run(&years[i], &years[j], at, seed(at))));
        progress.inc(1);
    }
    progress.finish_and_clear();
    if let Some(path) = &options.picture {
        write_file(path, picture(&outcomes)?.as_bytes()).map_err(|error| error.to_string())?;
    }
    // A reader that has seen enough is no error.
    std::io::stdout().write_all(text(&outcomes).as_bytes()).or(Ok(()))
}

fn text(outcomes: &[Outcome]) -> String {
    let of = |matcher: fn(&Outcome) -> Answer| outcomes.iter().map(matcher).collect::<Vec<Answer>>();
    let mut lines = vec![
        HEAD.to_owned(),
        line("high-pass", &of(|outcome| outcome.high_pass)),
        line("directions", &of(|outcome| outcome.directions)),
        String::new(),
        "stated risk  wrong      of  observed".to_owned(),
    ];
    lines.extend(
        reliability(outcomes).into_iter().map(|(mean, wrong, count)| {
            format!("{mean:11.1e} {wrong:6} {count:7} {:9.1e}", wrong as f64 / count as f64)
        }),
    );
    lines.join("\n") + "\n"
}
