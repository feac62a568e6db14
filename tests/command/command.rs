//! The built command and a run of it.

use serde_json::Value;
use std::path::Path;
use std::process::{Command, Output, Stdio};

/// How a run ended and what it said.
#[derive(Debug)]
pub struct Run {
    /// Exit code; `None` when a signal ended it.
    pub code: Option<i32>,
    pub stdout: String,
    pub stderr: String,
}

impl From<Output> for Run {
    fn from(output: Output) -> Self {
        let text = |bytes: Vec<u8>| String::from_utf8(bytes).expect("the command writes UTF-8");
        Run { code: output.status.code(), stdout: text(output.stdout), stderr: text(output.stderr) }
    }
}

impl Run {
    /// This run, which has to have ended well.
    pub fn done(self) -> Self {
        assert_eq!(self.code, Some(0), "{self:?}");
        self
    }

    /// The one JSON document that stdout holds, and nothing else: one line, closed by a line feed.
    pub fn json(self) -> Value {
        let run = self.done();
        let document = serde_json::from_str(&run.stdout).unwrap_or_else(|error| panic!("{error}: {run:?}"));
        assert_eq!(run.stdout.trim_end_matches('\n').len() + 1, run.stdout.len(), "white space around: {run:?}");
        document
    }
}

/// The command with `arguments`, separated by blanks, in `folder`. No file name in these tests holds a blank.
pub fn plumbline(folder: &Path, arguments: &str) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_plumbline"));
    command.args(arguments.split_whitespace()).current_dir(folder).stdin(Stdio::null());
    command
}
