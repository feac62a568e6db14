//! Runs the bench image in QEMU with the plugin that counts, and joins what both tell.

use crate::process::{cargo, run};
use crate::set_up::{self, Compiler};
use crate::{Failure, build, places};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// What a region cost.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Cost {
    /// Instructions executed.
    pub instructions: u64,
    /// Cycles below which nothing can be.
    pub floor: u64,
    /// Cycles of the serial estimate.
    pub serial: u64,
    /// Lines of external memory fetched.
    pub lines: u64,
}

/// A piece of work that the bench marked.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Region {
    /// What is measured.
    pub workload: String,
    /// Which part of it.
    pub stage: String,
    /// How the camera looks.
    pub pose: String,
    /// What the plugin counted.
    pub cost: Cost,
}

/// Longer than this no run takes, even on a busy machine.
const PATIENCE: Duration = Duration::from_secs(600);

/// Regions of the working tree, whose images are built.
pub fn here(compiler: &Compiler) -> Result<Vec<Region>, Failure> {
    of(&places::root(), &places::target(), compiler)
}

/// Builds the bench of the tree at `root` into `target` and runs it. The plugin is always that of the working tree.
pub fn of(root: &Path, target: &Path, compiler: &Compiler) -> Result<Vec<Region>, Failure> {
    let mut image = cargo();
    image.current_dir(root).env("CARGO_TARGET_DIR", target);
    image.args(["build", "--package", "plumbline-firmware", "--bin", "bench", "--features", build::AN500]);
    image.args(["--profile", places::PROFILE]);
    compiler.apply(&mut image);
    run(&mut image)?;
    count(&target.join(places::THUMB).join(places::PROFILE).join("bench"))
}

/// The plugin, as cargo leaves it.
fn plugin() -> Result<PathBuf, Failure> {
    let library = places::target().join("debug").join("libplumbline_cost.so");
    if library.is_file() { Ok(library) } else { Err(format!("there is no plugin at {}", library.display())) }
}

fn count(image: &Path) -> Result<Vec<Region>, Failure> {
    let folder = places::scratch();
    fs::create_dir_all(&folder).map_err(|error| format!("{}: {error}", folder.display()))?;
    let [records, told] = ["budget.csv", "budget.txt"].map(|name| folder.join(name));
    emulate(image, &records, &told)?;
    let read = |path: &Path| fs::read_to_string(path).map_err(|error| format!("{}: {error}", path.display()));
    join(&read(&told)?, &read(&records)?)
}

/// One run to its end. What the firmware prints goes to a file, since nobody reads while it runs.
fn emulate(image: &Path, records: &Path, told: &Path) -> Result<(), Failure> {
    let standard_error = fs::File::create(told).map_err(|error| format!("{}: {error}", told.display()))?;
    let mut command = Command::new(set_up::emulator()?);
    command.args(["-M", "mps2-an500", "-nodefaults", "-display", "none", "-net", "none"]);
    command.args(["-icount", "shift=1,sleep=off", "-semihosting-config", "enable=on,target=native"]);
    let (plugin, out) = (plugin()?, records.display());
    command.arg("-plugin").arg(format!("{},image={},out={out}", plugin.display(), image.display()));
    command.arg("-kernel").arg(image).stdin(Stdio::null()).stdout(Stdio::null()).stderr(standard_error);
    let mut process = command.spawn().map_err(|error| format!("QEMU could not be started: {error}"))?;
    let begin = Instant::now();
    loop {
        match process.try_wait() {
            Ok(Some(status)) if status.success() => return Ok(()),
            Ok(Some(status)) => {
                let told = fs::read_to_string(told).unwrap_or_default();
                let why = told.lines().rev().find(|line| !line.starts_with("region: ")).unwrap_or("it told nothing");
                return Err(format!("the bench ended with {status}: {why}"));
            }
            Ok(None) if begin.elapsed() < PATIENCE => std::thread::sleep(Duration::from_millis(20)),
            outcome => {
                let _ = process.kill();
                let _ = process.wait();
                return Err(match outcome {
                    Err(error) => format!("the bench was lost: {error}"),
                    Ok(_) => format!("the bench did not end within {} s", PATIENCE.as_secs()),
                });
            }
        }
    }
}

/// The n-th name that the bench printed belongs to the n-th record that the plugin wrote.
fn join(told: &str, records: &str) -> Result<Vec<Region>, Failure> {
    let names: Vec<&str> = told.lines().filter_map(|line| line.strip_prefix("region: ")).collect();
    let mut lines = records.lines();
    let columns: Vec<&str> = lines.next().unwrap_or_default().split(',').collect();
    let lines: Vec<&str> = lines.collect();
    if names.is_empty() || names.len() != lines.len() {
        return Err(format!("the bench named {} regions, but {} were counted", names.len(), lines.len()));
    }
    let region = |(name, line): (&&str, &&str)| {
        let fields: Vec<&str> = line.split(',').collect();
        let number = |column: &str| {
            let at = columns.iter().position(|&other| other == column)?;
            fields.get(at)?.parse().ok()
        };
        let mut parts = name.split(" | ").map(str::to_owned);
        Some(Region {
            workload: parts.next()?,
            stage: parts.next()?,
            pose: parts.next()?,
            cost: Cost {
                instructions: number("instructions")?,
                floor: number("floor")?,
                serial: number("serial")?,
                lines: number("lines")?,
            },
        })
    };
    let regions = names.iter().zip(&lines).map(|pair| region(pair).ok_or_else(|| format!("unreadable: {}", pair.1)));
    regions.collect()
}

#[cfg(test)]
mod tests {
    use super::join;

    const RECORDS: &str = "region,instructions,floor,serial,lines,taken\n1,10,5,20,3,1\n2,30,15,60,0,2\n";

    #[test]
    fn names_and_records_are_joined_in_order() {
        let told = "bench: hello\nregion: a | b | any\nregion: a | c | heading 5\n";
        let regions = join(told, RECORDS).expect("two and two");
        assert_eq!((regions[1].stage.as_str(), regions[1].pose.as_str()), ("c", "heading 5"));
        assert_eq!((regions[0].cost.lines, regions[1].cost.serial), (3, 60));
    }

    #[test]
    fn a_missing_or_unreadable_record_fails() {
        assert!(join("region: a | b | any\n", RECORDS).is_err());
        assert!(join("", RECORDS).is_err());
        assert!(join("region: a\nregion: a | c | 5\n", RECORDS).is_err());
        assert!(join("region: a | b | c\nregion: a | c | 5\n", &RECORDS.replace("60", "x")).is_err());
    }
}
