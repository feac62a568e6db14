//! `plumbline serve`: a host process that acts as a board.

use crate::files::Files;
use crate::interrupt;
use crate::outcome::{Failure, Outcome, note, print};
use clap::ArgGroup;
use plumbline_firmware::boot::BootError;
use plumbline_firmware::stores::StoreError;
use plumbline_sim::link::Stores;
use plumbline_sim::link::device::Device;
use plumbline_sim::link::inproc::InProcess;
use plumbline_sim::live::connection::{Door, End, Waiting};
use plumbline_sim::live::desk::{Sitter, sit};
use plumbline_survey::error::InputError;
use plumbline_survey::io::input;
use std::io;
use std::os::unix::fs::FileTypeExt;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

#[derive(Debug, clap::Args)]
#[group(skip)]
#[command(group = ArgGroup::new("where").required(true).args(["socket", "pty", "mavlink"]))]
pub struct Args {
    /// Serve on a UNIX socket made at PATH
    #[arg(long, value_name = "PATH")]
    socket: Option<PathBuf>,
    /// Serve on a pseudo-terminal, whose name is printed
    #[arg(long)]
    pty: bool,
    /// Be the companion of an autopilot, with no camera, at tcp:HOST:PORT
    ///
    /// In real time and with the stores of a board: it asks for its streams, reads the autopilot's parameters and prints, with
    /// the seconds, each line that it has for the pilot. Where somebody listens it connects, else it listens itself; a
    /// connection that closes is waited for again.
    #[arg(long, value_name = "END", requires_all = ["configuration", "tiles"])]
    mavlink: Option<End>,
    /// Configuration store, for --mavlink
    #[arg(long, value_name = "FILE", requires = "mavlink")]
    configuration: Option<PathBuf>,
    /// Reference tile, for --mavlink
    #[arg(long, value_name = "FILE", requires = "mavlink")]
    tiles: Option<PathBuf>,
    /// Key store, for --mavlink; messages are not signed unless given
    #[arg(long, value_name = "FILE", requires = "mavlink")]
    key: Option<PathBuf>,
}

pub fn run(args: &Args) -> Result<Outcome, Failure> {
    if let Some(end) = &args.mavlink {
        return companion(args, end);
    }
    let device = match &args.socket {
        Some(path) => Device::socket(path).map_err(|error| InputError::new(no_socket(path, &error)))?,
        None => Device::terminal()
            .map_err(|error| Failure::Work(format!("this system has no pseudo-terminal to spare: {error}")))?,
    };
    print(&format!("plumbline fly --link serial:{}\n", device.path().display()))?;
    device.wait();
    Ok(Outcome::default())
}

/// Why there is no socket at a path.
fn no_socket(path: &Path, error: &io::Error) -> String {
    let why = match path.symlink_metadata() {
        Ok(about) if about.file_type().is_socket() => "somebody serves there already; name another".to_owned(),
        Ok(about) if about.is_dir() => "it is a folder; name a socket in it".to_owned(),
        Ok(_) => "there is a file of that name, which is left alone; name another".to_owned(),
        Err(_) if error.kind() == io::ErrorKind::InvalidFilename => error.to_string(),
        Err(_) => format!("cannot be made ({error})"),
    };
    format!("--socket {}: {why}", path.display())
}

/// Talks to an autopilot until it is interrupted.
fn companion(args: &Args, end: &End) -> Result<Outcome, Failure> {
    let stores = [("--configuration", &args.configuration), ("--tiles", &args.tiles), ("--key", &args.key)];
    let files = stores.iter().fold(Files::default(), |files, (option, path)| files.may_read(option, path.as_ref()));
    files.check()?;
    let [configuration, tiles, key] = stores.map(|(_, path)| path.as_deref().map_or(Ok(Vec::new()), input::bytes));
    let stores = Stores { configuration: configuration?, tiles: tiles?, plan: Vec::new(), key: key? };
    stores.check().map_err(|error| refused(args, error))?;
    let mut link = InProcess::boot(&stores, false);
    let mut desk = Desk { interrupted: interrupt::listen()? };
    sit(&mut link, Door::new("--mavlink", end.clone()), &mut desk)?;
    Ok(Outcome::default())
}

/// Which file is refused, what it is not or what is wrong with it, and what writes a right one.
fn refused(args: &Args, error: BootError) -> InputError {
    let (option, path, kind, writer) = match error {
        BootError::Configuration(_) => {
            ("--configuration", &args.configuration, "configuration store", "configuration --camera CAMERA --out FILE")
        }
        BootError::Tiles(_) | BootError::Misfit => {
            ("--tiles", &args.tiles, "tile store", "tiles --ortho ORTHO --resolution-m M --out FILE")
        }
        BootError::Key(_) => ("--key", &args.key, "key store", "configuration --signing-key KEY --out FILE"),
        // Nothing of what was given: there is no plan, and memory as on a board.
        BootError::Plan(_) | BootError::Astray | BootError::FrameMemory => return InputError::new(error.to_string()),
    };
    let path = path.as_deref().unwrap_or(Path::new("")).display();
    let why = match error {
        BootError::Configuration(why) | BootError::Tiles(why) | BootError::Key(why) => match why {
            StoreError::Nothing | StoreError::Magic => format!("is no {kind}"),
            why => format!("is a {kind} that the firmware refuses: {}", why.words()),
        },
        error => format!("is a {kind} that the firmware refuses: {}", error.words()[1]),
    };
    InputError::new(format!("{option} {path} {why}; plumbline {writer} writes a right one"))
}

/// Prints what is said.
struct Desk {
    interrupted: Arc<AtomicBool>,
}

impl Waiting for Desk {
    fn waits(&mut self, what: &str) {
        note(&format!("plumbline: {what}"));
    }

    fn is_interrupted(&self) -> bool {
        self.interrupted.load(Ordering::Relaxed)
    }
}

impl Sitter for Desk {
    fn hears(&mut self, at_s: f64, line: &str) {
        // Nobody reads any more: it goes on for the autopilot's sake.
        let _ = print(&format!("{at_s:8.1} s  {line}\n"));
    }
}
