//! Readers that have gone: a closed pipe is a quiet end, anything else that stops stdout a failure. Never a panic.

use crate::bad_options::{MAP, MATCH, RECTIFY};
use crate::command::{Run, plumbline};
use crate::folder::{Folder, with};
use std::io::pipe;
use std::process::Stdio;

/// The writing end of a pipe that nobody reads.
fn closed() -> Stdio {
    let (reader, writer) = pipe().expect("a pipe");
    drop(reader);
    writer.into()
}

fn run(folder: &Folder, arguments: &str, stdout: Stdio, stderr: Stdio) -> Run {
    let child = plumbline(&folder.path(""), arguments).stdout(stdout).stderr(stderr).spawn().expect("it starts");
    child.wait_with_output().expect("it ends").into()
}

#[test]
fn nobody_reads_stdout() {
    let folder = Folder::with_scene("closed-stdout");
    let quiet = |json: &str| json.replace(" --json", "");
    let many: Vec<String> = (0..2000).map(|point| format!("{point},0.5")).collect();
    for arguments in [
        MAP,
        &MAP.replace("10,20", &many.join(" ")),
        &format!("{} --oracle -- 1,2", MAP.split(" -- ").next().expect("options")),
        MATCH,
        &quiet(MATCH),
        RECTIFY,
        "fly --frames 1",
        "fly --frames 1 --out out --json",
        "help",
        "--version",
    ] {
        let run = run(&folder, arguments, closed(), Stdio::piped());
        let shown = &arguments[..arguments.len().min(80)];
        assert_eq!(run.code, Some(0), "{shown}: {run:?}");
        assert_eq!(run.stderr, "", "{shown}");
    }
    // What was asked for is written all the same.
    assert!(folder.path("out.png").is_file() && folder.path("out/report.json").is_file());
}

/// A full disk is no closed pipe: what was asked for did not come out.
#[test]
#[cfg(target_os = "linux")]
fn stdout_is_full() {
    let folder = Folder::with_scene("full-stdout");
    for arguments in [MAP, MATCH, &MATCH.replace(" --json", ""), RECTIFY, "fly --frames 1", "fly --frames 1 --json"] {
        let full = std::fs::OpenOptions::new().write(true).open("/dev/full").expect("Linux has it");
        let run = run(&folder, arguments, full.into(), Stdio::piped());
        assert_eq!(run.code, Some(1), "{arguments}: {run:?}");
        assert!(run.stderr.lines().count() == 1 && run.stderr.contains("stdout"), "{arguments}: {run:?}");
    }
}

/// Nobody hears the sentence either; the exit code still tells.
#[test]
fn nobody_reads_stderr() {
    let folder = Folder::with_scene("closed-stderr");
    for (arguments, code) in [
        (RECTIFY.replace(" --json", ""), 0),
        (with(RECTIFY, "--frame", "none.png"), 2),
        (with(RECTIFY, "--height-m", "0"), 2),
        ("fly --frames 0".to_owned(), 2),
    ] {
        let run = run(&folder, &arguments, Stdio::piped(), closed());
        assert_eq!(run.code, Some(code), "{arguments}: {run:?}");
    }
}
