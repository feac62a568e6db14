//! Which blocks of the reduced normal matrix are not zero, and where their numbers lie.

use super::model::Structure;
use faer::sparse::{SparseColMat, SymbolicSparseColMat};

/// The lower triangle by blocks: two blocks are joined where an observation touches both or a point is seen by both.
///
/// Numbers are stored block by block, each by columns, and go to faer's compressed columns by one gathering.
#[derive(Debug)]
pub(super) struct Pattern {
    /// First unknown of each block, and the number of all.
    pub(super) start: Vec<usize>,
    /// For each block row the blocks left of and on the diagonal, ascending, each with the offset of its numbers.
    rows: Vec<Vec<(u32, usize)>>,
    /// Numbers of all blocks.
    pub(super) len: usize,
    /// Compressed columns, and for each of their numbers its offset in the blocks.
    compressed: SymbolicSparseColMat<usize>,
    gather: Vec<usize>,
}

impl Pattern {
    /// From the blocks that each point joins.
    pub(super) fn new(structure: &Structure, groups: &Groups) -> Self {
        let sizes = &structure.sizes;
        let mut start = vec![0];
        for size in sizes {
            start.push(start[start.len() - 1] + size);
        }
        let mut joined: Vec<Vec<u32>> = (0..sizes.len() as u32).map(|block| vec![block]).collect();
        let mut join = |blocks: &[u32]| {
            for (index, &row) in blocks.iter().enumerate() {
                joined[row as usize].extend_from_slice(&blocks[..index]);
            }
        };
        let mut blocks = Vec::new();
        for point in 0..structure.points {
            groups.blocks_of(structure, point, &mut blocks);
            join(&blocks);
        }
        for &observation in &groups.without_point {
            let link = structure.links[observation as usize];
            if let (Some(station), Some(head)) = (link.station, link.head) {
                join(&[station.min(head), station.max(head)]);
            }
        }
        let mut len = 0;
        let mut rows = Vec::new();
        for (row, mut columns) in joined.into_iter().enumerate() {
            columns.sort_unstable();
            columns.dedup();
            let offset = |column: u32| {
                let offset = len;
                len += sizes[row] * sizes[column as usize];
                (column, offset)
            };
            rows.push(columns.into_iter().map(offset).collect());
        }
        let (compressed, gather) = compress(sizes, &start, &rows);
        Pattern { start, rows, len, compressed, gather }
    }

    /// Unknowns of the reduced system.
    pub(super) fn unknowns(&self) -> usize {
        self.start[self.start.len() - 1]
    }

    /// Unknowns of a block.
    pub(super) fn size(&self, block: usize) -> usize {
        self.start[block + 1] - self.start[block]
    }

    /// First row of each of some blocks put below each other, and the number of all rows.
    pub(super) fn rows_of(&self, blocks: &[u32]) -> Vec<usize> {
        let mut rows = vec![0];
        for &block in blocks {
            rows.push(rows[rows.len() - 1] + self.size(block as usize));
        }
        rows
    }

    /// The blocks of a block row, ascending, up to the diagonal, each with the offset of its numbers.
    pub(super) fn row(&self, block: usize) -> &[(u32, usize)] {
        &self.rows[block]
    }

    /// Offset of the numbers of the diagonal block.
    pub(super) fn diagonal(&self, block: usize) -> usize {
        let row = &self.rows[block];
        row[row.len() - 1].1
    }

    /// Offset of the numbers of the block at (`row`, `column`), `column` at most `row`, if it is not zero.
    pub(super) fn offset(&self, row: usize, column: usize) -> Option<usize> {
        let row = &self.rows[row];
        row.binary_search_by_key(&(column as u32), |(column, _)| *column).ok().map(|found| row[found].1)
    }

    /// Which numbers may be other than zero.
    pub(super) fn compressed(&self) -> &SymbolicSparseColMat<usize> {
        &self.compressed
    }

    /// The lower triangle for faer.
    pub(super) fn matrix(&self, values: &[f64]) -> SparseColMat<usize, f64> {
        SparseColMat::new(self.compressed.clone(), self.gather.iter().map(|&offset| values[offset]).collect())
    }
}

fn compress(sizes: &[usize], start: &[usize], rows: &[Vec<(u32, usize)>]) -> (SymbolicSparseColMat<usize>, Vec<usize>) {
    // Block rows of each block column, ascending since rows are visited so.
    let mut columns: Vec<Vec<(usize, usize)>> = vec![Vec::new(); sizes.len()];
    for (row, blocks) in rows.iter().enumerate() {
        for &(column, offset) in blocks {
            columns[column as usize].push((row, offset));
        }
    }
    let (mut pointers, mut indices, mut gather) = (vec![0], Vec::new(), Vec::new());
    for (column, blocks) in columns.iter().enumerate() {
        for inner in 0..sizes[column] {
            for &(row, offset) in blocks {
                let first = if row == column { inner } else { 0 };
                for within in first..sizes[row] {
                    indices.push(start[row] + within);
                    gather.push(offset + inner * sizes[row] + within);
                }
            }
            pointers.push(indices.len());
        }
    }
    let unknowns = start[sizes.len()];
    (SymbolicSparseColMat::new_checked(unknowns, unknowns, pointers, None, indices), gather)
}

/// Observations by the point they see.
#[derive(Debug)]
pub(super) struct Groups {
    /// Observations in the order of their points.
    order: Vec<u32>,
    /// First of each point in the order, and the number of all.
    start: Vec<usize>,
    /// Observations of known points.
    pub(super) without_point: Vec<u32>,
}

impl Groups {
    pub(super) fn new(structure: &Structure) -> Self {
        let mut start = vec![0; structure.points + 1];
        for link in &structure.links {
            if let Some(point) = link.point {
                start[point as usize + 1] += 1;
            }
        }
        for point in 0..structure.points {
            start[point + 1] += start[point];
        }
        let mut next = start.clone();
        let mut order = vec![0; start[structure.points]];
        let mut without_point = Vec::new();
        for (observation, link) in structure.links.iter().enumerate() {
            match link.point {
                Some(point) => {
                    let offset = &mut next[point as usize];
                    order[*offset] = observation as u32;
                    *offset += 1;
                }
                None => without_point.push(observation as u32),
            }
        }
        Groups { order, start, without_point }
    }

    /// Observations of a point.
    pub(super) fn of(&self, point: usize) -> &[u32] {
        &self.order[self.start[point]..self.start[point + 1]]
    }

    /// Blocks that a point joins, ascending.
    pub(super) fn blocks_of(&self, structure: &Structure, point: usize, blocks: &mut Vec<u32>) {
        blocks.clear();
        for &observation in self.of(point) {
            let link = structure.links[observation as usize];
            blocks.extend(link.station.iter().chain(link.head.iter()));
        }
        blocks.sort_unstable();
        blocks.dedup();
    }

    /// Points in `pieces` runs of about equally many observations. The number is fixed, so that sums do not depend on the
    /// machine's cores.
    pub(super) fn pieces(&self, pieces: usize) -> Vec<std::ops::Range<usize>> {
        let points = self.start.len() - 1;
        let end = |piece: usize| self.start.partition_point(|&start| start * pieces < piece * self.order.len());
        let mut from = 0;
        (1..=pieces)
            .map(|piece| {
                let to = if piece == pieces { points } else { end(piece).clamp(from, points) };
                let range = from..to;
                from = to;
                range
            })
            .collect()
    }
}
