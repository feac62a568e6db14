//! One plain resampler for all three kernels: the mean of nearest pixels over each cell.
//!
//! It is not what flies (that is the core's rectifier, with rows reduced on arrival); it treats the three alike, so
//! that times and pictures differ by the kernel alone.

use super::baselines::{Polynomial, resect};
use super::kernel::Kernel;
use super::setting::{HEIGHT_M, Observed, Setting};
use plumbline_core::frames;
use plumbline_core::homography::{FrameFromPatch, Homography};
use plumbline_core::tilt::{equivalent_tilt, follow_up_command};
use plumbline_survey::io::picture::Picture;

/// A patch to be filled: centred on the nadir, north-up.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cells {
    /// Columns and rows.
    pub side: u16,
    /// Metres a cell.
    pub cell_m: f64,
    /// Nearest pixels taken along each side of a cell.
    pub samples: u16,
}

/// Fills `patch` (`side` x `side`, row-major) from `frame`; a cell of which the frame does not see every sample is 0.
/// `None` when the control points determine nothing.
pub fn rectify_into(
    kernel: Kernel,
    setting: &Setting,
    observed: &Observed,
    frame: &Picture,
    cells: Cells,
    patch: &mut [u8],
) -> Option<()> {
    let camera = &setting.camera;
    let scale = (HEIGHT_M as f32, cells.cell_m as f32);
    let size = (cells.side, cells.side);
    let (k, _) = camera.tangent_per_px();
    match kernel {
        Kernel::Automatic => {
            let attitude = observed.attitude();
            let tilt = equivalent_tilt(attitude, follow_up_command(attitude));
            let map = FrameFromPatch::new(Homography::simplified(tilt, camera), camera, scale, size);
            fill(frame, cells, patch, |col, row| map.frame_position(col, row));
        }
        Kernel::Collinearity => {
            let rotation = resect(observed.rotation(), &observed.control, HEIGHT_M, f64::from(k))?;
            let map = Homography::full(&rotation.map(|element| element as f32), camera);
            let map = FrameFromPatch::new(map, camera, scale, size);
            fill(frame, cells, patch, |col, row| map.frame_position(col, row));
        }
        Kernel::Polynomial => {
            let [m, n] = Polynomial::fit(&observed.control)?.inverse()?.map(|c| c.map(|c| c as f32));
            fill(frame, cells, patch, |col, row| {
                let (east, north) = frames::centred(col, row, cells.side, cells.side);
                let (east, north) = (east * scale.1, north * scale.1);
                let of = |c: [f32; 3]| c[0] + c[1] * east + c[2] * north;
                Some(frames::pixel(of(m), of(n), camera.cols(), camera.rows()))
            });
        }
    }
    Some(())
}

/// The frame's (col, row) at each sample of each cell by `position`.
fn fill(frame: &Picture, cells: Cells, patch: &mut [u8], position: impl Fn(f32, f32) -> Option<(f32, f32)>) {
    let samples = cells.samples.max(1);
    let offset = |sample: u16| (f32::from(sample) + 0.5) / f32::from(samples) - 0.5;
    let (last_col, last_row) = (frame.cols as f32 - 0.5, frame.rows as f32 - 0.5);
    let nearest = |col: f32, row: f32| {
        let (col, row) = position(col, row)?;
        let inside = col >= -0.5 && row >= -0.5 && col < last_col && row < last_row;
        // Truncation of a non-negative number is its floor.
        let index = || (row + 0.5) as usize * frame.cols + (col + 0.5) as usize;
        if inside { frame.pixels.get(index()).copied() } else { None }
    };
    let cell = |col: usize, row: usize| {
        let mut sum = 0u32;
        for sub_row in 0..samples {
            for sub_col in 0..samples {
                sum += u32::from(nearest(col as f32 + offset(sub_col), row as f32 + offset(sub_row))?);
            }
        }
        Some((sum / (u32::from(samples) * u32::from(samples))) as u8)
    };
    let cols = usize::from(cells.side);
    for (row, line) in patch.chunks_exact_mut(cols.max(1)).take(cols).enumerate() {
        for (col, pixel) in line.iter_mut().enumerate() {
            *pixel = cell(col, row).unwrap_or(0);
        }
    }
}

#[cfg(test)]
mod tests;
