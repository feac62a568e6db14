//! `plumbline serve`: a host process that acts as a board.

use crate::outcome::{Failure, Outcome, print};
use plumbline_sim::link::device::Device;
use plumbline_survey::error::InputError;
use std::path::PathBuf;

#[derive(Debug, clap::Args)]
#[group(required = true, multiple = false)]
pub struct Args {
    /// Serve on a UNIX socket made at PATH
    #[arg(long, value_name = "PATH")]
    socket: Option<PathBuf>,
    /// Serve on a pseudo-terminal, whose name is printed
    #[arg(long)]
    pty: bool,
}

pub fn run(args: &Args) -> Result<Outcome, Failure> {
    let device = match &args.socket {
        Some(path) => Device::socket(path)
            .map_err(|error| InputError::new(format!("--socket {}: cannot be made ({error})", path.display())))?,
        None => Device::terminal()
            .map_err(|error| Failure::Work(format!("this system has no pseudo-terminal to spare: {error}")))?,
    };
    print(&format!("plumbline fly --link serial:{}\n", device.path().display()))?;
    device.wait();
    Ok(Outcome::default())
}
