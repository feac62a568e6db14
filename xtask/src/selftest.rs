//! The host's half of the emulated board's self-test: shares the window, rings, sends bytes that must come back.

use super::{Failure, places, set_up};
use std::fs::{self, File};
use std::io::{Read, Write};
use std::os::unix::fs::FileExt;
use std::os::unix::net::{UnixListener, UnixStream};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::thread;
use std::time::{Duration, Instant};

/// Offsets and values that `firmware/src/shared_memory.rs` defines.
const WINDOW_BYTES: u64 = 16 << 20;
const MAGIC: u64 = 0x00;
const MAGIC_VALUE: u32 = 0x3342_4c50;
const STEP: u64 = 0x04;
const STEP_DONE: u64 = 0x80;
const STATUS: u64 = 0x84;
const FRAME: u64 = 0x1_0000;
/// What the self-test itself agrees with us.
const PATTERN_BYTES: u32 = 4096;
const LAST_STEP: u32 = u32::MAX;
const ECHO_STEP: u32 = u32::MAX - 1;
const RECEIVED: u64 = 0x88;
const RING_BYTES: u32 = 512;

/// Round trips of the doorbell, and bytes to be echoed: eight times what the firmware's ring holds.
const RINGS: u32 = 1000;
const ECHO_BYTES: u32 = 4096;

/// Nothing takes longer than this, even on a busy machine.
const PATIENCE: Duration = Duration::from_secs(60);

/// Runs it twice: the second run must execute the same instructions.
pub fn selftest() -> Result<(), Failure> {
    let [first, second] = [run()?, run()?];
    if first == second {
        Ok(())
    } else {
        Err(format!("two runs differ in their instruction counts: {first}, {second}"))
    }
}

/// One run; the timer's counts up to where the host comes in, as the firmware printed them.
fn run() -> Result<String, Failure> {
    let folder = Folder::new()?;
    let window = window(&folder.0.join("window")).map_err(|error| format!("the shared window: {error}"))?;
    let [link, bell] = ["link", "bell"].map(|name| listen(&folder.0.join(name)));
    let (link, bell) = (link?, bell?);
    let mut emulator = Emulator::start(&folder.0)?;
    let (mut link, mut bell) = (emulator.accept(&link)?, emulator.accept(&bell)?);
    // Until it is through what it tests alone nothing must come from here: its instructions are to be the same each run.
    emulator.until("get through its own tests", || Ok((word(&window, STATUS)? != 0).then_some(())))?;
    let told = match converse(&window, &mut link, &mut bell) {
        Ok(()) => emulator.finish()?,
        Err(why) => {
            emulator.end();
            return Err(why);
        }
    };
    let counts = told.lines().find_map(|line| line.strip_prefix("selftest: counts so far: "));
    counts.map(str::to_owned).ok_or_else(|| "the firmware told no instruction count".into())
}

/// The host's part of the test.
fn converse(window: &File, link: &mut UnixStream, bell: &mut UnixStream) -> Result<(), Failure> {
    let told = word(window, STATUS)?;
    let sum: u32 = (0..PATTERN_BYTES).map(pattern).map(u32::from).sum();
    if told != sum {
        return Err(format!("the firmware added the window's pattern up to {told}, not {sum}"));
    }
    let begin = Instant::now();
    for step in 1..=RINGS {
        ring(window, bell, step)?;
    }
    let ring_us = begin.elapsed().as_micros() / u128::from(RINGS);
    let rate = f64::from(ECHO_BYTES) / echo(window, link, bell)?.as_secs_f64();
    println!("{RINGS} rings of the doorbell at {ring_us} us, {ECHO_BYTES} bytes echoed at {rate:.0} bytes/s");
    ring(window, bell, LAST_STEP)
}

/// A step's round trip.
fn ring(window: &File, bell: &mut UnixStream, step: u32) -> Result<(), Failure> {
    let lost = |error: std::io::Error| format!("the doorbell was not answered: {}", reason(&error));
    window.write_all_at(&step.to_le_bytes(), STEP).map_err(lost)?;
    bell.write_all(b"!").map_err(lost)?;
    bell.read_exact(&mut [0]).map_err(lost)?;
    match word(window, STEP_DONE)? {
        done if done == step => Ok(()),
        done => Err(format!("step {step} was rung for, but step {done} done")),
    }
}

/// Sends all before anything is read, so that the firmware's ring fills up, and compares what comes back; how long that
/// took.
fn echo(window: &File, link: &mut UnixStream, bell: &mut UnixStream) -> Result<Duration, Failure> {
    let lost = |error: std::io::Error| format!("the link's echo was lost: {}", reason(&error));
    let sent: Vec<u8> = (0..ECHO_BYTES).map(|n| (n ^ n >> 8) as u8).collect();
    link.write_all(&sent).map_err(lost)?;
    let begin = Instant::now();
    while word(window, RECEIVED)? < RING_BYTES {
        if begin.elapsed() > PATIENCE {
            return Err(format!("the firmware's ring holds {} bytes only", word(window, RECEIVED)?));
        }
        ring(window, bell, 1)?;
    }
    let begin = Instant::now();
    ring(window, bell, ECHO_STEP)?;
    let mut returned = vec![0; sent.len()];
    link.read_exact(&mut returned).map_err(lost)?;
    match sent.iter().zip(&returned).position(|(sent, returned)| sent != returned) {
        None => Ok(begin.elapsed()),
        Some(at) => Err(format!("byte {at} came back as another")),
    }
}

/// A time-out in words; other errors have their own.
fn reason(error: &std::io::Error) -> String {
    match error.kind() {
        std::io::ErrorKind::WouldBlock => format!("nothing came for {} s", PATIENCE.as_secs()),
        _ => error.to_string(),
    }
}

fn pattern(n: u32) -> u8 {
    (n * 7 % 251) as u8
}

fn window(path: &Path) -> std::io::Result<File> {
    let file = File::options().read(true).write(true).create_new(true).open(path)?;
    file.set_len(WINDOW_BYTES)?;
    file.write_all_at(&MAGIC_VALUE.to_le_bytes(), MAGIC)?;
    file.write_all_at(&(0..PATTERN_BYTES).map(pattern).collect::<Vec<_>>(), FRAME)?;
    Ok(file)
}

fn word(window: &File, offset: u64) -> Result<u32, Failure> {
    let mut bytes = [0; 4];
    window.read_exact_at(&mut bytes, offset).map_err(|error| format!("the shared window: {error}"))?;
    Ok(u32::from_le_bytes(bytes))
}

fn listen(path: &Path) -> Result<UnixListener, Failure> {
    let listener = UnixListener::bind(path).and_then(|listener| listener.set_nonblocking(true).map(|()| listener));
    listener.map_err(|error| format!("{}: {error}", path.display()))
}

/// A folder that is gone when it is dropped. Socket paths must be short, so it is not under the target folder.
struct Folder(PathBuf);

impl Folder {
    fn new() -> Result<Self, Failure> {
        let path = std::env::temp_dir().join(format!("plumbline-selftest-{}", std::process::id()));
        let _ = fs::remove_dir_all(&path);
        fs::create_dir(&path).map_err(|error| format!("{}: {error}", path.display()))?;
        Ok(Folder(path))
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

/// A running emulator, ended when it is dropped.
struct Emulator(Child);

impl Emulator {
    fn start(folder: &Path) -> Result<Self, Failure> {
        let at = |name: &str| folder.join(name).display().to_string();
        let mut command = Command::new(set_up::emulator()?);
        command.args(["-M", "mps2-an500,memory-backend=window", "-nodefaults", "-display", "none", "-net", "none"]);
        command.args(["-icount", "shift=1,sleep=off", "-semihosting-config", "enable=on,target=native"]);
        command.arg("-object");
        command.arg(format!("memory-backend-file,id=window,size=16M,share=on,mem-path={}", at("window")));
        command.args(["-serial", &format!("unix:{}", at("link")), "-serial", &format!("unix:{}", at("bell"))]);
        command.arg("-kernel").arg(places::image("selftest"));
        // Standard output carries defmt's frames; what the firmware has to say in words comes on standard error.
        command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::piped());
        command.spawn().map(Emulator).map_err(|error| format!("QEMU could not be started: {error}"))
    }

    /// The emulator's connection, with time-outs set.
    fn accept(&mut self, listener: &UnixListener) -> Result<UnixStream, Failure> {
        let stream = self.until("connect", || match listener.accept() {
            Ok((stream, _)) => Ok(Some(stream)),
            Err(error) if error.kind() == std::io::ErrorKind::WouldBlock => Ok(None),
            Err(error) => Err(error.to_string()),
        })?;
        let ready = stream.set_nonblocking(false).and_then(|()| stream.set_read_timeout(Some(PATIENCE)));
        ready.map(|()| stream).map_err(|error| format!("a link of the emulator: {error}"))
    }

    /// Waits for something that a living emulator does.
    fn until<T>(&mut self, what: &str, ready: impl Fn() -> Result<Option<T>, Failure>) -> Result<T, Failure> {
        let begin = Instant::now();
        loop {
            if let Some(value) = ready()? {
                return Ok(value);
            }
            if let Ok(Some(_)) = self.0.try_wait() {
                return Err(format!("the emulator ended before it could {what}: {}", self.told()));
            }
            if begin.elapsed() > PATIENCE {
                self.end();
                return Err(format!("the emulator did not {what} within {} s", PATIENCE.as_secs()));
            }
            thread::sleep(Duration::from_millis(2));
        }
    }

    /// Waits for the end; what the firmware told.
    fn finish(mut self) -> Result<String, Failure> {
        let begin = Instant::now();
        loop {
            match self.0.try_wait() {
                Ok(Some(status)) => {
                    let told = self.told();
                    let failures: Vec<&str> = told.lines().filter(|line| line.contains("FAILED")).collect();
                    let why = || format!("the emulator ended with {status}: {}", failures.join("; "));
                    return if status.success() { Ok(told) } else { Err(why()) };
                }
                Ok(None) if begin.elapsed() > PATIENCE => return Err("the firmware did not end".into()),
                Ok(None) => thread::sleep(Duration::from_millis(5)),
                Err(error) => return Err(format!("the emulator was lost: {error}")),
            }
        }
    }

    /// Ends it, and shows what it told.
    fn end(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
        self.told();
    }

    /// All it wrote to standard error. To be read when it has ended: it writes less than a pipe holds.
    fn told(&mut self) -> String {
        let mut told = String::new();
        if let Some(stderr) = &mut self.0.stderr {
            let _ = stderr.read_to_string(&mut told);
        }
        eprint!("{told}");
        told
    }
}

impl Drop for Emulator {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}
