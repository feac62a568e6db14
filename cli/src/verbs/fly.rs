//! `plumbline fly`: a flight of the firmware.

mod live;
mod output;
mod setting;
mod text;

use crate::interrupt;
use crate::outcome::{self, Failure, Outcome};
use crate::pages::flight::{REFUSED_MAX, Report};
use crate::progress;
use output::Output;
use plumbline_charts::plot::PlotError;
use plumbline_sim::link::inproc::InProcess;
use plumbline_sim::link::mirror::{Mirror, Opened, Station};
use plumbline_sim::link::pace::Patience;
use plumbline_sim::link::qemu::{Qemu, default_image};
use plumbline_sim::link::serial::Serial;
use plumbline_sim::link::{Account, Link, LinkError, NO_REBOOT};
use plumbline_sim::live::connection::End;
use plumbline_sim::run::{FrameRecord, Keep, Observer, fly};
use plumbline_sim::scenario::{FRAMES_MAX, Fault, Setting, What};
use plumbline_sim::score::unrectified::Unrectified;
use plumbline_sim::score::{self, Linked};
use plumbline_sim::setup::Setup;
use plumbline_survey::error::InputError;
use plumbline_survey::io::input::sha256;
use plumbline_survey::io::output::write_file;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Frames whose pictures are kept for the report, spread over the flight.
const PICTURED: u32 = 12;

#[derive(Debug, clap::Args)]
pub struct Args {
    /// Scenario file (TOML) or the name of a built-in one; the default scene unless given
    #[arg(long, value_name = "FILE")]
    scenario: Option<PathBuf>,
    /// Where the firmware runs: inproc, qemu or serial:PATH
    ///
    /// serial:PATH is a board on a serial port (set to 921600 baud where it has a rate), or whatever serves a UNIX socket
    /// or a pseudo-terminal, as `plumbline serve` does. Configuration and reference tile are uploaded first. Requests that are
    /// not answered are sent again; a line may be unplugged for ten seconds, and a board that boots in mid-flight is
    /// loaded anew: report.json counts all of it under link_faults, and the frames a reboot took as lost.
    #[arg(long, default_value = "inproc", value_parser = reach)]
    link: Reach,
    /// Firmware image for --link qemu; the one `cargo xtask build` makes unless given
    #[arg(long, value_name = "ELF")]
    firmware: Option<PathBuf>,
    /// A key of the scenario and its value, as range.sigma_m=0.5; may be given several times
    ///
    /// KEY is dotted, VALUE is TOML, and what is no TOML is a string. It lies over the scenario's own; --frames and --seed lie
    /// over it.
    #[arg(long = "set", value_name = "KEY=VALUE")]
    settings: Vec<Setting>,
    /// A fault: `UNIT.TYPE[=VALUE][@FROM..[TO]]`, as range.scale=1.1@30..60; may be given several times
    ///
    /// FROM and TO are seconds of the simulated time: the first frame is taken at 3. Without TO it lasts to the end of
    /// the flight, without @ it is there all the time. It is added to the `[[fault]]` of the scenario, whose documentation lists
    /// units, types and values; report.json says under faults what each did to the fixes.
    #[arg(long = "fault", value_name = "SPEC")]
    faults: Vec<Fault>,
    /// Frames to take
    #[arg(long, allow_negative_numbers = true, value_parser = clap::value_parser!(u32).range(1..=i64::from(FRAMES_MAX)))]
    frames: Option<u32>,
    /// What every random number comes from
    #[arg(long, allow_negative_numbers = true)]
    seed: Option<u64>,
    /// Orthophoto to fly over (GeoTIFF)
    #[arg(long, value_name = "ORTHO")]
    ground: Option<PathBuf>,
    /// Surface or terrain model under it; flat at height 0 unless given
    #[arg(long)]
    dem: Option<PathBuf>,
    /// Orthophoto that the reference is made of; the one flown over unless given
    ///
    /// How it differs from the ground is real then: nothing that the scenario makes up is added, but what --set says.
    #[arg(long, value_name = "ORTHO2")]
    reference: Option<PathBuf>,
    /// Attitude log to fly, from its first row: ULog, DataFlash, telemetry, or CSV with t_s, roll_deg, pitch_deg, yaw_deg
    ///
    /// A log is known by its content. What the autopilot flew by is taken: vehicle_attitude of a ULog (.ulg), ATT of a DataFlash
    /// log (.bin), ATTITUDE or ATTITUDE_QUATERNION of telemetry (.tlog), whichever was sent more often. A table may have t_ms or t_us,
    /// angles in _rad, or a quaternion qw, qx, qy, qz.
    #[arg(long, value_name = "LOG")]
    replay: Option<PathBuf>,
    /// Plan to fly: plan.json, as `plumbline plan` writes it
    ///
    /// Its strips are flown one after the other over its elevation model (or --dem), with its camera; the firmware has the plan
    /// in flash and decides when a photo is due. The scenario's keys apply as far as the plan leaves them open; without one the
    /// platform is calm and the camera fixed to it. --frames N ends after N photos.
    #[arg(long, value_name = "PLAN", conflicts_with = "replay")]
    plan: Option<PathBuf>,
    /// A real autopilot to fly with: where firmware and autopilot talk to each other, tcp:HOST:PORT; needs --truth
    ///
    /// Both ends are connected to where somebody listens; else Plumbline listens there and waits for a connection. MAVLink 2
    /// passes both ways unchanged. The flight follows the autopilot's clock, begins at a height ([live] of the scenario) and
    /// ends when the vehicle disarms, a connection closes, --frames have been taken or at an interrupt. What the scenario does
    /// not say is as in the built-in scenario live.
    #[arg(long, value_name = "END", requires = "truth", conflicts_with_all = ["plan", "replay", "dem"])]
    autopilot: Option<End>,
    /// Where the same simulated vehicle tells the truth (SIM_STATE), tcp:HOST:PORT; needs --autopilot
    #[arg(long, value_name = "END", requires = "autopilot")]
    truth: Option<End>,
    /// Seconds to wait for each end of a live flight, and for the vehicle's first word
    #[arg(long, value_name = "S", default_value_t = 30.0, value_parser = seconds, allow_negative_numbers = true)]
    wait_s: f64,
    /// A ground station that watches the flight: udp:HOST:PORT or tcp:HOST:PORT
    ///
    /// What autopilot and firmware say to each other goes there as it is said: heartbeats, attitude, position, fixes, lines of
    /// text. The flight then takes its own time, or less with --speed. A tcp: address is connected to where somebody listens; else
    /// whoever connects to it may listen. Who asks is told
    /// the mission of a flight along a plan or waypoints and the autopilot's parameters; orders are declined.
    #[arg(long, value_name = "STATION", conflicts_with = "autopilot")]
    mavlink: Option<Station>,
    /// Simulated seconds in a second of a flight that is watched by --mavlink
    #[arg(long, value_name = "FACTOR", default_value_t = 1.0, value_parser = speed, requires = "mavlink", allow_negative_numbers = true)]
    speed: f64,
    /// Fail, with exit code 1, where fewer percent of the frames have a fix
    #[arg(long, value_name = "PERCENT", value_parser = percent, allow_negative_numbers = true)]
    require_rate: Option<f64>,
    /// Folder for fixes.csv, poses.csv, report.json, report.html, fixes.geojson, track.kml and tile.tif; nothing is written unless given
    ///
    /// poses.csv is the truth: where the antenna was on the grid of fixes.csv, how high the camera above the ground, heading
    /// from grid north, pitch, roll and follow-up angle at each stamp, as a navigation without error would log them for
    /// `plumbline boresight`.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Write the flight's log, for `plumbline replay`; with --link inproc
    #[arg(long, value_name = "FILE")]
    log: Option<PathBuf>,
    /// Write the flight for Foxglove and other viewers of MCAP: true pose, fixes and their ellipses, map, pictures
    ///
    /// The pictures are those of a few frames spread over the flight and of those without a fix, up to 36, and with --dump N of the first N.
    #[arg(long, value_name = "MCAP")]
    export: Option<PathBuf>,
    /// Write frame, patch, mask and reference of the first N frames as PNG
    ///
    /// flown_frames.csv beside them is what `plumbline evaluate` takes, with tile.tif as the map: frames with place and attitude as
    /// the board had them and with the truth.
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    dump: Option<u32>,
    /// Print report.json on stdout
    #[arg(long)]
    json: bool,
}

/// Where the firmware runs.
#[derive(Clone, Debug, PartialEq, Eq)]
enum Reach {
    InProcess,
    Qemu,
    Serial(PathBuf),
}

fn reach(text: &str) -> Result<Reach, String> {
    match text {
        "inproc" => Ok(Reach::InProcess),
        "qemu" => Ok(Reach::Qemu),
        _ => match text.strip_prefix("serial:") {
            Some("") => Err("serial: lacks the path of a serial port or a socket".to_owned()),
            Some(path) => Ok(Reach::Serial(PathBuf::from(path))),
            None => Err("not one of inproc, qemu and serial:PATH".to_owned()),
        },
    }
}

fn seconds(text: &str) -> Result<f64, String> {
    let seconds: f64 = text.parse().map_err(|_| "not a number".to_owned())?;
    if (0.1..=86_400.0).contains(&seconds) { Ok(seconds) } else { Err("not between 0.1 and 86400".to_owned()) }
}

fn speed(text: &str) -> Result<f64, String> {
    let factor: f64 = text.parse().map_err(|_| "not a number".to_owned())?;
    if (0.01..=1000.0).contains(&factor) { Ok(factor) } else { Err("not between 0.01 and 1000".to_owned()) }
}

fn percent(text: &str) -> Result<f64, String> {
    let percent: f64 = text.parse().map_err(|_| "not a number".to_owned())?;
    if percent > 0.0 && percent <= 1.0 {
        // As many digits as were given.
        return Err(format!(
            "this is percent; for a share of 1 write --require-rate {}",
            (1e8 * percent).round() / 1e6
        ));
    }
    if (0.0..=100.0).contains(&percent) { Ok(percent) } else { Err("not between 0 and 100".to_owned()) }
}

pub fn run(args: &Args) -> Result<Outcome, Failure> {
    let output = Output::check(args)?;
    if args.firmware.is_some() && args.link != Reach::Qemu {
        return Err(Failure::Input(InputError::new("--firmware is an image for --link qemu, which is not given")));
    }
    if args.log.is_some() && args.link != Reach::InProcess {
        return Err(Failure::Input(InputError::new("--log is for --link inproc; a board keeps its log itself")));
    }
    if let (Some(autopilot), Some(truth)) = (&args.autopilot, &args.truth) {
        return live::run(args, [autopilot, truth], &output);
    }
    // Who watches may come while the ground is made.
    let opened = args.mavlink.as_ref().map(Opened::new).transpose()?;
    if let Some((station, at)) = args.mavlink.as_ref().zip(opened.as_ref().and_then(Opened::listens_at)) {
        outcome::note(&format!("plumbline: --mavlink {station}: listening on {at}"));
    }
    let setup = setting::setup(args)?;
    let has_power_faults = setup.scenario.faults.timed.of(What::PowerOff).next().is_some();
    if has_power_faults && (args.link != Reach::InProcess || args.log.is_some()) {
        return Err(Failure::Input(InputError::new(NO_REBOOT)));
    }
    let frames = setup.scenario.run.frames;
    let late = setting::late_faults(&setup.scenario);
    for note in setup.plan.iter().flat_map(|plan| &plan.notes).chain(&setup.notes).chain(&late) {
        outcome::note(note);
    }
    let (mut link, mut linked) = watched(args, opened, &setup, link(args, &setup)?);
    let keep = keep(args, frames.div_ceil(PICTURED).max(1));
    let mut watch = Watch::new(progress::bar(frames.into(), "frame"))?;
    let (flight, aborted) = match fly(&setup, link.as_mut(), keep, &mut watch) {
        Ok(flight) => (flight, None),
        Err(aborted) => (aborted.flight, Some(aborted.why)),
    };
    watch.bar.finish_and_clear();
    // A flight that was cut short is the one whose log is wanted.
    if let Some(path) = &args.log {
        write_file(path, &link.close_log())?;
    }
    linked.account = link.account();
    // A board on a line is free for the next one.
    drop(link);
    let failure =
        aborted.as_ref().map(|why| format!("{why}; {} of {frames} frames were finished", flight.frames.len()));
    if let Some(why) = aborted.as_ref().filter(|_| flight.frames.is_empty()) {
        return Err(Failure::Work(why.to_string()));
    }
    let scored = score::score(&setup, &flight, &watch.unrectified);
    let mut summary = score::summarise(&setup, &flight, &scored, &linked);
    summary.aborted = aborted.map(|why| why.to_string());
    let report = Report { setup: &setup, flight: &flight, scored: &scored, summary: &summary };
    output.write(&report)?;
    let failure = failure.or_else(|| too_few(args, summary.accepted, summary.frames));
    Ok(Outcome::new(args.json, &summary, || text::table(&summary, args.out.as_deref()))?.failed(failure))
}

/// The pictures that are kept: those of a dump, of one frame of `every`, and of frames without a fix.
fn keep(args: &Args, every: u32) -> Keep {
    Keep { first: args.dump.unwrap_or(0), every, refused: REFUSED_MAX as u32 }
}

/// Why too few frames have a fix, if they are.
fn too_few(args: &Args, accepted: usize, frames: usize) -> Option<String> {
    let (required, rate) = (args.require_rate?, 100.0 * accepted as f64 / frames.max(1) as f64);
    (rate < required)
        .then(|| format!("{accepted} of {frames} frames have a fix, {rate:.1} %; --require-rate asks for {required} %"))
}

/// The link, with a ground station beside it where one watches.
fn watched(
    args: &Args,
    opened: Option<Opened>,
    setup: &Setup,
    (link, linked): (Box<dyn Link>, Linked),
) -> (Box<dyn Link>, Linked) {
    match opened {
        Some(opened) => (Box::new(Mirror::new(link, opened, args.speed, &setup.knowledge())), linked),
        None => (link, linked),
    }
}

/// Shows how far the flight is, matches its raw frames, and ends it at an interrupt.
struct Watch {
    bar: progress::Bar,
    unrectified: Unrectified,
    interrupted: Arc<AtomicBool>,
}

impl Watch {
    fn new(bar: progress::Bar) -> Result<Self, Failure> {
        Ok(Watch { bar, unrectified: Unrectified::default(), interrupted: interrupt::listen()? })
    }
}

impl Observer for Watch {
    fn exposed(&mut self, frame: u32) {
        self.bar.set_position(u64::from(frame) + 1);
    }

    fn finished(&mut self, setup: &Setup, record: &FrameRecord) {
        self.unrectified.finished(setup, record);
    }

    fn is_interrupted(&self) -> bool {
        self.interrupted.load(Ordering::Relaxed)
    }
}

impl From<LinkError> for Failure {
    fn from(error: LinkError) -> Self {
        match error {
            LinkError::Input(error) => Failure::Input(error),
            lost => Failure::Work(lost.to_string()),
        }
    }
}

impl From<PlotError> for Failure {
    fn from(error: PlotError) -> Self {
        Failure::Work(error.to_string())
    }
}

/// The firmware, booted, and what the report calls it.
fn link(args: &Args, setup: &Setup) -> Result<(Box<dyn Link>, Linked), Failure> {
    let linked =
        |name: &str, firmware_sha256| Linked { name: name.to_owned(), firmware_sha256, account: Account::default() };
    match &args.link {
        Reach::InProcess => {
            let link =
                if args.log.is_some() { InProcess::logged(&setup.flash)? } else { InProcess::new(&setup.flash)? };
            Ok((Box::new(link), linked("inproc", None)))
        }
        Reach::Serial(path) => {
            let link = Serial::open(&setup.flash, path, Patience::default())?;
            Ok((Box::new(link), linked("serial", None)))
        }
        Reach::Qemu => {
            let image = args.firmware.clone().unwrap_or_else(default_image);
            let link = Qemu::launch(&setup.flash, &image)?;
            Ok((Box::new(link), linked("qemu", Some(sha256(&image)?))))
        }
    }
}
