//! Eq. 7 and 4 of paper 003, and its Table 1: what holds when the camera follows exactly.

use super::projection::{Camera, Projection, frame_from_tangents};

/// How far kH and kV may differ, relatively, for eq. 7, which has one k: rounding only.
const EQUAL_TANGENTS: f64 = 1e-12;

/// Eq. 7: undistorted pixel (m, n) -> frame pixel (m', n') from the equivalent pitch and roll in radians.
///
/// Holds for a followed beta only, and for square pixels (kH = kV), else `None`. The paper prints `m a11` for `n a11`
/// in the second line, and the fraction without its minus; both are mended. The distortion and the offsets act after
/// it, as for [`super::frame_from_ground`].
pub fn frame_from_ground_simplified(
    equivalent_pitch_rad: f64,
    equivalent_roll_rad: f64,
    camera: &Camera,
    m: f64,
    n: f64,
) -> Option<Projection> {
    let (k, k_v) = camera.tangent_per_px();
    if ((k - k_v) / k).abs() > EQUAL_TANGENTS {
        return None;
    }
    let (st, ct) = equivalent_pitch_rad.sin_cos();
    let (sg, cg) = equivalent_roll_rad.sin_cos();
    let den = cg * ct - m * k * sg + n * k * cg * st;
    let m_ideal = (m * cg + n * sg * st + sg * ct / k) / den;
    let n_ideal = (n * ct - st / k) / den;
    Some(frame_from_tangents(camera, m_ideal * k, n_ideal * k, den > 0.0))
}

/// Eq. 4: columns and rows of the patch before rounding down, from the VERTICAL height above ground.
///
/// The paper has the two fields of view the wrong way round; the width lies across.
pub fn patch_size(height_m: f64, fov_h_rad: f64, fov_v_rad: f64, resolution_m: f64) -> (f64, f64) {
    let cells = |fov_rad: f64| 2.0 * height_m * (fov_rad / 2.0).tan() / resolution_m;
    (cells(fov_h_rad), cells(fov_v_rad))
}

/// Table 1: by how many pixels of `resolution_m` the frame's centre misses the nadir, (cross, along), signed as the
/// paper prints it: the ground point at the frame's centre lies at (-cross, +along) to the right and forward.
pub fn centre_offset(
    height_m: f64,
    equivalent_pitch_rad: f64,
    equivalent_roll_rad: f64,
    resolution_m: f64,
) -> (f64, f64) {
    let cross_m = height_m * equivalent_roll_rad.tan() / equivalent_pitch_rad.cos();
    let along_m = height_m * equivalent_pitch_rad.tan();
    (cross_m / resolution_m, along_m / resolution_m)
}
