//! The core's kernels on single pictures, with the host's memory.

use heapless::Vec as FixedVec;
use plumbline_core::camera::Camera;
use plumbline_core::homography::{FrameFromPatch, Homography};
use plumbline_core::image::Run;
use plumbline_core::rectify::{Node, Source, rectify_into};
use plumbline_core::reduce::{Reducer, Reduction};
use plumbline_survey::error::InputError;
use plumbline_survey::io::picture::Picture;
use std::borrow::Cow;

/// Largest patch side.
pub const PATCH_MAX_PX: usize = 4096;
/// Runs a patch may have: four a row.
const RUNS_MAX: usize = 4 * PATCH_MAX_PX;

/// A rectified picture.
#[derive(Clone, Debug)]
pub struct Patch {
    /// Pixels, 0 where invalid.
    pub picture: Picture,
    /// Valid pixels.
    pub runs: Vec<Run>,
}

impl Patch {
    /// 255 valid, 0 not.
    pub fn mask(&self) -> Picture {
        let mut mask = Picture { pixels: vec![0; self.picture.pixels.len()], ..self.picture };
        for run in &self.runs {
            let row = run.row as usize * mask.cols;
            mask.pixels[row + run.start as usize..row + run.end as usize].fill(255);
        }
        mask
    }

    /// Share of the pixels that are valid.
    pub fn valid_fraction(&self) -> f64 {
        let valid: usize = self.runs.iter().map(|run| (run.end - run.start) as usize).sum();
        valid as f64 / self.picture.pixels.len() as f64
    }
}

/// What a frame is rectified to.
#[derive(Clone, Copy, Debug)]
pub struct Target {
    /// Height above ground, metres.
    pub height_m: f64,
    /// A patch pixel, metres.
    pub resolution_m: f64,
    /// (cols, rows); by eq. 4 when `None`.
    pub size: Option<(usize, usize)>,
}

/// Rectifies `frame` by the core: rows reduced as on board, though only as far as the resolution suggests,
/// memory being plenty here.
///
/// # Errors
/// One sentence for a frame of another size than the camera's, or a patch that is empty or too large.
pub fn rectify(camera: &Camera, frame: &Picture, homography: Homography, target: &Target) -> Result<Patch, InputError> {
    if (frame.cols, frame.rows) != (camera.cols() as usize, camera.rows() as usize) {
        return Err(InputError::new(format!(
            "the frame has {} x {} pixels, the camera {} x {}",
            frame.cols,
            frame.rows,
            camera.cols(),
            camera.rows()
        )));
    }
    let (height_m, resolution_m) = (target.height_m as f32, target.resolution_m as f32);
    let (cols, rows) = target.size.unwrap_or_else(|| {
        let (cols, rows) = camera.patch_size(height_m, resolution_m);
        (cols as usize, rows as usize)
    });
    if cols == 0 || rows == 0 {
        return Err(InputError::new(format!(
            "at {resolution_m} m a pixel the footprint of {height_m} m height is less than one pixel"
        )));
    }
    if cols > PATCH_MAX_PX || rows > PATCH_MAX_PX {
        return Err(InputError::new(format!(
            "the patch would have {cols} x {rows} pixels, at most {PATCH_MAX_PX} x {PATCH_MAX_PX} are made"
        )));
    }
    let reduced = Reduced::new(camera, frame, camera.ratio(height_m, resolution_m))?;
    reduced.rectify(homography, (height_m, resolution_m), (cols, rows))
}

/// A frame as the core keeps it, to be rectified as often as one likes.
#[derive(Clone, Debug)]
pub struct Reduced<'a> {
    camera: Camera,
    reduction: Reduction,
    /// Prefix sums of boxes, or the frame's own pixels.
    kept: Cow<'a, [u8]>,
}

impl<'a> Reduced<'a> {
    /// `frame`, of the size of `camera`, for patches a pixel of which spans `ratio` of its own.
    ///
    /// # Errors
    /// One sentence for a frame of another size or one that is too small.
    pub fn new(camera: &Camera, frame: &'a Picture, ratio: f32) -> Result<Self, InputError> {
        let size = (camera.cols(), camera.rows());
        let reduction = Reduction::choose(size, ratio, usize::MAX).map_err(|_| internal("it is too small"))?;
        let kept = if reduction.is_boxes() {
            let mut table = vec![0; reduction.bytes()];
            let taken = Reducer::new(reduction, size).take(&frame.pixels, &mut table);
            taken.map_err(|_| internal("its rows do not fit"))?;
            Cow::Owned(table)
        } else {
            Cow::Borrowed(frame.pixels.as_slice())
        };
        Source::new(&kept, reduction).map_err(|_| internal("it is too small"))?;
        Ok(Reduced { camera: *camera, reduction, kept })
    }

    /// A patch of (cols, rows), at most [`PATCH_MAX_PX`] each, of so many metres a pixel from so many metres' height.
    ///
    /// # Errors
    /// One sentence for an empty patch.
    pub fn rectify(
        &self,
        homography: Homography,
        (height_m, resolution_m): (f32, f32),
        (cols, rows): (usize, usize),
    ) -> Result<Patch, InputError> {
        let source = Source::new(&self.kept, self.reduction).map_err(|_| internal("it is too small"))?;
        let map = FrameFromPatch::new(homography, &self.camera, (height_m, resolution_m), (cols as u16, rows as u16));
        let mut pixels = vec![0; cols * rows];
        let mut runs = Box::new(FixedVec::<Run, RUNS_MAX>::new());
        let mut nodes = vec![Node::NOWHERE; 2 * (cols + 1)];
        rectify_into(&map, source, &mut pixels, &mut nodes, runs.as_mut())
            .map_err(|_| internal("its buffers do not fit"))?;
        Ok(Patch { picture: Picture { cols, rows, pixels }, runs: runs.iter().copied().collect() })
    }
}

fn internal(what: &str) -> InputError {
    InputError::new(format!("the frame cannot be rectified: {what}"))
}

/// Runs of the pixels of `mask` that are not 0.
pub fn runs_of(mask: &Picture) -> Vec<Run> {
    let mut runs = Vec::new();
    for (row, pixels) in mask.pixels.chunks_exact(mask.cols).enumerate() {
        let mut col = 0;
        while let Some(first) = pixels[col..].iter().position(|&p| p != 0).map(|skip| col + skip) {
            col = first + pixels[first..].iter().take_while(|&&p| p != 0).count();
            runs.push(Run { row: row as u16, start: first as u16, end: col as u16 });
        }
    }
    runs
}
