//! `plumbline`: simulated flights of the firmware, and its algorithms on single pictures.

mod dump;
mod files;
mod interrupt;
mod outcome;
mod pages;
mod progress;
mod recording;
mod smoothing;
mod verbs;

use clap::Parser;
use clap::error::ErrorKind;
use std::process::ExitCode;

fn main() -> ExitCode {
    let command = match verbs::Cli::try_parse() {
        Ok(command) => command,
        Err(error) if matches!(error.kind(), ErrorKind::DisplayHelp | ErrorKind::DisplayVersion) => {
            // A closed pipe while help is printed is not worth a word.
            let _ = error.print();
            return ExitCode::SUCCESS;
        }
        // Without a verb: what there is.
        Err(error) if error.kind() == ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand => {
            let _ = error.print();
            return ExitCode::from(2);
        }
        Err(error) => {
            outcome::note(&verbs::one_sentence(&error));
            return ExitCode::from(2);
        }
    };
    verbs::run(command).and_then(outcome::Outcome::end).unwrap_or_else(|failure| {
        outcome::note(&failure.to_string());
        failure.code()
    })
}
