//! From a camera file's text to its checked content.

use toml::Table;

use crate::error::InputError;

use super::heads::{VIRTUAL_SIDE_MAX_PX, heads};
use super::keys::Keys;
use super::{CameraFile, checksum, lens, mounting};

/// Every key a file may have at its top.
const KEYS: [&str; 14] = [
    "cols",
    "rows",
    "fov_h_deg",
    "fov_v_deg",
    "offset_m_px",
    "offset_n_px",
    "pixel_mm",
    "distortion",
    "version",
    "crc32",
    "boresight",
    "heads",
    "lever_arms",
    "covariance",
];

/// Those that make a whole file.
const NEEDED: [&str; 6] = ["cols", "rows", "fov_h_deg", "fov_v_deg", "offset_m_px", "offset_n_px"];

/// Sides of a pixel, mm: sensors have 0.0005 to 0.05, a scan of film or frames that were made smaller some more.
const PIXEL_MM: [f64; 2] = [0.000_1, 0.2];

/// What a pixel's side has to be, where no sensor has such pixels, with what may have been meant; `key` is what stands before the number.
#[must_use]
pub fn no_pixel_mm(side_mm: f64, key: &str) -> Option<String> {
    let [least, most] = PIXEL_MM;
    if (least..=most).contains(&side_mm) {
        return None;
    }
    let meant = if (least..=most).contains(&(1e-3 * side_mm)) {
        // As many digits as were given.
        format!("; were micrometres meant, write {key}{}", (1e6 * side_mm).round() / 1e9)
    } else {
        String::new()
    };
    Some(format!("{least} to {most} mm, as the pixels of sensors are{meant}"))
}

/// Fields of view that lenses have, in radians: 17 degrees, a long lens, to 120, beyond which are fisheyes, which are not described so.
const RADIANS: [f64; 2] = [0.3, 2.1];

/// Names all keys that are missing.
fn is_whole(file: &Keys<'_>) -> Result<(), InputError> {
    let missing: Vec<&str> = NEEDED.into_iter().filter(|key| !file.table.contains_key(*key)).collect();
    let what = match missing.as_slice() {
        [] => return Ok(()),
        [one] => format!("the key {one} is"),
        several => format!("the keys {} are", several.join(", ")),
    };
    Err(InputError::new(format!(
        "camera file {}: {what} missing; `plumbline camera new` writes a whole file",
        file.name
    )))
}

pub(super) fn camera_file(text: &str, name: &str) -> Result<CameraFile, InputError> {
    let table: Table = toml::from_str(text).map_err(|error| {
        let line =
            error.span().and_then(|span| text.get(..span.start)).map_or(1, |before| before.matches('\n').count() + 1);
        InputError::new(format!("camera file {name}, line {line}, is not TOML: {}", error.message()))
    })?;
    let file = Keys { name, prefix: String::new(), table: &table };
    file.only(&KEYS)?;
    is_whole(&file)?;
    let heads = heads(&file)?;
    let camera = CameraFile {
        cols: file.side("cols", VIRTUAL_SIDE_MAX_PX)?,
        rows: file.side("rows", VIRTUAL_SIDE_MAX_PX)?,
        fov_h_deg: file.field_of_view("fov_h_deg")?,
        fov_v_deg: file.field_of_view("fov_v_deg")?,
        offset_m_px: file.needed_number("offset_m_px")?,
        offset_n_px: file.needed_number("offset_n_px")?,
        pixel_mm: file.number("pixel_mm")?,
        distortion: file.distortion()?,
        version: file.unsigned("version")?,
        crc32: file.unsigned("crc32")?,
        boresight: mounting::boresight(&file)?,
        lever_arms: mounting::lever_arms(&file)?,
        covariance: mounting::covariance(&file, heads.len())?,
        heads,
    };
    if let Some(wanted) = camera.pixel_mm.and_then(|side_mm| no_pixel_mm(side_mm, "pixel_mm = ")) {
        return Err(file.wrong("pixel_mm", &wanted));
    }
    in_degrees(&camera, &file)?;
    let nearest = [camera.fov_h_deg, camera.fov_v_deg].map(|deg| (0.5 * deg.to_radians()).tan());
    lens::check(&file, camera.distortion.as_ref(), nearest[0].min(nearest[1]))?;
    let size = [camera.cols, camera.rows];
    file.principal_point(size, [camera.offset_m_px, camera.offset_n_px])?;
    if !camera.heads.is_empty() {
        is_ideal(&camera, &file)?;
    }
    if let Some(stated) = camera.crc32 {
        match checksum::of_text_with_line(text) {
            Some(found) if found == stated => {}
            Some(found) => {
                return Err(InputError::new(format!(
                    "camera file {name}: crc32 is {stated:#010x} but the text has {found:#010x}, so it was altered or damaged"
                )));
            }
            None => {
                return Err(file.wrong("crc32", "on a line of its own before the first table"));
            }
        }
    }
    Ok(camera)
}

/// The degrees of fields of view that are usual ones in radians: as degrees they are a telescope's, from which nothing is surveyed. `None` for
/// others.
#[must_use]
pub fn as_radians(fields: [f64; 2]) -> Option<[f64; 2]> {
    let [least, most] = RADIANS;
    let are_radians = fields.iter().all(|field| (least..=most).contains(field));
    are_radians.then(|| fields.map(|field| (1e4 * field.to_degrees()).round() / 1e4))
}

/// Refuses fields of view in radians.
fn in_degrees(camera: &CameraFile, file: &Keys<'_>) -> Result<(), InputError> {
    let fields = [camera.fov_h_deg, camera.fov_v_deg];
    let Some([h, v]) = as_radians(fields) else { return Ok(()) };
    Err(InputError::new(format!(
        "camera file {}: fov_h_deg = {} and fov_v_deg = {} are degrees, and no lens of a survey has so small ones; as radians they are usual: write \
         fov_h_deg = {h} and fov_v_deg = {v}",
        file.name, fields[0], fields[1]
    )))
}

/// A virtual camera is a construction: its principal point is its centre and it has no lens.
fn is_ideal(camera: &CameraFile, file: &Keys<'_>) -> Result<(), InputError> {
    for (key, offset) in [("offset_m_px", camera.offset_m_px), ("offset_n_px", camera.offset_n_px)] {
        if offset != 0.0 {
            return Err(file.wrong(key, "0 for the virtual camera of a file with heads"));
        }
    }
    if camera.distortion.is_some() {
        return Err(InputError::new(format!(
            "camera file {}: the virtual camera of a file with heads has no distortion, only heads have",
            file.name
        )));
    }
    Ok(())
}
