//! `plumbline rectify`: one frame onto the ground plane, or onto its terrain.

mod orientation;
mod place;

use super::positive;
use crate::files::{Files, check_extension};
use crate::outcome::{Failure, Outcome, note};
use orientation::{Orientation, OrientationArgs};
use place::{Place, PlaceArgs, terrain};
use plumbline_core::camera::Camera;
use plumbline_sim::camera::still::{self, Patch, Target};
use plumbline_sim::camera::{core_camera, oriented, read, render_camera};
use plumbline_survey::camera_file::CameraFile;
use plumbline_survey::crs::System;
use plumbline_survey::dem::Heights;
use plumbline_survey::error::InputError;
use plumbline_survey::io::output::write_file;
use plumbline_survey::io::picture::{Picture, read_grey, write_grey_png};
use plumbline_survey::io::raster::grey_geotiff_bytes;
use serde::Serialize;
use std::path::{Path, PathBuf};

#[derive(Debug, clap::Args)]
pub struct Args {
    /// Camera file (TOML)
    #[arg(long)]
    camera: PathBuf,
    /// The frame, PNG, TIFF or JPEG, row 0 forward
    #[arg(long)]
    frame: PathBuf,
    #[command(flatten)]
    orientation: OrientationArgs,
    #[command(flatten)]
    place: PlaceArgs,
    /// Vertical height above level ground, metres
    #[arg(long, value_parser = positive, conflicts_with_all = ["range_m", "dem"], allow_negative_numbers = true)]
    height_m: Option<f64>,
    /// Slant range of a strapped-down range finder, metres
    #[arg(long, value_parser = range, conflicts_with = "dem", allow_negative_numbers = true)]
    range_m: Option<f64>,
    /// Metres a patch pixel
    #[arg(long, value_parser = positive, allow_negative_numbers = true)]
    resolution_m: f64,
    /// Patch columns, by eq. 4 unless given
    #[arg(long, requires = "rows", allow_negative_numbers = true, value_parser = side)]
    cols: Option<usize>,
    /// Patch rows
    #[arg(long, requires = "cols", allow_negative_numbers = true, value_parser = side)]
    rows: Option<usize>,
    /// The patch, row 0 north: PNG, or GeoTIFF with a position (no-data 0, the darkest grey 1)
    #[arg(long)]
    out: PathBuf,
    /// The mask, PNG, 255 valid
    #[arg(long)]
    mask: Option<PathBuf>,
    /// Print one JSON document
    #[arg(long)]
    json: bool,
}

/// A range; 65535 is what a range finder sends when it sees nothing.
fn range(text: &str) -> Result<f64, String> {
    let value = positive(text)?;
    if value >= 65535.0 { Err("an error code, not a range".to_owned()) } else { Ok(value) }
}

/// A side of the patch.
fn side(text: &str) -> Result<usize, String> {
    let most = still::PATCH_MAX_PX;
    let side = text.parse().ok().filter(|side| (1..=most).contains(side));
    side.ok_or_else(|| format!("not a whole number from 1 to {most}"))
}

/// What was made. Follow-up and equivalent angles are a vehicle's: null by omega, phi, kappa.
#[derive(Serialize)]
struct Summary {
    cols: usize,
    rows: usize,
    height_m: f64,
    valid_fraction: f64,
    follow_up_deg: Option<f32>,
    equivalent_pitch_deg: Option<f32>,
    equivalent_roll_deg: Option<f32>,
    #[serde(skip_serializing_if = "Option::is_none")]
    east_m: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    north_m: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    epsg: Option<u32>,
}

pub fn run(args: &Args) -> Result<Outcome, Failure> {
    check_files(args)?;
    let file = read(&args.camera)?;
    super::ask(&file);
    let camera = core_camera(&file)?;
    let orientation = Orientation::new(&args.orientation)?;
    let place = args.place.place()?;
    if is_geotiff(&args.out) && !place.is_known {
        let path = args.out.display();
        let why = format!("--out {path}: a GeoTIFF says where it lies: give --east-m and --north-m, or write a .png");
        return Err(Failure::Input(InputError::new(why)));
    }
    let frame = frame_of(args, &file)?;
    let (patch, height_m) = rectified(args, (&file, &camera), &frame, &orientation, &place)?;
    sees_something(args, &patch)?;
    write(args, &patch, &place)?;
    if place.is_known && args.place.dem.is_none() {
        eprintln!("plumbline: the ground is taken to be level; over relief give --dem");
    }
    let [follow_up_deg, equivalent_pitch_deg, equivalent_roll_deg] =
        orientation.angles_deg().map_or([None; 3], |angles| angles.map(Some));
    let summary = Summary {
        cols: patch.picture.cols,
        rows: patch.picture.rows,
        height_m,
        valid_fraction: patch.valid_fraction(),
        follow_up_deg,
        equivalent_pitch_deg,
        equivalent_roll_deg,
        east_m: place.is_known.then_some(place.centre[0]),
        north_m: place.is_known.then_some(place.centre[1]),
        epsg: place.system().filter(|_| place.is_known).and_then(System::code),
    };
    let cells = place.cells((summary.cols, summary.rows), args.resolution_m);
    let position = place.position(height_m);
    let shown = oriented::shown(&render_camera(&file), &orientation.exterior(position), position[2] - height_m, &cells);
    let text = || {
        format!(
            "{} x {} pixels of {} m at {:.2} m height, {:.1} % valid: {}{}\n",
            summary.cols,
            summary.rows,
            args.resolution_m,
            height_m,
            100.0 * summary.valid_fraction,
            args.out.display(),
            beyond(summary.valid_fraction, shown)
        )
    };
    Outcome::new(args.json, &summary, text)
}

/// Refuses a patch without a valid pixel.
fn sees_something(args: &Args, patch: &Patch) -> Result<(), InputError> {
    if patch.valid_fraction() > 0.0 {
        return Ok(());
    }
    let Picture { cols, rows, .. } = patch.picture;
    Err(InputError::new(format!(
        "{} sees nothing of the patch, {cols} x {rows} pixels of {} m around the point below the camera; angles, position and height say where it \
         looks, --cols and --rows make a larger patch",
        args.frame.display(),
        args.resolution_m
    )))
}

/// Shares of patch and frame that are worth a word.
const BEYOND: f64 = 0.05;

/// What of the patch the frame does not see, and what of the frame the patch does not show; each as a share of its own pixels.
fn beyond(valid: f64, shown: f64) -> String {
    let percent = |share: f64| format!("{:.1} %", 100.0 * (1.0 - share));
    let outside = (1.0 - valid > BEYOND).then(|| format!("{} of the patch is not seen by the frame", percent(valid)));
    let left_out = (1.0 - shown > BEYOND).then(|| {
        format!("{} of the frame lies outside the patch (--cols and --rows make a larger one)", percent(shown))
    });
    let parts: Vec<String> = outside.into_iter().chain(left_out).collect();
    if parts.is_empty() { String::new() } else { format!("; {}", parts.join(", ")) }
}

fn frame_of(args: &Args, file: &CameraFile) -> Result<Picture, Failure> {
    let frame = read_grey(&args.frame)?;
    if (frame.cols, frame.rows) == (file.cols as usize, file.rows as usize) {
        return Ok(frame);
    }
    Err(Failure::Input(InputError::new(format!(
        "{} has {} x {} pixels, but {} says {} x {}",
        args.frame.display(),
        frame.cols,
        frame.rows,
        args.camera.display(),
        file.cols,
        file.rows
    ))))
}

/// The patch and the height above the ground: by the core onto a plane, by each pixel's own height over an elevation model, and so by
/// omega, phi, kappa.
fn rectified(
    args: &Args,
    (file, camera): (&CameraFile, &Camera),
    frame: &Picture,
    orientation: &Orientation,
    place: &Place,
) -> Result<(Patch, f64), Failure> {
    let size = args.cols.zip(args.rows);
    // The ground below, for the height, and then as far as the patch reaches.
    let below = place.heights(args.resolution_m)?;
    let height_m = match (&below, args.height_m, args.range_m) {
        (Some(heights), ..) => place.height_m(heights)?,
        (None, Some(height), _) => height,
        (None, None, Some(range)) => range * orientation.cos_tilt(),
        (None, None, None) => {
            let why = "the height is missing: --height-m or --range-m, or --dem with the camera's position";
            return Err(Failure::Input(InputError::new(why)));
        }
    };
    if below.is_none()
        && let Some(homography) = orientation.homography(camera)
    {
        let target = Target { height_m, resolution_m: args.resolution_m, size };
        return Ok((still::rectify(camera, frame, homography, &target)?, height_m));
    }
    let size = size.unwrap_or_else(|| {
        let (cols, rows) = camera.patch_size(height_m as f32, args.resolution_m as f32);
        (cols as usize, rows as usize)
    });
    let reach_m = (size.0.max(size.1).min(still::PATCH_MAX_PX) as f64 + 2.0) * args.resolution_m;
    let heights = place.heights(reach_m)?;
    let doubt = heights.as_ref().and_then(Heights::doubt);
    doubt.zip(args.place.dem.as_ref()).iter().for_each(|(doubt, dem)| note(&doubt.of(dem)));
    let (exterior, cells) = (orientation.exterior(place.position(height_m)), place.cells(size, args.resolution_m));
    let patch = oriented::rectify(&render_camera(file), frame, &exterior, terrain(heights.as_ref()), &cells)?;
    Ok((patch, height_m))
}

fn write(args: &Args, patch: &Patch, place: &Place) -> Result<(), Failure> {
    let mask = patch.mask();
    if is_geotiff(&args.out) {
        let geo = place.georeference((patch.picture.cols, patch.picture.rows), args.resolution_m);
        // 0 is no-data: what is black and valid is a grey above.
        let grey = |(pixel, valid): (&u8, &u8)| if *valid == 0 { 0 } else { (*pixel).max(1) };
        let pixels = patch.picture.pixels.iter().zip(&mask.pixels).map(grey).collect();
        let bytes = grey_geotiff_bytes(&Picture { pixels, ..patch.picture }, &geo, place.system(), Some(0))?;
        write_file(&args.out, &bytes)?;
    } else {
        write_grey_png(&args.out, &patch.picture)?;
    }
    if let Some(path) = &args.mask {
        write_grey_png(path, &mask)?;
    }
    Ok(())
}

fn is_geotiff(path: &Path) -> bool {
    let is =
        |extension: &std::ffi::OsStr| extension.eq_ignore_ascii_case("tif") || extension.eq_ignore_ascii_case("tiff");
    path.extension().is_some_and(is)
}

fn check_files(args: &Args) -> Result<(), InputError> {
    Files::default()
        .reads("--camera", &args.camera)
        .reads("--frame", &args.frame)
        .may_read("--dem", args.place.dem.as_ref())
        .writes("--out", &args.out)
        .may_write("--mask", args.mask.as_ref())
        .check()?;
    if !is_geotiff(&args.out) {
        check_extension("--out", &args.out, "png")?;
    }
    args.mask.iter().try_for_each(|mask| check_extension("--mask", mask, "png"))
}
