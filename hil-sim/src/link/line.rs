//! A line of bytes: a serial port, a pseudo-terminal or a UNIX socket. No wait on it is without an end.

use plumbline_survey::error::InputError;
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::fs::{OFlags, fcntl_getfl, fcntl_setfl};
use rustix::termios::{OptionalActions, isatty, tcgetattr, tcsetattr};
use std::fs::File;
use std::io::{self, ErrorKind, Read, Write};
use std::os::fd::{AsFd, BorrowedFd, OwnedFd};
use std::os::unix::fs::{FileTypeExt, OpenOptionsExt};
use std::os::unix::net::UnixStream;
use std::path::Path;
use std::time::{Duration, Instant};

/// Rate of a serial port, bits a second; USB and pseudo-terminals do not care.
pub const BAUD: u32 = 921_600;

/// Bytes of a socket's name that the system takes, beside the zero that ends it.
const NAME_MAX_BYTES: usize = 107;

/// An open line.
#[derive(Debug)]
pub struct Line {
    file: File,
}

impl Line {
    /// Opens `path`.
    ///
    /// # Errors
    /// One sentence that says why it is no line.
    pub fn open(path: &Path) -> Result<Self, InputError> {
        let refuse = |why: String| InputError::new(format!("--link serial:{}: {why}", path.display()));
        let kind = std::fs::metadata(path).map_err(|error| refuse(sentence(&error)))?.file_type();
        if kind.is_socket() {
            let stream = of_socket(path).and_then(UnixStream::connect).map_err(|error| {
                refuse(match error.kind() {
                    ErrorKind::ConnectionRefused => "nobody listens on this socket".to_owned(),
                    ErrorKind::InvalidFilename => error.to_string(),
                    _ => sentence(&error),
                })
            })?;
            return Line::new(stream.into()).map_err(|error| refuse(error.to_string()));
        }
        if !kind.is_char_device() {
            return Err(refuse("neither a serial port nor a socket".to_owned()));
        }
        // Non-blocking from the start: a port may wait for a modem's carrier. Not our controlling terminal.
        let flags = (OFlags::NOCTTY | OFlags::NONBLOCK).bits() as i32;
        let file = File::options().read(true).write(true).custom_flags(flags).open(path);
        let file = file.map_err(|error| refuse(sentence(&error)))?;
        if !isatty(&file) {
            return Err(refuse("neither a serial port nor a socket".to_owned()));
        }
        make_raw(&file).map_err(|error| refuse(format!("cannot be set up ({error})")))?;
        Ok(Line { file })
    }

    /// The line of an open descriptor.
    ///
    /// # Errors
    /// One that cannot be set not to block.
    pub fn new(descriptor: OwnedFd) -> io::Result<Self> {
        fcntl_setfl(&descriptor, fcntl_getfl(&descriptor)? | OFlags::NONBLOCK)?;
        Ok(Line { file: descriptor.into() })
    }

    /// Waits at most `patience` for bytes; how many were moved into `buffer`, 0 for none in time.
    ///
    /// # Errors
    /// A line that was unplugged.
    pub fn read(&mut self, buffer: &mut [u8], patience: Duration) -> io::Result<usize> {
        if !wait(&self.file, PollFlags::IN, patience)? {
            return Ok(0);
        }
        match self.file.read(buffer) {
            Ok(0) => Err(ErrorKind::UnexpectedEof.into()),
            Err(error) if matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::Interrupted) => Ok(0),
            other => other,
        }
    }

    /// Writes all of `bytes` within `patience`.
    ///
    /// # Errors
    /// [`ErrorKind::TimedOut`], or a line that was unplugged.
    pub fn write_all(&mut self, bytes: &[u8], patience: Duration) -> io::Result<()> {
        let end = Instant::now() + patience;
        let mut rest = bytes;
        while !rest.is_empty() {
            match self.file.write(rest) {
                Ok(0) => return Err(ErrorKind::WriteZero.into()),
                Ok(count) => rest = rest.get(count..).unwrap_or(&[]),
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                Err(error) if error.kind() == ErrorKind::WouldBlock => {
                    if !wait(&self.file, PollFlags::OUT, end.saturating_duration_since(Instant::now()))? {
                        return Err(ErrorKind::TimedOut.into());
                    }
                }
                Err(error) => return Err(error),
            }
        }
        Ok(())
    }
}

impl AsFd for Line {
    fn as_fd(&self) -> BorrowedFd<'_> {
        self.file.as_fd()
    }
}

/// `path`, if a socket can have it.
pub(super) fn of_socket(path: &Path) -> io::Result<&Path> {
    let bytes = path.as_os_str().len();
    if bytes <= NAME_MAX_BYTES {
        return Ok(path);
    }
    let why = format!(
        "the path has {bytes} bytes, and that of a socket has {NAME_MAX_BYTES} at most; name a shorter one, or one from the folder it is in"
    );
    Err(io::Error::new(ErrorKind::InvalidFilename, why))
}

/// Bytes as they are: no echo, no line editing, eight bits; at [`BAUD`] where there is a rate.
pub(super) fn make_raw(terminal: &impl AsFd) -> io::Result<()> {
    let mut settings = tcgetattr(terminal)?;
    settings.make_raw();
    settings.set_speed(BAUD)?;
    tcsetattr(terminal, OptionalActions::Now, &settings)?;
    Ok(())
}

/// Whether the line is ready, or broken, within `patience`.
fn wait(file: &File, what: PollFlags, patience: Duration) -> io::Result<bool> {
    let timeout = Timespec { tv_sec: patience.as_secs() as i64, tv_nsec: patience.subsec_nanos().into() };
    match poll(&mut [PollFd::new(file, what)], Some(&timeout)) {
        Ok(ready) => Ok(ready > 0),
        Err(rustix::io::Errno::INTR) => Ok(false),
        Err(error) => Err(error.into()),
    }
}

fn sentence(error: &io::Error) -> String {
    match error.kind() {
        ErrorKind::NotFound => "there is no such port or socket".to_owned(),
        ErrorKind::PermissionDenied => "no permission to open it".to_owned(),
        _ => format!("cannot be opened ({error})"),
    }
}
