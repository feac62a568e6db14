//! Paper 000 in `f64`: image motion during an exposure, the centroid of its track, and the intersection of two photos.
//!
//! Axes (paper 000): ground X across, Y flight, Z up; image x across, y flight, z up, the image plane at z = -f. The
//! rotation is R = R_phi R_omega R_kappa, its rows a, b, c; P - S = lambda R (x, y, -f). Lengths on the image plane
//! have the unit of the focal length, lengths on the ground are metres, angles radians, times seconds.
//!
//! Against the paper: (3,3) of R_omega is +cos omega in eq. 1 and 6 (as printed det R = -1 and R(0,0,0) is no
//! identity); (1,1) of R_v in eq. 24 is -f - x^2/f (eq. 13 at zero angles); every term of eq. 21 carries the time, and
//! its first vector holds the nine products of angles and rates.

use super::rotation::{Matrix3, apply, product, transpose};

/// Intervals of Simpson's rule over a track. Its error is that of the fourth derivative by time, (w t)^4 f / 2880 /
/// 16^4: below 1e-15 mm for 20 deg/s and 5 ms.
const INTERVALS: usize = 16;

/// Exterior orientation at one instant.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Exterior {
    /// Projection centre S, metres.
    pub station_m: [f64; 3],
    /// phi, omega, kappa, radians.
    pub angles_rad: [f64; 3],
}

/// A photo during its exposure: exterior orientation where the shutter opens, and how it changes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Photo {
    /// Where the shutter opens.
    pub opening: Exterior,
    /// Rates of phi, omega, kappa, radians a second.
    pub rates_rad_s: [f64; 3],
    /// V along Y, metres a second.
    pub speed_m_s: f64,
    /// Principal distance f.
    pub focal: f64,
}

/// R of eq. 1: ground from image axes.
pub fn ground_from_image([phi, omega, kappa]: [f64; 3]) -> Matrix3 {
    let ((sp, cp), (sw, cw), (sk, ck)) = (phi.sin_cos(), omega.sin_cos(), kappa.sin_cos());
    let by_phi = [[cp, 0.0, -sp], [0.0, 1.0, 0.0], [sp, 0.0, cp]];
    let by_omega = [[1.0, 0.0, 0.0], [0.0, cw, -sw], [0.0, sw, cw]];
    let by_kappa = [[ck, -sk, 0.0], [sk, ck, 0.0], [0.0, 0.0, 1.0]];
    product(&by_phi, &product(&by_omega, &by_kappa))
}

impl Exterior {
    /// Eq. 4 and 5: image point of a ground point; `None` where it lies in or behind the lens.
    pub fn image(&self, focal: f64, ground_m: [f64; 3]) -> Option<[f64; 2]> {
        let sight = std::array::from_fn(|axis| ground_m[axis] - self.station_m[axis]);
        let [x, y, z] = apply(&transpose(&ground_from_image(self.angles_rad)), sight);
        (z < 0.0).then(|| [-focal * x / z, -focal * y / z])
    }

    /// Ground point of an image point on the level plane at height `up_m`; `None` above the horizon.
    pub fn ground(&self, focal: f64, [x, y]: [f64; 2], up_m: f64) -> Option<[f64; 3]> {
        let ray = apply(&ground_from_image(self.angles_rad), [x, y, -focal]);
        let lambda = (up_m - self.station_m[2]) / ray[2];
        (lambda > 0.0 && lambda.is_finite())
            .then(|| std::array::from_fn(|axis| self.station_m[axis] + lambda * ray[axis]))
    }
}

impl Photo {
    /// Exterior orientation `t_s` after the shutter opened (eq. 6 to 8): angles and Y grow at constant rates.
    pub fn at(&self, t_s: f64) -> Exterior {
        let Exterior { mut station_m, angles_rad } = self.opening;
        station_m[1] += self.speed_m_s * t_s;
        Exterior { station_m, angles_rad: std::array::from_fn(|axis| angles_rad[axis] + self.rates_rad_s[axis] * t_s) }
    }

    /// Eq. 9 and 10: how far the image of a ground point has moved `t_s` after the shutter opened.
    pub fn exact(&self, ground_m: [f64; 3], t_s: f64) -> Option<[f64; 2]> {
        let [from, to] = [self.opening.image(self.focal, ground_m)?, self.at(t_s).image(self.focal, ground_m)?];
        Some([to[0] - from[0], to[1] - from[1]])
    }

    /// Corrected eq. 21 to 25: the same to first order in the time and in the residual angles, from the image point (x,
    /// y) where the shutter opens and the depth HA = Z_S - Z_A below the station.
    pub fn first_order(&self, [x, y]: [f64; 2], height_m: f64, t_s: f64) -> [f64; 2] {
        let (f, [p, w, k], [dp, dw, dk]) = (self.focal, self.opening.angles_rad, self.rates_rad_s);
        let v_per_h = self.speed_m_s / height_m;
        // In the paper's order: R_omega-v with nine products, R_a with the angles, R_v with the rates, L.
        let by_products = [
            y * w * dp + x * y / f * k * dp - (f + x * x / f) * k * dw,
            -x * w * dp + (f + y * y / f) * k * dp - x * y / f * k * dw,
        ];
        let by_angles = [v_per_h * (x * w - f * k), v_per_h * (x * p + 2.0 * y * w)];
        let by_rates =
            [-(f + x * x / f) * dp - x * y / f * dw + y * dk, -x * y / f * dp - (f + y * y / f) * dw - x * dk];
        let forward = [0.0, -f * v_per_h];
        std::array::from_fn(|axis| t_s * (by_products[axis] + by_angles[axis] + by_rates[axis] + forward[axis]))
    }

    /// Eq. 26 for a track of even brightness in time: the mean image point over the first `exposure_s`, by Simpson's
    /// rule.
    ///
    /// The paper weighs by the length of the track instead, which is the same for a track of even speed; light falls
    /// evenly in time.
    pub fn centroid(&self, ground_m: [f64; 3], exposure_s: f64) -> Option<[f64; 2]> {
        let mut sum = [0.0; 2];
        for node in 0..=INTERVALS {
            let weight = match node {
                0 | INTERVALS => 1.0,
                odd if odd % 2 == 1 => 4.0,
                _ => 2.0,
            };
            let point = self.at(exposure_s * node as f64 / INTERVALS as f64).image(self.focal, ground_m)?;
            sum = [sum[0] + weight * point[0], sum[1] + weight * point[1]];
        }
        Some(sum.map(|sum| sum / (3 * INTERVALS) as f64))
    }
}

/// Forward intersection: the ground point whose images in two photos are nearest to two measured ones, by least squares
/// of the four collinearity equations in their linear form, (f a_i + x a_3) . (P - S) = 0, each of weight one. `None`
/// where the rays are parallel.
pub fn intersect(focal: f64, photos: [(Exterior, [f64; 2]); 2]) -> Option<[f64; 3]> {
    let (mut normal, mut right) = ([[0.0; 3]; 3], [0.0; 3]);
    for (exterior, point) in photos {
        let r = ground_from_image(exterior.angles_rad);
        for (axis, measured) in point.into_iter().enumerate() {
            let line: [f64; 3] = std::array::from_fn(|i| focal * r[i][axis] + measured * r[i][2]);
            let constant: f64 = (0..3).map(|i| line[i] * exterior.station_m[i]).sum();
            for i in 0..3 {
                right[i] += line[i] * constant;
                for j in 0..3 {
                    normal[i][j] += line[i] * line[j];
                }
            }
        }
    }
    solve(&normal, right)
}

/// Cramer's rule; `None` for a matrix that is singular to rounding.
fn solve(a: &Matrix3, b: [f64; 3]) -> Option<[f64; 3]> {
    let determinant = |a: &Matrix3| {
        a[0][0] * (a[1][1] * a[2][2] - a[1][2] * a[2][1]) - a[0][1] * (a[1][0] * a[2][2] - a[1][2] * a[2][0])
            + a[0][2] * (a[1][0] * a[2][1] - a[1][1] * a[2][0])
    };
    let whole = determinant(a);
    // Of a positive matrix the determinant is at most the product of the diagonal.
    if whole.is_nan() || whole <= 1e-12 * a[0][0] * a[1][1] * a[2][2] {
        return None;
    }
    Some(std::array::from_fn(|column| {
        let mut replaced = *a;
        for (row, value) in replaced.iter_mut().zip(b) {
            row[column] = value;
        }
        determinant(&replaced) / whole
    }))
}
