//! Every call of the core's kernels: what flies, and the other ways to use them.

use super::view::View;
use super::{Failure, Grey};
use heapless::Vec as Runs;
use plumbline_core::budget::{FRAME_MEMORY_BYTES, PATCH_MAX_PX};
use plumbline_core::image::Run;
use plumbline_core::rectify::{Node, Source, rectify_into};
use plumbline_core::reduce::{ReduceError, Reducer, Reduction};

/// A way to use them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Way {
    /// As on board: reduced to fit its memory.
    OnBoard,
    /// Area averages over boxes of so many pixels a side, whatever memory they take.
    Boxes(u16),
    /// The frame as it is, one reading a cell.
    OneReading,
}

/// Boxes that a cell may span at nadir, so that tilt does not bring it to 256, which are too many for its integrals.
const BOXES_A_CELL: f32 = 128.0;

impl Way {
    /// All of them.
    pub const ALL: [Way; 5] = [Way::OnBoard, Way::Boxes(2), Way::Boxes(1), Way::Boxes(8), Way::OneReading];

    /// In the table.
    pub fn name(self) -> String {
        match self {
            Way::OnBoard => "core, as on board".into(),
            Way::Boxes(1) => "core, frame not reduced".into(),
            Way::Boxes(factor) => format!("core, boxes of {factor} x {factor}"),
            Way::OneReading => "core, one reading a cell".into(),
        }
    }

    /// Its case in the table of exact counts: 512 x 512 to 64 x 64.
    pub fn workload(self) -> String {
        match self {
            Way::OnBoard => "rectify 512x512 to 64x64".into(),
            Way::Boxes(factor) => format!("boxes of {factor}x{factor}, 512x512 to 64x64"),
            Way::OneReading => "one reading, 512x512 to 64x64".into(),
        }
    }

    /// Whether the view can be rectified this way: on board, patch and memory have their largest sizes; a cell spans a box
    /// at least, and not too many.
    pub fn suits(self, view: &View) -> bool {
        let (cols, rows) = view.ground().cells;
        let is_kept = self.reduction(view).is_ok();
        match self {
            Way::OnBoard => is_kept && usize::from(cols.max(rows)) <= PATCH_MAX_PX,
            Way::Boxes(factor) => {
                let boxes = view.ratio() / f32::from(factor);
                is_kept && boxes > 0.99 && boxes * boxes <= BOXES_A_CELL
            }
            Way::OneReading => true,
        }
    }

    /// What is kept of the frame.
    ///
    /// # Errors
    /// What the core refuses.
    pub fn reduction(self, view: &View) -> Result<Reduction, ReduceError> {
        match self {
            Way::OnBoard => Reduction::choose(view.frame_size(), view.ratio(), FRAME_MEMORY_BYTES),
            // The core's own choice for cells of three boxes and enough memory.
            Way::Boxes(factor) => Reduction::choose(view.frame_size(), 3.0 * f32::from(factor), usize::MAX),
            Way::OneReading => Ok(Reduction::none(view.frame_size())),
        }
    }
}

/// Room for everything, made before the time is taken.
#[derive(Debug)]
pub struct Kernel<'a> {
    way: Way,
    view: &'a View,
    kept: Vec<u8>,
    patch: Vec<u8>,
    nodes: Vec<Node>,
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
        let cells = view.ground().cells;
        let bytes = way.reduction(view).map_or(0, |reduction| reduction.bytes());
        Kernel {
            way,
            view,
            kept: vec![0; bytes],
            patch: vec![0; usize::from(cells.0) * usize::from(cells.1)],
            nodes: vec![Node::NOWHERE; 2 * (usize::from(cells.0) + 1)],
            runs: Runs::new(),
        }
    }

    /// From a frame's first row to its patch.
    ///
    /// # Errors
    /// What the core refuses.
    pub fn rectify(&mut self, frame: &Grey) -> Result<(), Failure> {
        let refused = |why: &dyn std::fmt::Debug| format!("{}: refused, {why:?}", self.way.name());
        let reduction = self.way.reduction(self.view).map_err(|why| refused(&why))?;
        let kept = if reduction.is_boxes() || self.way == Way::OnBoard {
            let mut reducer = Reducer::new(reduction, self.view.frame_size());
            reducer.take(&frame.pixels, &mut self.kept).map_err(|why| refused(&why))?;
            &self.kept
        } else {
            // The frame is at hand: the rectifier reads it itself.
            &frame.pixels
        };
        let source = Source::new(kept, reduction).map_err(|why| refused(&why))?;
        let map = self.view.map();
        rectify_into(&map, source, &mut self.patch, &mut self.nodes, &mut self.runs).map_err(|why| refused(&why))
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
