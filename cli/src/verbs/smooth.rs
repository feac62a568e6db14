//! `plumbline smooth`: columns of a log as smooth curves.

use super::{finite, positive};
use crate::files::{Files, check_extension};
use crate::outcome::{Failure, Outcome, note};
use crate::smoothing::{Smoothed, Wanted};
use plumbline_survey::error::InputError;
use plumbline_survey::io::output::write_file;
use plumbline_survey::smooth::{Alpha, Options, Order};
use std::path::PathBuf;

#[derive(Debug, clap::Args)]
pub struct Args {
    /// The log: CSV with a header, or a flight log: ULog (.ulg), DataFlash (.bin) or MAVLink telemetry (.tlog)
    #[arg(long = "in", value_name = "LOG")]
    input: PathBuf,
    /// The message of a flight log, as vehicle_attitude, ATT or ATTITUDE
    ///
    /// Of several that say it the first is taken; NAME:INSTANCE is another one, as sensor_accel:1, XKF1:1 or, by system and component,
    /// ATTITUDE:2.1. A name that is not there is told with those that are.
    #[arg(long, value_name = "NAME", value_parser = column)]
    message: Option<String>,
    /// Its column of time, seconds; of a flight log t_s, its clock, unless given
    #[arg(long, value_name = "COLUMN")]
    time: Option<String>,
    /// Its columns to smooth, each for itself; of a flight log all that change unless given
    #[arg(long, value_name = "A,B", value_delimiter = ',', num_args = 1, value_parser = column)]
    columns: Vec<String>,
    /// Differences of the penalty: 2 (lines are smooth) or 3 (parabolas)
    #[arg(long, default_value = "2", value_parser = order, allow_negative_numbers = true)]
    order: Order,
    /// Smoothing factor without unit: gcv, or a number above 0
    #[arg(long, default_value = "gcv", value_parser = alpha, value_name = "gcv|X", allow_negative_numbers = true)]
    alpha: Alpha,
    /// Times at which the curves are wanted, CSV; those of the log unless given
    #[arg(long, value_name = "CSV")]
    at: Option<PathBuf>,
    /// Those of the columns that are angles: whole turns are added, so that they do not jump
    ///
    /// A turn is 360, or 2 pi where the column is counted over at pi or 2 pi as radians are. Columns of a DataFlash log that are degrees by its
    /// own units need not be named.
    #[arg(long, value_name = "A,B", value_delimiter = ',', num_args = 1, value_parser = column)]
    angles: Vec<String>,
    /// Column of weights, 1 / variance; 0 = no sample
    #[arg(long, value_name = "COLUMN")]
    weights: Option<String>,
    /// Longest gap that is bridged, seconds; 20 median spacings unless given
    #[arg(long, value_name = "S", value_parser = positive, allow_negative_numbers = true)]
    gap_s: Option<f64>,
    /// Leave out samples farther off than so many standard deviations
    #[arg(long, value_name = "K", value_parser = positive, allow_negative_numbers = true)]
    gate: Option<f64>,
    /// The curves, CSV: time, then value, rate and sigma of each column
    #[arg(long, value_name = "CSV")]
    out: PathBuf,
    /// Picture of samples, curves and residuals, SVG
    #[arg(long, value_name = "SVG")]
    plot: Option<PathBuf>,
    /// Print one JSON document
    #[arg(long)]
    json: bool,
}

/// A column's name, without the blanks of a list.
fn column(text: &str) -> Result<String, String> {
    match text.trim() {
        "" => Err("names no column".to_owned()),
        name => Ok(name.to_owned()),
    }
}

fn order(text: &str) -> Result<Order, String> {
    match text {
        "2" => Ok(Order::Second),
        "3" => Ok(Order::Third),
        _ => Err("must be 2 or 3".to_owned()),
    }
}

/// What is too large depends on order and weights, so it is found later.
fn alpha(text: &str) -> Result<Alpha, String> {
    match text {
        "gcv" => Ok(Alpha::Gcv),
        _ => match finite(text) {
            Ok(value) if value > 0.0 => Ok(Alpha::Given(value)),
            Ok(_) => Err("must be above 0".to_owned()),
            Err(why) => Err(format!("{why}, nor gcv")),
        },
    }
}

pub fn run(args: &Args) -> Result<Outcome, Failure> {
    check_files(args)?;
    let wanted = Wanted {
        file: &args.input,
        message: args.message.as_deref(),
        time: args.time.as_deref(),
        columns: &args.columns,
        angles: &args.angles,
        weights: args.weights.as_deref(),
        at: args.at.as_deref(),
        options: Options { order: args.order, alpha: args.alpha, gap_s: args.gap_s, gate: args.gate },
    };
    let smoothed = Smoothed::of(&wanted)?;
    let picture = args.plot.as_ref().map(|_| smoothed.picture()).transpose().map_err(Failure::Work)?;
    write_file(&args.out, smoothed.csv().as_bytes())?;
    if let (Some(path), Some(picture)) = (&args.plot, picture) {
        write_file(path, picture.as_bytes())?;
    }
    smoothed.warnings().iter().for_each(|line| note(line));
    Outcome::new(args.json, &smoothed.summaries(), || smoothed.lines().iter().map(|line| format!("{line}\n")).collect())
}

fn check_files(args: &Args) -> Result<(), InputError> {
    Files::default()
        .reads("--in", &args.input)
        .may_read("--at", args.at.as_ref())
        .writes("--out", &args.out)
        .may_write("--plot", args.plot.as_ref())
        .check()?;
    args.plot.iter().try_for_each(|plot| check_extension("--plot", plot, "svg"))
}
