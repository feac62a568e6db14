//! OpenCV's part: the script `tests/timing/compare.py`, given frames and matrices by files in a folder.

use super::view::View;
use super::{Failure, Grey};
use serde_json::{Value, json};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// The script and where files are handed over.
#[derive(Clone, Debug)]
pub struct Script {
    /// The interpreter.
    pub python: PathBuf,
    /// The script.
    pub script: PathBuf,
    /// An existing folder; what it holds under our names is replaced.
    pub folder: PathBuf,
}

/// A frame to be rectified.
#[derive(Clone, Copy, Debug)]
pub struct Task<'a> {
    /// Pixels.
    pub frame: &'a Grey,
    /// Geometry.
    pub view: &'a View,
    /// How long each kernel is repeated, seconds; 0: once.
    pub seconds: f64,
}

/// What came back.
#[derive(Clone, Debug, PartialEq)]
pub struct Answer {
    /// OpenCV's version.
    pub version: String,
    /// Whether a warp with INTER_AREA gave the very pixels of INTER_LINEAR, for every task.
    pub area_is_linear: bool,
    /// Names of the kernels; the first is the rival to be beaten.
    pub kernels: Vec<String>,
    /// A patch a kernel, task by task.
    pub patches: Vec<Vec<Vec<u8>>>,
    /// Shortest time of each, seconds.
    pub seconds: Vec<Vec<f64>>,
}

/// Size of the picture that is warped before INTER_AREA reduces it: as many pixels as the patch spans in the frame, at
/// most the frame's own size, at least the cells.
fn full_size(view: &View) -> [u16; 2] {
    let side = |cells: u16, frame: u16| {
        let spanned = (f64::from(cells) * f64::from(view.ratio())).round() as u16;
        spanned.min(frame).max(cells)
    };
    let ((cols, rows), frame) = (view.ground().cells, view.frame_size());
    [side(cols, frame.0), side(rows, frame.1)]
}

impl Script {
    /// Does all tasks, one thread.
    ///
    /// # Errors
    /// A sentence where files or the script fail.
    pub fn run(&self, tasks: &[Task<'_>]) -> Result<Answer, Failure> {
        let mut jobs = Vec::new();
        for (i, task) in tasks.iter().enumerate() {
            let name = format!("frame-{i}.raw");
            self.write(&name, &task.frame.pixels)?;
            jobs.push(json!({
                "frame": name,
                "frame_size": [task.frame.size.0, task.frame.size.1],
                "cells": [task.view.ground().cells.0, task.view.ground().cells.1],
                "full": full_size(task.view),
                "frame_from_patch": task.view.frame_from_patch(),
                "patch": format!("opencv-{i}"),
                "seconds": task.seconds,
            }));
        }
        self.write("tasks.json", json!(jobs).to_string().as_bytes())?;
        let mut command = Command::new(&self.python);
        command.arg(&self.script).arg(&self.folder).stdin(Stdio::null()).stdout(Stdio::null());
        let status = command.status().map_err(|error| format!("{}: {error}", self.python.display()))?;
        if !status.success() {
            return Err(format!("{} ended with {status}", self.script.display()));
        }
        let told = String::from_utf8_lossy(&self.read("answer.json")?).into_owned();
        let told: Value = serde_json::from_str(&told).map_err(|error| format!("answer.json is no JSON: {error}"))?;
        self.answer(&told, tasks).ok_or_else(|| "answer.json or a patch beside it is not as agreed".into())
    }

    /// Leaves numbers in the folder, little-endian, NaN where there is none.
    ///
    /// # Errors
    /// A sentence where they cannot be written.
    pub fn keep(&self, name: &str, values: &[Option<f64>]) -> Result<(), Failure> {
        let bytes: Vec<u8> = values.iter().flat_map(|value| value.unwrap_or(f64::NAN).to_le_bytes()).collect();
        self.write(name, &bytes)
    }

    fn answer(&self, told: &Value, tasks: &[Task<'_>]) -> Option<Answer> {
        let kernels = told["kernels"].as_array()?.iter().map(|name| name.as_str().map(str::to_owned));
        let kernels: Vec<String> = kernels.collect::<Option<_>>()?;
        let numbers = |row: &Value| -> Option<Vec<f64>> { row.as_array()?.iter().map(Value::as_f64).collect() };
        let seconds: Vec<Vec<f64>> = told["seconds"].as_array()?.iter().map(numbers).collect::<Option<_>>()?;
        let mut patches = Vec::new();
        for (i, task) in tasks.iter().enumerate() {
            let area = usize::from(task.view.ground().cells.0) * usize::from(task.view.ground().cells.1);
            let patch = |k: usize| self.read(&format!("opencv-{i}-{k}.raw")).ok().filter(|patch| patch.len() == area);
            patches.push((0..kernels.len()).map(patch).collect::<Option<Vec<_>>>()?);
        }
        let fits = seconds.len() == tasks.len() && seconds.iter().all(|row| row.len() == kernels.len());
        let version = told["version"].as_str()?.to_owned();
        let area_is_linear = told["area_is_linear"].as_bool()?;
        (fits && !kernels.is_empty()).then_some(Answer { version, area_is_linear, kernels, patches, seconds })
    }

    fn write(&self, name: &str, bytes: &[u8]) -> Result<(), Failure> {
        let path = self.folder.join(name);
        fs::write(&path, bytes).map_err(|error| describe(&path, &error))
    }

    fn read(&self, name: &str) -> Result<Vec<u8>, Failure> {
        let path = self.folder.join(name);
        fs::read(&path).map_err(|error| describe(&path, &error))
    }
}

fn describe(path: &Path, error: &std::io::Error) -> Failure {
    format!("{}: {error}", path.display())
}
