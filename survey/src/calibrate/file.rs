//! The camera file of a calibrated block.

use super::block::{Block, Sizes};
use super::observations::Observations;
use super::result::Calibration;
use super::symmetrise::{Symmetrised, mount};
use crate::adjust::rig::{HEAD, LENS};
use crate::adjust::rotation;
use crate::camera_file::{CameraFile, Covariance, Distortion, Head, heads::VIRTUAL_SIDE_MAX_PX};
use crate::error::InputError;
use nalgebra::{DMatrix, Matrix3, Vector3};

/// Least part of the heads' axes, in the mean, that goes down the platform.
const AXIS_MIN: f64 = 0.1;
/// Version of the calibration in the file.
const VERSION: u32 = 1;
/// Step by which angles are moved to see what turning the frame does to their covariance, rad.
const STEP_RAD: f64 = 1e-6;
const ARCSEC: f64 = 3600.0;

/// A camera file, and what had to be assumed for it, a sentence each.
#[derive(Clone, Debug, PartialEq)]
pub struct Calibrated {
    /// The file.
    pub camera: CameraFile,
    /// What was assumed.
    pub assumed: Vec<String>,
}

/// The file of a calibrated camera: of several heads the virtual camera with the heads in its frame (symmetrised), of
/// one head that camera itself.
///
/// # Errors
/// Heads that look so far apart that no picture holds them.
pub fn camera_file(
    block: &Block,
    observations: &Observations,
    calibration: &Calibration,
) -> Result<Calibrated, InputError> {
    let mut assumed = Vec::new();
    let [cols, rows] = head_size(&block.sizes, observations, &mut assumed);
    if let [head] = &calibration.heads[..] {
        let mut camera = of_head(head, [cols, rows]).camera();
        (camera.pixel_mm, camera.version) = (block.sizes.pixel_mm, Some(VERSION));
        return Ok(Calibrated { camera, assumed });
    }
    let axis: Vector3<f64> = calibration.heads.iter().map(|head| -mount(head).column(2).into_owned()).sum();
    if axis.z > -AXIS_MIN * calibration.heads.len() as f64 {
        return Err(InputError::new("the heads' axes have no mean that looks down: there is no virtual camera"));
    }
    let symmetrised = Symmetrised::new(&calibration.heads);
    let f_px = block.sizes.virtual_f_px.unwrap_or_else(|| {
        let sum: f64 = calibration.heads.iter().map(|head| head[LENS]).sum();
        sum / calibration.heads.len() as f64
    });
    let size = match block.sizes.virtual_image {
        Some(size) => size,
        None => {
            let size = surrounding(&symmetrised.heads, f_px, [cols, rows]).ok_or_else(|| {
                InputError::new("the heads look so far apart that no virtual image holds them: virtual_cols and virtual_rows are missing")
            })?;
            assumed.push(format!("no virtual_cols and virtual_rows: {} x {} pixels hold all heads", size[0], size[1]));
            size
        }
    };
    let fov_deg = size.map(|side| 2.0 * (0.5 * f64::from(side) / f_px).atan().to_degrees());
    let mut camera = CameraFile::new((size[0], size[1]), (fov_deg[0], fov_deg[1]));
    camera.pixel_mm = block.sizes.pixel_mm;
    camera.version = Some(VERSION);
    camera.heads = symmetrised.heads.iter().map(|head| of_head(head, [cols, rows])).collect();
    camera.covariance = covariance(calibration, &symmetrised);
    Ok(Calibrated { camera, assumed })
}

fn of_head(head: &[f64; HEAD], [cols, rows]: [u32; 2]) -> Head {
    let [c, xp, yp, k1, k2, k3, p1, p2]: [f64; 8] = std::array::from_fn(|k| head[LENS + k]);
    let distortion = Distortion { k1, k2, k3, p1, p2 };
    Head {
        cols,
        rows,
        f_px: c,
        offset_m_px: xp,
        offset_n_px: yp,
        distortion: (distortion != Distortion::default()).then_some(distortion),
        rotation_deg: [0, 1, 2].map(|k| head[k].to_degrees()),
        d_m: [head[3], head[4], head[5]],
    }
}

/// The heads' frame, or the smallest that holds all observations.
fn head_size(sizes: &Sizes, observations: &Observations, assumed: &mut Vec<String>) -> [u32; 2] {
    sizes.head.unwrap_or_else(|| {
        let size = [0, 1].map(|k| {
            let most = observations.seen.iter().fold(0.5, |most: f64, seen| most.max(seen.image_px[k].abs()));
            2 * most.ceil() as u32
        });
        assumed.push(format!("no cols and rows: {} x {} pixels hold all observations", size[0], size[1]));
        size
    })
}

/// Columns and rows of the smallest virtual image that holds all heads' frames.
fn surrounding(heads: &[[f64; HEAD]], f_px: f64, size: [u32; 2]) -> Option<[u32; 2]> {
    let mut half = [0.5_f64; 2];
    for head in heads {
        for (right, up) in [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)] {
            let corner = Vector3::new(right * f64::from(size[0]) / 2.0, up * f64::from(size[1]) / 2.0, -head[LENS]);
            let ray = mount(head) * corner;
            if ray.z >= 0.0 {
                return None;
            }
            half = [half[0].max((f_px * ray.x / ray.z).abs()), half[1].max((f_px * ray.y / ray.z).abs())];
        }
    }
    let sides = half.map(|half| 2.0 * half.ceil());
    sides.iter().all(|side| *side <= f64::from(VIRTUAL_SIDE_MAX_PX)).then(|| sides.map(|side| side as u32))
}

/// Covariance of the angles after the turn into the virtual camera's frame, which is taken as given; `None` unless all
/// angles after the first head's were unknown.
fn covariance(calibration: &Calibration, symmetrised: &Symmetrised) -> Option<Covariance> {
    let mut indices = Vec::new();
    for head in 1..calibration.heads.len() {
        for angle in 0..3 {
            let is_it = |of: &super::HeadUnknown| (of.head, of.number) == (head, angle);
            indices.push(calibration.unknowns.iter().position(is_it)?);
        }
    }
    let count = indices.len();
    let before = DMatrix::from_fn(count, count, |i, j| calibration.covariance[indices[i]][indices[j]]);
    let mut turn = DMatrix::<f64>::zeros(count, count);
    for (index, head) in calibration.heads.iter().skip(1).enumerate() {
        let by = turned_by(head, &symmetrised.platform_from_virtual);
        turn.view_mut((3 * index, 3 * index), (3, 3)).copy_from(&by);
    }
    let after = &turn * before * turn.transpose();
    let arcsec2 = 1f64.to_degrees().powi(2) * ARCSEC * ARCSEC;
    // Rounding must not make it unsymmetrical.
    let row = |i: usize| (0..count).map(|j| 0.5 * (after[(i, j)] + after[(j, i)]) * arcsec2).collect();
    Some(Covariance::new((0..count).map(row).collect()))
}

/// Derivatives of a head's turned angles by its angles.
fn turned_by(head: &[f64; HEAD], q: &Matrix3<f64>) -> Matrix3<f64> {
    let turned = |angles: [f64; 3]| Vector3::from(rotation::angles_rad(&(q.transpose() * rotation::matrix(angles))));
    let mut by = Matrix3::zeros();
    for k in 0..3 {
        let moved = |by: f64| {
            let mut angles = [head[0], head[1], head[2]];
            angles[k] += by;
            turned(angles)
        };
        by.set_column(k, &((moved(STEP_RAD) - moved(-STEP_RAD)) / (2.0 * STEP_RAD)));
    }
    by
}
