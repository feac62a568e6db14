//! `plumbline map`: eq. 3 and eq. 7 on single pixels, by the core or by the oracle.

use super::attitude::AttitudeArgs;
use super::finite;
use crate::outcome::Failure::Input;
use crate::outcome::{Failure, Outcome};
use clap::ValueEnum;
use plumbline_core::homography::Homography;
use plumbline_core::tilt::{camera_from_local, equivalent_tilt};
use plumbline_sim::camera::{core_camera, oracle_camera, read};
use plumbline_sim::oracle;
use plumbline_survey::error::InputError;
use serde::Serialize;
use std::path::PathBuf;

#[derive(Debug, clap::Args)]
pub struct Args {
    /// Camera file (TOML)
    #[arg(long)]
    camera: PathBuf,
    #[command(flatten)]
    attitude: AttitudeArgs,
    /// Model: eq. 3 in full, or eq. 7, which needs equal fields of view and a camera that follows
    #[arg(long, value_enum, default_value = "full")]
    model: Model,
    /// Answer by the independent f64 oracle instead of the core's f32 code
    #[arg(long)]
    oracle: bool,
    /// Points M,N: undistorted pixels right and forward of the centre
    #[arg(last = true, required = true, value_parser = point, value_name = "M,N")]
    points: Vec<(f64, f64)>,
}

#[derive(Clone, Copy, Debug, PartialEq, ValueEnum)]
enum Model {
    Full,
    Simplified,
}

/// Farthest point that is mapped: many frames beside the largest.
const POINT_MAX_PX: f64 = 1e6;

fn point(text: &str) -> Result<(f64, f64), String> {
    let (m, n) = text.split_once(',').ok_or("a point is M,N")?;
    match (finite(m.trim())?, finite(n.trim())?) {
        (m, n) if m.abs().max(n.abs()) <= POINT_MAX_PX => Ok((m, n)),
        _ => Err(format!("farther than {POINT_MAX_PX} pixels from the centre")),
    }
}

/// A line of output; frame positions are null behind the camera.
#[derive(Serialize)]
struct Line<T> {
    m: f64,
    n: f64,
    m_frame: Option<T>,
    n_frame: Option<T>,
    in_front: bool,
}

pub fn run(args: &Args) -> Result<Outcome, Failure> {
    let file = read(&args.camera)?;
    super::ask(&file);
    let camera = core_camera(&file)?;
    let attitude = args.attitude.looking_down()?;
    if args.model == Model::Simplified {
        if !camera.is_isotropic() {
            return Err(Input(InputError::new(format!(
                "--model simplified: eq. 7 needs equal fields of view a pixel, and {} has different ones",
                args.camera.display()
            ))));
        }
        if !args.attitude.is_followed(attitude) {
            return Err(Input(InputError::new(
                "--model simplified: eq. 7 holds only for a camera that follows, use --follow-up-deg auto or --model full",
            )));
        }
    }
    if args.oracle { by_oracle(args, &file) } else { by_core(args, &camera, attitude) }
}

fn by_core(
    args: &Args,
    camera: &plumbline_core::camera::Camera,
    attitude: plumbline_core::tilt::Attitude,
) -> Result<Outcome, Failure> {
    let follow_up = args.attitude.follow_up(attitude);
    let homography = match args.model {
        Model::Full => Homography::full(&camera_from_local(attitude, follow_up), camera),
        Model::Simplified => Homography::simplified(equivalent_tilt(attitude, follow_up), camera),
    };
    let line = |&(m, n): &(f64, f64)| {
        let frame = homography.ideal(m as f32, n as f32).map(|(m, n)| camera.distorted(m, n));
        let in_front = homography.denominator(m as f32, n as f32) > 0.0;
        Line { m, n, m_frame: frame.map(|f| f.0), n_frame: frame.map(|f| f.1), in_front }
    };
    Outcome::lines(&args.points.iter().map(line).collect::<Vec<_>>())
}

fn by_oracle(args: &Args, file: &plumbline_survey::camera_file::CameraFile) -> Result<Outcome, Failure> {
    let [heading, pitch, roll] = args.attitude.angles_rad();
    let follow_up = args.attitude.follow_up_rad(oracle::follow_up_exact(heading, pitch, roll));
    let a = oracle::matrix_a(heading, pitch, roll, follow_up);
    let camera = oracle_camera(file);
    let line = |&(m, n): &(f64, f64)| {
        let frame = match args.model {
            Model::Full => oracle::frame_from_ground(&a, &camera, m, n),
            Model::Simplified => {
                let (pitch, roll) = oracle::equivalent_pitch_roll(heading, pitch, roll);
                oracle::frame_from_ground_simplified(pitch, roll, &camera, m, n)
                    .ok_or_else(|| Failure::Work("eq. 7 needs square pixels".to_owned()))?
            }
        };
        let seen = |value: f64| frame.in_front.then_some(value);
        Ok(Line { m, n, m_frame: seen(frame.m), n_frame: seen(frame.n), in_front: frame.in_front })
    };
    Outcome::lines(&args.points.iter().map(line).collect::<Result<Vec<_>, Failure>>()?)
}
