//! `plumbline match`: where a rectified patch lies in a reference.

mod georeference;

use crate::outcome::{Failure, Outcome};
use georeference::{Georeference, OnGround};
use plumbline_sim::camera::still::{PATCH_MAX_PX, runs_of};
use plumbline_sim::camera::still_match::{Place, find};
use plumbline_sim::camera::unknown::filled;
use plumbline_survey::error::InputError;
use plumbline_survey::io::picture::{Picture, read_grey};
use serde::Serialize;
use std::path::{Path, PathBuf};

#[derive(Debug, clap::Args)]
pub struct Args {
    /// The patch, row 0 north. Where it and the reference are georeferenced, it is looked for where it says that it lies, else in the
    /// reference's middle
    #[arg(long)]
    patch: PathBuf,
    /// Its mask, 0 invalid; everything valid unless given
    #[arg(long)]
    mask: Option<PathBuf>,
    /// The reference, row 0 north, same resolution; a GeoTIFF gives metres as well
    #[arg(long)]
    reference: PathBuf,
    /// Mask of the reference, 0 where it is not to be matched (clouds, water, what has no data); all of it counts unless given
    #[arg(long, value_name = "MASK")]
    reference_mask: Option<PathBuf>,
    /// Search radius, pixels, 1 to 256
    #[arg(long, value_parser = clap::value_parser!(u16).range(1..=256), allow_negative_numbers = true)]
    search_px: u16,
    /// Accepted probability that the place is wrong by more than three pixels, 1e-5 to below 1
    #[arg(long, default_value_t = 1e-4, allow_negative_numbers = true)]
    risk: f32,
    /// One sigma, each axis, of where the reference has its ground, metres; what two orthophotos of other years lie apart is in the sigmas
    /// without it. The reference must be a GeoTIFF in metres
    #[arg(long, value_name = "METRES", value_parser = sigma, default_value_t = 0.0, allow_negative_numbers = true)]
    map_sigma_m: f64,
    /// Print one JSON document
    #[arg(long)]
    json: bool,
}

/// The answer, with its place on the ground where the reference has one.
#[derive(Serialize)]
struct Answer {
    #[serde(flatten)]
    place: Place,
    #[serde(flatten)]
    on_ground: Option<OnGround>,
}

/// What a map may be off: as the board's settings have it.
fn sigma(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if (0.0..=1000.0).contains(&value) => Ok(value),
        _ => Err("not between 0 and 1000".to_owned()),
    }
}

pub fn run(args: &Args) -> Result<Outcome, Failure> {
    let patch = sized(&args.patch)?;
    let mask = match &args.mask {
        Some(path) => {
            let mask = read_grey(path)?;
            if (mask.cols, mask.rows) != (patch.cols, patch.rows) {
                return Err(Failure::Input(InputError::new(format!(
                    "{} has {} x {} pixels, the patch {} x {}",
                    path.display(),
                    mask.cols,
                    mask.rows,
                    patch.cols,
                    patch.rows
                ))));
            }
            mask
        }
        None => Picture { pixels: vec![255; patch.pixels.len()], ..patch },
    };
    let reference = reference(args)?;
    let margin = 2 * args.search_px as usize;
    if reference.cols < patch.cols + margin || reference.rows < patch.rows + margin {
        return Err(Failure::Input(InputError::new(format!(
            "{} has {} x {} pixels, a patch of {} x {} and a search of {} need {} x {}",
            args.reference.display(),
            reference.cols,
            reference.rows,
            patch.cols,
            patch.rows,
            args.search_px,
            patch.cols + margin,
            patch.rows + margin
        ))));
    }
    let named = |error: InputError| {
        let mask = args.mask.as_ref().map(|mask| format!(" under {}", mask.display())).unwrap_or_default();
        InputError::new(format!("{}{mask} in {}: {error}", args.patch.display(), args.reference.display()))
    };
    let georeference = Georeference::read(&args.patch, &args.reference, (patch.cols, patch.rows))?;
    let near = georeference.and_then(|georeference| georeference.near());
    let is_on = |(col, row): (f64, f64)| {
        (0.0..=reference.cols as f64 - 1.0).contains(&col) && (0.0..=reference.rows as f64 - 1.0).contains(&row)
    };
    if near.is_some_and(|near| !is_on(near)) {
        let (patch, reference) = (args.patch.display(), args.reference.display());
        return Err(Failure::Input(InputError::new(format!("{patch} lies beside {reference} by their georeferences"))));
    }
    let map_px = map_px(args, georeference.as_ref())?;
    let searched = (&reference, near);
    let place = find(&patch, &runs_of(&mask), searched, args.search_px, (args.risk, map_px)).map_err(named)?;
    let on_ground = georeference.map(|georeference| georeference.on_ground(&place, (reference.cols, reference.rows)));
    let answer = Answer { place, on_ground };
    Outcome::new(args.json, &answer, || text_of(&answer))
}

/// The map's sigma in pixels.
fn map_px(args: &Args, georeference: Option<&Georeference>) -> Result<f32, InputError> {
    match georeference {
        Some(georeference) => Ok((args.map_sigma_m / georeference.pixel_m()) as f32),
        None if args.map_sigma_m == 0.0 => Ok(0.0),
        None => Err(InputError::new(format!(
            "--map-sigma-m {} counts metres, and {} does not say how many a pixel has",
            args.map_sigma_m,
            args.reference.display()
        ))),
    }
}

/// The reference; what its mask leaves out is filled in so that it says nothing.
fn reference(args: &Args) -> Result<Picture, InputError> {
    let reference = read_grey(&args.reference)?;
    let Some(path) = &args.reference_mask else { return Ok(reference) };
    let mask = read_grey(path)?;
    if (mask.cols, mask.rows) != (reference.cols, reference.rows) {
        return Err(InputError::new(format!(
            "{} has {} x {} pixels, the reference {} x {}",
            path.display(),
            mask.cols,
            mask.rows,
            reference.cols,
            reference.rows
        )));
    }
    let known: Vec<bool> = mask.pixels.iter().map(|pixel| *pixel > 0).collect();
    if !known.contains(&true) {
        return Err(InputError::new(format!("{}: it leaves nothing of the reference", path.display())));
    }
    Ok(filled(&reference, &known))
}

/// A picture that sixteen bits can address.
fn sized(path: &Path) -> Result<Picture, Failure> {
    let picture = read_grey(path)?;
    if picture.cols > PATCH_MAX_PX || picture.rows > PATCH_MAX_PX {
        return Err(Failure::Input(InputError::new(format!(
            "{} has {} x {} pixels, a patch has at most {PATCH_MAX_PX} x {PATCH_MAX_PX}",
            path.display(),
            picture.cols,
            picture.rows
        ))));
    }
    Ok(picture)
}

fn text_of(Answer { place, on_ground }: &Answer) -> String {
    let verdict = place.reason.unwrap_or("accepted");
    let mut text = format!(
        "d_col {} d_row {} px right and down from the reference's middle, sigma {:.2} {:.2} score {} second {} risk {:.1e} {verdict}\n",
        place.d_col, place.d_row, place.sigma_col, place.sigma_row, place.score, place.second_peak, place.risk
    );
    if let Some(at) = on_ground {
        let system = at.epsg.map(|code| format!("EPSG:{code}")).or(at.crs.clone());
        let system = system.map_or_else(String::new, |system| format!(" on {system}"));
        text.push_str(&format!(
            "east {:.2} north {:.2} sigma {:.2} {:.2} m{system}\n",
            at.east_m, at.north_m, at.sigma_east_m, at.sigma_north_m
        ));
        if let (Some(east), Some(north)) = (at.offset_east_m, at.offset_north_m) {
            text.push_str(&format!(
                "offset east {east:.2} north {north:.2} m from where the patch's own georeference has it\n"
            ));
        }
    }
    text
}
