//! The pages that commands write, loaded by a browser: nothing in its console, and what a person can do there does something.
//!
//! Scripts of `tests/pages` are appended to copies of the pages, and throw where something does not hold.

use super::debian::{Machine, Wanted};
use super::process::{run, succeeds};
use super::steps::Outcome;
use super::{Failure, places};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// Debian's browser without a window, and where it lies in its package.
const PACKAGE: &str = "chromium-headless-shell";
const PROGRAM: &str = "usr/lib/chromium/chromium-headless-shell";
/// What browsers of its kind are called on other machines.
const BROWSERS: [&str; 5] = [PACKAGE, "chromium", "chromium-browser", "google-chrome", "chrome"];
/// Without a window, a network or the sandbox, which containers do not allow; with the script's time run through at once.
const OPTIONS: [&str; 7] = [
    "--headless",
    "--no-sandbox",
    "--disable-gpu",
    "--disable-background-networking",
    "--enable-logging=stderr",
    "--virtual-time-budget=3000",
    "--dump-dom",
];
/// Windows that each page is loaded in: a screen and a telephone, pixels.
const WINDOWS: [&str; 2] = ["1240,900", "420,900"];
/// And one whose style is that of print, as wide as what is printed of a sheet of A4.
const SHEET: &str = "688,900";
const CAMERA: &str = "cols = 96\nrows = 96\nfov_h_deg = 60.0\nfov_v_deg = 60.0\noffset_m_px = 0.0\noffset_n_px = 0.0\n";

/// Writes each page and loads it.
pub fn check() -> Outcome {
    match browser() {
        Ok(browser) => pages().and_then(|pages| pages.iter().try_for_each(|page| load(&browser, page))).into(),
        Err(why) => Outcome::Skipped(format!("no Chromium: {why}")),
    }
}

/// The machine's own, else Debian's under `target/tools`.
fn browser() -> Result<PathBuf, Failure> {
    let machine = Machine::here();
    let private = machine.private(PACKAGE);
    let starts = |program: &Path| succeeds(machine.command(program).arg("--no-sandbox").arg("--version"));
    let known = BROWSERS.iter().map(PathBuf::from).chain([private.clone()]);
    if let Some(program) = known.into_iter().find(|program| starts(program)) {
        return Ok(program);
    }
    machine.unpack(&Wanted { packages: &[PACKAGE], programs: &[(PROGRAM, "")] }, || starts(&private))?;
    Ok(private)
}

/// A page, and the script that is appended to it beside the one of all pages.
struct Page {
    path: PathBuf,
    script: Option<&'static str>,
}

/// One of each kind, of little data.
fn pages() -> Result<Vec<Page>, Failure> {
    let folder = places::scratch().join("pages");
    let failed = |error: std::io::Error| format!("{}: {error}", folder.display());
    let _ = fs::remove_dir_all(&folder);
    fs::create_dir_all(&folder).map_err(failed)?;
    fs::write(folder.join("camera.toml"), CAMERA).map_err(failed)?;
    // Hills of 40 m, 25 m apart.
    let height = |col: i32, row: i32| format!("{:.1}", 20.0 * (f64::from(col * row) / 300.0).sin());
    let row = |row| (0..141).map(|col| height(col, row)).collect::<Vec<_>>().join(" ");
    let grid = (0..141).map(row).collect::<Vec<_>>().join("\n");
    let head = "ncols 141\nnrows 141\nxllcenter -1500\nyllcenter -1500\ncellsize 25\n";
    fs::write(folder.join("dem.asc"), format!("{head}{grid}\n")).map_err(failed)?;
    for command in COMMANDS[..2].iter().map(|command| (*command).to_owned()).chain([calibration()]) {
        plumbline(&folder, &command)?;
    }
    let poses = fs::read_to_string(folder.join("flight/poses.csv")).map_err(failed)?;
    fs::write(folder.join("frames.csv"), frames(&poses)).map_err(failed)?;
    COMMANDS[2..].iter().try_for_each(|command| plumbline(&folder, command))?;
    let page = |name: &str, script| Page { path: folder.join(name).join("report.html"), script };
    let others = ["plan", "calibration", "boresight", "evaluation", "reproduction"].map(|name| page(name, None));
    Ok([page("flight", Some("flight.js"))].into_iter().chain(others).collect())
}

/// What writes the pages; the first two know nothing of the others.
const COMMANDS: [&str; 5] = [
    "fly --frames 40 --dump 40 --set camera_file=camera.toml --set follow_up.mode=fixed --out flight",
    "plan --dem dem.asc --area 0,0,400,300 --camera camera.toml --height-m 300 --overlap 60/30 --out plan",
    "boresight --camera camera.toml --fixes flight/fixes.csv --poses flight/poses.csv --out new.toml --report boresight",
    "evaluate --frames frames.csv --camera camera.toml --reference flight/tile.tif --out evaluation",
    "reproduce 000 --out reproduction",
];

fn calibration() -> String {
    let of = |name: &str| places::root().join("examples/calibrate").join(name).display().to_string();
    let (block, observations) = (of("block.json"), of("observations.csv"));
    format!("calibrate --block {block} --observations {observations} --out heads.toml --report calibration")
}

fn plumbline(folder: &Path, command: &str) -> Result<(), Failure> {
    let mut plumbline = Command::new(places::tested("plumbline"));
    run(plumbline.args(command.split_whitespace()).current_dir(folder).stdout(Stdio::null()))
}

/// The frames of a flight as `evaluate` reads them, from its `poses.csv`.
fn frames(poses: &str) -> String {
    let mut frames = "file,east_m,north_m,height_m,heading_deg,pitch_deg,roll_deg\n".to_owned();
    for (index, pose) in poses.lines().skip(1).enumerate() {
        let fields: Vec<&str> = pose.split(',').skip(1).take(6).collect();
        frames.push_str(&format!("flight/frame_{index:04}.png,{}\n", fields.join(",")));
    }
    frames
}

/// Loads a page in every window, and as it is printed.
fn load(browser: &Path, page: &Page) -> Result<(), Failure> {
    let failed = |error: std::io::Error| format!("{}: {error}", page.path.display());
    let text = fs::read_to_string(&page.path).map_err(failed)?;
    load_with(browser, page, &text, page.script, &WINDOWS)?;
    let printed = text.replace("@media screen", "@media not all").replace("@media print", "@media all");
    load_with(browser, page, &printed, Some("paper.js"), &[SHEET])
}

/// Loads a copy of a page, with its script and that of every page.
fn load_with(browser: &Path, page: &Page, copy: &str, script: Option<&str>, windows: &[&str]) -> Result<(), Failure> {
    let path = &page.path;
    let failed = |error: std::io::Error| format!("{}: {error}", path.display());
    let mut text = copy.to_owned();
    for name in script.into_iter().chain(["every.js"]) {
        let script = fs::read_to_string(places::root().join("tests/pages").join(name)).map_err(failed)?;
        text.push_str(&format!("<script>\n{script}</script>\n"));
    }
    let checked = path.with_file_name("checked.html");
    fs::write(&checked, text).map_err(failed)?;
    for window in windows {
        let mut command = Machine::here().command(browser);
        command.args(OPTIONS).arg(format!("--window-size={window}")).arg(format!("file://{}", checked.display()));
        let output = command.output().map_err(|error| format!("{}: {error}", browser.display()))?;
        let [page, said] = [&output.stdout, &output.stderr].map(|bytes| String::from_utf8_lossy(bytes));
        if let Some(line) = said.lines().find(|line| line.contains("CONSOLE")) {
            return Err(format!("{}, window {window}: {line}", path.display()));
        }
        if !page.contains("data-checked=\"yes\"") {
            let why = said.lines().last().unwrap_or("no word");
            return Err(format!("{}, window {window}: the browser did not come to its end: {why}", path.display()));
        }
    }
    Ok(())
}
