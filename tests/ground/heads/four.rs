//! The camera of paper 002, its lost tables 1 to 3 assumed: places 0.045 m right and left, 0.06 m forward and back of the
//! middle, tilts of 22 and 18 degrees.

use plumbline_survey::camera_file::{CameraFile, Head};

/// Columns, rows of the virtual image and of a head; focal length of all: 47 mm of 6.8 um.
const VIRTUAL: (f64, f64) = (15_400.0, 10_400.0);
const HEAD: (f64, f64) = (7_228.0, 5_428.0);
pub const F_PX: f64 = 47.0 / 0.0068;

/// The camera with so much larger pixels.
pub fn four(larger: f64) -> CameraFile {
    let f_px = F_PX / larger;
    let sides = |(cols, rows): (f64, f64)| ((cols / larger).round(), (rows / larger).round());
    let head = |side: f64, ahead: f64| {
        let (cols, rows) = sides(HEAD);
        Head {
            cols: cols as u32,
            rows: rows as u32,
            f_px,
            offset_m_px: 0.0,
            offset_n_px: 0.0,
            distortion: None,
            rotation_deg: [22.0 * side, 18.0 * ahead, 0.0],
            d_m: [0.045 * side, 0.06 * ahead, 0.0],
        }
    };
    let (cols, rows) = sides(VIRTUAL);
    let fov_deg = |side: f64| 2.0 * (0.5 * side / f_px).atan().to_degrees();
    CameraFile {
        heads: vec![head(-1.0, 1.0), head(1.0, 1.0), head(-1.0, -1.0), head(1.0, -1.0)],
        ..CameraFile::new((cols as u32, rows as u32), (fov_deg(cols), fov_deg(rows)))
    }
}
