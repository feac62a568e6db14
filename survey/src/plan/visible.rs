//! What every photo of a camera sees, whichever way it is flown.
//!
//! A principal point off the middle, or a lens, makes a frame see farther to one side than to the other. Every other line is
//! flown backwards, which turns the sides around, so a plan counts on the nearer one of each pair alone.

use crate::camera_file::CameraFile;
use crate::error::InputError;

/// Points along a border of the frame.
const POINTS: u32 = 64;
/// Steps that undo a lens, and what is left of them.
const STEPS_MAX: usize = 100;
const LEFT_MAX: f64 = 1e-9;

/// Tangents of half of what every photo sees, along and across: of a camera without offsets and distortion those of half its
/// fields of view.
///
/// # Errors
/// The principal point lies outside the frame, or the distortion cannot be undone on its border.
pub fn half_tangents(camera: &CameraFile) -> Result<[f64; 2], InputError> {
    let half = [camera.fov_v_deg, camera.fov_h_deg].map(|fov| (0.5 * fov.to_radians()).tan());
    let (across_px, along_px) = camera.tangent_per_px();
    let per_px = [along_px, across_px];
    // Forward and right of the principal point the frame ends nearer by the offset, and farther on the other sides.
    let offset = [camera.offset_n_px * per_px[0], camera.offset_m_px * per_px[1]];
    let nearer = [0, 1].map(|k| half[k] - offset[k].abs());
    if nearer.iter().any(|half| *half <= 0.0) {
        return Err(InputError::new(
            "the camera's principal point lies outside its frame, so its photos cannot overlap both ways",
        ));
    }
    if camera.distortion.is_none() {
        return Ok(nearer);
    }
    let mut least = nearer;
    for point in 0..=POINTS {
        let share = 2.0 * f64::from(point) / f64::from(POINTS) - 1.0;
        for side in [-1.0, 1.0] {
            let along_edge = [side * half[0] - offset[0], share * half[1] - offset[1]];
            let across_edge = [share * half[0] - offset[0], side * half[1] - offset[1]];
            for (k, border) in [(0, along_edge), (1, across_edge)] {
                let ideal = undistorted(camera, border).ok_or_else(|| {
                    InputError::new("the camera's distortion cannot be undone on the border of its frame")
                })?;
                least[k] = if point == 0 && side < 0.0 { ideal[k].abs() } else { least[k].min(ideal[k].abs()) };
            }
        }
    }
    Ok(least)
}

/// The ideal point, along and across, of one on the frame; `None` where the steps do not settle.
fn undistorted(camera: &CameraFile, [along, across]: [f64; 2]) -> Option<[f64; 2]> {
    let d = camera.distortion.unwrap_or_default();
    // The file's y runs down the frame, against the flight.
    let distorted = |[x, y]: [f64; 2]| {
        let r2 = x * x + y * y;
        let g = 1.0 + r2 * (d.k1 + r2 * (d.k2 + r2 * d.k3));
        [x * g + 2.0 * d.p1 * x * y + d.p2 * (r2 + 2.0 * x * x), y * g + d.p1 * (r2 + 2.0 * y * y) + 2.0 * d.p2 * x * y]
    };
    let seen = [across, -along];
    let mut ideal = seen;
    for _ in 0..STEPS_MAX {
        let at = distorted(ideal);
        let off = [seen[0] - at[0], seen[1] - at[1]];
        if off[0].abs() + off[1].abs() < LEFT_MAX {
            return Some([-ideal[1], ideal[0]]);
        }
        // Half steps, which settle for stronger lenses than whole ones.
        ideal = [ideal[0] + 0.5 * off[0], ideal[1] + 0.5 * off[1]];
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera_file::Distortion;

    #[test]
    fn the_nearer_side_counts_and_the_lens_is_undone() {
        let camera = CameraFile::new((800, 600), (90.0, 60.0));
        let [along, across] = half_tangents(&camera).expect("level");
        assert!((across - 1.0).abs() < 1e-15 && (along - 30.0_f64.to_radians().tan()).abs() < 1e-15);
        let off = CameraFile { offset_m_px: -80.0, ..camera.clone() };
        assert!((half_tangents(&off).expect("off")[1] - 0.8).abs() < 1e-12);
        assert!(half_tangents(&CameraFile { offset_n_px: 300.0, ..camera.clone() }).is_err());
        // Pincushion: the frame sees less; on the axis r (1 + k r^2) = 1 at r = 0.9217 for k = 0.1.
        let lens = Distortion { k1: 0.1, ..Distortion::default() };
        let [_, across] = half_tangents(&CameraFile { distortion: Some(lens), ..camera.clone() }).expect("undone");
        let corner =
            undistorted(&CameraFile { distortion: Some(lens), ..camera.clone() }, [0.577, 1.0]).expect("undone");
        assert!((across - corner[1]).abs() < 1e-3 && across < 0.9217, "{across}");
        // Barrel: the middle of each side is the nearest.
        let barrel = Distortion { k1: -0.05, ..Distortion::default() };
        let [_, across] = half_tangents(&CameraFile { distortion: Some(barrel), ..camera }).expect("undone");
        assert!((across - 0.05 * across.powi(3) - 1.0).abs() < 1e-8, "{across}");
    }
}
