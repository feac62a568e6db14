//! Normal equations, with the points eliminated.
//!
//! N = \[U W; W' V\] over blocks and points: V is 3 x 3 a point, so S = U - W V^-1 W' is summed up point by point and N is
//! never formed. Points are worked on in a fixed number of pieces by rayon; the sums are the same whatever the cores.

use super::error::SolveError;
use super::loss::Loss;
use super::model::{At, Model, Place, Row, Structure};
use super::pattern::{Groups, Pattern};
use rayon::prelude::*;

/// Runs of points, each with sums of its own.
const PIECES: usize = 8;
/// Least pivot of a point's 3 x 3 matrix over its diagonal: below, its rays are parallel to rounding.
const PIVOT_MIN: f64 = 1e-13;
/// Range of what damping multiplies, as in Ceres.
const DAMPED: std::ops::RangeInclusive<f64> = 1e-6..=1e32;

/// What does not change from one iteration to the next.
#[derive(Debug)]
pub(super) struct Layout {
    pub(super) pattern: Pattern,
    pub(super) groups: Groups,
    pieces: Vec<std::ops::Range<usize>>,
    block_priors: Vec<usize>,
    point_priors: Vec<Vec<usize>>,
}

impl Layout {
    pub(super) fn new(structure: &Structure) -> Self {
        let groups = Groups::new(structure);
        let (mut block_priors, mut point_priors) = (Vec::new(), vec![Vec::new(); structure.points]);
        for (index, prior) in structure.priors.iter().enumerate() {
            match prior.place {
                Place::Block(_) => block_priors.push(index),
                Place::Point(point) => point_priors[point].push(index),
            }
        }
        Layout {
            pattern: Pattern::new(structure, &groups),
            pieces: groups.pieces(PIECES),
            groups,
            block_priors,
            point_priors,
        }
    }
}

/// Reduced equations S dx = -g at some values of the unknowns.
#[derive(Clone, Debug)]
pub(super) struct Reduced {
    /// S, block by block.
    pub(super) values: Vec<f64>,
    /// g.
    pub(super) gradient: Vec<f64>,
    /// g before the points were eliminated.
    pub(super) full_gradient: Vec<f64>,
    /// What was added to U's diagonal.
    pub(super) damping: Vec<f64>,
}

/// Why equations could not be set up.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum NormalError {
    /// A point behind a camera: the observation.
    Behind(usize),
    /// A point whose rays do not meet.
    Parallel(usize),
}

/// A point's own equations.
pub(super) struct OfPoint {
    /// Blocks that the point joins, ascending.
    pub(super) blocks: Vec<u32>,
    /// First row of each of them in `mixed`, and the number of all.
    pub(super) rows: Vec<usize>,
    /// W.
    pub(super) mixed: Vec<[f64; 3]>,
    /// W V^-1.
    pub(super) weighted: Vec<[f64; 3]>,
    /// V^-1, symmetric.
    pub(super) inverse: [[f64; 3]; 3],
    /// The point's part of the gradient.
    gradient: [f64; 3],
    /// What was added to V's diagonal.
    damping: [f64; 3],
    normal: [[f64; 3]; 3],
}

/// Sums of a piece.
pub(super) struct Sums {
    values: Vec<f64>,
    gradient: Vec<f64>,
    eliminated: Vec<f64>,
}

/// A model with the layout of its equations.
#[derive(Debug)]
pub(super) struct Equations<'a, M: Model> {
    pub(super) model: &'a M,
    pub(super) layout: Layout,
    pub(super) loss: Loss,
}

impl<M: Model> Equations<'_, M> {
    fn structure(&self) -> &Structure {
        self.model.structure()
    }

    /// The values of a point.
    pub(super) fn point<'x>(&self, x: &'x [f64], point: usize) -> &'x [f64] {
        let from = self.layout.pattern.unknowns() + 3 * point;
        &x[from..from + 3]
    }

    fn block<'x>(&self, x: &'x [f64], block: usize) -> &'x [f64] {
        &x[self.layout.pattern.start[block]..self.layout.pattern.start[block + 1]]
    }

    /// Half the sum of squares, each reduced by the loss; `None` where a point lies behind a camera.
    pub(super) fn cost(&self, x: &[f64]) -> Option<f64> {
        let at = self.model.at(x);
        let count = self.structure().links.len();
        let piece = |piece: usize| {
            let range = piece * count / PIECES..(piece + 1) * count / PIECES;
            range.map(|observation| Some(self.loss.of(at.residual(observation)?))).sum::<Option<f64>>()
        };
        let pieces: Vec<Option<f64>> = (0..PIECES).into_par_iter().map(piece).collect();
        let seen = pieces.into_iter().sum::<Option<f64>>()?;
        Some(seen + self.cost_of_priors(x))
    }

    /// Which observation has no finite cost.
    pub(super) fn behind(&self, x: &[f64]) -> SolveError {
        let at = self.model.at(x);
        let behind = (0..self.structure().links.len()).find(|observation| at.residual(*observation).is_none());
        behind.map_or(SolveError::NotFinite, |observation| SolveError::Behind { observation })
    }

    fn cost_of_priors(&self, x: &[f64]) -> f64 {
        let values = |place| match place {
            Place::Block(block) => self.block(x, block),
            Place::Point(point) => self.point(x, point),
        };
        let of = |prior: &super::model::Prior| prior.residuals(values(prior.place)).map(|v| 0.5 * v * v).sum::<f64>();
        self.structure().priors.iter().map(of).sum()
    }

    /// The reduced equations, with `damping` times the diagonal added to all of N's.
    pub(super) fn reduced(&self, x: &[f64], damping: f64) -> Result<Reduced, NormalError> {
        let at = self.model.at(x);
        let pieces: Vec<_> =
            self.layout.pieces.par_iter().map(|points| self.sums(&at, x, points.clone(), damping)).collect();
        let mut sums = Sums::zero(self);
        for piece in pieces {
            sums.add(&piece?);
        }
        self.add_known_points(&at, &mut sums)?;
        self.add_priors(x, &mut sums);
        let pattern = &self.layout.pattern;
        let mut added = vec![0.0; pattern.unknowns()];
        if damping > 0.0 {
            for block in 0..pattern.start.len() - 1 {
                let (size, place) = (pattern.size(block), pattern.diagonal(block));
                for inner in 0..size {
                    let diagonal = pattern.start[block] + inner;
                    // U's own diagonal: what the points took away is put back first.
                    let own = sums.values[place + inner * (size + 1)] + sums.eliminated[diagonal];
                    added[diagonal] = damping * own.clamp(*DAMPED.start(), *DAMPED.end());
                    sums.values[place + inner * (size + 1)] += added[diagonal];
                }
            }
        }
        let full_gradient = sums.gradient[pattern.unknowns()..].to_vec();
        sums.gradient.truncate(pattern.unknowns());
        Ok(Reduced { values: sums.values, gradient: sums.gradient, full_gradient, damping: added })
    }

    fn sums(
        &self,
        at: &M::At<'_>,
        x: &[f64],
        points: std::ops::Range<usize>,
        damping: f64,
    ) -> Result<Sums, NormalError> {
        let mut sums = Sums::zero(self);
        let pattern = &self.layout.pattern;
        let unknowns = pattern.unknowns();
        for point in points {
            let of = self.of_point(at, x, point, damping, Some(&mut sums))?;
            for (k, &row) in of.blocks.iter().enumerate() {
                let rows = of.rows[k]..of.rows[k + 1];
                let size = rows.len();
                let start = pattern.start[row as usize];
                for (inner, (weighted, mixed)) in
                    of.weighted[rows.clone()].iter().zip(&of.mixed[rows.clone()]).enumerate()
                {
                    sums.gradient[start + inner] -= dot(weighted, &of.gradient);
                    sums.eliminated[start + inner] += dot(weighted, mixed);
                }
                // Both lists ascend: one walk finds every place.
                let mut places = pattern.row(row as usize).iter();
                for (j, &column) in of.blocks[..=k].iter().enumerate() {
                    let Some(&(_, place)) = places.find(|(other, _)| *other == column) else { continue };
                    for (inner, mixed) in of.mixed[of.rows[j]..of.rows[j + 1]].iter().enumerate() {
                        let values = &mut sums.values[place + inner * size..place + (inner + 1) * size];
                        for (value, weighted) in values.iter_mut().zip(&of.weighted[rows.clone()]) {
                            *value -= dot(weighted, mixed);
                        }
                    }
                }
            }
        }
        debug_assert_eq!(sums.gradient.len(), 2 * unknowns);
        Ok(sums)
    }

    /// A point's equations; the blocks' own parts go to `sums`.
    pub(super) fn of_point(
        &self,
        at: &M::At<'_>,
        x: &[f64],
        point: usize,
        damping: f64,
        mut sums: Option<&mut Sums>,
    ) -> Result<OfPoint, NormalError> {
        let structure = self.structure();
        let pattern = &self.layout.pattern;
        let mut of = OfPoint {
            blocks: Vec::new(),
            rows: Vec::new(),
            mixed: Vec::new(),
            weighted: Vec::new(),
            inverse: [[0.0; 3]; 3],
            gradient: [0.0; 3],
            damping: [0.0; 3],
            normal: [[0.0; 3]; 3],
        };
        self.layout.groups.blocks_of(structure, point, &mut of.blocks);
        of.rows = pattern.rows_of(&of.blocks);
        of.mixed = vec![[0.0; 3]; of.rows[of.rows.len() - 1]];
        let mut row = Row::zero();
        for &observation in self.layout.groups.of(point) {
            if !self.weighted_row(at, observation as usize, &mut row) {
                return Err(NormalError::Behind(observation as usize));
            }
            let link = structure.links[observation as usize];
            for e in 0..2 {
                add_outer(&mut of.normal, &row.point[e]);
                (0..3).for_each(|k| of.gradient[k] += row.point[e][k] * row.residual[e]);
                for (block, values) in [(link.station, &row.station[e][..]), (link.head, &row.head[e][..])] {
                    let Some(block) = block else { continue };
                    let Ok(place) = of.blocks.binary_search(&block) else { continue };
                    for (mixed, value) in of.mixed[of.rows[place]..of.rows[place + 1]].iter_mut().zip(values) {
                        (0..3).for_each(|k| mixed[k] += value * row.point[e][k]);
                    }
                }
            }
            if let Some(sums) = &mut sums {
                sums.add_row(pattern, link.station, link.head, &row);
            }
        }
        for &prior in &self.layout.point_priors[point] {
            let prior = &structure.priors[prior];
            for (row, residual) in prior.rows.iter().zip(prior.residuals(self.point(x, point))) {
                let row = [row[0], row[1], row[2]];
                add_outer(&mut of.normal, &row);
                (0..3).for_each(|k| of.gradient[k] += row[k] * residual);
            }
        }
        if damping > 0.0 {
            for k in 0..3 {
                of.damping[k] = damping * of.normal[k][k].clamp(*DAMPED.start(), *DAMPED.end());
                of.normal[k][k] += of.damping[k];
            }
        }
        of.inverse = inverse(&of.normal).ok_or(NormalError::Parallel(point))?;
        of.weighted = of.mixed.iter().map(|mixed| of.inverse.map(|column| dot(&column, mixed))).collect();
        Ok(of)
    }

    /// A row, reduced by the loss.
    pub(super) fn weighted_row(&self, at: &M::At<'_>, observation: usize, row: &mut Row) -> bool {
        if !at.linearise(observation, row) {
            return false;
        }
        let weight = self.loss.weight(row.residual[0].hypot(row.residual[1]));
        if weight < 1.0 {
            row.scale(weight.sqrt());
        }
        true
    }

    fn add_known_points(&self, at: &M::At<'_>, sums: &mut Sums) -> Result<(), NormalError> {
        let mut row = Row::zero();
        for &observation in &self.layout.groups.without_point {
            if !self.weighted_row(at, observation as usize, &mut row) {
                return Err(NormalError::Behind(observation as usize));
            }
            let link = self.structure().links[observation as usize];
            sums.add_row(&self.layout.pattern, link.station, link.head, &row);
        }
        Ok(())
    }

    fn add_priors(&self, x: &[f64], sums: &mut Sums) {
        for &prior in &self.layout.block_priors {
            let prior = &self.structure().priors[prior];
            let Place::Block(block) = prior.place else { continue };
            for (row, residual) in prior.rows.iter().zip(prior.residuals(self.block(x, block))) {
                sums.add_one(&self.layout.pattern, block, row, residual);
            }
        }
    }

    /// The whole step from that of the blocks, and by how much the linearised cost falls.
    pub(super) fn step(
        &self,
        x: &[f64],
        reduced: &Reduced,
        blocks: &[f64],
        damping: f64,
    ) -> Result<(Vec<f64>, f64), NormalError> {
        let at = self.model.at(x);
        let pattern = &self.layout.pattern;
        let pieces: Vec<_> = self
            .layout
            .pieces
            .par_iter()
            .map(|points| {
                let (mut steps, mut gain) = (Vec::with_capacity(3 * points.len()), 0.0);
                for point in points.clone() {
                    let of = self.of_point(&at, x, point, damping, None)?;
                    let mut right = of.gradient;
                    for (k, &block) in of.blocks.iter().enumerate() {
                        let from = pattern.start[block as usize];
                        for (inner, mixed) in of.mixed[of.rows[k]..of.rows[k + 1]].iter().enumerate() {
                            (0..3).for_each(|k| right[k] += mixed[k] * blocks[from + inner]);
                        }
                    }
                    let step = of.inverse.map(|column| -dot(&column, &right));
                    gain += (0..3).map(|k| step[k] * (of.damping[k] * step[k] - of.gradient[k])).sum::<f64>();
                    steps.extend(step);
                }
                Ok((steps, gain))
            })
            .collect();
        let (mut step, mut gain) = (blocks.to_vec(), 0.0);
        for (k, value) in blocks.iter().enumerate() {
            gain += value * (reduced.damping[k] * value - reduced.full_gradient[k]);
        }
        for piece in pieces {
            let (steps, more) = piece?;
            step.extend(steps);
            gain += more;
        }
        Ok((step, 0.5 * gain))
    }
}

impl Sums {
    /// The gradient is kept twice: reduced, then whole.
    fn zero<M: Model>(equations: &Equations<'_, M>) -> Self {
        let unknowns = equations.layout.pattern.unknowns();
        Sums {
            values: vec![0.0; equations.layout.pattern.len],
            gradient: vec![0.0; 2 * unknowns],
            eliminated: vec![0.0; unknowns],
        }
    }

    fn add(&mut self, other: &Sums) {
        let add = |to: &mut [f64], from: &[f64]| to.iter_mut().zip(from).for_each(|(to, from)| *to += from);
        add(&mut self.values, &other.values);
        add(&mut self.gradient, &other.gradient);
        add(&mut self.eliminated, &other.eliminated);
    }

    fn add_row(&mut self, pattern: &Pattern, station: Option<u32>, head: Option<u32>, row: &Row) {
        for e in 0..2 {
            for (block, values) in [(station, &row.station[e][..]), (head, &row.head[e][..])] {
                let Some(block) = block else { continue };
                self.add_one(pattern, block as usize, &values[..pattern.size(block as usize)], row.residual[e]);
            }
        }
        if let (Some(station), Some(head)) = (station, head) {
            let station = (station as usize, &row.station.each_ref().map(|row| &row[..])[..]);
            let head = (head as usize, &row.head.each_ref().map(|row| &row[..])[..]);
            let (high, low) = if station.0 > head.0 { (station, head) } else { (head, station) };
            let Some(place) = pattern.place(high.0, low.0) else { return };
            let (rows, columns) = (pattern.size(high.0), pattern.size(low.0));
            for e in 0..2 {
                for column in 0..columns {
                    let factor = low.1[e][column];
                    let values = &mut self.values[place + column * rows..place + (column + 1) * rows];
                    values.iter_mut().zip(high.1[e]).for_each(|(value, row)| *value += factor * row);
                }
            }
        }
    }

    /// One equation's part in a diagonal block and the gradient.
    fn add_one(&mut self, pattern: &Pattern, block: usize, row: &[f64], residual: f64) {
        let (start, place, size) = (pattern.start[block], pattern.diagonal(block), row.len());
        let unknowns = pattern.unknowns();
        for (column, factor) in row.iter().enumerate() {
            let part = factor * residual;
            self.gradient[start + column] += part;
            self.gradient[unknowns + start + column] += part;
            let values = &mut self.values[place + column * size..place + (column + 1) * size];
            values.iter_mut().zip(row).for_each(|(value, row)| *value += factor * row);
        }
    }
}

pub(super) fn dot(a: &[f64; 3], b: &[f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn add_outer(to: &mut [[f64; 3]; 3], row: &[f64; 3]) {
    for (to, a) in to.iter_mut().zip(row) {
        to.iter_mut().zip(row).for_each(|(to, b)| *to += a * b);
    }
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
