//! `plumbline camera new`: a commented camera file.

use super::positive;
use crate::files::Files;
use crate::outcome::{Failure, Outcome, note};
use plumbline_survey::camera_file::CameraFile;
use plumbline_survey::camera_file::imported::{
    PRESETS, check_made, commented, focal_px_of_35_mm, from_odm, from_opencv, not_square, of_focal_px, of_fov, preset,
};
use plumbline_survey::error::InputError;
use plumbline_survey::io::input;
use plumbline_survey::io::output::write_file;
use std::path::PathBuf;

#[derive(Debug, clap::Args)]
pub struct Args {
    #[command(subcommand)]
    what: What,
}

#[derive(Debug, clap::Subcommand)]
enum What {
    /// Write a commented camera file to standard output, or to --out
    New(New),
}

#[derive(Debug, clap::Args)]
#[group(required = true, multiple = false)]
struct Source {
    /// A camera by its maker's data sheet, not calibrated: paper, pi-v2, pi-hq-6mm, pi-gs-6mm, phantom-4-pro, mavic-3e, zenmuse-p1-35mm
    #[arg(long, value_name = "NAME")]
    preset: Option<String>,
    /// A calibration stored by OpenCV (YAML or JSON, with image_width, image_height, camera_matrix, distortion_coefficients)
    #[arg(long, value_name = "FILE")]
    from_opencv: Option<PathBuf>,
    /// A camera of OpenDroneMap's cameras.json
    #[arg(long, value_name = "FILE")]
    from_odm: Option<PathBuf>,
    /// Full fields of view across and along, degrees: 60x46.8; needs --size
    #[arg(long, value_name = "HxV", value_parser = fields, requires = "size", allow_hyphen_values = true)]
    fov: Option<[f64; 2]>,
    /// Focal length, pixels; needs --size
    #[arg(long, value_name = "PX", value_parser = positive, requires = "size", allow_negative_numbers = true)]
    focal_px: Option<f64>,
    /// Focal length, mm; needs --size and --sensor-mm
    #[arg(long, value_name = "MM", value_parser = positive, requires = "size", requires = "sensor_mm", allow_negative_numbers = true)]
    focal_mm: Option<f64>,
    /// Focal length, mm on a 36 x 24 mm sensor of the same diagonal field of view, as shops and EXIF have it; needs --size
    #[arg(long, value_name = "MM", value_parser = positive, requires = "size", allow_negative_numbers = true)]
    focal_35mm: Option<f64>,
}

impl Source {
    /// The option that was given, as messages call it.
    fn words(&self) -> String {
        let file =
            |option: &str, path: &Option<PathBuf>| path.as_ref().map(|path| format!("{option} {}", path.display()));
        let number = |option: &str, value: Option<f64>| value.map(|value| format!("{option} {value}"));
        let given = [
            self.preset.as_ref().map(|name| format!("--preset {name}")),
            file("--from-opencv", &self.from_opencv),
            file("--from-odm", &self.from_odm),
            self.fov.map(|[h, v]| format!("--fov {h}x{v}")),
            number("--focal-px", self.focal_px),
            number("--focal-mm", self.focal_mm),
            number("--focal-35mm", self.focal_35mm),
        ];
        given.into_iter().flatten().next().unwrap_or_default()
    }
}

#[derive(Debug, clap::Args)]
struct New {
    #[command(flatten)]
    source: Source,
    /// Which camera of --from-odm, where there are several
    #[arg(long, requires = "from_odm", conflicts_with_all = ["preset", "from_opencv", "fov", "focal_px", "focal_mm", "focal_35mm"])]
    name: Option<String>,
    /// Pixels of a frame: 640x480; of --from-opencv where the file does not tell
    #[arg(long, value_name = "COLSxROWS", value_parser = size, allow_hyphen_values = true, conflicts_with_all = ["preset", "from_odm"])]
    size: Option<[u32; 2]>,
    /// Width of the sensor, mm
    #[arg(long, value_name = "MM", value_parser = positive, requires = "focal_mm", allow_negative_numbers = true,
        conflicts_with_all = ["preset", "from_opencv", "from_odm", "fov", "focal_px", "focal_35mm"])]
    sensor_mm: Option<f64>,
    /// The file to write; standard output unless given
    #[arg(long, value_name = "TOML")]
    out: Option<PathBuf>,
    /// Replace a file of that name that says something else, as one that was calibrated or edited
    #[arg(long, requires = "out")]
    overwrite: bool,
}

/// Two numbers around an x.
fn pair<T: std::str::FromStr>(text: &str, form: &str) -> Result<[T; 2], String> {
    let both =
        text.split_once(['x', 'X', '×', '*']).and_then(|(a, b)| Some([a.trim().parse().ok()?, b.trim().parse().ok()?]));
    both.ok_or_else(|| format!("not of the form {form}"))
}

fn fields(text: &str) -> Result<[f64; 2], String> {
    let fields: [f64; 2] = pair(text, "60x46.8")?;
    if fields.iter().any(|deg| !(*deg > 0.0 && *deg < 180.0)) {
        return Err("not between 0 and 180 degrees".to_owned());
    }
    if fields.iter().all(|deg| *deg < 3.2) {
        return Err(format!(
            "fields of view of {} and {} degrees; were radians meant? They are {:.1}x{:.1} degrees",
            fields[0],
            fields[1],
            fields[0].to_degrees(),
            fields[1].to_degrees()
        ));
    }
    Ok(fields)
}

fn size(text: &str) -> Result<[u32; 2], String> {
    let size: [u32; 2] = pair(text, "640x480")?;
    if size.contains(&0) { Err("a frame without pixels".to_owned()) } else { Ok(size) }
}

pub fn run(args: &Args) -> Result<Outcome, Failure> {
    let What::New(new) = &args.what;
    Files::default()
        .may_read("--from-opencv", new.source.from_opencv.as_ref())
        .may_read("--from-odm", new.source.from_odm.as_ref())
        .may_write("--out", new.out.as_ref())
        .check()?;
    let (camera, from) = camera(new)?;
    check_made(&camera, &new.source.words())?;
    not_square(&camera).iter().for_each(|what| note(&format!("{}: {what}", new.source.words())));
    if camera.is_off_centre() {
        note(&format!(
            "{}: the principal point lies {:.0} px right and {:.0} px forward of the middle of a frame of {} x {}, as that of frames of another \
             size would",
            new.source.words(),
            camera.offset_m_px,
            camera.offset_n_px,
            camera.cols,
            camera.rows
        ));
    }
    let text = commented(&camera, &from);
    // What is written must be what is taken.
    CameraFile::from_toml_str(&text, &new.source.words())?;
    let Some(out) = &new.out else { return Outcome::new(false, &(), || text) };
    // Calibrations and edits are lost otherwise; what is there already may be made again.
    if !new.overwrite && out.exists() && std::fs::read(out).ok().as_deref() != Some(text.as_bytes()) {
        return Err(Failure::Input(InputError::new(format!(
            "--out {}: there is another file of that name: --overwrite replaces it",
            out.display()
        ))));
    }
    write_file(out, text.as_bytes())?;
    Outcome::new(false, &(), String::new)
}

/// The camera, and what it comes from.
fn camera(new: &New) -> Result<(CameraFile, String), InputError> {
    if let Some(path) = &new.source.from_opencv {
        let name = path.display().to_string();
        return Ok((from_opencv(&input::text(path)?, &name, new.size)?, format!("OpenCV's calibration {name}")));
    }
    if let Some(path) = &new.source.from_odm {
        let name = path.display().to_string();
        return Ok((from_odm(&input::text(path)?, &name, new.name.as_deref())?, format!("OpenDroneMap's {name}")));
    }
    if let Some(name) = &new.source.preset {
        let known = PRESETS.map(|(name, ..)| name).join(", ");
        let unknown = || InputError::new(format!("--preset {name}: there is none of that name, but {known}"));
        let what = PRESETS.iter().find(|(known, ..)| known == name).map_or("", |(_, what, ..)| what);
        return Ok((preset(name).ok_or_else(unknown)?, format!("data sheets, not calibrated: {what}")));
    }
    // clap has seen to it that there is a size with what follows.
    let [cols, rows] = new.size.unwrap_or([1, 1]);
    if let Some(fov_deg) = new.source.fov {
        return Ok((of_fov(cols, rows, fov_deg), "fields of view, not calibrated".to_owned()));
    }
    if let (Some(focal_mm), Some(sensor_mm)) = (new.source.focal_mm, new.sensor_mm) {
        let pixel_mm = sensor_mm / f64::from(cols);
        let camera = CameraFile { pixel_mm: Some(pixel_mm), ..of_focal_px(cols, rows, focal_mm / pixel_mm) };
        return Ok((camera, "focal length and sensor, not calibrated".to_owned()));
    }
    let of_35 = new.source.focal_35mm.map(|focal_mm| focal_px_of_35_mm(cols, rows, focal_mm));
    let focal_px = new.source.focal_px.or(of_35).unwrap_or(1.0);
    Ok((of_focal_px(cols, rows, focal_px), "a focal length, not calibrated".to_owned()))
}
