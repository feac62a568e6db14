//! What a cell's average may be off, from the greys and boxes under it.

use super::super::corner_px;
use super::super::scene::Scene;

/// A cell in boxes.
pub struct Outline {
    pub corners: Vec<(f64, f64)>,
    /// How far an edge is from the chord that the kernel takes for it.
    pub bent: f64,
}

impl Outline {
    pub fn new(scene: &Scene, (col, row): (usize, usize), factor: u16) -> Option<Self> {
        let at = |(right, down): (f64, f64)| {
            let (x, y) = scene.position(col as f64 + right, row as f64 + down)?;
            Some(((x + 0.5) / f64::from(factor), (y + 0.5) / f64::from(factor)))
        };
        let corners: Vec<_> =
            [(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)].into_iter().map(at).collect::<Option<_>>()?;
        let middles: Vec<_> =
            [(0.0, -0.5), (0.5, 0.0), (0.0, 0.5), (-0.5, 0.0)].into_iter().map(at).collect::<Option<_>>()?;
        let sagitta = |n: usize| {
            let (a, m, b) = (corners[n], middles[n], corners[(n + 1) % 4]);
            let (dx, dy) = (b.0 - a.0, b.1 - a.1);
            ((m.0 - a.0) * dy - (m.1 - a.1) * dx).abs() / dx.hypot(dy)
        };
        let bent = (0..4).map(sagitta).fold(0.0, f64::max);
        Some(Outline { corners, bent })
    }

    pub fn edges(&self) -> impl Iterator<Item = (f64, f64)> {
        (0..4).map(|n| {
            let (a, b) = (self.corners[n], self.corners[(n + 1) % 4]);
            (b.0 - a.0, b.1 - a.1)
        })
    }

    pub fn area(&self) -> f64 {
        let [a, b, c, d] = [0, 1, 2, 3].map(|n| self.corners[n]);
        0.5 * ((c.0 - a.0) * (d.1 - b.1) - (c.1 - a.1) * (d.0 - b.0)).abs()
    }

    /// Columns and rows of boxes that the cell may touch.
    pub fn boxes(&self, slack: f64, (cols, rows): (usize, usize)) -> [std::ops::Range<usize>; 2] {
        let range = |axis: fn(&(f64, f64)) -> f64, count: usize| {
            let (low, high) =
                self.corners.iter().map(axis).fold((f64::MAX, f64::MIN), |(l, h), x| (l.min(x), h.max(x)));
            (low - slack).max(0.0) as usize..((high + slack).max(0.0) as usize + 1).min(count)
        };
        [range(|p| p.0, cols), range(|p| p.1, rows)]
    }

    /// Grey levels that the kernel may be off.
    ///
    /// Corners off by d move the border by d: what the swept strip adds differs from the mean by no more than greys in the
    /// cell differ. The integrals of both chains of borders are off by at most what a sum is, over their height: 1/128
    /// (and 2⁻¹² of the slope's rounding) of a box of a grey less 128, and what the shift has cut off; both chains are cut to
    /// the same side, so that greys on one side of 128 count once. A sum at the
    /// middle of a piece is off by an eighth of its length times the difference of greys along it (with slopes that
    /// differ by D, the part of a function that is not straight has a slope of D/2, and the mean distance from the middle
    /// is a quarter of the length). Areas are whole 2⁻¹⁵.
    pub fn allowed(&self, cell: &Greys, corner: f64, shift: u32) -> f64 {
        let off = std::f64::consts::SQRT_2 * corner + self.bent;
        let (mut around, mut height, mut crossed) = (0.0, 0.0, 0.0);
        for (dx, dy) in self.edges() {
            around += dx.hypot(dy);
            height += dy.abs();
            // Pieces end where a row of boxes does.
            let (dx, dy) = (dx.abs() + 2.0 * corner, dy.abs() + 2.0 * corner);
            crossed += dx * dy / f64::max(1.0, dy);
        }
        let strip = (around + 8.0 * off) * off;
        let area = self.area() - strip;
        if area <= 0.0 {
            return 256.0;
        }
        let cut = f64::from((1u32 << shift) - 1);
        let sums = 0.5 * height * (cell.beside_mid * (1.0 / 128.0 + 1.0 / 4096.0) + cut);
        let middles = crossed * cell.along_rows / 8.0;
        0.5 + (cell.difference * strip + sums + middles + 256.0 / 32768.0) / area
    }
}

/// Greys in and around a cell.
#[derive(Clone, Copy, Debug, Default)]
pub struct Greys {
    /// Largest less smallest.
    pub difference: f64,
    /// That along a row.
    pub along_rows: f64,
    /// Largest distance above 128 and largest below it, added.
    pub beside_mid: f64,
}

/// Whether sums read to 1/128 of a box can show in a cell of one grey.
pub fn one_grey_may_be_off(corners: &[Option<(f64, f64)>], factor: u16) -> bool {
    let per = 1.0 / f64::from(factor);
    let corners: Option<Vec<_>> = corners.iter().map(|p| p.map(|(x, y)| ((x + 0.5) * per, (y + 0.5) * per))).collect();
    let Some(corners) = corners else { return true };
    let greys = Greys { beside_mid: 128.0, ..Greys::default() };
    Outline { corners, bent: 0.0 }.allowed(&greys, corner_px(factor) * per, 1) >= 1.0
}

/// A picture that is constant in each box, and what is kept of it is.
pub struct Boxes {
    factor: usize,
    size: (usize, usize),
    greys: Vec<u8>,
}

impl Boxes {
    pub fn new(frame: (u16, u16), factor: u16, grey: impl FnMut((usize, usize)) -> u8) -> Self {
        let factor = usize::from(factor);
        let size = (usize::from(frame.0).div_ceil(factor), usize::from(frame.1).div_ceil(factor));
        let cells = (0..size.1).flat_map(|row| (0..size.0).map(move |col| (col, row)));
        Boxes { factor, size, greys: cells.map(grey).collect() }
    }

    pub fn frame(&self, (cols, rows): (u16, u16)) -> Vec<u8> {
        let at = |row: usize, col: usize| self.greys[row / self.factor * self.size.0 + col / self.factor];
        (0..usize::from(rows)).flat_map(|row| (0..usize::from(cols)).map(move |col| at(row, col))).collect()
    }

    pub fn around(&self, outline: &Outline, slack: f64) -> Greys {
        let [cols, rows] = outline.boxes(slack, self.size);
        let (mut low, mut high, mut along_rows) = (255u8, 0u8, 0.0);
        for row in rows {
            let line = &self.greys[row * self.size.0..][cols.clone()];
            let (Some(&least), Some(&most)) = (line.iter().min(), line.iter().max()) else { continue };
            (low, high) = (low.min(least), high.max(most));
            along_rows = f64::max(along_rows, f64::from(most - least));
        }
        let (low, high) = (f64::from(low), f64::from(high));
        Greys { difference: high - low, along_rows, beside_mid: f64::max(high, 128.0) - f64::min(low, 128.0) }
    }
}
