//! The virtual camera: its axis is the mean of the heads' (paper 002, 3.1.2).

use crate::adjust::rig::HEAD;
use crate::adjust::rotation;
use nalgebra::{Matrix3, Vector3};

/// Heads as the virtual camera sees them, and how it is turned against the platform they were adjusted in.
#[derive(Clone, Debug, PartialEq)]
pub struct Symmetrised {
    /// Q: virtual camera to platform.
    pub platform_from_virtual: Matrix3<f64>,
    /// Numbers of the heads, angles and centres in the virtual camera's frame.
    pub heads: Vec<[f64; HEAD]>,
}

impl Symmetrised {
    /// Turns the heads so that the mean of their axes is the virtual camera's: Q is the smallest rotation that takes
    /// (0, 0, -1) there, R_i becomes Q'R_i, d_i becomes Q'd_i (left out, the centres were off by 0.4 mm for 0.38 degrees),
    /// a station's rotation R_v Q.
    #[must_use]
    pub fn new(heads: &[[f64; HEAD]]) -> Self {
        let axis: Vector3<f64> = heads.iter().map(|head| -mount(head).column(2).into_owned()).sum();
        let q = rotation::between(-Vector3::z(), axis.normalize());
        let turned = |head: &[f64; HEAD]| {
            let mut turned = *head;
            turned[..3].copy_from_slice(&rotation::angles_rad(&(q.transpose() * mount(head))));
            let d = q.transpose() * Vector3::new(head[3], head[4], head[5]);
            turned[3..6].copy_from_slice(d.as_slice());
            turned
        };
        Symmetrised { platform_from_virtual: q, heads: heads.iter().map(turned).collect() }
    }

    /// A station's numbers with the virtual camera's rotation.
    #[must_use]
    pub fn station(&self, station: &[f64; 6]) -> [f64; 6] {
        let rotation = rotation::matrix([station[0], station[1], station[2]]) * self.platform_from_virtual;
        let [phi, omega, kappa] = rotation::angles_rad(&rotation);
        [phi, omega, kappa, station[3], station[4], station[5]]
    }
}

/// Rotation of a head: head to platform.
#[must_use]
pub fn mount(head: &[f64; HEAD]) -> Matrix3<f64> {
    rotation::matrix([head[0], head[1], head[2]])
}

/// Orientation (phi, omega, kappa, X, Y, Z) of the picture that a head takes at a station, each given by its numbers.
#[must_use]
pub fn picture(station: &[f64; 6], head: &[f64; HEAD]) -> [f64; 6] {
    let platform = rotation::matrix([station[0], station[1], station[2]]);
    let [phi, omega, kappa] = rotation::angles_rad(&(platform * mount(head)));
    let centre = platform * Vector3::new(head[3], head[4], head[5]);
    [phi, omega, kappa, station[3] + centre[0], station[4] + centre[1], station[5] + centre[2]]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::adjust::Interior;
    use crate::adjust::rig::{Head, Station, project};

    #[test]
    fn images_stay_where_they_are() {
        let heads: Vec<[f64; HEAD]> =
            [(-0.385, 0.31, -0.045, 0.06), (0.38, 0.322, 0.045, 0.06), (-0.38, -0.31, -0.045, -0.06)]
                .iter()
                .map(|&(phi, omega, dx, dy)| {
                    Head::new([phi, omega, 0.004], [dx, dy, 0.0], Interior::ideal(6900.0), false).values
                })
                .collect();
        let station = [0.02, -0.03, 1.6, 1000.0, 2000.0, 700.0];
        let virtual_camera = Symmetrised::new(&heads);
        let of = |values: [f64; 6]| Station { values, rates: [0.0; 6], is_free: true };
        for (head, turned) in heads.iter().zip(&virtual_camera.heads) {
            let point = [1100.0, 1900.0, 20.0];
            let before = project(head, &of(station), point).expect("in front");
            let after = project(turned, &of(virtual_camera.station(&station)), point).expect("in front");
            assert!((before[0] - after[0]).hypot(before[1] - after[1]) < 1e-8);
        }
        let axes: Vector3<f64> = virtual_camera.heads.iter().map(|head| mount(head).column(2).into_owned()).sum();
        assert!(axes.x.abs() < 1e-14 && axes.y.abs() < 1e-14);
    }
}
