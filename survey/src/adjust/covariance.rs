//! How well the unknowns are determined, and how well the observations control each other.

use super::error::SolveError;
use super::model::{Link, Model, Row};
use super::normal::{NormalError, dot};
use super::solve::{Adjustment, solved};
use super::weakest::{EIGENVALUE_MIN, largest};
use faer::sparse::linalg::solvers::Llt;
use rayon::prelude::*;

/// The cofactors Q = N^-1 at a solution: covariances for a variance of weight of 1.
#[derive(Debug)]
pub struct Cofactors<'a, M: Model> {
    adjustment: &'a Adjustment<'a, M>,
    x: &'a [f64],
    factor: Llt<usize, f64>,
    /// Smallest eigenvalue of the reduced equations scaled to a diagonal of ones: 1 over their condition, about.
    pub eigenvalue_min: f64,
}

/// A point's cofactors, symmetric.
pub type OfPoint = [[f64; 3]; 3];
/// Of a point's observations, each with its number, and of the point.
type Controlled = (Vec<(u32, Redundancy)>, OfPoint);

/// What an observation is worth: its parts of the redundancy (in \[0, 1\]) in x and y.
pub type Redundancy = [f64; 2];

impl<M: Model> Adjustment<'_, M> {
    /// The cofactors at a solution.
    ///
    /// # Errors
    /// The observations do not determine the unknowns.
    pub fn cofactors<'a>(&'a self, x: &'a [f64]) -> Result<Cofactors<'a, M>, SolveError> {
        let reduced = match self.equations.reduced(x, 0.0) {
            Ok(reduced) => reduced,
            Err(NormalError::Behind(observation)) => return Err(SolveError::Behind { observation }),
            Err(NormalError::Parallel(point)) => return Err(SolveError::Parallel { point }),
        };
        let Some(factor) = self.factor(&reduced) else { return Err(self.singular(x)) };
        let (eigenvalue_min, vector) = self.weakest(&reduced, &factor);
        if eigenvalue_min.is_nan() || eigenvalue_min < EIGENVALUE_MIN {
            return Err(SolveError::Singular { along: largest(&vector) });
        }
        Ok(Cofactors { adjustment: self, x, factor, eigenvalue_min })
    }
}

impl<M: Model> Cofactors<'_, M> {
    /// Cofactors of the chosen unknowns of the blocks among each other, row by row.
    #[must_use]
    pub fn of(&self, unknowns: &[usize]) -> Vec<Vec<f64>> {
        let count = self.adjustment.equations.layout.pattern.unknowns();
        unknowns
            .par_iter()
            .map(|&unknown| {
                let mut unit = vec![0.0; count];
                unit[unknown] = 1.0;
                let column = solved(&self.factor, &unit);
                unknowns.iter().map(|&row| column[row]).collect()
            })
            .collect()
    }

    /// Cofactors of every block with those it is joined to, laid out as the reduced equations are. Blocks are taken one
    /// by one, so that the memory is that of the equations.
    fn joined(&self) -> Vec<f64> {
        let pattern = &self.adjustment.equations.layout.pattern;
        let rows: Vec<Vec<f64>> = (0..pattern.start.len() - 1)
            .into_par_iter()
            .map(|block| {
                let size = pattern.size(block);
                let columns: Vec<Vec<f64>> = (0..size)
                    .map(|inner| {
                        let mut unit = vec![0.0; pattern.unknowns()];
                        unit[pattern.start[block] + inner] = 1.0;
                        solved(&self.factor, &unit)
                    })
                    .collect();
                let mut values = Vec::new();
                for &(other, _) in pattern.row(block) {
                    for unknown in pattern.start[other as usize]..pattern.start[other as usize + 1] {
                        values.extend(columns.iter().map(|column| column[unknown]));
                    }
                }
                values
            })
            .collect();
        rows.concat()
    }

    /// Cofactors of some blocks, ascending, as one dense matrix; `rows` is the first row of each, and the number of all.
    fn dense(&self, joined: &[f64], blocks: &[u32], rows: &[usize]) -> Dense {
        let pattern = &self.adjustment.equations.layout.pattern;
        let count = rows[blocks.len()];
        let mut values = vec![0.0; count * count];
        for (a, &row) in blocks.iter().enumerate() {
            for (b, &column) in blocks[..=a].iter().enumerate() {
                let Some(offset) = pattern.offset(row as usize, column as usize) else { continue };
                let size = rows[a + 1] - rows[a];
                for (j, column) in (rows[b]..rows[b + 1]).enumerate() {
                    for (i, row) in (rows[a]..rows[a + 1]).enumerate() {
                        let value = joined[offset + j * size + i];
                        values[row * count + column] = value;
                        values[column * count + row] = value;
                    }
                }
            }
        }
        Dense { count, values }
    }

    /// The redundancy of every observation, 1 - diag(A Q A' P), and the cofactors of every point, row by row.
    ///
    /// # Errors
    /// None at a solution that [`Adjustment::cofactors`] accepted.
    pub fn redundancies(&self) -> Result<(Vec<Redundancy>, Vec<OfPoint>), SolveError> {
        let equations = &self.adjustment.equations;
        let structure = equations.model.structure();
        let joined = self.joined();
        let at = equations.model.at(self.x);
        let refused = |error| match error {
            NormalError::Behind(observation) => SolveError::Behind { observation },
            NormalError::Parallel(point) => SolveError::Parallel { point },
        };
        let of_points: Vec<_> =
            (0..structure.points).into_par_iter().map(|point| self.of_point(&at, &joined, point)).collect();
        let mut redundancies = vec![[0.0; 2]; structure.links.len()];
        let mut points = Vec::with_capacity(structure.points);
        for of_point in of_points {
            let (of_observations, own) = of_point.map_err(refused)?;
            points.push(own);
            of_observations.into_iter().for_each(|(observation, value)| redundancies[observation as usize] = value);
        }
        let mut row = Row::zero();
        for &observation in &equations.layout.groups.without_point {
            equations.weighted_row(&at, observation as usize, &mut row);
            let link = structure.links[observation as usize];
            let mut blocks: Vec<u32> = link.station.into_iter().chain(link.head).collect();
            blocks.sort_unstable();
            let rows = equations.layout.pattern.rows_of(&blocks);
            let dense = self.dense(&joined, &blocks, &rows);
            redundancies[observation as usize] =
                [0, 1].map(|e| 1.0 - dense.quadratic(&entries(&row, e, link, &blocks, &rows)));
        }
        Ok((redundancies, points))
    }

    fn of_point(&self, at: &M::At<'_>, joined: &[f64], point: usize) -> Result<Controlled, NormalError> {
        let equations = &self.adjustment.equations;
        let of = equations.of_point(at, self.x, point, 0.0, None)?;
        let dense = self.dense(joined, &of.blocks, &of.rows);
        // Q T with T = W V^-1: less of it is what point and blocks have in common. The point's own is V^-1 + T'Q T.
        let common: Vec<[f64; 3]> = (0..dense.count).map(|row| dense.times(row, &of.weighted)).collect();
        let mut own = of.inverse;
        for (t, common) in of.weighted.iter().zip(&common) {
            (0..9).for_each(|k| own[k / 3][k % 3] += t[k / 3] * common[k % 3]);
        }
        let mut row = Row::zero();
        let mut redundancies = Vec::new();
        for &observation in equations.layout.groups.of(point) {
            equations.weighted_row(at, observation as usize, &mut row);
            let link = equations.model.structure().links[observation as usize];
            let redundancy = [0, 1].map(|e| {
                let entries = entries(&row, e, link, &of.blocks, &of.rows);
                let by_point = &row.point[e];
                let mixed: f64 = entries.iter().map(|(k, value)| value * dot(&common[*k], by_point)).sum();
                let alone: f64 = (0..3).map(|k| by_point[k] * dot(&own[k], by_point)).sum();
                1.0 - (dense.quadratic(&entries) - 2.0 * mixed + alone)
            });
            redundancies.push((observation, redundancy));
        }
        Ok((redundancies, own))
    }
}

/// A symmetric matrix.
struct Dense {
    count: usize,
    values: Vec<f64>,
}

impl Dense {
    /// a'Qa of a sparse a.
    fn quadratic(&self, a: &[(usize, f64)]) -> f64 {
        let row = |i: usize| a.iter().map(|(j, value)| value * self.values[i * self.count + j]).sum::<f64>();
        a.iter().map(|(i, value)| value * row(*i)).sum()
    }

    /// A row times three columns.
    fn times(&self, row: usize, columns: &[[f64; 3]]) -> [f64; 3] {
        let mut sum = [0.0; 3];
        for (value, column) in self.values[row * self.count..].iter().zip(columns) {
            (0..3).for_each(|k| sum[k] += value * column[k]);
        }
        sum
    }
}

/// An equation's derivatives by the blocks, with their rows in the dense matrix.
fn entries(row: &Row, e: usize, link: Link, blocks: &[u32], rows: &[usize]) -> Vec<(usize, f64)> {
    let of = |block: Option<u32>, values: &[f64]| -> Vec<(usize, f64)> {
        let Some(Ok(index)) = block.map(|block| blocks.binary_search(&block)) else { return Vec::new() };
        (rows[index]..rows[index + 1]).zip(values.iter().copied()).collect()
    };
    let mut entries = of(link.station, &row.station[e]);
    entries.extend(of(link.head, &row.head[e]));
    entries
}
