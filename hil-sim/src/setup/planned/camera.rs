//! The plan's camera as a board can hold it, and the reference's resolution that suits both.

use crate::scenario::Frame;
use plumbline_core::budget::PATCH_MAX_PX;
use plumbline_firmware::shared_memory::AREA_MAX;
use plumbline_survey::camera_file::{CameraFile, Distortion, SIDE_MAX_PX};
use plumbline_survey::plan::PlanFile;

/// Bytes of reference that every board has room for in the simulator's mode.
const TILE_BYTES: f64 = 384.0 * 1024.0 - 128.0;

/// The camera with its pixels binned by the smallest whole factor that the boards' memory takes, and that factor. The fields
/// of view stay but for what is cut off of columns and rows that are no multiple of it.
pub fn binned(file: &PlanFile) -> (Frame, u32) {
    let camera = &file.camera;
    let fits = |factor: u32| {
        let (cols, rows) = (camera.cols / factor, camera.rows / factor);
        cols <= SIDE_MAX_PX && rows <= SIDE_MAX_PX && cols as usize * rows as usize <= AREA_MAX
    };
    let factor = (1..=u32::MAX).find(|&factor| fits(factor)).unwrap_or(1);
    let side = |count: u32| (count / factor).max(1);
    let cut = |fov_deg: f64, count: u32| {
        let kept = f64::from(side(count) * factor) / f64::from(count);
        2.0 * (kept * (0.5 * fov_deg.to_radians()).tan()).atan().to_degrees()
    };
    let (fov_h_deg, fov_v_deg) = match factor {
        1 => (camera.fov_h_deg, camera.fov_v_deg),
        _ => (cut(camera.fov_h_deg, camera.cols), cut(camera.fov_v_deg, camera.rows)),
    };
    let binned = Frame {
        cols: side(camera.cols) as u16,
        rows: side(camera.rows) as u16,
        fov_h_deg,
        fov_v_deg,
        offset_m_px: camera.offset_m_px / f64::from(factor),
        offset_n_px: camera.offset_n_px / f64::from(factor),
        distortion: camera.distortion.map(|[k1, k2, k3, p1, p2]| Distortion { k1, k2, k3, p1, p2 }),
    };
    (binned, factor)
}

/// The finest resolution, rounded up to two digits, at which a patch of the whole footprint from `height_m` fits the board's
/// patch, and a reference of `extent_m` its flash.
pub fn resolution_m(camera: &CameraFile, height_m: f64, extent_m: [f64; 2]) -> f64 {
    let side_m = |fov_deg: f64| 2.0 * height_m * (0.5 * fov_deg.to_radians()).tan();
    let footprint_m = side_m(camera.fov_h_deg).max(side_m(camera.fov_v_deg));
    let patch_px = PATCH_MAX_PX as f64;
    // What a reference needs around the flight is some patches' width more.
    let fits = |r: f64| {
        let side = |extent: f64| extent / r + 3.0 * patch_px;
        footprint_m <= r * patch_px && side(extent_m[0]) * side(extent_m[1]) <= TILE_BYTES
    };
    let mut r = 10f64.powf((footprint_m / patch_px).max(0.01).log10().floor());
    let digit = r / 10.0;
    while !fits(r) && r < 1000.0 {
        r += digit;
    }
    // Divided, since tenths as products are not the shortest numbers.
    let steps = (r / digit).round();
    if digit < 1.0 { steps / (1.0 / digit).round() } else { steps * digit }
}

#[cfg(test)]
mod tests {
    use super::resolution_m;
    use crate::scenario::Frame;

    #[test]
    fn the_resolution_is_the_finest_that_fits() {
        let camera = Frame { fov_h_deg: 60.0, fov_v_deg: 40.0, ..Frame::default() }.file();
        // 2 * 500 * tan 30 / 64 = 9.02 m.
        assert_eq!(resolution_m(&camera, 500.0, [1000.0, 1000.0]), 9.1);
        // As it is told: no 7.300000000000001.
        for height_m in 1..1000 {
            let r = resolution_m(&camera, f64::from(height_m), [1000.0, 1000.0]).to_string();
            assert!(r.len() <= 5, "{height_m} m: {r}");
        }
        // 393,088 cells: 20 km by 10 km at r are (20000 / r + 192) (10000 / r + 192), first within them at 30 m.
        let r = resolution_m(&camera, 500.0, [20_000.0, 10_000.0]);
        let cells = |r: f64| (20_000.0 / r + 192.0) * (10_000.0 / r + 192.0);
        assert!(cells(r) <= 393_088.0 && cells(r - 0.1) > 393_088.0, "{r}");
    }
}
