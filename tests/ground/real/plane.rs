//! The offsets of many parts of an overlap as one linear function of their places, taken apart by cause.
//!
//! A part at p east and north of the overlap's middle has the offset d + J p + noise. Over ground whose slope is small,
//! J = d sᵀ + k I + ω [0 1; −1 0]: higher ground is nearer, so its offset in metres of the ground plane is longer, by
//! s = slope / height; k is what both frames' scales, ω what their headings differ by beyond what was assumed. Four
//! causes, four numbers: it has one solution. (A tilt that both frames have and nobody states looks like a slope.)

use super::register::Registered;

/// Residual at which a part has a quarter of its weight, metres: what a tree or car of half a metre's height shifts at
/// a base of 14 m and a height of 40 m.
const OUTLIER_M: f64 = 0.15;

/// A part: its middle east and north of the overlap's, metres, and its registration.
pub type Placed = ([f64; 2], Registered);

/// The function, and its causes.
#[derive(Clone, Debug)]
pub struct Plane {
    /// d: the offset at the middle of the overlap, metres east and north.
    pub offset_m: [f64; 2],
    /// s: share by which the offset grows per metre east and north.
    pub rise_per_m: [f64; 2],
    /// k: by how much the second frame is drawn too small.
    pub scale: f64,
    /// ω: what has to be added to the second heading, radians clockwise, for both frames to fit.
    pub turn_rad: f64,
    /// Distance of every part to the function, metres.
    pub residuals_m: Vec<f64>,
}

impl Plane {
    /// Fits at least 6 parts by least squares with Geman-McClure weights.
    pub fn fit(parts: &[Placed]) -> Self {
        assert!(parts.len() >= 6, "{} parts are too few for a plane", parts.len());
        let mut weights = vec![1.0; parts.len()];
        let (mut at_middle, mut j, mut residuals_m) = ([0.0; 2], [[0.0; 2]; 2], Vec::new());
        for _ in 0..30 {
            (at_middle, j) = linear(parts, &weights);
            residuals_m = parts
                .iter()
                .map(|(p, found)| {
                    let rest = |axis: usize| found.offset_m[axis] - at_middle[axis] - dot(j[axis], *p);
                    rest(0).hypot(rest(1))
                })
                .collect();
            weights = residuals_m.iter().map(|r| (1.0 + (r / OUTLIER_M).powi(2)).powi(-2)).collect();
        }
        let d = at_middle;
        let (x, y) = (j[0][0] - j[1][1], j[0][1] + j[1][0]);
        let d2 = dot(d, d);
        let rise_per_m = [(d[0] * x + d[1] * y) / d2, (d[0] * y - d[1] * x) / d2];
        let scale = 0.5 * (j[0][0] + j[1][1] - dot(d, rise_per_m));
        let turn_rad = 0.5 * (j[0][1] - j[1][0] - (d[0] * rise_per_m[1] - d[1] * rise_per_m[0]));
        Plane { offset_m: d, rise_per_m, scale, turn_rad, residuals_m }
    }

    /// Median of the residuals, metres.
    pub fn median_m(&self) -> f64 {
        let mut sorted = self.residuals_m.clone();
        sorted.sort_by(f64::total_cmp);
        sorted[sorted.len() / 2]
    }
}

fn dot(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

/// Weighted least squares of offset = d + J p.
fn linear(parts: &[Placed], weights: &[f64]) -> ([f64; 2], [[f64; 2]; 2]) {
    let total: f64 = weights.iter().sum();
    let mean = |value: &dyn Fn(&Placed) -> f64| {
        parts.iter().zip(weights).map(|(part, weight)| weight * value(part)).sum::<f64>() / total
    };
    let place = [0, 1].map(|axis| mean(&|part| part.0[axis]));
    let offset = [0, 1].map(|axis| mean(&|part| part.1.offset_m[axis]));
    let off = |part: &Placed, axis: usize| part.0[axis] - place[axis];
    let square = |a: usize, b: usize| mean(&|part| off(part, a) * off(part, b));
    let (ee, en, nn) = (square(0, 0), square(0, 1), square(1, 1));
    let determinant = ee * nn - en * en;
    let j = [0, 1].map(|axis| {
        let product = |a: usize| mean(&|part| off(part, a) * (part.1.offset_m[axis] - offset[axis]));
        let (e, n) = (product(0), product(1));
        [(nn * e - en * n) / determinant, (ee * n - en * e) / determinant]
    });
    ([0, 1].map(|axis| offset[axis] - dot(j[axis], place)), j)
}
