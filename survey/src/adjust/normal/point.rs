//! A point's own equations, and its elimination from those of the blocks.

use super::super::model::{Link, Model, Row};
use super::super::pattern::Pattern;
use super::sums::Sums;
use super::{DAMPED, Equations, NormalError};

/// Least pivot of a point's 3 x 3 matrix over its diagonal: below, its rays are parallel to rounding.
const PIVOT_MIN: f64 = 1e-13;

/// A point's own equations.
pub(in super::super) struct OfPoint {
    /// Blocks that the point joins, ascending.
    pub(in super::super) blocks: Vec<u32>,
    /// First row of each of them in `mixed`, and the number of all.
    pub(in super::super) rows: Vec<usize>,
    /// W.
    pub(in super::super) mixed: Vec<[f64; 3]>,
    /// W V^-1.
    pub(in super::super) weighted: Vec<[f64; 3]>,
    /// V^-1, symmetric.
    pub(in super::super) inverse: [[f64; 3]; 3],
    /// The point's part of the gradient.
    pub(super) gradient: [f64; 3],
    /// What was added to V's diagonal.
    pub(super) damping: [f64; 3],
    /// V.
    normal: [[f64; 3]; 3],
}

impl OfPoint {
    /// Those of a point that joins `blocks`, with nothing in them yet.
    fn zero(blocks: Vec<u32>, pattern: &Pattern) -> Self {
        let rows = pattern.rows_of(&blocks);
        OfPoint {
            mixed: vec![[0.0; 3]; rows[rows.len() - 1]],
            blocks,
            rows,
            weighted: Vec::new(),
            inverse: [[0.0; 3]; 3],
            gradient: [0.0; 3],
            damping: [0.0; 3],
            normal: [[0.0; 3]; 3],
        }
    }

    /// Adds an observation.
    fn add_row(&mut self, link: &Link, row: &Row) {
        for e in 0..2 {
            self.add_one(&row.point[e], row.residual[e]);
            for (block, values) in [(link.station, &row.station[e][..]), (link.head, &row.head[e][..])] {
                let Some(block) = block else { continue };
                let Ok(index) = self.blocks.binary_search(&block) else { continue };
                for (mixed, value) in self.mixed[self.rows[index]..self.rows[index + 1]].iter_mut().zip(values) {
                    (0..3).for_each(|k| mixed[k] += value * row.point[e][k]);
                }
            }
        }
    }

    /// Adds one equation's part in V and the gradient.
    fn add_one(&mut self, row: &[f64; 3], residual: f64) {
        for (to, a) in self.normal.iter_mut().zip(row) {
            to.iter_mut().zip(row).for_each(|(to, b)| *to += a * b);
        }
        (0..3).for_each(|k| self.gradient[k] += row[k] * residual);
    }

    /// Adds `damping` times V's diagonal to it.
    fn damp(&mut self, damping: f64) {
        for k in 0..3 {
            self.damping[k] = damping * self.normal[k][k].clamp(*DAMPED.start(), *DAMPED.end());
            self.normal[k][k] += self.damping[k];
        }
    }
}

impl<M: Model> Equations<'_, M> {
    /// A point's equations; the blocks' own parts go to `sums`.
    pub(in super::super) fn of_point(
        &self,
        at: &M::At<'_>,
        x: &[f64],
        point: usize,
        damping: f64,
        mut sums: Option<&mut Sums>,
    ) -> Result<OfPoint, NormalError> {
        let structure = self.structure();
        let pattern = &self.layout.pattern;
        let mut blocks = Vec::new();
        self.layout.groups.blocks_of(structure, point, &mut blocks);
        let mut of = OfPoint::zero(blocks, pattern);
        let mut row = Row::zero();
        for &observation in self.layout.groups.of(point) {
            if !self.weighted_row(at, observation as usize, &mut row) {
                return Err(NormalError::Behind(observation as usize));
            }
            let link = structure.links[observation as usize];
            of.add_row(&link, &row);
            if let Some(sums) = &mut sums {
                sums.add_row(pattern, link.station, link.head, &row);
            }
        }
        for &prior in &self.layout.point_priors[point] {
            let prior = &structure.priors[prior];
            for (row, residual) in prior.rows.iter().zip(prior.residuals(self.point(x, point))) {
                of.add_one(&[row[0], row[1], row[2]], residual);
            }
        }
        if damping > 0.0 {
            of.damp(damping);
        }
        of.inverse = inverse(&of.normal).ok_or(NormalError::Parallel(point))?;
        of.weighted = of.mixed.iter().map(|mixed| of.inverse.map(|column| dot(&column, mixed))).collect();
        Ok(of)
    }
}

pub(in super::super) fn dot(a: &[f64; 3], b: &[f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Inverse of a symmetric positive definite matrix by L D L'; `None` where a pivot vanishes.
fn inverse(m: &[[f64; 3]; 3]) -> Option<[[f64; 3]; 3]> {
    let holds = |pivot: f64, diagonal: f64| pivot > PIVOT_MIN * diagonal && diagonal.is_finite();
    let d0 = m[0][0];
    let (l10, l20) = (m[1][0] / d0, m[2][0] / d0);
    let d1 = m[1][1] - l10 * m[1][0];
    let l21 = (m[2][1] - l20 * m[1][0]) / d1;
    let d2 = m[2][2] - l20 * m[2][0] - l21 * l21 * d1;
    if !(holds(d0, m[0][0]) && holds(d1, m[1][1]) && holds(d2, m[2][2])) {
        return None;
    }
    // Rows of L^-1.
    let (k10, k21) = (-l10, -l21);
    let k20 = l10 * l21 - l20;
    let (w0, w1, w2) = (1.0 / d0, 1.0 / d1, 1.0 / d2);
    let (a, b, c) = (k20 * w2, k21 * w2, w2);
    let off = k10 * w1 + k21 * a;
    Some([[w0 + k10 * k10 * w1 + k20 * a, off, a], [off, w1 + k21 * b, b], [a, b, c]])
}
