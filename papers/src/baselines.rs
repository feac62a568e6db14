//! The two kernels that the paper compares itself with, on ground control points, in f64.
//!
//! Ground positions are metres (east, north) from the nadir, frame positions pixels (right, forward) from the frame's
//! centre. Position and height of the camera are known to both, as they are to the automatic kernel.

use nalgebra::{Matrix3, Rotation3, SMatrix, SVector, Vector3};

/// Control points that a fit takes.
pub const CONTROL_POINTS: usize = 6;
/// Equations of them: two coordinates each.
const EQUATIONS: usize = 2 * CONTROL_POINTS;

/// A point seen in the frame whose place on the ground is known.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ControlPoint {
    /// Metres east and north of the nadir.
    pub ground_m: [f64; 2],
    /// Pixels right and forward of the frame's centre.
    pub frame_px: [f64; 2],
}

/// First-order polynomial: ground = c0 + c1 m + c2 n, for each of the two coordinates. It has no perspective.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Polynomial {
    east: [f64; 3],
    north: [f64; 3],
}

/// What [`Polynomial::fit`] keeps at once: the design, its normal matrix and the right-hand sides.
pub type PolynomialWorkspace = (SMatrix<f64, CONTROL_POINTS, 3>, Matrix3<f64>, SMatrix<f64, 3, 2>);

impl Polynomial {
    /// Least squares on the control points; `None` when they lie on a line.
    pub fn fit(points: &[ControlPoint; CONTROL_POINTS]) -> Option<Self> {
        let design = SMatrix::<f64, CONTROL_POINTS, 3>::from_fn(|row, col| match col {
            0 => 1.0,
            _ => points[row].frame_px[col - 1],
        });
        let ground = SMatrix::<f64, CONTROL_POINTS, 2>::from_fn(|row, col| points[row].ground_m[col]);
        let normal: Matrix3<f64> = design.transpose() * design;
        let c: SMatrix<f64, 3, 2> = normal.cholesky()?.solve(&(design.transpose() * ground));
        Some(Polynomial { east: [c[(0, 0)], c[(1, 0)], c[(2, 0)]], north: [c[(0, 1)], c[(1, 1)], c[(2, 1)]] })
    }

    /// Ground under a frame position.
    pub fn ground_m(&self, [m, n]: [f64; 2]) -> [f64; 2] {
        [self.east, self.north].map(|c| c[0] + c[1] * m + c[2] * n)
    }

    /// The way back, which a resampler needs: [c0, c1, c2] with m = c0 + c1 east + c2 north, and the same for n.
    /// `None` when the polynomial flattens the plane.
    pub fn inverse(&self) -> Option<[[f64; 3]; 2]> {
        let (e, n) = (self.east, self.north);
        let determinant = e[1] * n[2] - e[2] * n[1];
        if determinant == 0.0 || !determinant.is_finite() {
            return None;
        }
        let m_row = [n[2] / determinant, -e[2] / determinant];
        let n_row = [-n[1] / determinant, e[1] / determinant];
        Some([m_row, n_row].map(|[a, b]| [-a * e[0] - b * n[0], a, b]))
    }
}

/// Most Gauss-Newton steps of a resection; two or three are usual from an attitude a degree off.
const STEPS_MAX: usize = 12;
/// A step shorter than this ends it, radians.
const STEP_RAD: f64 = 1e-12;

/// What [`resect`] keeps at once: the design, the misclosures, the normal matrix, the step and the rotation.
pub type ResectionWorkspace =
    (SMatrix<f64, EQUATIONS, 3>, SVector<f64, EQUATIONS>, Matrix3<f64>, Vector3<f64>, Matrix3<f64>);

/// Resection of the three angles by collinearity, eq. 3 of the paper: the rotation `camera_from_local` (forward, up,
/// right from north, up, east) that brings the control points nearest to where the frame shows them, least squares in
/// the frame from the rotation `start`.
///
/// The angles enter as a small turn d in front of the rotation, v' = v + d x v, so there is no singular attitude. With
/// v = (forward, up, right) of the ray, m = -right / (up k), n = -forward / (up k).
///
/// `None` when a point lies behind the camera or the steps do not settle.
pub fn resect(
    start: Matrix3<f64>,
    points: &[ControlPoint; CONTROL_POINTS],
    height_m: f64,
    tangent_per_px: f64,
) -> Option<Matrix3<f64>> {
    let mut rotation = start;
    for _ in 0..STEPS_MAX {
        let mut design = SMatrix::<f64, EQUATIONS, 3>::zeros();
        let mut misclosure = SVector::<f64, EQUATIONS>::zeros();
        for (index, point) in points.iter().enumerate() {
            let [east, north] = point.ground_m;
            let v = rotation * Vector3::new(north, -height_m, east);
            let (forward, up, right) = (v.x, v.y, v.z);
            if up >= 0.0 {
                return None;
            }
            // d(d x v): columns are the unit turns about forward, up, right.
            let turned = [Vector3::x(), Vector3::y(), Vector3::z()].map(|axis| axis.cross(&v));
            let scale = 1.0 / (tangent_per_px * up * up);
            for (col, dv) in turned.iter().enumerate() {
                design[(2 * index, col)] = (right * dv.y - up * dv.z) * scale;
                design[(2 * index + 1, col)] = (forward * dv.y - up * dv.x) * scale;
            }
            misclosure[2 * index] = point.frame_px[0] + right / (up * tangent_per_px);
            misclosure[2 * index + 1] = point.frame_px[1] + forward / (up * tangent_per_px);
        }
        let normal: Matrix3<f64> = design.transpose() * design;
        let step = normal.cholesky()?.solve(&(design.transpose() * misclosure));
        rotation = Rotation3::new(step).into_inner() * rotation;
        if step.norm() < STEP_RAD {
            return Some(rotation);
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;
    use plumbline_sim::oracle::matrix_a;

    const HEIGHT_M: f64 = 191.0;
    const K: f64 = 0.0025;

    fn matrix(heading_deg: f64, pitch_deg: f64, roll_deg: f64) -> Matrix3<f64> {
        let a = matrix_a(heading_deg.to_radians(), pitch_deg.to_radians(), roll_deg.to_radians(), 0.0);
        Matrix3::from_fn(|row, col| a[row][col])
    }

    const GROUND_M: [[f64; 2]; CONTROL_POINTS] =
        [[-70.0, -65.0], [2.0, -72.0], [71.0, -60.0], [-68.0, 66.0], [-3.0, 70.0], [66.0, 75.0]];

    #[test]
    fn resection_recovers_the_rotation_from_exact_points() {
        let truth = matrix(3.0, 10.0, -8.0);
        let points = GROUND_M.map(|ground_m| {
            let v = truth * Vector3::new(ground_m[1], -HEIGHT_M, ground_m[0]);
            ControlPoint { ground_m, frame_px: [-v.z / v.y / K, -v.x / v.y / K] }
        });
        // From two degrees off in each angle.
        let found = resect(matrix(1.0, 12.0, -10.0), &points, HEIGHT_M, K).unwrap();
        assert!((found - truth).norm() < 1e-11, "{}", found - truth);
    }

    #[test]
    fn polynomial_recovers_an_affine_map_and_its_inverse() {
        let (east, north) = ([3.0, 0.41, -0.02], [-7.0, 0.03, 0.39]);
        let points = GROUND_M.map(|[m, n]| ControlPoint {
            ground_m: [east, north].map(|c| c[0] + c[1] * m + c[2] * n),
            frame_px: [m, n],
        });
        let found = Polynomial::fit(&points).unwrap();
        for (c, truth) in [(found.east, east), (found.north, north)] {
            for i in 0..3 {
                assert!((c[i] - truth[i]).abs() < 1e-12, "{c:?}");
            }
        }
        let inverse = found.inverse().unwrap();
        let [east, north] = found.ground_m([12.0, -34.0]);
        let [m, n] = inverse.map(|c| c[0] + c[1] * east + c[2] * north);
        assert!((m - 12.0).abs() < 1e-10 && (n + 34.0).abs() < 1e-10, "{m} {n}");
    }

    #[test]
    fn points_on_a_line_and_points_behind_the_camera_are_refused() {
        let line = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0].map(|x| ControlPoint { ground_m: [x, x], frame_px: [x, 2.0 * x] });
        assert_eq!(Polynomial::fit(&line), None);
        let points = GROUND_M.map(|ground_m| ControlPoint { ground_m, frame_px: [0.0, 0.0] });
        assert_eq!(resect(matrix(0.0, 180.0, 0.0), &points, HEIGHT_M, K), None);
    }
}
