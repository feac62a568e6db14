//! Lens distortion in OpenCV's convention and its inverse, on normalised coordinates.

/// Brown-Conrady, ideal to distorted, x right, y down.
pub(super) fn distorted([k1, k2, k3, p1, p2]: &[f64; 5], [x, y]: [f64; 2]) -> [f64; 2] {
    let r2 = x * x + y * y;
    let radial = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3));
    [x * radial + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x), y * radial + p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y]
}

/// Newton's iteration for the ideal point. None if it does not settle to 1e-12 (2e-10 px at 500 px focal length) in 20 steps
/// or ends where the picture is folded over, beyond the reach of the coefficients.
pub(super) fn undistorted(coefficients: &[f64; 5], wanted: [f64; 2]) -> Option<[f64; 2]> {
    let &[k1, k2, k3, p1, p2] = coefficients;
    let [mut x, mut y] = wanted;
    for _ in 0..20 {
        let is = distorted(coefficients, [x, y]);
        let miss = [is[0] - wanted[0], is[1] - wanted[1]];
        let r2 = x * x + y * y;
        let radial = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3));
        let slope = 2.0 * (k1 + r2 * (2.0 * k2 + r2 * 3.0 * k3)); // d radial / d r2, doubled
        let xx = radial + slope * x * x + 2.0 * p1 * y + 6.0 * p2 * x;
        let yy = radial + slope * y * y + 6.0 * p1 * y + 2.0 * p2 * x;
        let xy = slope * x * y + 2.0 * p1 * x + 2.0 * p2 * y;
        let determinant = xx * yy - xy * xy;
        if miss[0].abs().max(miss[1].abs()) < 1e-12 {
            return (determinant > 0.0 && xx > 0.0).then_some([x, y]);
        }
        x -= (yy * miss[0] - xy * miss[1]) / determinant;
        y -= (xx * miss[1] - xy * miss[0]) / determinant;
    }
    None
}
