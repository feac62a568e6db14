//! A new user's first minutes: the commands of `docs/first-steps.md` and of `examples/README.md`, as they stand there.
//!
//! Each beginning runs as a shell script in an empty folder that has the examples in it and nothing else, with an empty home and no
//! other program than the system's and the command, as in a container.

use crate::folder::Folder;
use serde_json::Value;
use std::fs;
use std::os::unix::fs::symlink;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// A folder with a copy of the examples, a home, and the command on the path.
fn clean(name: &str) -> Folder {
    let folder = Folder::new(name);
    copy(&root().join("examples"), &folder.path("examples"));
    folder.make("home");
    folder.make("bin");
    symlink(env!("CARGO_BIN_EXE_plumbline"), folder.path("bin/plumbline")).expect("linked");
    folder
}

fn copy(from: &Path, to: &Path) {
    fs::create_dir(to).expect("made");
    for entry in fs::read_dir(from).expect("the examples are there").flatten() {
        let (from, to) = (entry.path(), to.join(entry.file_name()));
        if from.is_dir() { copy(&from, &to) } else { fs::copy(&from, &to).map(drop).expect("copied") }
    }
}

/// Runs lines by the system's shell; the first that fails ends them.
fn script(folder: &Folder, lines: &str) {
    let path = format!("{}:/usr/bin:/bin", folder.path("bin").display());
    let mut shell = Command::new("sh");
    shell.args(["-eu", "-c", lines]).current_dir(folder.path("")).stdin(Stdio::null());
    let run = shell.env_clear().env("PATH", path).env("HOME", folder.path("home")).output().expect("a shell");
    let (out, error) = (String::from_utf8_lossy(&run.stdout), String::from_utf8_lossy(&run.stderr));
    assert!(run.status.success(), "{lines}\n{out}\n{error}");
}

/// The indented lines of a page under a heading.
fn commands(page: &str, heading: &str) -> String {
    let text = fs::read_to_string(root().join(page)).expect("the page is there");
    let section = text.split("\n## ").find(|section| section.starts_with(heading)).expect(heading);
    let lines: Vec<&str> = section.lines().filter_map(|line| line.strip_prefix("    ")).collect();
    assert!(lines.len() >= 3, "{heading} has commands: {lines:?}");
    lines.join("\n")
}

fn json(folder: &Folder, name: &str) -> Value {
    serde_json::from_str(&folder.text(name)).expect("JSON")
}

#[test]
fn with_a_board_and_an_autopilot() {
    let folder = clean("first-board");
    script(&folder, &commands("docs/first-steps.md", "A board and an autopilot"));
    for store in ["configuration.bin", "tiles.bin"] {
        assert!(folder.read(store).len() > 100, "{store}");
    }
    let fixes = folder.text("desk/fixes.csv");
    assert_eq!(fixes.lines().skip(1).filter(|row| row.split(',').nth(2) == Some("1")).count(), 12, "{fixes}");
}

#[test]
fn with_own_orthophotos_and_logs() {
    let folder = clean("first-research");
    script(&folder, &commands("docs/first-steps.md", "Own orthophotos and logs"));
    let report = json(&folder, "evaluated/report.json");
    let count = |key: &str| report[key].as_u64().expect("a count");
    assert_eq!(count("frames"), 24, "{report}");
    assert!(count("right") >= 20 && count("wrong") == 0, "{report}");
    let fault = &json(&folder, "flight/report.json")["faults"][0];
    assert_eq!([&fault["frames"], &fault["accepted"], &fault["accepted_after"]], [20, 20, 12], "{fault}");
    assert_eq!(folder.text("smooth.csv").lines().count(), 602);
    assert!(json(&folder, "replayed/report.json")["accepted"].as_u64() >= Some(20));
}

#[test]
fn with_a_camera_and_an_elevation_model() {
    let folder = clean("first-survey");
    script(&folder, &commands("docs/first-steps.md", "A camera and an elevation model"));
    let mission = json(&folder, "plan/plan.plan");
    assert_eq!((&mission["mission"]["vehicleType"], &mission["mission"]["firmwareType"]), (&2.into(), &12.into()));
    assert!(json(&folder, "plan/plan.json")["overlap_min"]["forward"].as_f64() >= Some(0.8));
    assert_eq!(json(&folder, "survey/report.json")["frames"], 10);
    assert!(folder.text("four.toml").contains("[[heads]]") && !folder.read("calibrated/report.html").is_empty());
}

#[test]
fn each_example_does_what_its_table_says() {
    let folder = clean("first-examples");
    let table = fs::read_to_string(root().join("examples/README.md")).expect("the table is there");
    let commands: Vec<&str> = table
        .lines()
        .filter_map(|line| line.rsplit_once("| `")?.1.strip_suffix("` |"))
        .filter(|command| command.starts_with("plumbline "))
        .collect();
    assert!(commands.len() >= 8, "{commands:?}");
    script(&folder, &commands.join("\n"));
    // Nothing lies there that the table does not have.
    for path in folder.content().keys().filter(|path| path.starts_with(folder.path("examples")) && path.is_file()) {
        let name = path.strip_prefix(folder.path("examples")).expect("below").display().to_string();
        assert!(name == "README.md" || table.contains(&format!("`{name}`")), "{name}");
    }
}
