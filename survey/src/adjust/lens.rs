//! Interior orientation of a head: principal distance, principal point, distortion.

/// How many numbers an interior orientation has.
pub const INTERIOR: usize = 8;
/// What they are, in this order.
pub const INTERIOR_NAMES: [&str; INTERIOR] = ["c", "xp", "yp", "k1", "k2", "k3", "p1", "p2"];

/// Principal distance c, principal point (xp right, yp up), all in pixels, and Brown-Conrady coefficients on normalised
/// coordinates in the camera file's convention (OpenCV's: x right, y *down*, ideal to distorted).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interior(pub [f64; INTERIOR]);

/// An image point and its derivatives.
#[derive(Clone, Copy, Debug)]
pub struct Imaged {
    /// x right, y up, pixels.
    pub point_px: [f64; 2],
    /// By the tangents (right, up) of the ray.
    pub by_tangent: [[f64; 2]; 2],
    /// By the interior orientation.
    pub by_interior: [[f64; INTERIOR]; 2],
}

impl Interior {
    /// A lens without distortion.
    #[must_use]
    pub fn ideal(c_px: f64) -> Self {
        let mut interior = [0.0; INTERIOR];
        interior[0] = c_px;
        Interior(interior)
    }

    /// Whether any coefficient of distortion is not 0.
    #[must_use]
    pub fn is_distorted(&self) -> bool {
        self.0[3..].iter().any(|k| *k != 0.0)
    }

    /// Image point (x right, y up, pixels) of a ray with the tangents (right, up).
    #[must_use]
    pub fn image(&self, [a, b]: [f64; 2]) -> [f64; 2] {
        let [c, xp, yp, k1, k2, k3, p1, p2] = self.0;
        let (x, y) = (a, -b);
        let r2 = x * x + y * y;
        let radial = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3));
        let xd = x * radial + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x);
        let yd = y * radial + p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y;
        [c * xd + xp, yp - c * yd]
    }

    /// The distortion with its derivatives.
    #[must_use]
    pub fn imaged(&self, [a, b]: [f64; 2]) -> Imaged {
        let [c, _, _, k1, k2, k3, p1, p2] = self.0;
        let (x, y) = (a, -b);
        let r2 = x * x + y * y;
        let radial = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3));
        let slope = 2.0 * (k1 + r2 * (2.0 * k2 + r2 * 3.0 * k3));
        let xd = x * radial + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x);
        let yd = y * radial + p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y;
        let across = x * y * slope + 2.0 * p1 * x + 2.0 * p2 * y;
        let xd_x = radial + x * x * slope + 2.0 * p1 * y + 6.0 * p2 * x;
        let yd_y = radial + y * y * slope + 6.0 * p1 * y + 2.0 * p2 * x;
        let (r4, r6) = (r2 * r2, r2 * r2 * r2);
        Imaged {
            point_px: self.image([a, b]),
            // y runs down, b up: two signs a turn.
            by_tangent: [[c * xd_x, -c * across], [-c * across, c * yd_y]],
            by_interior: [
                [xd, 1.0, 0.0, c * x * r2, c * x * r4, c * x * r6, c * 2.0 * x * y, c * (r2 + 2.0 * x * x)],
                [-yd, 0.0, 1.0, -c * y * r2, -c * y * r4, -c * y * r6, -c * (r2 + 2.0 * y * y), -c * 2.0 * x * y],
            ],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn derivatives_are_the_differences() {
        let interior = Interior([7000.0, 3.0, -5.0, -0.1, 0.05, -0.02, 1e-3, -2e-3]);
        let ray = [0.41, -0.33];
        let imaged = interior.imaged(ray);
        for k in 0..2 {
            let moved = |by: f64| {
                let mut ray = ray;
                ray[k] += by;
                interior.image(ray)
            };
            let (up, down) = (moved(1e-6), moved(-1e-6));
            for i in 0..2 {
                assert!(((up[i] - down[i]) / 2e-6 - imaged.by_tangent[i][k]).abs() < 1e-4, "{i} {k}");
            }
        }
        for k in 0..INTERIOR {
            let moved = |by: f64| {
                let mut interior = interior;
                interior.0[k] += by;
                interior.image(ray)
            };
            let (up, down) = (moved(1e-5), moved(-1e-5));
            for i in 0..2 {
                assert!(((up[i] - down[i]) / 2e-5 - imaged.by_interior[i][k]).abs() < 1e-4, "{i} {k}");
            }
        }
    }
}
