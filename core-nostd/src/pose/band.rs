//! Symmetric positive definite systems of up to seven diagonals, factored as L D L' without an array of their size.
//!
//! A window has at most [`WINDOW`] unknowns. Shorter ones are padded with ones on the diagonal, which change nothing,
//! so that every loop has a constant length and no index can leave its array.

/// Unknowns of the largest window: 0.1 s of attitude at 200 Hz. Positions are fitted over the eleven of their ring, 2 s
/// at 5 Hz. More gain little: at a lag of two samples 21 are within 2 % of any number.
pub const WINDOW: usize = 21;
/// Diagonals below the main one: as many as the highest order of differences.
pub const BELOW: usize = 3;
/// Rows of a matrix: padded at both ends, so that the rows of an earlier and of a later unknown always exist.
const ROWS: usize = BELOW + WINDOW + BELOW;

/// A number for each sample of a window. Zeros follow its end, so that a row of differences may begin at any sample.
pub type Column = [f32; WINDOW + BELOW];

/// A matrix: row `i` holds the elements (i, i), (i, i − 1), (i, i − 2), (i, i − 3).
#[derive(Clone, Debug)]
pub struct Band {
    rows: [[f32; BELOW + 1]; ROWS],
}

/// Its factors.
#[derive(Clone, Debug)]
pub struct Factors {
    /// (i, i − 1) to (i, i − 3) of the unit lower triangle.
    lower: [[f32; BELOW]; ROWS],
    /// 1/D.
    reciprocal: [f32; ROWS],
}

impl Band {
    /// The diagonal matrix of `diagonal`, ones beyond its end.
    #[inline]
    pub fn diagonal(diagonal: &[f32]) -> Self {
        let mut band = Band { rows: [[1.0, 0.0, 0.0, 0.0]; ROWS] };
        for (row, value) in band.rows.iter_mut().skip(BELOW).zip(diagonal) {
            row[0] = *value;
        }
        band
    }

    /// Adds `factor` r r', r being zero but for `elements` from the unknown `first` on.
    #[inline]
    pub fn add(&mut self, first: usize, elements: &[f32; BELOW + 1], factor: f32) {
        let [a, b, c, d] = *elements;
        let Some([w, x, y, z]) = self.rows.get_mut(BELOW + first..).and_then(|rows| rows.first_chunk_mut()) else {
            return;
        };
        let [fa, fb, fc, fd] = [factor * a, factor * b, factor * c, factor * d];
        w[0] += fa * a;
        x[0] += fb * b;
        x[1] += fb * a;
        y[0] += fc * c;
        y[1] += fc * b;
        y[2] += fc * a;
        z[0] += fd * d;
        z[1] += fd * c;
        z[2] += fd * b;
        z[3] += fd * a;
    }

    /// A = L D L'. `false` if A is not positive definite.
    #[inline(never)]
    pub fn factor_into(&self, factors: &mut Factors) -> bool {
        let Factors { lower, reciprocal } = factors;
        for i in BELOW..BELOW + WINDOW {
            let [a0, a1, a2, a3] = self.rows[i];
            // c = l d, from the farthest diagonal to the nearest.
            let c3 = a3;
            let c2 = a2 - c3 * lower[i - 2][0];
            let c1 = a1 - c3 * lower[i - 1][1] - c2 * lower[i - 1][0];
            let l = [c1 * reciprocal[i - 1], c2 * reciprocal[i - 2], c3 * reciprocal[i - 3]];
            let d = a0 - l[0] * c1 - l[1] * c2 - l[2] * c3;
            if !(d > 0.0 && d < f32::INFINITY) {
                return false;
            }
            (lower[i], reciprocal[i]) = (l, 1.0 / d);
        }
        true
    }
}

impl Factors {
    /// Those of the identity, to be overwritten.
    pub const NONE: Factors = Factors { lower: [[0.0; BELOW]; ROWS], reciprocal: [1.0; ROWS] };

    /// x of A x = `right`.
    #[inline(never)]
    pub fn solve(&self, right: &Column) -> Column {
        let mut x = [0.0f32; WINDOW + BELOW];
        let (mut z1, mut z2, mut z3) = (0.0f32, 0.0f32, 0.0f32);
        for i in 0..WINDOW {
            let [l1, l2, l3] = self.lower[BELOW + i];
            let z = right[i] - l1 * z1 - l2 * z2 - l3 * z3;
            x[i] = z;
            (z1, z2, z3) = (z, z1, z2);
        }
        // From the last to the first, with the contributions of the three rows below.
        let (mut x1, mut x2, mut x3) = (0.0f32, 0.0f32, 0.0f32);
        let mut behind = [[0.0f32; BELOW]; BELOW];
        for i in (0..WINDOW).rev() {
            let value = x[i] * self.reciprocal[BELOW + i] - behind[0][0] * x1 - behind[1][1] * x2 - behind[2][2] * x3;
            x[i] = value;
            (x1, x2, x3) = (value, x1, x2);
            behind = [self.lower[BELOW + i], behind[0], behind[1]];
        }
        x
    }
}
