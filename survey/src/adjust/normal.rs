//! Normal equations, with the points eliminated.
//!
//! N = \[U W; W' V\] over blocks and points: V is 3 x 3 a point, so S = U - W V^-1 W' is summed up point by point and N is
//! never formed. Points are worked on in a fixed number of pieces by rayon; the sums are the same whatever the cores.

mod point;
mod sums;

pub(super) use point::dot;

use super::error::SolveError;
use super::loss::Loss;
use super::model::{At, Model, Place, Row, Structure};
use super::pattern::{Groups, Pattern};
use rayon::prelude::*;
use sums::Sums;

/// Runs of points, each with sums of its own.
const PIECES: usize = 8;
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
        let mut sums = Sums::zero(&self.layout.pattern);
        for piece in pieces {
            sums.add(&piece?);
        }
        self.add_known_points(&at, &mut sums)?;
        self.add_priors(x, &mut sums);
        let pattern = &self.layout.pattern;
        let mut added = vec![0.0; pattern.unknowns()];
        if damping > 0.0 {
            for block in 0..pattern.start.len() - 1 {
                let (size, offset) = (pattern.size(block), pattern.diagonal(block));
                for inner in 0..size {
                    let diagonal = pattern.start[block] + inner;
                    // U's own diagonal: what the points took away is put back first.
                    let own = sums.values[offset + inner * (size + 1)] + sums.eliminated[diagonal];
                    added[diagonal] = damping * own.clamp(*DAMPED.start(), *DAMPED.end());
                    sums.values[offset + inner * (size + 1)] += added[diagonal];
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
        let mut sums = Sums::zero(&self.layout.pattern);
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
                // Both lists ascend: one walk finds every block.
                let mut offsets = pattern.row(row as usize).iter();
                for (j, &column) in of.blocks[..=k].iter().enumerate() {
                    let Some(&(_, offset)) = offsets.find(|(other, _)| *other == column) else { continue };
                    for (inner, mixed) in of.mixed[of.rows[j]..of.rows[j + 1]].iter().enumerate() {
                        let values = &mut sums.values[offset + inner * size..offset + (inner + 1) * size];
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
