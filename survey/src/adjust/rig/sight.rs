//! From a point on the ground to its image in a head at a station.

use super::super::lens::{INTERIOR, Interior};
use super::super::rotation;
use super::{HEAD, LENS, Station, TIME};
use nalgebra::{Matrix3, Vector3};

/// Where a point would be seen, x right and y up in pixels; `None` where it is not in front of the head.
#[must_use]
pub fn project(head: &[f64; HEAD], station: &Station, point_m: [f64; 3]) -> Option<[f64; 2]> {
    let sight = Sight::new(head, station);
    let u = sight.u(point_m);
    in_front(&u).then(|| Interior(lens(head)).image([-u.x / u.z, -u.y / u.z]))
}

/// A head's interior orientation.
pub(super) fn lens(head: &[f64; HEAD]) -> [f64; INTERIOR] {
    std::array::from_fn(|k| head[LENS + k])
}

/// Whether the ray goes into the camera: the axis is -z.
pub(super) fn in_front(u: &Vector3<f64>) -> bool {
    u.z < 0.0
}

/// What a station and a head have in common for all points.
#[derive(Clone, Debug)]
pub(super) struct Sight {
    pub(super) centre: Vector3<f64>,
    /// Ground to platform, and its derivatives by the station's angles.
    pub(super) to_platform: Matrix3<f64>,
    pub(super) by_angle: [Matrix3<f64>; 3],
    /// Platform to head, and its derivatives by the head's angles.
    pub(super) to_head: Matrix3<f64>,
    pub(super) by_mount: [Matrix3<f64>; 3],
    pub(super) d: Vector3<f64>,
    pub(super) rates: [f64; 6],
}

impl Sight {
    pub(super) fn new(head: &[f64; HEAD], station: &Station) -> Self {
        let at = |k: usize| station.values[k] + head[TIME] * station.rates[k];
        let (rotation, by_angle) = rotation::with_derivatives([at(0), at(1), at(2)]);
        let (mount, by_mount) = rotation::with_derivatives([head[0], head[1], head[2]]);
        Sight {
            centre: Vector3::new(at(3), at(4), at(5)),
            to_platform: rotation.transpose(),
            by_angle: by_angle.map(|matrix| matrix.transpose()),
            to_head: mount.transpose(),
            by_mount: by_mount.map(|matrix| matrix.transpose()),
            d: Vector3::new(head[3], head[4], head[5]),
            rates: station.rates,
        }
    }

    /// The point on the head's axes.
    pub(super) fn u(&self, point_m: [f64; 3]) -> Vector3<f64> {
        self.to_head * (self.to_platform * (Vector3::from(point_m) - self.centre) - self.d)
    }
}
