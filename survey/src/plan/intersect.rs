//! Multi-ray intersection of a ground point, and how well it is determined (paper 004, section 2, steps 3 to 6).
//!
//! Level photos, axes along, across, up. A point at tangents (a, b) from a photo's vertical at depth d is measured with errors
//! of the image, of the projection centre and of the attitude. To first order a ray's two tangents are off by
//!
//! ```text
//! image      sigma_along, sigma_across
//! position   (-1/d, 0), (0, -1/d), (-a/d, -b/d)       of along, across, up
//! attitude   (1 + a^2, ab), (ab, 1 + b^2), (b, -a)     of the turns about across, along and up
//! ```
//!
//! A photo gives a point one ray, so the rays of a point are independent, each with its 2 x 2 covariance; weighted by it,
//! N = sum A' S^-1 A with A = (1, 0, a; 0, 1, b) / d, and N^-1 is the point's covariance.

use super::sight::Ray;
use nalgebra::{Matrix2, Matrix2x3, Matrix3, Vector2, Vector3};

/// Standard deviations of what is measured.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sigmas {
    /// Of the image's tangents, along and across: pixels times the tangent of one.
    pub image: [f64; 2],
    /// Of each coordinate of a projection centre.
    pub position_m: f64,
    /// Of each angle.
    pub attitude_rad: f64,
}

/// Derivatives of a ray's tangents by the point's along, across, up.
fn design(ray: &Ray) -> Matrix2x3<f64> {
    let [a, b] = ray.tangent;
    Matrix2x3::new(1.0, 0.0, a, 0.0, 1.0, b) / ray.depth_m
}

/// Covariance of a ray's tangents.
#[must_use]
pub fn covariance_of_ray(ray: &Ray, sigmas: &Sigmas) -> Matrix2<f64> {
    let [a, b] = ray.tangent;
    let position = Matrix2::new(1.0 + a * a, a * b, a * b, 1.0 + b * b) * (sigmas.position_m / ray.depth_m).powi(2);
    let turns = [Vector2::new(1.0 + a * a, a * b), Vector2::new(a * b, 1.0 + b * b), Vector2::new(b, -a)];
    let attitude: Matrix2<f64> = turns.iter().map(|turn| turn * turn.transpose()).sum();
    let image = Matrix2::from_diagonal(&Vector2::from(sigmas.image.map(|sigma| sigma * sigma)));
    image + position + attitude * sigmas.attitude_rad.powi(2)
}

/// Covariance of the point that the rays meet in (along, across, up; square metres); `None` where they do not determine it.
#[must_use]
pub fn covariance(rays: &[Ray], sigmas: &Sigmas) -> Option<Matrix3<f64>> {
    if rays.len() < 2 {
        return None;
    }
    let mut normal = Matrix3::zeros();
    for ray in rays {
        let a = design(ray);
        normal += a.transpose() * covariance_of_ray(ray, sigmas).try_inverse()? * a;
    }
    inverse(&normal)
}

/// The point nearest to all rays, each at its weight: where it comes to lie relative to the true one, along, across, up.
/// `measured` are the tangents that came out, in the order of the rays, for the nominal positions and attitudes.
#[must_use]
pub fn intersection(rays: &[Ray], measured: &[[f64; 2]], sigmas: &Sigmas) -> Option<[f64; 3]> {
    let mut normal = Matrix3::zeros();
    let mut right = Vector3::zeros();
    for (ray, seen) in rays.iter().zip(measured) {
        let a = design(ray);
        let weighted = a.transpose() * covariance_of_ray(ray, sigmas).try_inverse()?;
        normal += weighted * a;
        right += weighted * Vector2::new(seen[0] - ray.tangent[0], seen[1] - ray.tangent[1]);
    }
    // One step from the true point: errors of 1e-4 leave 1e-8 of the depth to a second.
    inverse(&normal).map(|covariance| (covariance * right).into())
}

/// Inverse of a normal matrix that determines all three coordinates: two rays that coincide determine no depth.
fn inverse(normal: &Matrix3<f64>) -> Option<Matrix3<f64>> {
    let most = normal[(0, 0)] * normal[(1, 1)] * normal[(2, 2)];
    (normal.determinant() > 1e-12 * most).then(|| normal.try_inverse()).flatten()
}
