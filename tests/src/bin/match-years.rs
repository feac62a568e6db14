//! The host program behind `cargo xtask compare --matching`: every orthophoto of an area as ground, every other as reference,
//! patches of both found by both of the core's matchers.

use clap::Parser;
use indicatif::ProgressBar;
use plumbline_core::budget::{PATCH_MAX_PX, SEARCH_MAX_PX};
use plumbline_core::pipeline::BELIEVED_RISK;
use plumbline_survey::io::output::{try_file, write_file};
use plumbline_tests::years::displacements::Displacements;
use plumbline_tests::years::picture::picture;
use plumbline_tests::years::reliability::{Stated, bins, lines, of_scenes};
use plumbline_tests::years::table::{HEAD, line, reliability, reliability_lines};
use plumbline_tests::years::{Answer, Outcome, Pair, Trial, Year, chain, features, made, years};
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
    #[arg(required_unless_present = "made", num_args = 1..)]
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
    /// Instead add up so many patches side by side, as on board: at most 64 pixels a side, searched over ±10
    #[arg(long, value_parser = clap::value_parser!(u16).range(1..=16), conflicts_with_all = ["picture", "features"])]
    chain: Option<u16>,
    /// Also say what is stated of so many made-up lands after changes, and of as many whose parcels are nearly alike
    #[arg(long, value_parser = clap::value_parser!(u64).range(1..=10_000), conflicts_with_all = ["chain", "same"])]
    made: Option<u64>,
    /// Judge by how far the years lie apart (CSV, as tests/years/displacements.py writes it), not by their georeferences alone
    #[arg(long)]
    displacements: Option<PathBuf>,
    /// Also write what each risk and covariance is made of into this CSV file
    #[arg(long)]
    features: Option<PathBuf>,
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
    for path in options.picture.iter().chain(&options.features) {
        try_file(path).map_err(|error| error.to_string())?;
    }
    let years = years(&options.orthos).map_err(|error| error.to_string())?;
    if years.len() == 1 && !options.same {
        return Err("one orthophoto alone has no other to be looked for in; give two, or --same".into());
    }
    let trial = trial(options)?;
    let displacements = options.displacements.as_ref().map(|path| Displacements::read(path)).transpose();
    let displacements = displacements.map_err(|error| error.to_string())?;
    let pairs = pairs(options, &years, displacements.as_ref())?;
    let mut text = match options.chain {
        _ if options.orthos.is_empty() => String::new(),
        Some(count) => chains(options, &trial, &years, &pairs, count.into())?,
        None => patches(options, &trial, &years, &pairs)?,
    };
    if let Some(count) = options.made {
        text += &made_up(options, &trial, count)?;
    }
    // A reader that has seen enough is no error.
    std::io::stdout().write_all(text.as_bytes()).or(Ok(()))
}

/// Two years by their places among the files.
type Numbered<'a> = ((usize, usize), Pair<'a>);

/// Every year in every other, or each in itself.
fn pairs<'a>(
    options: &Options,
    years: &'a [Year],
    displacements: Option<&'a Displacements>,
) -> Result<Vec<Numbered<'a>>, String> {
    let numbers = (0..years.len()).flat_map(|i| (0..years.len()).map(move |j| (i, j)));
    let pair = |(i, j): (usize, usize)| {
        let (ground, reference) = (&years[i], &years[j]);
        let field = displacements.filter(|_| i != j).map(|all| all.between(&ground.name, &reference.name));
        let field = field.transpose().map_err(|error| error.to_string())?;
        Ok(((i, j), Pair { ground, reference, field }))
    };
    numbers.filter(|(i, j)| (i == j) == options.same).map(pair).collect()
}

fn trial(options: &Options) -> Result<Trial, String> {
    let chained = options.chain.is_some();
    if chained && usize::from(options.side) > PATCH_MAX_PX {
        return Err(format!("--chain adds up patches of at most {PATCH_MAX_PX} pixels; give --side {PATCH_MAX_PX}"));
    }
    Ok(Trial {
        side: options.side,
        radius: if chained { SEARCH_MAX_PX as u16 } else { options.radius },
        turn_rad: options.turn_deg.to_radians(),
        scale: options.scale_percent / 100.0,
        noise: options.noise,
    })
}

/// Places of the grid, `step` apart, where patches of that size `wide` side by side and their search lie within all pictures.
fn places(trial: &Trial, years: &[Year], step: usize, wide: usize) -> Result<Vec<[usize; 2]>, String> {
    let margin = usize::from(trial.side / 2 + 2 * trial.radius);
    let size = years.first().map_or((0, 0), |year| (year.cols, year.rows));
    let others = (wide - 1) * usize::from(trial.side);
    if size.0 <= 2 * margin + others || size.1 <= 2 * margin {
        return Err(format!(
            "what all have in common, {} x {} pixels, is less than a patch and its search",
            size.0, size.1
        ));
    }
    let rows = (margin..size.1 - margin).step_by(step);
    Ok(rows.flat_map(|row| (margin..size.0 - margin - others).step_by(step).map(move |col| [col, row])).collect())
}

/// Of each trial its own random numbers.
fn seed(options: &Options, (i, j): (usize, usize), [col, row]: [usize; 2]) -> u64 {
    options.seed << 56 ^ ((i * 97 + j) as u64) << 40 ^ (col as u64) << 20 ^ row as u64
}

fn patches(options: &Options, trial: &Trial, years: &[Year], pairs: &[Numbered<'_>]) -> Result<String, String> {
    let places = places(trial, years, options.step.into(), 1)?;
    let progress = ProgressBar::new(pairs.len() as u64);
    let (mut outcomes, mut made_of) = (Vec::<Outcome>::new(), features::HEAD.to_owned());
    for &(numbers, pair) in pairs {
        let of_pair = places.par_iter().filter_map(|&at| trial.run(pair, at, seed(options, numbers, at)));
        let of_pair: Vec<Outcome> = of_pair.collect();
        made_of += &features::lines(trial, numbers, &of_pair);
        outcomes.extend(of_pair);
        progress.inc(1);
    }
    progress.finish_and_clear();
    if let Some(path) = &options.picture {
        write_file(path, picture(&outcomes, &bins(&of_scenes(&outcomes, 0)))?.as_bytes())
            .map_err(|error| error.to_string())?;
    }
    if let Some(path) = &options.features {
        write_file(path, made_of.as_bytes()).map_err(|error| error.to_string())?;
    }
    Ok(text(&outcomes))
}

fn chains(
    options: &Options,
    trial: &Trial,
    years: &[Year],
    pairs: &[Numbered<'_>],
    count: usize,
) -> Result<String, String> {
    let places = places(trial, years, options.step.into(), count)?;
    let progress = ProgressBar::new(pairs.len() as u64);
    let mut chains = Vec::new();
    for &(numbers, pair) in pairs {
        chains
            .par_extend(places.par_iter().map(|&at| chain::chain(trial, pair, at, count, seed(options, numbers, at))));
        progress.inc(1);
    }
    progress.finish_and_clear();
    let mut lines = vec![chain::HEAD.to_owned()];
    lines.extend((1..=count).map(|cut| chain::line(&chains, cut, f64::from(BELIEVED_RISK))));
    let links = chains.iter().flatten().flatten();
    lines.extend(reliability_lines(&reliability(links.map(|link| (link.risk, link.is_wrong)))));
    Ok(lines.join("\n") + "\n")
}

/// What no stated risk has in it.
const WITHIN: &str =
    "The place is taken to lie within the search: where it does not with a probability p, a risk r is r + p.";

/// Risks that are stated of made-up lands, in halves of as many lands.
fn made_up(options: &Options, trial: &Trial, count: u64) -> Result<String, String> {
    let mut text = Vec::new();
    let progress = ProgressBar::new(2 * count);
    for (name, repeats) in [("made-up land", false), ("made-up land of parcels nearly alike", true)] {
        let mut all: Vec<Stated> = Vec::new();
        for land in 0..count {
            let (reference, grounds) = made::made(options.seed * 100_000 + land, repeats);
            let places = places(trial, std::slice::from_ref(&reference), options.step.into(), 1)?;
            for (number, ground) in grounds.iter().enumerate() {
                let pair = Pair { ground, reference: &reference, field: None };
                let numbers = (land as usize, number);
                let run = |&at: &[usize; 2]| trial.run(pair, at, seed(options, numbers, at));
                let outcomes: Vec<Outcome> = places.par_iter().filter_map(run).collect();
                all.extend(of_scenes(&outcomes, land));
            }
            progress.inc(1);
        }
        text.extend(lines(name, &bins(&all)));
    }
    progress.finish_and_clear();
    text.push(WITHIN.to_owned());
    Ok(text.join("\n") + "\n")
}

fn text(outcomes: &[Outcome]) -> String {
    let of = |matcher: fn(&Outcome) -> Answer| outcomes.iter().map(matcher).collect::<Vec<Answer>>();
    let mut lines = vec![
        HEAD.to_owned(),
        line("high-pass", &of(|outcome| outcome.high_pass)),
        line("directions", &of(|outcome| outcome.directions)),
    ];
    lines.extend(self::lines("orthophotos", &bins(&of_scenes(outcomes, 0))));
    lines.push(WITHIN.to_owned());
    lines.join("\n") + "\n"
}
