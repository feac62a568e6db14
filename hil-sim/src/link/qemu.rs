//! The image in QEMU's `mps2-an500`, a Cortex-M7, step by step.
//!
//! The emulator maps the board's PSRAM onto a file that this process maps too: registers, stores and frames
//! travel through it, see [`plumbline_firmware::shared_memory`]. MAVLink goes over one serial port, the knocks of the lockstep
//! over another. Emulated time is a function of the instructions executed, so counts repeat.

use super::line::of_socket;
use super::{Account, Event, Flash, Link, LinkError};
use memmap2::MmapMut;
use plumbline_firmware::serial::message::Counts;
use plumbline_firmware::shared_memory as at;
use plumbline_survey::error::InputError;
use std::ffi::OsString;
use std::io::{ErrorKind, Read, Write};
use std::os::unix::net::{UnixListener, UnixStream};
use std::os::unix::process::CommandExt;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

/// The emulator.
const PROGRAM: &str = "qemu-system-arm";
/// The sensor's row time, nanoseconds: 31.7 µs, the MT9V034's at 752 columns.
const ROW_TIME_NS: u32 = 31_700;
/// Rows a front end keeps before the oldest is overwritten.
const RING_ROWS: u32 = 24;
/// How long the emulator may take to boot or to do a step, real time. A frame takes tens of milliseconds.
const STEP_TIMEOUT: Duration = Duration::from_secs(60);

/// A running emulator. Stopped when dropped.
#[derive(Debug)]
pub struct Qemu {
    process: Child,
    window: MmapMut,
    link: UnixStream,
    doorbell: UnixStream,
    step: u32,
    sent_total: u32,
}

/// Where `cargo xtask build` puts the image.
pub fn default_image() -> PathBuf {
    target().join("thumbv7em-none-eabihf").join("firmware").join("an500")
}

/// The emulator: the one that `cargo xtask` has unpacked for this workspace, else the command on the search path. On Linux
/// it ends with the thread that starts it, however that ends.
pub fn emulator() -> Command {
    let private = target().join("tools").join("bin").join(PROGRAM);
    let mut command = Command::new(if private.is_file() { private } else { PROGRAM.into() });
    #[cfg(target_os = "linux")]
    end_with_this_thread(&mut command);
    command
}

#[cfg(target_os = "linux")]
fn end_with_this_thread(command: &mut Command) {
    use rustix::process::{Signal, getpid, getppid, set_parent_process_death_signal};
    let us = getpid();
    let before_it_starts = move || {
        set_parent_process_death_signal(Some(Signal::KILL))?;
        // We may have ended before that took effect.
        if getppid() == Some(us) { Ok(()) } else { Err(ErrorKind::Interrupted.into()) }
    };
    // SAFETY: between fork and exec it makes system calls and nothing else: no memory is allocated, no lock taken.
    unsafe { command.pre_exec(before_it_starts) };
}

/// Cargo's target folder.
fn target() -> PathBuf {
    std::env::var_os("CARGO_TARGET_DIR")
        .map_or_else(|| Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join("target"), PathBuf::from)
}

impl Qemu {
    /// Starts `image` with what lies in its flash.
    ///
    /// # Errors
    /// [`LinkError::Input`] for a missing image or emulator and for a configuration that the firmware refuses.
    pub fn launch(flash: &Flash, image: &Path) -> Result<Self, LinkError> {
        let (cols, rows) = flash.configuration.frame;
        if usize::from(cols) * usize::from(rows) > at::AREA_MAX {
            return Err(LinkError::Input(InputError::new(format!(
                "frames of {cols} x {rows} pixels do not fit the emulated board, which takes {} at most",
                at::AREA_MAX
            ))));
        }
        if !image.is_file() {
            return Err(LinkError::Input(InputError::new(format!(
                "there is no firmware image at {}: build it with `cargo xtask build`",
                image.display()
            ))));
        }
        is_arm_executable(image)?;
        let folder = scratch_folder()?;
        let prepared = prepare(&folder, flash);
        let booted = prepared.and_then(|(window, sockets)| {
            let mut qemu = start(image, &folder, window, sockets)?;
            qemu.boot().map(|status| (qemu, status))
        });
        // Both sides hold what they need of it open, so that nothing is left even by a process that is killed. Leaving it
        // behind is not worth an error.
        let _ = std::fs::remove_dir_all(&folder);
        match booted? {
            (qemu, 1) => Ok(qemu),
            (_, status) => Err(LinkError::Input(InputError::new(format!(
                "the firmware refuses what lies in flash (status {status:#x})"
            )))),
        }
    }

    /// Waits until the firmware has read its flash; its verdict. The capture timer does not run yet.
    fn boot(&mut self) -> Result<u32, LinkError> {
        let started = Instant::now();
        loop {
            match self.word(at::STATUS) {
                0 => std::thread::sleep(Duration::from_millis(1)),
                status => return Ok(status),
            }
            if let Ok(Some(_)) = self.process.try_wait() {
                return Err(self.ended());
            }
            if started.elapsed() > STEP_TIMEOUT {
                return Err(LinkError::Lost("the firmware did not boot".to_owned()));
            }
        }
    }

    fn word(&self, offset: usize) -> u32 {
        // SAFETY: an aligned word of the mapping; the emulator may write it meanwhile, hence volatile.
        u32::from_le(unsafe { self.window.as_ptr().add(offset).cast::<u32>().read_volatile() })
    }

    fn set(&mut self, offset: usize, value: u32) {
        self.window[offset..offset + 4].copy_from_slice(&value.to_le_bytes());
    }

    /// Rings and waits for the answer; what the firmware sent meanwhile.
    fn knock(&mut self) -> Result<Vec<u8>, LinkError> {
        self.step = self.step.wrapping_add(1);
        self.set(at::STEP, self.step);
        self.doorbell.write_all(b"!").map_err(|error| self.lost("cannot ring", &error))?;
        let started = Instant::now();
        let mut sent = Vec::new();
        let mut answer = [0; 1];
        loop {
            match self.doorbell.read(&mut answer) {
                Ok(1) => break,
                Ok(_) => return Err(self.ended()),
                Err(error) if matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut) => {}
                Err(error) => return Err(self.lost("no answer", &error)),
            }
            // The firmware may be waiting for room to send.
            self.drain(&mut sent)?;
            if started.elapsed() > STEP_TIMEOUT {
                return Err(LinkError::Lost(format!("no answer for {} s", STEP_TIMEOUT.as_secs())));
            }
        }
        self.drain(&mut sent)?;
        if self.word(at::STEP_DONE) != self.step {
            return Err(LinkError::Lost("an answer to another step".to_owned()));
        }
        Ok(sent)
    }

    /// Takes what is there, without waiting.
    fn drain(&mut self, sent: &mut Vec<u8>) -> Result<(), LinkError> {
        let mut buffer = [0; 4096];
        loop {
            match self.link.read(&mut buffer) {
                Ok(0) => return Err(self.ended()),
                Ok(count) => sent.extend_from_slice(&buffer[..count]),
                Err(error) if error.kind() == ErrorKind::WouldBlock => return Ok(()),
                Err(error) => return Err(self.lost("cannot receive", &error)),
            }
        }
    }

    fn lost(&self, what: &str, error: &std::io::Error) -> LinkError {
        LinkError::Lost(format!("{what}: {error}"))
    }

    fn ended(&mut self) -> LinkError {
        match self.process.try_wait() {
            Ok(Some(status)) => LinkError::Lost(format!("the emulator ended with {status}")),
            _ => LinkError::Lost("the emulator closed its serial port".to_owned()),
        }
    }
}

impl Link for Qemu {
    fn step(&mut self, timer: u32, event: Event<'_>) -> Result<Vec<u8>, LinkError> {
        self.set(at::TIMER, timer);
        match event {
            Event::Nothing => {}
            Event::Bytes(bytes) => {
                self.sent_total = self.sent_total.wrapping_add(bytes.len() as u32);
                self.set(at::RECEIVED_TOTAL, self.sent_total);
                let mut rest = bytes;
                while !rest.is_empty() {
                    match self.link.write(rest) {
                        Ok(count) => rest = &rest[count..],
                        Err(error) if error.kind() == ErrorKind::WouldBlock => std::thread::yield_now(),
                        Err(error) => return Err(self.lost("cannot send", &error)),
                    }
                }
            }
            Event::Pulse(tick) => {
                self.set(at::PULSE_TICK, tick);
                self.set(at::PULSES, self.word(at::PULSES).wrapping_add(1));
            }
            Event::Edge { tick, rising } => {
                let number = self.word(at::EDGES);
                let place = at::EDGE_WORDS + number as usize % at::EDGE_RING * 8;
                self.set(place, tick);
                self.set(place + 4, rising.into());
                self.set(at::EDGES, number.wrapping_add(1));
            }
            Event::Frame(frame) => {
                self.window[at::FRAME..at::FRAME + frame.pixels.len()].copy_from_slice(frame.pixels);
                self.set(at::FRAME_SEQUENCE, frame.sequence);
                self.set(at::FRAME_ARRIVAL, frame.arrival);
                self.set(at::FRAME_COLS, frame.size.0.into());
                self.set(at::FRAME_ROWS, frame.size.1.into());
                self.set(at::FRAMES, self.word(at::FRAMES).wrapping_add(1));
            }
        }
        self.knock()
    }

    fn account(&self) -> Account {
        Account { counts: Counts::Instructions, ..Account::default() }
    }
}

impl Drop for Qemu {
    fn drop(&mut self) {
        // The process may have ended by itself; nothing is to be done about a failure here.
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

/// # Errors
/// One sentence where `image` is no ELF file for 32 bit ARM: the emulator would load anything and dump its registers.
fn is_arm_executable(image: &Path) -> Result<(), InputError> {
    let mut head = [0; 20];
    let read = std::fs::File::open(image).and_then(|mut file| file.read_exact(&mut head));
    // Magic, 32 bit, little end first; the machine is the half word at 18.
    let sound = read.is_ok() && head.starts_with(&[0x7f, b'E', b'L', b'F', 1, 1]) && head[18..] == [40, 0];
    if sound { Ok(()) } else { Err(InputError::new(format!("{} is no ARM firmware image (ELF)", image.display()))) }
}

/// A folder of this flight's own.
fn scratch_folder() -> Result<PathBuf, LinkError> {
    for attempt in 0..1000 {
        let folder = std::env::temp_dir().join(format!("plumbline-{}-{attempt}", std::process::id()));
        match std::fs::create_dir(&folder) {
            Ok(()) => return Ok(folder),
            Err(error) if error.kind() == ErrorKind::AlreadyExists => {}
            Err(error) => {
                return Err(LinkError::Input(InputError::new(format!(
                    "cannot create {} for the emulator's window: {error}",
                    folder.display()
                ))));
            }
        }
    }
    Err(LinkError::Lost("no free scratch folder".to_owned()))
}

type Sockets = (UnixListener, UnixListener);

/// The window, filled, and the sockets that the emulator will connect to.
fn prepare(folder: &Path, flash: &Flash) -> Result<(MmapMut, Sockets), LinkError> {
    let lost = |error: std::io::Error| LinkError::Lost(format!("cannot prepare the emulator's window: {error}"));
    let file =
        std::fs::File::options().read(true).write(true).create_new(true).open(folder.join("window")).map_err(lost)?;
    file.set_len(at::SIZE as u64).map_err(lost)?;
    // SAFETY: the file is this flight's own; the emulator, which maps it too, and this process take turns, as the
    // lockstep has it.
    let mut window = unsafe { MmapMut::map_mut(&file) }.map_err(lost)?;
    let stores = flash.stores()?;
    if stores.tiles.len() > at::TILES_BYTES {
        return Err(LinkError::Input(InputError::new("the reference does not fit the emulated board's flash")));
    }
    if stores.plan.len() > at::PLAN_BYTES {
        return Err(LinkError::Input(InputError::new("the plan does not fit the emulated board's flash")));
    }
    let mut put = |offset: usize, bytes: &[u8]| window[offset..offset + bytes.len()].copy_from_slice(bytes);
    put(at::MAGIC, &at::MAGIC_VALUE.to_le_bytes());
    put(at::ROW_TIME_NS, &ROW_TIME_NS.to_le_bytes());
    put(at::RING_ROWS, &RING_ROWS.to_le_bytes());
    put(at::CONFIGURATION, &stores.configuration);
    put(at::TILES, &stores.tiles);
    put(at::PLAN, &stores.plan);
    put(at::KEY, &stores.key);
    let listen = |name: &str| of_socket(&folder.join(name)).and_then(UnixListener::bind).map_err(lost);
    Ok((window, (listen("link")?, listen("doorbell")?)))
}

fn start(image: &Path, folder: &Path, window: MmapMut, sockets: Sockets) -> Result<Qemu, LinkError> {
    let path = |prefix: &str, name: &str| {
        let mut argument = OsString::from(prefix);
        argument.push(folder.join(name));
        argument
    };
    let process = emulator()
        .args(["-M", "mps2-an500,memory-backend=window", "-object"])
        .arg(path("memory-backend-file,id=window,size=16M,share=on,mem-path=", "window"))
        .args(["-icount", "shift=1,sleep=off", "-nodefaults", "-display", "none", "-monitor", "none"])
        .args(["-semihosting-config", "enable=on,target=native", "-kernel"])
        .arg(image)
        .arg("-serial")
        .arg(path("unix:", "link"))
        .arg("-serial")
        .arg(path("unix:", "doorbell"))
        // An interrupt at the terminal is the flight's to handle, which then still needs its firmware.
        .process_group(0)
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        // Its warnings concern devices that nobody asked for.
        .stderr(Stdio::null())
        .spawn()
        .map_err(|error| {
            LinkError::Input(InputError::new(format!(
                "{PROGRAM} cannot be started ({error}): `cargo xtask build` unpacks one"
            )))
        })?;
    let mut guard = Started(Some(process));
    let link = accept(&sockets.0, &mut guard)?;
    let doorbell = accept(&sockets.1, &mut guard)?;
    let lost = |error: std::io::Error| LinkError::Lost(format!("the emulator's serial port: {error}"));
    link.set_nonblocking(true).map_err(lost)?;
    doorbell.set_read_timeout(Some(Duration::from_millis(2))).map_err(lost)?;
    let process = guard.0.take().ok_or_else(|| LinkError::Lost("the emulator is gone".to_owned()))?;
    Ok(Qemu { process, window, link, doorbell, step: 0, sent_total: 0 })
}

/// A process that is killed if nobody takes it over.
struct Started(Option<Child>);

impl Drop for Started {
    fn drop(&mut self) {
        if let Some(process) = &mut self.0 {
            let _ = process.kill();
            let _ = process.wait();
        }
    }
}

/// Waits for the emulator to connect, or to end.
fn accept(listener: &UnixListener, guard: &mut Started) -> Result<UnixStream, LinkError> {
    let lost = |error: std::io::Error| LinkError::Lost(format!("the emulator did not connect: {error}"));
    listener.set_nonblocking(true).map_err(lost)?;
    let started = Instant::now();
    loop {
        match listener.accept() {
            Ok((stream, _)) => {
                stream.set_nonblocking(false).map_err(lost)?;
                return Ok(stream);
            }
            Err(error) if error.kind() == ErrorKind::WouldBlock => std::thread::sleep(Duration::from_millis(2)),
            Err(error) => return Err(lost(error)),
        }
        let ended = guard.0.as_mut().and_then(|process| process.try_wait().ok().flatten());
        if let Some(status) = ended {
            return Err(LinkError::Lost(format!("the emulator ended with {status} before it connected")));
        }
        if started.elapsed() > STEP_TIMEOUT {
            return Err(LinkError::Lost("the emulator did not connect".to_owned()));
        }
    }
}
