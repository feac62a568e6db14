//! `cargo xtask flash`: puts image, configuration, plan, key and tiles onto the flight computer, and never erases its bootloader
//! unasked.
//!
//! By default a DFU file for the camera's own bootloader, which listens for a second and a half after power-up and keeps
//! its own sector read-only (37c5:9204; the partition FIRMWARE is 0x08040000 to 0x081e0000). With `--probe` the same image
//! by a debug probe. With `--bare` the bare image by a debug probe, over the bootloader.

mod dfu;
mod store;

use super::board::probe::region;
use super::board::{self, Image, map};
use super::process::{output, run, succeeds};
use super::{Failure, build, places, set_up};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};
use store::{Blob, KEY, PLAN, TILES};

/// The chip, as probe-rs calls it.
const CHIP: &str = "STM32H743VITx";
/// End of what the camera's bootloader writes.
const DFU_END: u32 = 0x081e_0000;

/// What was asked for.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
struct Asked {
    way: Way,
    configuration: Option<PathBuf>,
    settings: Option<PathBuf>,
    tiles: Option<PathBuf>,
    plan: Option<PathBuf>,
    key: Option<PathBuf>,
}

/// How it gets there.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Way {
    /// By the camera's bootloader.
    #[default]
    Dfu,
    /// By a probe, behind the bootloader.
    Probe,
    /// By a probe, over the bootloader.
    Bare,
}

/// Checks, builds and writes.
///
/// # Errors
/// Arguments that cannot be meant, and stores that the board would refuse.
pub fn flash(args: &[String]) -> Result<ExitCode, Failure> {
    let asked = asked(args)?;
    let mut blobs = Vec::new();
    if let Some(path) = &asked.tiles {
        let all = region("TILES")?;
        let end = if asked.way == Way::Dfu { DFU_END } else { all.end };
        blobs.push(store::read(path, TILES, all.start..end)?);
    }
    let settings = asked.settings.as_deref();
    let configuration = match asked.configuration {
        Some(camera) if store::is_camera_file(&camera) => match build::command() {
            Ok(()) => Some(store::made(&camera, settings)?),
            Err(sentence) => return Ok(super::failed(sentence)),
        },
        other => other,
    };
    let has_configuration = configuration.is_some();
    if let Some(path) = configuration {
        blobs.push(store::read(&path, store::CONFIGURATION, region("CONFIGURATION")?)?);
    }
    match &asked.key {
        Some(path) => blobs.push(store::read(path, KEY, region("KEY")?)?),
        None if has_configuration => {
            eprintln!("without --key the board signs nothing: a key on it goes with the configuration's sector");
        }
        None => {}
    }
    if let Some(path) = &asked.plan {
        blobs.push(store::read(path, PLAN, region("PLAN")?)?);
    }
    if asked.plan.is_some() || asked.key.is_some() {
        // By a probe each piece is written by its own call, which erases its sector.
        blobs = store::joined(blobs)?;
    }
    Ok(write(asked.way, &blobs).map_or_else(super::failed, |()| ExitCode::SUCCESS))
}

fn asked(args: &[String]) -> Result<Asked, Failure> {
    let mut asked = Asked::default();
    let mut args = args.iter();
    while let Some(arg) = args.next() {
        let mut file = || args.next().map(PathBuf::from).ok_or_else(|| format!("{arg} needs a file"));
        match arg.as_str() {
            "--bare" => asked.way = Way::Bare,
            "--probe" if asked.way == Way::Dfu => asked.way = Way::Probe,
            "--probe" => {}
            // One store: the camera file's content is part of the configuration's.
            "--configuration" | "--mission" | "--camera" if asked.configuration.is_some() => {
                return Err("flash writes one configuration: give --camera or --configuration, once".into());
            }
            "--configuration" | "--mission" | "--camera" => asked.configuration = Some(file()?),
            "--settings" => asked.settings = Some(file()?),
            "--tiles" => asked.tiles = Some(file()?),
            "--plan" => asked.plan = Some(file()?),
            "--key" => asked.key = Some(file()?),
            other => {
                return Err(format!(
                    "flash knows --bare, --probe, --camera, --settings, --configuration, --plan, --key and --tiles, but not {other:?}"
                ));
            }
        }
    }
    let is_camera_file = asked.configuration.as_deref().is_some_and(store::is_camera_file);
    match asked.settings {
        Some(_) if !is_camera_file => Err("--settings goes with a camera file: --camera FILE.toml".into()),
        _ if asked.plan.is_some() && asked.configuration.is_none() => {
            Err("the plan goes with the configuration, whose sector it shares and which is erased: give --camera or --configuration too".into())
        }
        _ if asked.key.is_some() && asked.configuration.is_none() => {
            Err("the key goes with the configuration, whose sector it shares and which is erased: give --camera or --configuration too".into())
        }
        _ if asked.way == Way::Dfu && asked.tiles.is_some() && asked.configuration.is_none() => Err(
            "by DFU the tiles go with the configuration, whose sector lies before them and is erased: give --camera or --configuration too"
                .into(),
        ),
        _ => Ok(asked),
    }
}

fn write(way: Way, blobs: &[Blob]) -> Result<(), Failure> {
    let compiler = set_up::compiler()?;
    build::h743(&compiler)?;
    board::check(None).map_err(|why| format!("{why}; nothing was written"))?;
    let path = places::image_h743(if way == Way::Bare { "h743" } else { "h743-dfu" });
    match way {
        Way::Dfu => by_dfu(&Image::read(&path)?, blobs),
        Way::Probe => by_probe(&path, blobs),
        Way::Bare => {
            eprintln!(
                "--bare: the image goes over the camera's bootloader; DFU works again when that has been restored"
            );
            by_probe(&path, blobs)
        }
    }
}

/// Makes the file, and writes it where the tool and the camera are there; else says what to type.
fn by_dfu(image: &Image, blobs: &[Blob]) -> Result<(), Failure> {
    let pieces = image.loads.iter().map(|load| {
        let from = load.offset as usize;
        (load.address, image.file.get(from..from + load.size as usize).unwrap_or(&[]))
    });
    let blobs = blobs.iter().map(|blob| (blob.address, &blob.bytes[..]));
    let file = dfu::file(pieces.chain(blobs), map::APPLICATION..DFU_END)?;
    let path = places::scratch().join("plumbline-h743.dfu");
    fs::create_dir_all(places::scratch()).map_err(|error| format!("{}: {error}", places::scratch().display()))?;
    fs::write(&path, &file).map_err(|error| format!("{}: {error}", path.display()))?;
    println!("{}: {} bytes", path.display(), file.len());
    let device = format!("{:04x}:{:04x}", dfu::VENDOR, dfu::PRODUCT);
    let mut command = Command::new("dfu-util");
    command.args(["-w", "-d", &device, "-a", "FIRMWARE", "--reset", "-D"]).arg(&path);
    let typed = format!("dfu-util -w -d {device} -a FIRMWARE --reset -D {}", path.display());
    match output(Command::new("dfu-util").arg("--list")) {
        Some(devices) if devices.contains(&device) => run(&mut command),
        Some(_) => {
            println!("no camera in its bootloader: type this, then plug it in\n    {typed}");
            Ok(())
        }
        None => {
            println!(
                "dfu-util is missing: install it (`apt-get install dfu-util`), type this, then plug the camera in"
            );
            println!("    {typed}");
            Ok(())
        }
    }
}

/// Each piece by its own call: probe-rs erases no more than the sectors of what it is given.
fn by_probe(image: &Path, blobs: &[Blob]) -> Result<(), Failure> {
    if !succeeds(Command::new("probe-rs").arg("--version")) {
        return Err(
            "probe-rs is missing: type `cargo install probe-rs-tools --locked` (Debian: needs libudev-dev and \
            pkg-config)"
                .into(),
        );
    }
    run(Command::new("probe-rs").args(["download", "--chip", CHIP]).arg(image))?;
    for blob in blobs {
        let address = format!("{:#010x}", blob.address);
        let options = ["download", "--chip", CHIP, "--binary-format", "bin", "--base-address", &address];
        run(Command::new("probe-rs").args(options).arg(&blob.path))?;
    }
    run(Command::new("probe-rs").args(["reset", "--chip", CHIP]))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn asked_for(line: &str) -> Result<Asked, Failure> {
        asked(&line.split_whitespace().map(String::from).collect::<Vec<_>>())
    }

    #[test]
    fn the_bare_image_is_written_only_when_it_is_asked_for() {
        assert_eq!(asked_for("").unwrap().way, Way::Dfu);
        assert_eq!(asked_for("--probe").unwrap().way, Way::Probe);
        assert_eq!(asked_for("--bare").unwrap().way, Way::Bare);
        assert_eq!(asked_for("--bare --probe").unwrap().way, Way::Bare);
        assert_eq!(asked_for("--tiles t.bin --camera m.bin").unwrap().tiles, Some("t.bin".into()));
        assert!(asked_for("--tiles").is_err() && asked_for("--erase-all").is_err());
    }

    #[test]
    fn settings_go_with_a_camera_file_and_there_is_one_configuration() {
        let asked = asked_for("--settings s.toml --camera c.toml").unwrap();
        assert_eq!((asked.configuration, asked.settings), (Some("c.toml".into()), Some("s.toml".into())));
        assert!(asked_for("--settings s.toml").unwrap_err().contains("camera file"));
        assert!(asked_for("--plan p.bin").unwrap_err().contains("configuration"));
        assert_eq!(asked_for("--probe --plan p.bin --configuration m.bin").unwrap().plan, Some("p.bin".into()));
        assert!(asked_for("--key k.bin").unwrap_err().contains("configuration") && asked_for("--key").is_err());
        assert_eq!(asked_for("--configuration m.bin --key k.bin").unwrap().key, Some("k.bin".into()));
        assert!(asked_for("--settings s.toml --mission m.bin").unwrap_err().contains("camera file"));
        assert!(asked_for("--camera c.toml --mission m.bin").unwrap_err().contains("one configuration"));
    }
}
