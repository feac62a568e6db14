//! `plumbline`: simulated flights of the firmware, and its algorithms on single pictures.

mod cli;

use clap::Parser;
use clap::error::ErrorKind;
use std::process::ExitCode;

fn main() -> ExitCode {
    let command = match cli::Cli::try_parse() {
        Ok(command) => command,
        Err(error) if matches!(error.kind(), ErrorKind::DisplayHelp | ErrorKind::DisplayVersion) => {
            // A closed pipe while help is printed is not worth a word.
            let _ = error.print();
            return ExitCode::SUCCESS;
        }
        Err(error) => {
            cli::note(&cli::one_sentence(&error));
            return ExitCode::from(2);
        }
    };
    match cli::run(command) {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            cli::note(&failure.to_string());
            ExitCode::from(failure.code())
        }
    }
}
