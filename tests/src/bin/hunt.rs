//! `hunt [--target NAME] [--inputs N] [--seed S]`: damaged inputs by the million, for `cargo xtask fuzz`.

use clap::Parser;
use indicatif::{ProgressBar, ProgressStyle};
use plumbline_tests::fuzz::{SLOWEST_OVER_MEAN, Target, hunt, targets};
use std::process::ExitCode;

/// Hands damaged inputs to everything that reads bytes from outside
#[derive(Parser)]
struct Args {
    /// Only this reader
    #[arg(long, value_name = "NAME")]
    target: Option<String>,
    /// Inputs for each reader
    #[arg(long, value_name = "N", default_value_t = 10_000_000)]
    inputs: u64,
    /// Seed of the mutations
    #[arg(long, value_name = "S", default_value_t = 1)]
    seed: u64,
}

fn main() -> ExitCode {
    let args = Args::parse();
    let mut targets = targets();
    let names = targets.iter().map(|target| target.name()).collect::<Vec<_>>().join(", ");
    targets.retain(|target| args.target.as_ref().is_none_or(|name| name == target.name()));
    if targets.is_empty() {
        eprintln!("--target: not one of {names}");
        return ExitCode::from(2);
    }
    // A panic is a finding, told once, with its input.
    std::panic::set_hook(Box::new(|_| {}));
    let is_clean = targets.iter_mut().all(|target| run(target.as_mut(), &args));
    if is_clean { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

/// Hunts one target and tells how it went.
fn run(target: &mut dyn Target, args: &Args) -> bool {
    let name = target.name();
    let bar = ProgressBar::new(args.inputs);
    if let Ok(style) = ProgressStyle::with_template("{msg} {human_pos} of {human_len} {wide_bar} {eta} left") {
        bar.set_style(style);
    }
    bar.set_message(name);
    let told = hunt(target, args.seed, args.inputs, &mut |done| {
        if done % 1024 == 0 {
            bar.set_position(done);
        }
    });
    bar.finish_and_clear();
    match told {
        Ok(hunted) => {
            println!(
                "{name}: {} inputs of seed {}, {} bytes, none broke it; the slowest took {:.0} times the mean",
                hunted.inputs, args.seed, hunted.bytes, hunted.slowest_over_mean
            );
            hunted.slowest_over_mean < SLOWEST_OVER_MEAN
        }
        Err(found) => {
            let bytes: String = found.input.iter().map(|byte| format!("{byte:02x}")).collect();
            println!("{name}: input {} of seed {}: {}\n{bytes}", found.number, args.seed, found.what);
            false
        }
    }
}
