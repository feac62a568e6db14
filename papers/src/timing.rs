//! Wall time of the three kernels on this host, as ratios to the automatic one.
//!
//! Each kernel starts from what it is given (angles, or control points) and ends with a full patch. The three take turns
//! in every round, so that a busy machine slows all of them, and the median of the rounds stands. No milliseconds: this is
//! not the board.

use super::SEED;
use super::kernel::Kernel;
use super::resample::{Cells, rectify_into};
use super::setting::{CELL_M, FOV_DEG, HEIGHT_M, SIDE_PX, Setting};
use plumbline_core::camera::CameraError;
use plumbline_survey::io::picture::Picture;
use std::hint::black_box;
use std::time::Instant;

/// Cells along the side of the 5 m patch by eq. 4.
pub const CELLS_SIDE: u16 = 48;
/// Cells along the side of a patch as fine as the frame.
pub const FRAME_SIDE: u16 = SIDE_PX;
/// Cells that all rounds together fill, about: enough for a steady median at either size.
const CELLS_TOTAL: usize = 12_000_000;

/// (polynomial / automatic, collinearity / automatic) for a patch of `side` x `side` cells over the same footprint.
///
/// # Errors
/// None for this camera; the core's own check is passed on.
pub fn ratios(side: u16) -> Result<[f64; 2], CameraError> {
    let setting = Setting::new()?;
    let observed = setting.observe(SEED, 0);
    let frame = texture();
    let footprint_m = 2.0 * HEIGHT_M * (0.5 * FOV_DEG).to_radians().tan();
    let cell_m = if side == CELLS_SIDE { CELL_M } else { footprint_m / f64::from(side) };
    let cells = Cells { side, cell_m, samples: 1 };
    let area = usize::from(side) * usize::from(side);
    let mut patch = vec![0; area];
    let mut times: [Vec<f64>; 3] = Default::default();
    for _ in 0..(CELLS_TOTAL / area.max(1)).max(3) {
        for (kernel, times) in Kernel::ALL.into_iter().zip(&mut times) {
            let start = Instant::now();
            let done = rectify_into(kernel, &setting, black_box(&observed), &frame, cells, &mut patch);
            black_box((done, &patch));
            times.push(start.elapsed().as_secs_f64());
        }
    }
    let [automatic, polynomial, collinearity] = times.map(median);
    Ok([polynomial / automatic, collinearity / automatic])
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(f64::NAN)
}

/// Any frame does: times do not depend on grey values.
fn texture() -> Picture {
    let side = usize::from(SIDE_PX);
    let pixels = (0..side * side).map(|i| (i / side * 31 + i % side * 17) as u8).collect();
    Picture { cols: side, rows: side, pixels }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_patch_has_the_size_of_eq_4() {
        let setting = Setting::new().unwrap();
        let (cols, rows) = setting.camera.patch_size(HEIGHT_M as f32, CELL_M as f32);
        assert_eq!((cols as u16, rows as u16), (CELLS_SIDE, CELLS_SIDE));
    }

    #[test]
    fn the_median_is_the_middle() {
        assert_eq!(median(vec![5.0, 1.0, 3.0]), 3.0);
    }
}
