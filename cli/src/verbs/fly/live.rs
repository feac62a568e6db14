//! A flight with a real autopilot.

use super::output::Output;
use super::{Args, Reach, Watch, setting, text};
use crate::outcome::{self, Failure, Outcome};
use crate::pages::flight::Report;
use crate::progress;
use indicatif::ProgressBar;
use plumbline_sim::link::inproc::InProcess;
use plumbline_sim::link::{Account, Link};
use plumbline_sim::live::LiveError;
use plumbline_sim::live::approach::{Approach, Limits};
use plumbline_sim::live::connection::{Door, End, Waiting};
use plumbline_sim::live::flight::{Flown, Wanted, fly};
use plumbline_sim::live::truth::Place;
use plumbline_sim::run::Observer;
use plumbline_sim::scenario::{FRAMES_MAX, Scenario};
use plumbline_sim::score::kept::Navigated;
use plumbline_sim::score::{self, Linked};
use plumbline_sim::setup::Setup;
use plumbline_sim::vehicle::motion::Motion;
use plumbline_survey::error::InputError;
use plumbline_survey::io::output::write_file;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::Duration;

/// Frames between two pictures for the report where nobody says how many frames there will be: five minutes at 4 Hz have six.
const PICTURE_EVERY: u32 = 200;

/// Flights begun anew at most. Chosen: a script that sets parameters reboots once or twice; this many mean that nobody is there
/// who flies.
const RECONNECTS_MAX: u32 = 20;
/// How long a vehicle that boots anew is left alone.
const REBOOT: Duration = Duration::from_millis(500);

/// Flies until the flight ends.
pub fn run(args: &Args, ends: [&End; 2], output: &Output) -> Result<Outcome, Failure> {
    if args.link != Reach::InProcess {
        let why = "--autopilot flies the firmware in this process; --link is not for it";
        return Err(Failure::Input(InputError::new(why)));
    }
    let scenario = scenario(args)?;
    let bar = args.frames.map_or_else(progress::spinner, |frames| progress::bar(frames.into(), "frame"));
    let mut watch = Watch::new(bar)?;
    let [autopilot, truth] = ends;
    let mut doors = [Door::new("--autopilot", autopilot.clone()), Door::new("--truth", truth.clone())];
    let mut reconnects = 0;
    let (mut setup, flown, link) = loop {
        match attempt(args, &scenario, &mut doors, reconnects, &mut watch)? {
            Some(flown) => break flown,
            None if reconnects >= RECONNECTS_MAX => {
                return Err(Failure::Work(format!(
                    "the connection was closed {reconnects} times before the vehicle was armed"
                )));
            }
            None => {
                reconnects += 1;
                thread::sleep(REBOOT);
                outcome::note(
                    "plumbline: the connection was closed before the vehicle was armed; waiting for it again",
                );
            }
        }
    };
    watch.bar.finish_and_clear();
    let mut link = link;
    if let Some(path) = &args.log {
        write_file(path, &link.close_log())?;
    }
    let Flown { flight, motion, live, navigation } = flown;
    if !motion.is_empty() {
        setup.motion = Motion::recorded(motion);
    }
    let aborted = args.frames.filter(|frames| flight.frames.len() < *frames as usize);
    let aborted = aborted.map(|frames| (frames, format!("the flight ended early: {}", live.ended)));
    if flight.frames.is_empty() {
        return Err(Failure::Work(format!("the flight ended ({}) before a frame was taken", live.ended)));
    }
    let linked = Linked { name: "inproc".to_owned(), firmware_sha256: None, account: Account::default() };
    let scored = score::score(&setup, &flight, &watch.unrectified);
    let mut summary = score::summarise(&setup, &flight, &scored, &linked);
    (summary.live, summary.navigation) = (Some(live), navigation.map(Navigated::Live));
    summary.aborted = aborted.as_ref().map(|(_, why)| why.clone());
    let report = Report { setup: &setup, flight: &flight, scored: &scored, summary: &summary };
    output.write(&report)?;
    let failure = aborted.map(|(frames, why)| format!("{why}; {} of {frames} frames were taken", flight.frames.len()));
    Ok(Outcome::new(args.json, &summary, || text::table(&summary, args.out.as_deref()))?.failed(failure))
}

/// The scenario, which has to leave to the autopilot what is the autopilot's.
fn scenario(args: &Args) -> Result<Scenario, Failure> {
    let (mut scenario, _) = setting::scenario(args)?;
    if scenario.run.replay.is_some() {
        return Err(Failure::Input(InputError::new(
            "a scenario with a replay is not for --autopilot, which flies itself",
        )));
    }
    if let Some(fault) = scenario.faults.timed.all().first() {
        return Err(Failure::Input(InputError::new(format!(
            "the fault {fault} is of a simulated vehicle, and --autopilot flies a real one"
        ))));
    }
    scenario.run.frames = args.frames.unwrap_or(FRAMES_MAX);
    Ok(scenario)
}

/// One flight; `None` where a connection closed before the vehicle was armed.
fn attempt(
    args: &Args,
    scenario: &Scenario,
    doors: &mut [Door; 2],
    reconnects: u32,
    watch: &mut Watch,
) -> Result<Option<(Setup, Flown, InProcess)>, Failure> {
    let limits = Limits { wait: Duration::from_secs_f64(args.wait_s) };
    let mut lookout = Lookout { bar: &watch.bar, interrupted: &watch.interrupted };
    let approach = match Approach::begin(doors, limits, &mut lookout) {
        // It boots anew.
        Err(LiveError::Closed(_)) if reconnects > 0 => return Ok(None),
        approach => approach?,
    };
    let Some(start) = approach.start() else { return Ok(None) };
    watch.bar.set_message(if args.frames.is_some() { "frame" } else { "waiting for take-off" });
    let setup = Setup::live(scenario.clone(), &start)?;
    let mut link = if args.log.is_some() { InProcess::logged(&setup.flash)? } else { InProcess::new(&setup.flash)? };
    let place = Place { crs: setup.crs.clone(), home_alt_m: start.home_alt_m };
    let every = args.frames.map_or(PICTURE_EVERY, |frames| frames.div_ceil(super::PICTURED).max(1));
    let wanted = Wanted { frames: args.frames, keep: super::keep(args, every), reconnects };
    let flown = fly(&setup, &place, &mut link, approach, &wanted, &mut lookout, &mut watch.unrectified)?;
    Ok(flown.map(|flown| (setup, flown, link)))
}

/// Tells what is waited for, on the bar and where nobody sees it in a line; shows how far the flight is, and ends it at an
/// interrupt.
struct Lookout<'a> {
    bar: &'a ProgressBar,
    interrupted: &'a AtomicBool,
}

impl Waiting for Lookout<'_> {
    fn waits(&mut self, what: &str) {
        if self.bar.is_hidden() {
            outcome::note(&format!("plumbline: {what}"));
        }
        self.bar.set_message(what.to_owned());
        self.bar.tick();
    }

    fn is_interrupted(&self) -> bool {
        self.interrupted.load(Ordering::Relaxed)
    }
}

impl Observer for Lookout<'_> {
    fn exposed(&mut self, frame: u32) {
        self.bar.set_position(u64::from(frame) + 1);
        // A spinner shows no position.
        if self.bar.length().is_none() {
            self.bar.set_message(format!("frame {frame}"));
        }
    }

    fn is_interrupted(&self) -> bool {
        Waiting::is_interrupted(self)
    }
}

impl From<LiveError> for Failure {
    fn from(error: LiveError) -> Self {
        match error {
            LiveError::Input(error) => error.into(),
            other => Failure::Work(other.to_string()),
        }
    }
}
