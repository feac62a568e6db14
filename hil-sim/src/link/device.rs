//! A host process that acts as a board: the application behind a UNIX socket or a pseudo-terminal, with the boards' own
//! end of the line ([`plumbline_firmware::serial`]). For tests, and for people without a board.

mod host;

use super::line::{Line, make_raw, of_socket};
use host::{Host, power_on};
use plumbline_firmware::board::{Reader, Writer};
use plumbline_firmware::serial::serve::{End, serve};
use plumbline_firmware::serial::session::Session;
use rustix::pty::{OpenptFlags, grantpt, ioctl_tiocgptpeer, openpt, ptsname, unlockpt};
use std::cell::RefCell;
use std::io::{self, ErrorKind};
use std::os::unix::fs::FileTypeExt;
use std::os::unix::net::{UnixListener, UnixStream};
use std::path::{Path, PathBuf};
use std::pin::pin;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use std::task::{Context, Poll, Waker};
use std::thread::JoinHandle;
use std::time::{Duration, SystemTime, UNIX_EPOCH};

/// How often the thread looks whether it is wanted elsewhere.
const GLANCE: Duration = Duration::from_millis(20);
/// How long the other end may refuse bytes.
const WRITE_PATIENCE: Duration = Duration::from_secs(2);

/// A running device. Stopped when dropped.
#[derive(Debug)]
pub struct Device {
    path: PathBuf,
    is_socket: bool,
    wishes: Arc<Wishes>,
    thread: Option<JoinHandle<()>>,
}

/// What is wanted of the thread.
#[derive(Debug, Default)]
struct Wishes {
    stop: AtomicBool,
    reboots: AtomicU32,
}

impl Wishes {
    fn stop(&self) -> bool {
        self.stop.load(Ordering::Acquire)
    }

    /// Whether a reboot is wanted.
    fn reboot(&self) -> bool {
        self.reboots.load(Ordering::Acquire) > 0
    }
}

impl Device {
    /// Listens on a socket that is made at `path`; one line at a time.
    ///
    /// # Errors
    /// A path that cannot be listened on.
    pub fn socket(path: &Path) -> io::Result<Self> {
        let listener = UnixListener::bind(of_socket(path)?).or_else(|error| match UnixStream::connect(path) {
            // Left behind by one that was killed.
            Err(refused) if refused.kind() == ErrorKind::ConnectionRefused && is_socket(path) => {
                std::fs::remove_file(path)?;
                UnixListener::bind(path)
            }
            _ => Err(error),
        })?;
        listener.set_nonblocking(true)?;
        let next = move || match listener.accept() {
            Ok((stream, _)) => Line::new(stream.into()).ok(),
            Err(_) => {
                std::thread::sleep(GLANCE);
                None
            }
        };
        Ok(Device::start(path.to_owned(), true, next))
    }

    /// Makes a pseudo-terminal; [`Device::path`] is its other end.
    ///
    /// # Errors
    /// A system without one to spare.
    pub fn terminal() -> io::Result<Self> {
        let device = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY)?;
        grantpt(&device)?;
        unlockpt(&device)?;
        let name = ptsname(&device, Vec::new())?;
        let path = PathBuf::from(name.to_str().map_err(|_| io::Error::from(ErrorKind::InvalidData))?);
        // Held open, so that a simulator that leaves does not end the line; raw, so that nothing is echoed before one
        // comes.
        let other = ioctl_tiocgptpeer(&device, OpenptFlags::RDWR | OpenptFlags::NOCTTY)?;
        make_raw(&other)?;
        let mut line = Some(Line::new(device)?);
        let next = move || {
            let _held_open = &other;
            let line = line.take();
            if line.is_none() {
                std::thread::sleep(GLANCE);
            }
            line
        };
        Ok(Device::start(path, false, next))
    }

    /// `next` waits a little for a line.
    fn start(path: PathBuf, is_socket: bool, next: impl FnMut() -> Option<Line> + Send + 'static) -> Self {
        let wishes = Arc::new(Wishes::default());
        let theirs = wishes.clone();
        let thread = std::thread::spawn(move || live(next, &theirs));
        Device { path, is_socket, wishes, thread: Some(thread) }
    }

    /// What to give to `--link serial:`.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Has it reboot as if its power had failed.
    pub fn reboot(&self) {
        self.wishes.reboots.fetch_add(1, Ordering::AcqRel);
    }

    /// As above, for somebody who does not hold the device.
    pub fn reset_button(&self) -> impl Fn() + Send + 'static {
        let wishes = self.wishes.clone();
        move || {
            wishes.reboots.fetch_add(1, Ordering::AcqRel);
        }
    }

    /// Waits until it ends, which it does by itself only where its thread dies.
    pub fn wait(mut self) {
        if let Some(thread) = self.thread.take() {
            // A thread that died has said why on stderr.
            let _ = thread.join();
        }
    }
}

impl Drop for Device {
    fn drop(&mut self) {
        self.wishes.stop.store(true, Ordering::Release);
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
        if self.is_socket {
            // It may have been taken away by somebody else.
            let _ = std::fs::remove_file(&self.path);
        }
    }
}

fn is_socket(path: &Path) -> bool {
    std::fs::metadata(path).is_ok_and(|metadata| metadata.file_type().is_socket())
}

/// From power-on to the end.
fn live(mut next: impl FnMut() -> Option<Line>, wishes: &Wishes) {
    // Another number than that of an earlier device on the same path.
    let now = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
    let mut boot = now.as_micros() as u32;
    let mut session = power_on(boot);
    let mut reboot = |session: &mut Session<Host>| {
        boot = boot.wrapping_add(1);
        *session = power_on(boot);
    };
    while !wishes.stop() {
        if wishes.reboots.swap(0, Ordering::AcqRel) > 0 {
            reboot(&mut session);
        }
        let Some(line) = next() else { continue };
        let line = RefCell::new(line);
        while !wishes.stop() {
            let end = finish(serve(&mut session, &mut Plug { line: &line, wishes }, &mut Plug { line: &line, wishes }));
            let is_wanted = wishes.reboots.swap(0, Ordering::AcqRel) > 0;
            if end == End::Reset || is_wanted {
                // The line is still plugged in.
                reboot(&mut session);
            } else {
                break;
            }
        }
    }
}

/// Both ends of the line; they block, so that a future over them never waits.
struct Plug<'l> {
    line: &'l RefCell<Line>,
    wishes: &'l Wishes,
}

impl Reader for Plug<'_> {
    async fn read(&mut self, buffer: &mut [u8]) -> usize {
        while !self.wishes.stop() && !self.wishes.reboot() {
            match self.line.borrow_mut().read(buffer, GLANCE) {
                Ok(0) => {}
                Ok(count) => return count,
                Err(_) => return 0,
            }
        }
        0
    }
}

impl Writer for Plug<'_> {
    async fn write(&mut self, bytes: &[u8]) {
        // A broken line is noticed by the reader, a lost answer by the simulator.
        let _ = self.line.borrow_mut().write_all(bytes, WRITE_PATIENCE);
    }
}

/// Runs a future that never waits.
fn finish<T>(future: impl Future<Output = T>) -> T {
    let mut future = pin!(future);
    loop {
        if let Poll::Ready(value) = future.as_mut().poll(&mut Context::from_waker(Waker::noop())) {
            return value;
        }
    }
}
