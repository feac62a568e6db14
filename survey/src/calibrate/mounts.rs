//! Mounts of heads from exterior orientations of their pictures: of any triangulation, or of resections on a test field.
//!
//! A resection on a field of known points 40 m away (paper 002, section 4.1) sees the heads' centres 17 times better than a
//! flight at 700 m does, and their angles worse; so the centres are taken from there and held in the flight's adjustment.

use super::block::Block;
use super::observations::Observations;
use super::result::{Calibration, options};
use super::symmetrise::picture;
use crate::adjust::rig::{Head, Observation, Rig, Station};
use crate::adjust::rotation;
use crate::error::InputError;
use crate::io::table::{Table, text_of};
use nalgebra::{Matrix3, Rotation3, Vector3};
use std::path::Path;

/// Least singular value of the mean of the exposures' rotations: a scatter of some 25 degrees.
const AGREEING_MIN: f64 = 0.9;
/// Centres nearer to each other than this are one, m.
const APART_MIN_M: f64 = 1e-9;

/// Exterior orientation of a picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Exterior {
    /// Head to ground.
    pub rotation: Matrix3<f64>,
    /// Projection centre, east, north, up, m.
    pub centre_m: Vector3<f64>,
}

/// Another head's mount against the first one's, in the mean over the exposures.
#[derive(Clone, Debug, PartialEq)]
pub struct Mount {
    /// First head from this one.
    pub rotation: Matrix3<f64>,
    /// Scatter of an exposure's rotation about the mean, about the first head's x, y, z axes, rad.
    pub rotation_sd_rad: [f64; 3],
    /// Centre in the first head's axes (x right, y up, z backwards), m.
    pub centre_m: [f64; 3],
    /// Scatter of an exposure's centre, m.
    pub centre_sd_m: [f64; 3],
    /// Exposures.
    pub exposures: usize,
}

/// Mounts of `others` against `first`, picture by picture of the same exposures.
///
/// # Errors
/// Fewer than two exposures, or lists of different lengths.
pub fn mounts(first: &[Exterior], others: &[Vec<Exterior>]) -> Result<Vec<Mount>, InputError> {
    others.iter().enumerate().map(|(index, other)| mount(first, other, index + 2)).collect()
}

fn mount(first: &[Exterior], other: &[Exterior], number: usize) -> Result<Mount, InputError> {
    if first.len() != other.len() {
        return Err(InputError::new(format!(
            "head 1 has {} exposures, head {number} {}: row i of each has to be the same exposure",
            first.len(),
            other.len()
        )));
    }
    let count = first.len();
    if count < 2 {
        return Err(InputError::new(format!("{count} exposures: two at least tell a scatter")));
    }
    let against_first = |(a, b): (&Exterior, &Exterior)| Exterior {
        rotation: a.rotation.tr_mul(&b.rotation),
        centre_m: a.rotation.tr_mul(&(b.centre_m - a.centre_m)),
    };
    let pairs: Vec<Exterior> = first.iter().zip(other).map(against_first).collect();
    let sum: Matrix3<f64> = pairs.iter().map(|pair| pair.rotation).sum();
    let Some((mean, least)) = rotation::nearest(sum) else {
        return Err(InputError::new(format!("the rotations of head {number} have no mean")));
    };
    // Equal rotations add up to singular values of their number; a reflection is none of them.
    if least < AGREEING_MIN * count as f64 {
        return Err(InputError::new(format!(
            "the exposures of head {number} disagree by many degrees: row i of each has to be the same exposure"
        )));
    }
    let centre = pairs.iter().map(|pair| pair.centre_m).sum::<Vector3<f64>>() / count as f64;
    let scatter = |of: &dyn Fn(&Exterior) -> Vector3<f64>| {
        let squares: Vector3<f64> = pairs.iter().map(|pair| of(pair).component_mul(&of(pair))).sum();
        (squares / (count - 1) as f64).map(f64::sqrt).into()
    };
    Ok(Mount {
        rotation: mean,
        rotation_sd_rad: scatter(&|pair| {
            Rotation3::from_matrix_unchecked(pair.rotation * mean.transpose()).scaled_axis()
        }),
        centre_m: centre.into(),
        centre_sd_m: scatter(&|pair| pair.centre_m - centre),
        exposures: count,
    })
}

/// Centres in the axes of section 3.1.1: their middle is the origin, x and y lie in the plane fitted to them, y parallel
/// to the line from the third to the first (from the second to the first where there is no third). Of fewer than three
/// centres, or of such on a line, the plane is the one nearest to the first head's image.
///
/// # Errors
/// The heads that give the y axis have one centre.
pub fn platform_centres(mounts: &[Mount]) -> Result<Vec<[f64; 3]>, InputError> {
    let all: Vec<Vector3<f64>> =
        std::iter::once(Vector3::zeros()).chain(mounts.iter().map(|mount| Vector3::from(mount.centre_m))).collect();
    let middle = all.iter().sum::<Vector3<f64>>() / all.len() as f64;
    let spread: Matrix3<f64> = all.iter().map(|centre| (centre - middle) * (centre - middle).transpose()).sum();
    let eigen = spread.symmetric_eigen();
    let mut order = [0, 1, 2];
    order.sort_by(|a, b| eigen.eigenvalues[*b].total_cmp(&eigen.eigenvalues[*a]));
    let is_plane = all.len() >= 3 && eigen.eigenvalues[order[1]] > 1e-4 * eigen.eigenvalues[order[0]];
    let up = if is_plane { eigen.eigenvectors.column(order[2]).into_owned() } else { Vector3::z() };
    let up = if up.z < 0.0 { -up } else { up };
    let along = all[0] - all[if all.len() > 2 { 2 } else { 1 }.min(all.len() - 1)];
    let y = (along - up * along.dot(&up))
        .try_normalize(APART_MIN_M)
        .ok_or_else(|| InputError::new("the two heads that give the platform's y axis have one centre"))?;
    let x = y.cross(&up);
    Ok(all.iter().map(|centre| [x, y, up].map(|axis| axis.dot(&(centre - middle)))).collect())
}

/// Exterior orientations of all heads by resecting every picture of a block alone from its known points.
///
/// # Errors
/// A picture with fewer than four known points, or one whose resection does not come to an end.
pub fn resected(block: &Block, observations: &Observations) -> Result<Vec<Vec<Exterior>>, InputError> {
    let name = &observations.name;
    let known: Vec<usize> = (0..block.points.len()).filter(|point| !block.points[*point].is_free).collect();
    let mut heads = Vec::new();
    for (number, head) in block.heads.iter().enumerate() {
        let mut pictures = Vec::new();
        for (station, start) in block.stations.iter().enumerate() {
            let seen: Vec<Observation> = observations
                .seen
                .iter()
                .filter(|seen| (seen.station, seen.head) == (station, number))
                .filter_map(|seen| {
                    let point = known.binary_search(&seen.point).ok()?;
                    Some(Observation { station: 0, head: 0, point, image_px: seen.image_px })
                })
                .collect();
            if seen.len() < 4 {
                return Err(InputError::new(format!(
                    "{name}: head {number} sees {} known points at station {station}, a resection needs four",
                    seen.len()
                )));
            }
            let values = picture(&start.values, &head.values);
            let mut alone = Head { values: head.values, free: Vec::new() };
            alone.values[..7].fill(0.0);
            let points = known.iter().map(|point| block.points[*point]).collect();
            let rig = Rig::new(
                vec![Station { values, rates: [0.0; 6], is_free: true }],
                vec![alone],
                points,
                seen,
                vec![block.sigma_px[number]],
            );
            let picture = format!("{name}, head {number} at station {station}");
            let adjusted = Calibration::of_rig(&rig, &options(block), &mut |_, _| {}).map_err(|_| {
                InputError::failed(format!("{picture}: the resection does not come to an end from these start values"))
            })?;
            let adjusted = adjusted.plausible(&picture)?;
            let [phi, omega, kappa, east, north, up] = adjusted.stations[0];
            pictures.push(Exterior {
                rotation: rotation::matrix([phi, omega, kappa]),
                centre_m: Vector3::new(east, north, up),
            });
        }
        heads.push(pictures);
    }
    Ok(heads)
}

/// Reads exterior orientations: a row a picture with the columns Easting, Northing, Height (m) and Omega, Phi, Kappa (deg),
/// in any order, whatever is in brackets behind a name. R = R_x(omega) R_y(phi) R_z(kappa), head to ground.
///
/// # Errors
/// The file cannot be read, a column is missing, a field is not a finite number.
pub fn read_exterior(path: &Path) -> Result<Vec<Exterior>, InputError> {
    let (text, name) = text_of(path)?;
    let table = Table::parse(&text, name)?;
    let plain =
        |name: &str, wanted: &str| name.split('[').next().is_some_and(|name| name.trim().eq_ignore_ascii_case(wanted));
    let columns = table.columns_that(["easting", "northing", "height", "omega", "phi", "kappa"], plain)?;
    let mut pictures = Vec::new();
    for row in 0..table.rows.len() {
        let [east, north, up, omega, phi, kappa] = table.numbers_of(row, columns)?;
        pictures.push(Exterior {
            rotation: omega_phi_kappa([omega, phi, kappa].map(f64::to_radians)),
            centre_m: Vector3::new(east, north, up),
        });
    }
    Ok(pictures)
}

/// R_x(omega) R_y(phi) R_z(kappa), as aerial triangulations report.
fn omega_phi_kappa([omega, phi, kappa]: [f64; 3]) -> Matrix3<f64> {
    let about = |axis: Vector3<f64>, angle: f64| Rotation3::new(axis * angle).into_inner();
    about(Vector3::x(), omega) * about(Vector3::y(), phi) * about(Vector3::z(), kappa)
}

/// Omega, phi, kappa of R_x(omega) R_y(phi) R_z(kappa), rad.
#[must_use]
pub fn as_omega_phi_kappa(rotation: &Matrix3<f64>) -> [f64; 3] {
    let r = rotation;
    [(-r[(1, 2)]).atan2(r[(2, 2)]), r[(0, 2)].clamp(-1.0, 1.0).asin(), (-r[(0, 1)]).atan2(r[(0, 0)])]
}
