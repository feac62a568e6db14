//! `plumbline completions`: what a shell needs to complete verbs and options.

use crate::outcome::{Failure, Outcome};
use clap::Command;
use clap_complete::{Shell, generate};

#[derive(Debug, clap::Args)]
pub struct Args {
    /// The shell, as in `plumbline completions bash > ~/.local/share/bash-completion/completions/plumbline`
    #[arg(value_enum)]
    shell: Shell,
}

pub fn run(args: &Args, command: &mut Command) -> Result<Outcome, Failure> {
    let mut script = Vec::new();
    generate(args.shell, command, "plumbline", &mut script);
    let script = String::from_utf8(script).map_err(|error| Failure::Work(error.to_string()))?;
    Outcome::new(false, &(), || script)
}
