//! One file a verb: parses, checks, dispatches.

mod adjust;
mod attitude;
mod boresight;
mod calibrate;
mod camera;
mod completions;
mod configuration;
pub mod evaluate;
mod exterior;
mod fly;
mod intersect;
mod map;
mod markdown;
mod match_;
mod motion;
mod mounts;
mod plan;
mod rectify;
mod replay;
mod reproduce;
mod serve;
mod smooth;
mod stitch;
mod tiles;

use crate::outcome::{Failure, Outcome, note};
use clap::error::{ContextKind, ContextValue, ErrorKind};
use clap::{CommandFactory, Parser, Subcommand};
use plumbline_survey::camera_file::CameraFile;

/// Real-time rectification and scene matching: simulated flights of the firmware, and its algorithms on single
/// pictures.
#[derive(Debug, Parser)]
#[command(name = "plumbline", version, disable_help_subcommand = false, max_term_width = 100)]
pub struct Cli {
    #[command(subcommand)]
    verb: Verb,
}

#[derive(Debug, Subcommand)]
enum Verb {
    /// Fly the firmware over real or procedural ground and judge its fixes
    ///
    /// A frame without a fix says why, on the page and in fixes.csv: docs/refusals.md explains every reason.
    Fly(fly::Args),
    /// Run the application again on a flight's log and compare, bit for bit
    Replay(replay::Args),
    /// Act as a board until it is interrupted: behind a socket or a pseudo-terminal for `fly --link serial:PATH`, or as the
    /// companion of an autopilot
    Serve(serve::Args),
    /// Make a reference tile for the board's flash from an orthophoto
    Tiles(tiles::Args),
    /// Make the configuration store for the board's flash: camera, calibration, settings; or the store of a plan or of a key
    #[command(alias = "mission")]
    Configuration(configuration::Args),
    /// Map undistorted pixels to frame pixels (eq. 3 and 7)
    Map(map::Args),
    /// Rectify one frame onto the ground plane
    Rectify(rectify::Args),
    /// Make the virtual image of a camera of several heads from one frame of each (paper 002)
    ///
    /// The frames, taken at one instant, become what the virtual camera of the file would have seen: an image of its size, 8
    /// bits, grey or RGB as the frames are, 0 where no head sees anything. It is made in pieces and held in memory, a byte a
    /// pixel and band; frames have at most 8192 pixels a side, the image 65,535. How far neighbouring heads are off each other
    /// is measured by matching windows of both where they overlap.
    Stitch(stitch::Args),
    /// Find a rectified patch in a reference
    Match(match_::Args),
    /// Judge frames of a real flight by the board's own chain: what to do before a board is trusted
    ///
    /// The frames are handed to the firmware, in this process, as a flight is, with key frames, filter and every refusal of the board; a
    /// constant tilt of the camera and a constant offset of the map are estimated from the fixes, as far as the flight tells them apart,
    /// and the frames are judged without and with what was found of the camera.
    Evaluate(evaluate::Args),
    /// Image motion during an exposure: exact, to first order (eq. 21), and the centroid of its track
    Motion(motion::Args),
    /// Intersect points of two photos on the ground, with the exterior orientation at a stamp
    Intersect(intersect::Args),
    /// Smooth the columns of a log: value, rate and sigma at its times or at others (paper 001)
    Smooth(smooth::Args),
    /// Calibrate a camera of several heads by constrained bundle adjustment (paper 002)
    Calibrate(calibrate::Args),
    /// How heads sit to each other, from exterior orientations of their pictures or from resections on a test field
    Mounts(mounts::Args),
    /// Estimate how a camera of one head sits in its vehicle, from a flight's fixes and an independent navigation
    ///
    /// The fixes of a board that was configured with the boresight of --camera are compared with positions that are known
    /// otherwise, by GNSS for instance. An angle whose standard deviation exceeds 0.2 degrees keeps its value; kappa can be
    /// determined only from tilted frames. The file that is written has [boresight] replaced and all else kept but comments.
    Boresight(boresight::Args),
    /// Plan flight lines over terrain, so that the overlap on the ground holds everywhere (paper 004)
    ///
    /// Bases and the distances of strips follow the terrain; overlaps are given or chosen among 77 by simulated adjustment. The
    /// plan is flown by `plumbline fly --plan`.
    Plan(plan::Args),
    /// Adjust a problem of Bundle Adjustment in the Large
    Adjust(adjust::Args),
    /// Make a camera file: from a preset, a field of view, or a calibration of OpenCV or OpenDroneMap
    Camera(camera::Args),
    /// Completions of verbs and options for a shell, to be sourced by it
    Completions(completions::Args),
    /// Reproduce a paper's tables and say where and why they differ
    Reproduce(reproduce::Args),
    /// This command's verbs and options as Markdown, for docs/command-line.md
    #[command(hide = true)]
    Markdown,
}

/// Runs the verb.
pub fn run(cli: Cli) -> Result<Outcome, Failure> {
    match cli.verb {
        Verb::Fly(args) => fly::run(&args),
        Verb::Replay(args) => replay::run(&args),
        Verb::Serve(args) => serve::run(&args),
        Verb::Tiles(args) => tiles::run(&args),
        Verb::Configuration(args) => configuration::run(&args),
        Verb::Map(args) => map::run(&args),
        Verb::Rectify(args) => rectify::run(&args),
        Verb::Stitch(args) => stitch::run(&args),
        Verb::Match(args) => match_::run(&args),
        Verb::Evaluate(args) => evaluate::run(&args),
        Verb::Motion(args) => motion::run(&args),
        Verb::Intersect(args) => intersect::run(&args),
        Verb::Smooth(args) => smooth::run(&args),
        Verb::Calibrate(args) => calibrate::run(&args),
        Verb::Mounts(args) => mounts::run(&args),
        Verb::Boresight(args) => boresight::run(&args),
        Verb::Plan(args) => plan::run(&args),
        Verb::Adjust(args) => adjust::run(&args),
        Verb::Camera(args) => camera::run(&args),
        Verb::Completions(args) => completions::run(&args, &mut Cli::command()),
        Verb::Reproduce(args) => reproduce::run(&args),
        Verb::Markdown => Outcome::new(false, &(), || markdown::page(Cli::command())),
    }
}

/// clap's complaint without its usage lines: what is wrong and where, in one sentence.
pub fn one_sentence(error: &clap::Error) -> String {
    let text = error.render().to_string();
    let lines = text.lines().map(str::trim).take_while(|line| !line.is_empty() && !line.starts_with("Usage"));
    let sentence = whole_word(error, lines.collect::<Vec<_>>().join(" "));
    let sentence = RUST_WORDS.iter().fold(sentence, |sentence, (words, plain)| sentence.replace(words, plain));
    // What was likely meant stands apart: one, or several.
    let tip = |line: &str| {
        let tip = line.trim().strip_prefix("tip: ")?;
        ["a similar", "some similar"].iter().any(|start| tip.starts_with(start)).then(|| format!("; {tip}"))
    };
    let several = || text.lines().find_map(tip);
    let meant = verbs_like(error).or_else(several).or_else(|| letters_swapped(error)).unwrap_or_default();
    format!(
        "plumbline: {}{meant}{}{}",
        sentence.strip_prefix("error: ").unwrap_or(&sentence),
        points(error),
        loose_plan(error)
    )
}

/// What the standard library says of a text that is no whole number, and what people say.
const RUST_WORDS: [(&str, &str); 3] = [
    ("invalid digit found in string", "not a whole number from 0 on"),
    ("number too large to fit in target type", "too large"),
    ("cannot parse integer from empty string", "not a whole number"),
];

/// Verbs like the one that was typed, the likeliest first, which clap has last.
fn verbs_like(error: &clap::Error) -> Option<String> {
    let Some(ContextValue::Strings(verbs)) = error.get(ContextKind::SuggestedSubcommand) else { return None };
    let verbs: Vec<String> = verbs.iter().rev().take(LIKE_MAX).map(|verb| format!("'{verb}'")).collect();
    match verbs.as_slice() {
        [] => None,
        [one] => Some(format!("; a similar subcommand exists: {one}")),
        several => Some(format!("; similar subcommands exist: {}", several.join(", "))),
    }
}

/// How many verbs are named for one that was misspelt: chosen, as more say nothing.
const LIKE_MAX: usize = 3;

/// The verb with the letters of what was typed in another order, `fyl`: clap's measure of likeness sees none in words so short.
fn letters_swapped(error: &clap::Error) -> Option<String> {
    let Some(ContextValue::String(typed)) = error.get(ContextKind::InvalidSubcommand) else { return None };
    let sorted = |word: &str| {
        let mut letters: Vec<char> = word.chars().collect();
        letters.sort_unstable();
        letters
    };
    let command = Cli::command();
    let verb = command.get_subcommands().find(|verb| sorted(verb.get_name()) == sorted(typed))?;
    Some(format!("; a similar subcommand exists: '{}'", verb.get_name()))
}

/// A word that begins with a minus is taken for letters of options, and the first alone is complained of: the word as it was typed.
fn whole_word(error: &clap::Error, sentence: String) -> String {
    let Some(ContextValue::String(letter)) = error.get(ContextKind::InvalidArg) else { return sentence };
    if error.kind() != ErrorKind::UnknownArgument || letter.starts_with("--") || letter.chars().count() != 2 {
        return sentence;
    }
    let mut typed = std::env::args_os().skip(1).map(|word| word.to_string_lossy().into_owned());
    let word = typed.find(|word| word.starts_with(letter.as_str()));
    word.map_or(sentence.clone(), |word| sentence.replace(&format!("'{letter}'"), &format!("'{word}'")))
}

/// What to type where a plan stands without its option.
fn loose_plan(error: &clap::Error) -> String {
    let verb = std::env::args_os().nth(1).unwrap_or_default().to_string_lossy().into_owned();
    match error.get(ContextKind::InvalidArg) {
        Some(ContextValue::String(word))
            if error.kind() == ErrorKind::UnknownArgument
                && ["mission", "configuration"].contains(&verb.as_str())
                && word.ends_with(".json") =>
        {
            format!("; a plan stands behind its option: --plan {word}")
        }
        _ => String::new(),
    }
}

/// What to type where numbers that belong behind `--` stand without it.
fn points(error: &clap::Error) -> String {
    // An argument that is no text is no point either.
    let words: Vec<String> = std::env::args_os().skip(1).map(|word| word.to_string_lossy().into_owned()).collect();
    let takes_points = words.first().is_some_and(|verb| ["map", "motion", "intersect"].contains(&verb.as_str()));
    if error.kind() != ErrorKind::UnknownArgument || !takes_points || words.iter().any(|word| word == "--") {
        return String::new();
    }
    let is_point = |word: &str| word.contains(',') && word.split(',').all(|part| part.trim().parse::<f64>().is_ok());
    // Numbers behind an option's name are its value.
    let is_value = |index: usize| index > 0 && words[index - 1].starts_with("--") && !words[index - 1].contains('=');
    let loose = words.iter().enumerate().filter(|(index, word)| is_point(word) && !is_value(*index));
    let loose: Vec<&str> = loose.map(|(_, word)| word.as_str()).collect();
    if loose.is_empty() { String::new() } else { format!("; points come last and after --: -- {}", loose.join(" ")) }
}

/// Asks on stderr about what a camera file probably does not mean.
fn ask(camera: &CameraFile) {
    camera.doubt().iter().for_each(|question| note(question));
}

/// A finite number.
fn finite(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value.is_finite() => Ok(value),
        Ok(_) => Err("not a finite number".to_owned()),
        Err(_) => Err("not a number".to_owned()),
    }
}

/// Least and greatest of what is measured in any unit here: beyond it nothing is meant.
const MEASURED: [f64; 2] = [1e-9, 1e9];

/// A finite number above zero.
fn positive(text: &str) -> Result<f64, String> {
    let [least, most] = MEASURED;
    match finite(text)? {
        value if value <= 0.0 => Err("must be above 0".to_owned()),
        value if !(least..=most).contains(&value) => Err(format!("not between {least:e} and {most:e}")),
        value => Ok(value),
    }
}

#[cfg(test)]
mod tests {
    use super::Cli;
    use clap::{Arg, Command, CommandFactory};
    use std::any::TypeId;

    fn is_number(arg: &Arg) -> bool {
        let of = arg.get_value_parser().type_id();
        macro_rules! is_one_of {
            ($($kind:ty),*) => { [$(TypeId::of::<$kind>()),*].iter().any(|kind| of == *kind) };
        }
        is_one_of!(u8, u16, u32, u64, usize, i8, i16, i32, i64, isize, f32, f64, [f64; 2], [f64; 3], [f64; 4], [u32; 2])
    }

    /// Names of options that take numbers and no negative ones after a space: those are refused by what is wrong with them.
    fn deaf(command: &Command) -> Vec<String> {
        let own = command.get_arguments().filter(|arg| arg.get_long().is_some() && is_number(arg));
        let own = own.filter(|arg| !arg.is_allow_negative_numbers_set() && !arg.is_allow_hyphen_values_set());
        let own = own.map(|arg| format!("{} --{}", command.get_name(), arg.get_long().unwrap_or_default()));
        own.chain(command.get_subcommands().flat_map(deaf)).collect()
    }

    #[test]
    fn a_negative_number_follows_every_option_that_takes_numbers() {
        assert_eq!(deaf(&Cli::command()), Vec::<String>::new());
    }
}
