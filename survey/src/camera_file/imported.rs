//! Camera files from what people have: a field of view, a focal length, a calibration by OpenCV or OpenDroneMap, a maker's data sheet.
//!
//! OpenCV counts pixels from the middle of the first one, x to the right and y down: the frame's centre is ((cols − 1) / 2,
//! (rows − 1) / 2). Its distortion is this project's, but for the order: k1, k2, p1, p2, k3. OpenDroneMap (OpenSfM) has lengths in
//! units of the frame's longer side and its principal point from the centre.

use super::{CameraFile, Distortion, off_frame};
use crate::error::InputError;
use serde_json::Value;
use std::collections::BTreeMap;

/// Diagonal of the 36 x 24 mm that "35 mm equivalent" refers to.
const DIAGONAL_35_MM: f64 = 43.266_615_305_567_87;

/// What a maker says of a camera, not a calibration: name, what it is, columns, rows, horizontal field of view in degrees, pixel in mm.
type Preset = (&'static str, &'static str, u32, u32, f64, f64);

/// From makers' data sheets: sensor and focal length, whose field of view is 2 atan(side / (2 f)).
pub const PRESETS: [Preset; 7] = [
    ("paper", "the follow-up camera of the paper: 640 x 480, 60 degrees along the longer side", 640, 480, 60.0, 0.006),
    ("pi-v2", "Raspberry Pi camera 2 (IMX219), f 3.04 mm", 3280, 2464, 62.24, 0.001_12),
    ("pi-hq-6mm", "Raspberry Pi HQ camera (IMX477) with its 6 mm lens", 4056, 3040, 55.31, 0.001_55),
    ("pi-gs-6mm", "Raspberry Pi global shutter camera (IMX296) with its 6 mm lens", 1456, 1088, 45.42, 0.003_45),
    ("phantom-4-pro", "DJI Phantom 4 Pro or RTK, f 8.8 mm, 1 inch sensor", 5472, 3648, 73.74, 0.002_412),
    ("mavic-3e", "DJI Mavic 3 Enterprise, wide camera, f 12.29 mm, 4/3 inch sensor", 5280, 3956, 70.29, 0.003_277),
    ("zenmuse-p1-35mm", "DJI Zenmuse P1 with its 35 mm lens", 8192, 5460, 54.33, 0.004_39),
];

/// A camera of square pixels without distortion and with its principal point in the middle.
#[must_use]
pub fn of_focal_px(cols: u32, rows: u32, focal_px: f64) -> CameraFile {
    of_focals(cols, rows, [focal_px; 2], [0.0; 2], None)
}

/// Focal length in pixels of a lens whose "35 mm equivalent" has the same diagonal field of view (CIPA DCG-001).
#[must_use]
pub fn focal_px_of_35_mm(cols: u32, rows: u32, focal_mm: f64) -> f64 {
    f64::from(cols).hypot(f64::from(rows)) * focal_mm / DIAGONAL_35_MM
}

/// The fields of view of the frame's two sides, degrees.
#[must_use]
pub fn of_fov(cols: u32, rows: u32, [fov_h_deg, fov_v_deg]: [f64; 2]) -> CameraFile {
    CameraFile { fov_h_deg, fov_v_deg, ..of_focal_px(cols, rows, 1.0) }
}

/// Of a preset by its name.
#[must_use]
pub fn preset(name: &str) -> Option<CameraFile> {
    let (_, _, cols, rows, fov_h_deg, pixel_mm) = PRESETS.into_iter().find(|(known, ..)| *known == name)?;
    let focal_px = 0.5 * f64::from(cols) / (0.5 * fov_h_deg.to_radians()).tan();
    Some(CameraFile { pixel_mm: Some(pixel_mm), fov_h_deg, ..of_focal_px(cols, rows, focal_px) })
}

/// From a calibration that OpenCV or ROS has stored, as YAML or JSON: `image_width`, `image_height`, `camera_matrix`,
/// `distortion_coefficients`. `size` is what the frame's sides are where the file does not say.
///
/// # Errors
/// All that is missing; what is not taken: a rational, thin-prism or fisheye lens; a principal point outside the frame; a size that is
/// not the file's.
pub fn from_opencv(text: &str, name: &str, size: Option<[u32; 2]>) -> Result<CameraFile, InputError> {
    let wrong = |what: String| InputError::new(format!("{name}: {what}"));
    if let Some(model) = fisheye(text) {
        return Err(wrong(format!(
            "a fisheye lens ({model}) is not taken, only OpenCV's model of five (k1, k2, p1, p2, k3); calibrate anew without the fisheye model, \
             or undistort the frames (cv::fisheye) and describe those with --focal-px"
        )));
    }
    let side = |key: &str| {
        let found = numbers_behind(text, key, 1).and_then(|found| found.first().copied());
        let whole = found.filter(|side| *side >= 1.0 && side.fract() == 0.0 && *side <= f64::from(u32::MAX));
        whole.map(|side| side as u32)
    };
    let sides = [("image_width", 0), ("image_height", 1)].map(|(key, k)| (key, side(key), size.map(|size| size[k])));
    let matrix = matrix_behind(text, "camera_matrix").filter(|matrix| matrix.len() == 9);
    matrix.as_deref().map_or(Ok(()), is_camera_matrix).map_err(&wrong)?;
    let mut missing: Vec<&str> =
        sides.iter().filter(|(_, own, given)| own.or(*given).is_none()).map(|(key, ..)| *key).collect();
    let lacks_side = !missing.is_empty();
    let lacks_matrix = matrix.is_none();
    if lacks_matrix {
        missing.push("camera_matrix of 3 x 3 numbers");
    }
    let ([Some(cols), Some(rows)], Some(matrix)) = (sides.map(|(_, own, given)| own.or(given)), matrix) else {
        let hint = match (lacks_side, lacks_matrix) {
            (true, false) => "--size COLSxROWS says of what frames it is",
            _ => "is it a calibration stored by OpenCV?",
        };
        return Err(wrong(format!("it has no {}; {hint}", missing.join(" and no "))));
    };
    if let Some([width, height]) = size.filter(|size| *size != [cols, rows]) {
        return Err(wrong(format!(
            "it is a calibration of frames of {cols} x {rows}, but --size says {width} x {height}; leave --size out, and calibrate anew for \
             frames of another size"
        )));
    }
    let lens = matrix_behind(text, "distortion_coefficients").unwrap_or_default();
    if lens.len() > 5 && lens[5..].iter().any(|k| *k != 0.0) {
        return Err(wrong(
            "distortion_coefficients beyond k3 are not 0; calibrate with the model of five (k1, k2, p1, p2, k3)"
                .to_owned(),
        ));
    }
    let k = |index: usize| lens.get(index).copied().unwrap_or(0.0);
    let distortion = Distortion { k1: k(0), k2: k(1), p1: k(2), p2: k(3), k3: k(4) };
    let offset = [matrix[2] - 0.5 * (f64::from(cols) - 1.0), 0.5 * (f64::from(rows) - 1.0) - matrix[5]];
    is_inside([cols, rows], offset).map_err(wrong)?;
    let distortion = (distortion != Distortion::default()).then_some(distortion);
    Ok(of_focals(cols, rows, [matrix[0], matrix[4]], offset, distortion))
}

/// Of a skew, pixels, and of what is 0 or 1 in such a matrix: what rounding may leave.
const NEARLY: f64 = 1e-6;

/// Why nine numbers are no camera matrix that is taken.
fn is_camera_matrix(matrix: &[f64]) -> Result<(), String> {
    let is = |k: usize, wanted: f64| (matrix[k] - wanted).abs() <= NEARLY;
    let place = |k: usize| format!("camera_matrix[{}][{}] is {}", k / 3, k % 3, matrix[k]);
    if let Some(k) = [3, 6, 7].into_iter().find(|k| !is(*k, 0.0)) {
        return Err(format!(
            "{}, and 0 in every camera matrix, rows of which are fx, 0, cx and 0, fy, cy and 0, 0, 1",
            place(k)
        ));
    }
    if !is(8, 1.0) {
        return Err(format!("{}, and 1 in every camera matrix: divide all of it by that", place(8)));
    }
    if !is(1, 0.0) {
        return Err(format!(
            "{}, a skew of the axes, which is not modelled: calibrate without one, as OpenCV does",
            place(1)
        ));
    }
    Ok(())
}

/// Key and value that say that a lens is a fisheye's: OpenCV's `fisheye_model`, ROS' and Kalibr's `distortion_model`. Its four
/// coefficients are of a polynomial in the angle, and would be read as k1, k2, p1, p2.
fn fisheye(text: &str) -> Option<String> {
    if let Some(flag) = word_behind(text, "fisheye_model").filter(|flag| !["0", "false", "no"].contains(&flag.as_str()))
    {
        return Some(format!("fisheye_model: {flag}"));
    }
    let model = word_behind(text, "distortion_model")?;
    ["equidistant", "fisheye", "kannala_brandt", "equi", "omni"]
        .contains(&model.as_str())
        .then(|| format!("distortion_model: {model}"))
}

/// The word behind a key and its colon, in lower case.
fn word_behind(text: &str, key: &str) -> Option<String> {
    let (_, behind) = text.split_once(key)?;
    let (_, behind) = behind.split_once(':')?;
    let word = behind.trim_start().trim_start_matches(['"', '\'']);
    let word: String = word.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect();
    (!word.is_empty()).then(|| word.to_lowercase())
}

/// Why a principal point is none.
fn is_inside(size: [u32; 2], offset: [f64; 2]) -> Result<(), String> {
    if off_frame(size, offset).is_none() {
        return Ok(());
    }
    let [cols, rows] = size;
    Err(format!(
        "its principal point lies outside a frame of {cols} x {rows}; is it a calibration of frames of another size?"
    ))
}

/// Widest field of view of a lens that is none of a fisheye: the widest that are made see 130 degrees.
const WIDEST_DEG: f64 = 150.0;
/// Narrowest: 1200 mm before a sensor 24 mm wide see 1.1 degrees, half of that along its shorter side with something to spare.
const NARROWEST_DEG: f64 = 0.3;
/// How far the sides of a pixel may differ before it is asked about: square ones whose fields of view are rounded to degrees differ by less.
const SQUARE_WITHIN: f64 = 0.04;

/// Refuses a camera that nobody has.
///
/// # Errors
/// A field of view that is too wide or too narrow; `what` is where it comes from, and what may have been meant.
pub fn check_made(camera: &CameraFile, what: &str) -> Result<(), InputError> {
    let fields = [camera.fov_h_deg, camera.fov_v_deg];
    if fields.iter().all(|field| (NARROWEST_DEG..=WIDEST_DEG).contains(field)) {
        return Ok(());
    }
    let [h, v] = fields;
    Err(InputError::new(format!(
        "{what}: fields of view of {h:.4} x {v:.4} degrees, which no lens of this model has ({NARROWEST_DEG} to {WIDEST_DEG}); the focal length \
         goes in its option's unit, that of a fisheye cannot be described"
    )))
}

/// What is asked about pixels that are not square: nearly all sensors' are.
#[must_use]
pub fn not_square(camera: &CameraFile) -> Option<String> {
    let (across, along) = camera.tangent_per_px();
    if (across / along - 1.0).abs() <= SQUARE_WITHIN {
        return None;
    }
    let meant = (2.0 * (0.5 * f64::from(camera.rows) * across).atan()).to_degrees();
    Some(format!(
        "pixels that are {:.1} % {} than they are high, as few sensors have them; square ones have a field of view of {:.4}x{meant:.4} degrees",
        100.0 * (across / along - 1.0).abs(),
        if across > along { "wider" } else { "narrower" },
        camera.fov_h_deg
    ))
}

/// From a camera of OpenDroneMap's `cameras.json`; `wanted` where it has several.
///
/// # Errors
/// What is missing or not taken: a lens that is not of the perspective or the Brown model, several cameras and none named.
pub fn from_odm(text: &str, name: &str, wanted: Option<&str>) -> Result<CameraFile, InputError> {
    let wrong = |what: String| InputError::new(format!("{name}: {what}"));
    let json: Value = serde_json::from_str(text).map_err(|error| wrong(format!("it is not JSON: {error}")))?;
    if json[0]["cameras"].is_object() {
        return Err(wrong(
            "it is a reconstruction of OpenSfM; its cameras alone, which are taken, are in cameras.json in the folder of an OpenDroneMap \
             project and in camera_models.json in that of OpenSfM"
                .to_owned(),
        ));
    }
    let cameras: BTreeMap<&String, &Value> =
        json.as_object().into_iter().flatten().filter(|(_, camera)| camera.get("width").is_some()).collect();
    if cameras.is_empty() {
        return Err(wrong("it has no camera of width and height, as OpenDroneMap's cameras.json has".to_owned()));
    }
    let names = || cameras.keys().map(|name| format!("\"{name}\"")).collect::<Vec<_>>().join(", ");
    let camera = match (wanted, cameras.len()) {
        (Some(wanted), _) => cameras.get(&wanted.to_owned()),
        (None, 1) => cameras.values().next(),
        (None, _) => return Err(wrong(format!("it has several cameras; --name says which one: {}", names()))),
    };
    let Some(camera) = camera else { return Err(wrong(format!("it has no such camera, but {}", names()))) };
    let kind = camera["projection_type"].as_str().unwrap_or("perspective");
    if !["perspective", "brown"].contains(&kind) {
        return Err(wrong(format!("a lens of the model {kind} is not taken, only perspective and brown")));
    }
    let side = |key: &str| {
        let side = camera[key].as_u64().and_then(|side| u32::try_from(side).ok()).filter(|side| *side > 0);
        side.ok_or_else(|| wrong(format!("its {key} is no number of pixels")))
    };
    let (cols, rows) = (side("width")?, side("height")?);
    let number = |key: &str| camera[key].as_f64();
    let longer = f64::from(cols.max(rows));
    let focal = |key: &str| {
        let focal = number(key).or(number("focal")).filter(|focal| *focal > 0.0);
        focal.map(|focal| focal * longer).ok_or_else(|| wrong(format!("it has neither {key} nor focal")))
    };
    let focal_px = [focal("focal_x")?, focal("focal_y")?];
    let k = |key: &str| number(key).unwrap_or(0.0);
    let distortion = Distortion { k1: k("k1"), k2: k("k2"), k3: k("k3"), p1: k("p1"), p2: k("p2") };
    let distortion = (distortion != Distortion::default()).then_some(distortion);
    let offset = [k("c_x") * longer, -k("c_y") * longer];
    is_inside([cols, rows], offset).map_err(wrong)?;
    Ok(of_focals(cols, rows, focal_px, offset, distortion))
}

fn of_focals(
    cols: u32,
    rows: u32,
    focal_px: [f64; 2],
    [offset_m_px, offset_n_px]: [f64; 2],
    distortion: Option<Distortion>,
) -> CameraFile {
    let fov_deg = |side: u32, focal_px: f64| (2.0 * (0.5 * f64::from(side) / focal_px).atan()).to_degrees();
    CameraFile {
        cols,
        rows,
        fov_h_deg: fov_deg(cols, focal_px[0]),
        fov_v_deg: fov_deg(rows, focal_px[1]),
        // No -0.0, which reads as if something had been meant.
        offset_m_px: offset_m_px + 0.0,
        offset_n_px: offset_n_px + 0.0,
        pixel_mm: None,
        distortion,
        version: None,
        crc32: None,
        boresight: None,
        lever_arms: None,
        covariance: None,
        heads: Vec::new(),
    }
}

/// The first numbers behind a key and its colon.
fn numbers_behind(text: &str, key: &str, count: usize) -> Option<Vec<f64>> {
    let (_, behind) = text.split_once(key)?;
    let (_, behind) = behind.split_once(':')?;
    let is_between = |c: char| c.is_whitespace() || matches!(c, ',' | '[' | ']' | '}' | '"');
    let numbers: Vec<f64> = behind
        .split(is_between)
        .filter(|word| !word.is_empty())
        .map_while(|word| word.parse().ok())
        .take(count)
        .collect();
    (numbers.len() == count).then_some(numbers)
}

/// The numbers of a matrix: those in the brackets behind `data` behind its key, or behind the key itself, in one list or in lists of rows.
fn matrix_behind(text: &str, key: &str) -> Option<Vec<f64>> {
    let (_, behind) = text.split_once(key)?;
    let (_, behind) = behind.split_once(':')?;
    let list = if behind.trim_start().starts_with('[') { behind } else { behind.split_once("data")?.1 };
    let mut depth = 0_usize;
    let mut is_inside = |c: char| {
        depth = if c == '[' { depth + 1 } else { depth - usize::from(c == ']') };
        depth > 0
    };
    let (_, list) = list.split_once('[').map(|(before, _)| list.split_at(before.len()))?;
    let end = list.find(|c: char| !is_inside(c))?;
    let words = list[..end].split(|c: char| c.is_whitespace() || matches!(c, '[' | ']' | ','));
    words.filter(|word| !word.is_empty()).map(|word| word.parse().ok()).collect()
}

/// What a person reads above the keys of a camera file that was made.
#[must_use]
pub fn commented(camera: &CameraFile, from: &str) -> String {
    let keys = camera.to_toml_string();
    let lines = keys.lines().filter(|line| !line.starts_with("crc32")).map(|line| {
        match COMMENTS.iter().find(|(key, _)| line.starts_with(key)) {
            Some((_, comment)) => format!("{line:<32} # {comment}"),
            None => line.to_owned(),
        }
    });
    let body = lines.collect::<Vec<_>>().join("\n");
    format!("# Camera file of Plumbline, from {from}.\n{body}\n{TAIL}")
}

/// Keys and what they are.
const COMMENTS: [(&str, &str); 8] = [
    ("cols ", "pixels across a frame, to the right"),
    ("rows ", "pixels along a frame; row 0 looks forward"),
    ("fov_h_deg", "full field of view across, over the columns"),
    ("fov_v_deg", "full field of view along, over the rows"),
    ("offset_m_px", "principal point from the middle, to the right"),
    ("offset_n_px", "and forward"),
    ("pixel_mm", "side of a pixel on the sensor; `plan --scale` needs it"),
    ("[distortion]", "Brown-Conrady as OpenCV has it"),
];

const TAIL: &str = "
# How the camera sits in the vehicle, where that is known; `plumbline boresight` and `plumbline evaluate` find it.
# [boresight]
# phi_deg = 0.0                  # about the forward axis
# omega_deg = 0.0                # about the right axis
# kappa_deg = 0.0                # about the axis that looks up
# [lever_arms]
# antenna_to_camera_m = [0.0, 0.0, 0.0]   # right, forward, up
";

#[cfg(test)]
mod tests;
