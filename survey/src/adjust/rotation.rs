//! Rotations by phi, omega, kappa.

use nalgebra::{Matrix3, Vector3};

/// R = R_phi R_omega R_kappa, from the image (or head) to the ground (or platform); angles in radians.
///
/// Image: x right, y up, z backwards along the axis; ground: east, north, up. Papers 000 (eq. 1, whose printed
/// R_omega\[3,3\] has the wrong sign) and 002.
#[must_use]
pub fn matrix(angles_rad: [f64; 3]) -> Matrix3<f64> {
    let [phi, omega, kappa] = factors(angles_rad);
    phi * omega * kappa
}

/// R and its derivatives by phi, omega and kappa.
#[must_use]
pub fn with_derivatives(angles_rad: [f64; 3]) -> (Matrix3<f64>, [Matrix3<f64>; 3]) {
    let [phi, omega, kappa] = factors(angles_rad);
    let omega_kappa = omega * kappa;
    let rotation = phi * omega_kappa;
    // Each factor's derivative is itself times the generator of its axis.
    let by_phi = phi * Matrix3::new(0.0, 0.0, -1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0) * omega_kappa;
    let by_omega = phi * omega * Matrix3::new(0.0, 0.0, 0.0, 0.0, 0.0, -1.0, 0.0, 1.0, 0.0) * kappa;
    let by_kappa = rotation * Matrix3::new(0.0, -1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0);
    (rotation, [by_phi, by_omega, by_kappa])
}

fn factors([phi, omega, kappa]: [f64; 3]) -> [Matrix3<f64>; 3] {
    let (sp, cp) = phi.sin_cos();
    let (so, co) = omega.sin_cos();
    let (sk, ck) = kappa.sin_cos();
    [
        Matrix3::new(cp, 0.0, -sp, 0.0, 1.0, 0.0, sp, 0.0, cp),
        Matrix3::new(1.0, 0.0, 0.0, 0.0, co, -so, 0.0, so, co),
        Matrix3::new(ck, -sk, 0.0, sk, ck, 0.0, 0.0, 0.0, 1.0),
    ]
}

/// Phi, omega and kappa of a rotation, radians: phi and kappa in (-pi, pi], omega in \[-pi/2, pi/2\].
#[must_use]
pub fn angles_rad(rotation: &Matrix3<f64>) -> [f64; 3] {
    let r = rotation;
    let omega = (-r[(1, 2)]).clamp(-1.0, 1.0).asin();
    [(-r[(0, 2)]).atan2(r[(2, 2)]), omega, r[(1, 0)].atan2(r[(1, 1)])]
}

/// The rotation nearest to a sum of rotations, their mean, and the least singular value of the sum, which is their number
/// where all agree; `None` where the sum is not finite.
#[must_use]
pub fn nearest(sum: Matrix3<f64>) -> Option<(Matrix3<f64>, f64)> {
    let svd = sum.svd(true, true);
    Some((svd.u? * svd.v_t?, svd.singular_values.min()))
}

/// The smallest rotation that takes the direction `from` into the direction `to`, both of length 1 and not opposite.
#[must_use]
pub fn between(from: Vector3<f64>, to: Vector3<f64>) -> Matrix3<f64> {
    let axis = from.cross(&to);
    let cross = axis.cross_matrix();
    Matrix3::identity() + cross + cross * cross / (1.0 + from.dot(&to))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Reference, section 0.
    #[test]
    fn the_golden_rotation() {
        let golden = [
            -0.028594068,
            -0.999391211,
            -0.019989668,
            0.999123829,
            -0.029186384,
            0.029995500,
            -0.030560665,
            -0.019114460,
            0.999350130,
        ];
        let ours = matrix([0.02, -0.03, 1.6]);
        assert!((ours - Matrix3::from_row_slice(&golden)).amax() < 1e-9, "{ours}");
    }

    #[test]
    fn angles_come_back_and_derivatives_are_the_differences() {
        let angles = [-0.4, 0.3, 2.9];
        let (rotation, derivatives) = with_derivatives(angles);
        for (back, angle) in angles_rad(&rotation).iter().zip(angles) {
            assert!((back - angle).abs() < 1e-14);
        }
        for (k, derivative) in derivatives.iter().enumerate() {
            let moved = |by: f64| {
                let mut angles = angles;
                angles[k] += by;
                matrix(angles)
            };
            let difference = (moved(1e-6) - moved(-1e-6)) / 2e-6;
            assert!((difference - derivative).amax() < 1e-9, "{k}");
        }
    }

    #[test]
    fn the_smallest_rotation_takes_one_to_the_other() {
        let (from, to) = (-Vector3::z(), Vector3::new(0.01, -0.02, -1.0).normalize());
        let rotation = between(from, to);
        assert!((rotation * from - to).norm() < 1e-15);
        assert!((rotation * rotation.transpose() - Matrix3::identity()).amax() < 1e-15);
    }
}
