//! `cargo xtask fuzz`: ten million damaged inputs for each reader of bytes, then cargo-fuzz's coverage-guided search where
//! it runs.

use super::fly::option;
use super::process::{program, run, succeeds};
use super::{Failure, places};
use std::process::Command;

/// Inputs for each reader, of either kind.
const INPUTS: &str = "10000000";
/// The readers, as `fuzz/Cargo.toml` has them.
const TARGETS: [&str; 11] = [
    "mavlink",
    "line_device",
    "line_host",
    "configuration",
    "tiles",
    "plan",
    "key",
    "signing",
    "camera_file",
    "log",
    "flight_log",
];

/// `cargo xtask fuzz [--inputs N] [--seed S] [--target NAME]`.
pub fn fuzz(args: &[String]) -> Result<(), Failure> {
    run(program("hunt")?.args(args))?;
    // The compiler's coverage is a nightly feature, and cargo-fuzz a program of its own.
    if !succeeds(Command::new("cargo").args(["+nightly", "fuzz", "--version"])) {
        println!("coverage-guided search: skipped, it needs a nightly toolchain and `cargo install cargo-fuzz`");
        return Ok(());
    }
    let runs = option(args, "--inputs").unwrap_or(INPUTS);
    for target in TARGETS.iter().filter(|target| option(args, "--target").is_none_or(|wanted| wanted == **target)) {
        let mut search = Command::new("cargo");
        search.current_dir(places::root()).args(["+nightly", "fuzz", "run", target, "--", "-max_len=8192"]);
        // A flight in this process, whose log the valid inputs come from, leaks its application by intent.
        search.arg("-detect_leaks=0");
        run(search.arg(format!("-runs={runs}")))?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::TARGETS;

    #[test]
    fn every_target_is_searched() {
        let manifest = include_str!("../../fuzz/Cargo.toml");
        let (_, targets) = manifest.split_once("[[bin]]").expect("targets");
        let names = targets.lines().filter_map(|line| line.strip_prefix("name = ")).map(|name| name.trim_matches('"'));
        assert_eq!(names.collect::<Vec<_>>(), TARGETS);
    }
}
