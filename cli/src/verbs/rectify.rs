//! `plumbline rectify`: one frame onto the ground plane.

use super::attitude::AttitudeArgs;
use super::positive;
use crate::files::{Files, check_extension};
use crate::outcome::{Failure, Outcome};
use plumbline_core::homography::Homography;
use plumbline_core::tilt::{camera_from_local, equivalent_tilt, follow_up_command};
use plumbline_sim::camera::still::{self, Target};
use plumbline_sim::camera::{core_camera, read};
use plumbline_survey::error::InputError;
use plumbline_survey::io::picture::{read_grey, write_grey_png};
use serde::Serialize;
use std::path::PathBuf;

#[derive(Debug, clap::Args)]
pub struct Args {
    /// Camera file (TOML)
    #[arg(long)]
    camera: PathBuf,
    /// The frame, PNG, TIFF or JPEG, row 0 forward
    #[arg(long)]
    frame: PathBuf,
    #[command(flatten)]
    attitude: AttitudeArgs,
    /// Vertical height above ground, metres
    #[arg(long, value_parser = positive, required_unless_present = "range_m", conflicts_with = "range_m", allow_negative_numbers = true)]
    height_m: Option<f64>,
    /// Slant range of a strapped-down range finder, metres
    #[arg(long, value_parser = range, allow_negative_numbers = true)]
    range_m: Option<f64>,
    /// Metres a patch pixel
    #[arg(long, value_parser = positive, allow_negative_numbers = true)]
    resolution_m: f64,
    /// Patch columns, by eq. 4 unless given
    #[arg(long, requires = "rows", allow_negative_numbers = true)]
    cols: Option<usize>,
    /// Patch rows
    #[arg(long, requires = "cols", allow_negative_numbers = true)]
    rows: Option<usize>,
    /// The patch, PNG, row 0 north
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

#[derive(Serialize)]
struct Summary {
    cols: usize,
    rows: usize,
    height_m: f64,
    valid_fraction: f64,
    follow_up_deg: f32,
    equivalent_pitch_deg: f32,
    equivalent_roll_deg: f32,
}

pub fn run(args: &Args) -> Result<Outcome, Failure> {
    check_files(args)?;
    let file = read(&args.camera)?;
    let camera = core_camera(&file)?;
    let attitude = args.attitude.attitude()?;
    let frame = read_grey(&args.frame)?;
    if (frame.cols, frame.rows) != (file.cols as usize, file.rows as usize) {
        return Err(Failure::Input(InputError::new(format!(
            "{} has {} x {} pixels, but {} says {} x {}",
            args.frame.display(),
            frame.cols,
            frame.rows,
            args.camera.display(),
            file.cols,
            file.rows
        ))));
    }
    let height_m = match (args.height_m, args.range_m) {
        (Some(height), _) => height,
        (None, range) => range.unwrap_or_default() * f64::from(attitude.cos_tilt()),
    };
    let follow_up = args.attitude.follow_up(attitude);
    // Eq. 7 where it holds, eq. 3 otherwise, as on board.
    let homography = if args.attitude.is_followed(attitude) && camera.is_isotropic() {
        Homography::simplified(equivalent_tilt(attitude, follow_up), &camera)
    } else {
        Homography::full(&camera_from_local(attitude, follow_up), &camera)
    };
    let size = args.cols.zip(args.rows);
    let target = Target { height_m, resolution_m: args.resolution_m, size };
    let patch = still::rectify(&camera, &frame, homography, &target)?;
    let equivalent = equivalent_tilt(attitude, follow_up_command(attitude));
    write_grey_png(&args.out, &patch.picture)?;
    if let Some(mask) = &args.mask {
        write_grey_png(mask, &patch.mask())?;
    }
    let summary = Summary {
        cols: patch.picture.cols,
        rows: patch.picture.rows,
        height_m,
        valid_fraction: patch.valid_fraction(),
        follow_up_deg: follow_up.to_degrees(),
        equivalent_pitch_deg: equivalent.pitch.to_degrees(),
        equivalent_roll_deg: equivalent.roll.to_degrees(),
    };
    let text = || {
        format!(
            "{} x {} pixels of {} m at {:.2} m height, {:.1} % valid: {}\n",
            summary.cols,
            summary.rows,
            args.resolution_m,
            height_m,
            100.0 * summary.valid_fraction,
            args.out.display()
        )
    };
    Outcome::new(args.json, &summary, text)
}

fn check_files(args: &Args) -> Result<(), InputError> {
    Files::default()
        .reads("--camera", &args.camera)
        .reads("--frame", &args.frame)
        .writes("--out", &args.out)
        .may_write("--mask", args.mask.as_ref())
        .check()?;
    check_extension("--out", &args.out, "png")?;
    args.mask.iter().try_for_each(|mask| check_extension("--mask", mask, "png"))
}
