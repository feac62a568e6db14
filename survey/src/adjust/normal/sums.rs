//! Sums of the reduced equations over some of the observations.

use super::super::model::Row;
use super::super::pattern::Pattern;

/// What a piece adds to the reduced equations.
pub(in super::super) struct Sums {
    /// S, block by block.
    pub(super) values: Vec<f64>,
    /// Twice: reduced, then whole.
    pub(super) gradient: Vec<f64>,
    /// What the elimination of the points took from U's diagonal.
    pub(super) eliminated: Vec<f64>,
}

impl Sums {
    pub(super) fn zero(pattern: &Pattern) -> Self {
        let unknowns = pattern.unknowns();
        Sums { values: vec![0.0; pattern.len], gradient: vec![0.0; 2 * unknowns], eliminated: vec![0.0; unknowns] }
    }

    pub(super) fn add(&mut self, other: &Sums) {
        let add = |to: &mut [f64], from: &[f64]| to.iter_mut().zip(from).for_each(|(to, from)| *to += from);
        add(&mut self.values, &other.values);
        add(&mut self.gradient, &other.gradient);
        add(&mut self.eliminated, &other.eliminated);
    }

    /// An observation's part in the blocks that it touches.
    pub(super) fn add_row(&mut self, pattern: &Pattern, station: Option<u32>, head: Option<u32>, row: &Row) {
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
            let Some(offset) = pattern.offset(high.0, low.0) else { return };
            let (rows, columns) = (pattern.size(high.0), pattern.size(low.0));
            for e in 0..2 {
                for column in 0..columns {
                    let factor = low.1[e][column];
                    let values = &mut self.values[offset + column * rows..offset + (column + 1) * rows];
                    values.iter_mut().zip(high.1[e]).for_each(|(value, row)| *value += factor * row);
                }
            }
        }
    }

    /// One equation's part in a diagonal block and the gradient.
    pub(super) fn add_one(&mut self, pattern: &Pattern, block: usize, row: &[f64], residual: f64) {
        let (start, offset, size) = (pattern.start[block], pattern.diagonal(block), row.len());
        let unknowns = pattern.unknowns();
        for (column, factor) in row.iter().enumerate() {
            let part = factor * residual;
            self.gradient[start + column] += part;
            self.gradient[unknowns + start + column] += part;
            let values = &mut self.values[offset + column * size..offset + (column + 1) * size];
            values.iter_mut().zip(row).for_each(|(value, row)| *value += factor * row);
        }
    }
}
