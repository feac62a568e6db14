//! Every call of the core's kernels: what flies, and the other ways to use them.

use super::view::View;
use super::{Failure, Grey};
use heapless::Vec as Runs;
use plumbline_core::budget::{PATCH_MAX_PX, REDUCED_MAX_AREA};
use plumbline_core::rectify::{Run, Sampling, Source, rectify_into};
use plumbline_core::reduce::{ReduceError, Reducer, Reduction};

/// A way to use them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Way {
    /// As on board: reduced to fit its memory.
    OnBoard,
    /// As the core would reduce with plenty of memory.
    Plenty,
    /// The frame as it is, a reading a pixel.
    Whole,
    /// The frame as it is, one reading a cell.
    OneReading,
}

impl Way {
    /// All of them.
    pub const ALL: [Way; 4] = [Way::OnBoard, Way::Plenty, Way::Whole, Way::OneReading];

    /// In the table.
    pub fn name(self) -> &'static str {
        match self {
            Way::OnBoard => "core, as on board",
            Way::Plenty => "core, memory of a host",
            Way::Whole => "core, frame not reduced",
            Way::OneReading => "core, one reading a cell",
        }
    }

    /// Whether the view can be rectified this way: on board, patch and reduced frame have their largest sizes.
    pub fn suits(self, view: &View) -> bool {
        let (cols, rows) = view.ground().cells;
        let fits = usize::from(cols.max(rows)) <= PATCH_MAX_PX;
        fits && self.reduction(view).is_ok() || self != Way::OnBoard
    }

    fn reduction(self, view: &View) -> Result<Reduction, ReduceError> {
        let (wished, capacity) = match self {
            Way::OnBoard => (view.ratio(), REDUCED_MAX_AREA),
            Way::Plenty => (view.ratio(), usize::MAX),
            Way::Whole | Way::OneReading => (1.0, usize::MAX),
        };
        Reduction::choose(view.frame_size(), wished, capacity)
    }
}

/// Room for everything, made before the time is taken.
#[derive(Debug)]
pub struct Kernel<'a> {
    way: Way,
    view: &'a View,
    reduced: Vec<u8>,
    row_sums: Vec<u16>,
    patch: Vec<u8>,
    cell_sums: Vec<u32>,
    runs: Runs<Run, RUNS_MAX>,
}

/// Runs of the largest patch: a few a row.
const RUNS_MAX: usize = 4096;

/// What was made of a frame.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Patch {
    /// Pixels.
    pub pixels: Vec<u8>,
    /// Which of them count.
    pub is_valid: Vec<bool>,
}

impl<'a> Kernel<'a> {
    /// For one view.
    pub fn new(way: Way, view: &'a View) -> Self {
        let (frame, cells) = (view.frame_size(), view.ground().cells);
        let area = |(cols, rows): (u16, u16)| usize::from(cols) * usize::from(rows);
        Kernel {
            way,
            view,
            reduced: vec![0; area(frame)],
            row_sums: vec![0; frame.0.into()],
            patch: vec![0; area(cells)],
            cell_sums: vec![0; cells.0.into()],
            runs: Runs::new(),
        }
    }

    /// From a frame's first row to its patch.
    ///
    /// # Errors
    /// What the core refuses.
    pub fn rectify(&mut self, frame: &Grey) -> Result<(), Failure> {
        let size = self.view.frame_size();
        let ratio = self.view.ratio();
        let refused = |why: &dyn std::fmt::Debug| format!("{}: refused, {why:?}", self.way.name());
        let reduction = self.way.reduction(self.view).map_err(|why| refused(&why))?;
        let mut reducer = Reducer::new(reduction, size);
        let pixels = if reduction.factor() == 1 && self.way != Way::OnBoard {
            // Nothing to average, and the frame is at hand: the rectifier reads it itself.
            frame.pixels.as_slice()
        } else {
            for row in frame.pixels.chunks_exact(size.0.into()) {
                reducer.take(row, &mut self.row_sums, &mut self.reduced).map_err(|why| refused(&why))?;
            }
            &self.reduced[..usize::from(reduction.size().0) * usize::from(reduction.size().1)]
        };
        let source = Source::new(pixels, reduction).map_err(|why| refused(&why))?;
        let sampling = match self.way {
            Way::OneReading => Sampling { samples: 1 },
            _ => Sampling::choose(ratio, &reduction),
        };
        let map = self.view.map();
        rectify_into(&map, source, sampling, &mut self.patch, &mut self.cell_sums, &mut self.runs)
            .map_err(|why| refused(&why))
    }

    /// The last frame's patch.
    pub fn patch(&self) -> Patch {
        let mut is_valid = vec![false; self.patch.len()];
        for run in &self.runs {
            let first = usize::from(run.row) * usize::from(self.view.ground().cells.0);
            is_valid[first + usize::from(run.start)..first + usize::from(run.end)].fill(true);
        }
        Patch { pixels: self.patch.clone(), is_valid }
    }
}
