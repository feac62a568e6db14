//! `plumbline adjust`: a problem of Bundle Adjustment in the Large.

use crate::outcome::{Failure, Outcome, note};
use plumbline_survey::adjust::bal::Bal;
use plumbline_survey::adjust::{Adjustment, Loss, Model, Options, SolveError};
use plumbline_survey::error::InputError;
use serde::Serialize;
use std::path::PathBuf;
use std::time::Instant;

#[derive(Debug, clap::Args)]
pub struct Args {
    /// Problem file: numbers of cameras, points and observations; observations; cameras (9 numbers each); points
    #[arg(long, value_name = "FILE")]
    bal: PathBuf,
    /// Iterations after which it is given up
    #[arg(long, value_name = "N", default_value_t = 50, value_parser = clap::value_parser!(u16).range(1..), allow_negative_numbers = true)]
    iterations: u16,
    /// Print one JSON document
    #[arg(long)]
    json: bool,
}

#[derive(Debug, Serialize)]
struct Adjusted {
    cameras: usize,
    points: usize,
    observations: usize,
    cost_start: f64,
    cost_end: f64,
    iterations: usize,
    seconds: f64,
}

/// First damping and least relative gain: Ceres' own, so that the two are compared at the same work.
const OPTIONS: Options = Options { loss: Loss::Squares, iterations_max: 50, damping: 1e-4, gain_min: 1e-6 };

pub fn run(args: &Args) -> Result<Outcome, Failure> {
    let bal = Bal::read(&args.bal)?;
    let begin = Instant::now();
    let name = args.bal.display();
    let refused = |error: SolveError| match error {
        SolveError::NotConverged { iterations, cost, .. } | SolveError::Stuck { iterations, cost, .. } => {
            Failure::Work(format!("{name}: not converged after {iterations} iterations, the cost is {cost:.6e}"))
        }
        SolveError::NotFinite | SolveError::Behind { .. } => {
            Failure::Input(InputError::new(format!("{name}: the start values give residuals that are not finite")))
        }
        SolveError::TooLarge => Failure::Work(format!("{name}: there is no memory for the equations of this problem")),
        SolveError::Parallel { point } => Failure::Input(InputError::new(format!(
            "{name}: the rays of point {point}, counted from 0, are parallel, its position cannot be determined"
        ))),
        SolveError::Singular { .. } => Failure::Input(InputError::new(format!(
            "{name}: the observations do not determine all cameras and points: are there some that too few observations show?"
        ))),
    };
    let adjustment = Adjustment::new(&bal, OPTIONS.loss).map_err(refused)?;
    let options = Options { iterations_max: args.iterations.into(), ..OPTIONS };
    let mut iterated = |iteration: usize, cost: f64| {
        if !args.json {
            note(&format!("iteration {iteration:2}: cost {cost:.6e}"));
        }
    };
    let solution = adjustment.solve(bal.start(), &options, &mut iterated).map_err(refused)?;
    let adjusted = Adjusted {
        cameras: bal.cameras,
        points: bal.structure().points,
        observations: bal.observations(),
        cost_start: solution.cost_start,
        cost_end: solution.cost_end,
        iterations: solution.iterations,
        seconds: begin.elapsed().as_secs_f64(),
    };
    let text = || {
        format!(
            "{} cameras, {} points, {} observations: cost {:.6e} -> {:.6e} in {} iterations, {:.2} s\n",
            adjusted.cameras,
            adjusted.points,
            adjusted.observations,
            adjusted.cost_start,
            adjusted.cost_end,
            adjusted.iterations,
            adjusted.seconds
        )
    };
    Outcome::new(args.json, &adjusted, text)
}
