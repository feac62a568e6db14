//! The virtual image of a camera of several heads: one frame a head, each rectified onto it by the core (paper 002).
//!
//! The image is made piece by piece, each with a homography of its own (see [`Rig::homography`]): what the rectifier limits
//! is a piece and a frame (8192 pixels a side), not the image (65,535 a side, one byte a pixel and band in memory). Where
//! two heads or more see a pixel, either their greys are blended, by weights that fall to zero at each frame's border, or
//! the head whose axis is nearest to the ray has it alone.

mod mismatch;
mod simulated;

pub use mismatch::{Mismatch, SEARCH_PX, against, mismatches, pairs};
pub use simulated::{Simulated, simulate};

use crate::camera::heads::{Rig, Tile};
use crate::camera::still::{Patch, Reduced};
use plumbline_survey::error::InputError;
use plumbline_survey::io::picture::{Bands, Picture};
use rayon::prelude::*;

/// Side of a piece, pixels.
const TILE_PX: usize = 512;

/// What is done where several heads see a pixel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Seam {
    /// Their greys blended, weighed by the distance from each frame's border.
    Feather,
    /// The grey of the head whose axis is nearest to the ray: seams are where two axes are equally near.
    Hard,
}

/// A virtual image.
#[derive(Clone, Debug, PartialEq)]
pub struct Mosaic {
    /// Columns and rows.
    pub size: (usize, usize),
    /// 1, or 3 for colours.
    pub bands: usize,
    /// Interleaved by pixel; 0 where no head sees anything.
    pub samples: Vec<u8>,
    /// Share of the pixels that a head sees.
    pub coverage: f64,
}

/// How many pieces the virtual image is made of.
#[must_use]
pub fn pieces(rig: &Rig) -> usize {
    rig.size.0.div_ceil(TILE_PX) * rig.size.1.div_ceil(TILE_PX)
}

/// Stitches `frames`, one a head in the rig's order, all of one or all of three bands. `progress` is called after each
/// piece, from any thread.
///
/// # Errors
/// One sentence for a number or a size of frames that is not the rig's, for grey and colour together.
pub fn stitch(rig: &Rig, frames: &[Bands], seam: Seam, progress: &(dyn Fn() + Sync)) -> Result<Mosaic, InputError> {
    check(rig, frames)?;
    let bands = frames[0].0.len();
    let reduced = frames.iter().enumerate().map(|(head, frame)| reduce(rig, head, &frame.0));
    let reduced = reduced.collect::<Result<Vec<_>, _>>()?;
    let (cols, rows) = rig.size;
    let mut samples = vec![0; cols * rows * bands];
    let strip = |(index, out): (usize, &mut [u8])| {
        let mut seen = 0;
        for left in (0..cols).step_by(TILE_PX) {
            let corner = (left, index * TILE_PX);
            let tile = Tile { corner, size: (TILE_PX.min(cols - left), out.len() / (cols * bands)) };
            seen += Piece::new(rig, &reduced, tile)?.blend(seam, bands, out);
            progress();
        }
        Ok(seen)
    };
    let strips = samples.par_chunks_mut(TILE_PX * cols * bands).enumerate().map(strip);
    let seen = strips.collect::<Result<Vec<usize>, InputError>>()?;
    let coverage = seen.iter().sum::<usize>() as f64 / (cols * rows) as f64;
    Ok(Mosaic { size: rig.size, bands, samples, coverage })
}

fn check(rig: &Rig, frames: &[Bands]) -> Result<(), InputError> {
    if frames.len() != rig.views.len() {
        let (heads, frames) = (rig.views.len(), frames.len());
        return Err(InputError::new(format!("there are {frames} frames for {heads} heads")));
    }
    for (index, (view, frame)) in rig.views.iter().zip(frames).enumerate() {
        let (wanted, is) = ((view.camera.cols(), view.camera.rows()), frame.size());
        if (usize::from(wanted.0), usize::from(wanted.1)) != is {
            return Err(InputError::new(format!(
                "frame {} has {} x {} pixels, head {} has {} x {}",
                index + 1,
                is.0,
                is.1,
                index + 1,
                wanted.0,
                wanted.1
            )));
        }
        if frame.0.len() != frames[0].0.len() {
            return Err(InputError::new(format!(
                "frame 1 and frame {} are not both grey or both in colour",
                index + 1
            )));
        }
    }
    Ok(())
}

/// The bands of one head's frame, made ready.
fn reduce<'a>(rig: &Rig, head: usize, bands: &'a [Picture]) -> Result<Vec<Reduced<'a>>, InputError> {
    let named = |error: InputError| InputError::new(format!("head {}: {error}", head + 1));
    bands.iter().map(|band| Reduced::new(&rig.views[head].camera, band, rig.ratio(head)).map_err(named)).collect()
}

/// What one head shows of a piece of the virtual image.
fn rectified(rig: &Rig, head: usize, reduced: &Reduced<'_>, tile: &Tile) -> Result<Patch, InputError> {
    let (homography, scale) = rig.homography(head, tile);
    reduced.rectify(homography, scale, tile.size)
}

/// A piece of the virtual image, as each head shows it.
struct Piece<'r> {
    rig: &'r Rig,
    tile: Tile,
    /// Bands of each head.
    patches: Vec<Vec<Patch>>,
}

impl<'r> Piece<'r> {
    fn new(rig: &'r Rig, reduced: &[Vec<Reduced<'_>>], tile: Tile) -> Result<Self, InputError> {
        let of_head = |(head, bands): (usize, &Vec<Reduced<'_>>)| {
            bands.iter().map(|band| rectified(rig, head, band, &tile)).collect::<Result<Vec<_>, _>>()
        };
        let patches = reduced.iter().enumerate().map(of_head).collect::<Result<_, _>>()?;
        Ok(Piece { rig, tile, patches })
    }

    /// Fills its place in the strip of rows `out`; how many of its pixels are seen.
    fn blend(&self, seam: Seam, bands: usize, out: &mut [u8]) -> usize {
        let (cols, rows) = self.tile.size;
        let mut seen = 0;
        let mut weights = vec![vec![0.0; cols]; self.patches.len()];
        for row in 0..rows {
            for (head, weights) in weights.iter_mut().enumerate() {
                self.sees(head, row, weights);
            }
            let line = &mut out[(row * self.rig.size.0 + self.tile.corner.0) * bands..][..cols * bands];
            for (col, pixel) in line.chunks_exact_mut(bands).enumerate() {
                let seeing: usize = weights.iter().filter(|weights| weights[col] > 0.0).count();
                if seeing > 1 {
                    self.weigh(seam, (col, row), &mut weights);
                }
                seen += usize::from(seeing > 0);
                let sum: f64 = weights.iter().map(|weights| weights[col]).sum();
                for (band, sample) in pixel.iter_mut().enumerate().filter(|_| sum > 0.0) {
                    let grey = |head: usize| f64::from(self.patches[head][band].picture.pixels[row * cols + col]);
                    let greys = weights.iter().enumerate().map(|(head, weights)| weights[col] * grey(head));
                    *sample = (greys.sum::<f64>() / sum).round() as u8;
                }
            }
        }
        seen
    }

    /// 1 where head `head` sees a pixel of the row `row`, 0 where it does not.
    fn sees(&self, head: usize, row: usize, weights: &mut [f64]) {
        weights.fill(0.0);
        let runs = &self.patches[head][0].runs;
        let first = runs.partition_point(|run| usize::from(run.row) < row);
        for run in runs[first..].iter().take_while(|run| usize::from(run.row) == row) {
            weights[usize::from(run.start)..usize::from(run.end)].fill(1.0);
        }
    }

    /// Weights of a pixel that several heads see.
    fn weigh(&self, seam: Seam, (col, row): (usize, usize), weights: &mut [Vec<f64>]) {
        let at = ((self.tile.corner.0 + col) as f64, (self.tile.corner.1 + row) as f64);
        let seeing = weights.iter_mut().enumerate().map(|(head, weights)| (head, &mut weights[col]));
        let seeing = seeing.filter(|(_, weight)| **weight > 0.0);
        match seam {
            // Both at their very borders: as much of each, and never none at all.
            Seam::Feather => seeing.for_each(|(head, weight)| {
                *weight = self.rig.inside_px(head, at.0, at.1).max(1e-6);
            }),
            Seam::Hard => {
                let mut best: Option<(f64, &mut f64)> = None;
                for (head, weight) in seeing {
                    let nearness = self.rig.nearness(head, at.0, at.1);
                    *weight = 0.0;
                    if best.as_ref().is_none_or(|(most, _)| nearness > *most) {
                        best = Some((nearness, weight));
                    }
                }
                if let Some((_, weight)) = best {
                    *weight = 1.0;
                }
            }
        }
    }
}
