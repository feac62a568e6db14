//! Figure 3: one frame from 191 m, and the three kernels' patches of 5 m cells.
//!
//! The observations carry the noise of Table 2, so each picture has the error that its row speaks of: the polynomial's is
//! seen in the outline, which stays a parallelogram; the other two differ by less than a cell.

use super::kernel::Kernel;
use super::resample::{Cells, rectify_into};
use super::setting::{CELL_M, FOV_DEG, HEIGHT_M, SIDE_PX, Setting};
use plumbline_core::camera::CameraError;
use plumbline_sim::camera::render::{RenderCamera, Renderer, Station};
use plumbline_sim::world::Ground;
use plumbline_survey::io::picture::Picture;

/// Cells a side: more than eq. 4 asks for (48), so that the outline shows almost whole.
const SIDE_CELLS: u16 = 80;
/// Screen pixels along the side of a cell.
const ENLARGED: usize = 8;
/// Nearest pixels along the side of a cell: the frame has ten.
const SAMPLES: u16 = 8;
/// Noise of the camera's pixels, grey levels of 255, as in the default scene.
const NOISE_DN: f64 = 3.0;

/// The four pictures with their names: `a` the frame, `b` automatic, `c` polynomial, `d` collinearity, these three
/// enlarged. Cells that the frame does not see are black.
///
/// # Errors
/// None for this camera; the core's own check is passed on.
pub fn pictures(ground: &Ground, seed: u64) -> Result<Vec<(char, Picture)>, CameraError> {
    let setting = Setting::new()?;
    let observed = setting.observe(seed, 0);
    let frame = frame(ground, &setting, seed);
    let cells = Cells { side: SIDE_CELLS, cell_m: CELL_M, samples: SAMPLES };
    let side = usize::from(SIDE_CELLS);
    let mut pictures = Vec::new();
    for (letter, kernel) in ['b', 'c', 'd'].into_iter().zip(Kernel::ALL) {
        let mut pixels = vec![0; side * side];
        // Six points in a grid determine both fits; were it otherwise the picture would stay black.
        let _ = rectify_into(kernel, &setting, &observed, &frame, cells, &mut pixels);
        pictures.push((letter, enlarged(&Picture { cols: side, rows: side, pixels })));
    }
    pictures.insert(0, ('a', frame));
    Ok(pictures)
}

/// What the camera sees above the middle of `ground`.
fn frame(ground: &Ground, setting: &Setting, seed: u64) -> Picture {
    let fov_rad = FOV_DEG.to_radians();
    let side = usize::from(SIDE_PX);
    let camera = RenderCamera {
        cols: side,
        rows: side,
        fov_h_rad: fov_rad,
        fov_v_rad: fov_rad,
        offset_m_px: 0.0,
        offset_n_px: 0.0,
        distortion: None,
    };
    let [east_m, north_m] = ground.bounds().centre();
    let [heading_rad, pitch_rad, roll_rad] = setting.angles_rad;
    let up_m = ground.height(east_m, north_m) + HEIGHT_M;
    let station = Station { east_m, north_m, up_m, heading_rad, pitch_rad, roll_rad, ..Station::default() };
    let rendered = Renderer::new(camera, 2).render(ground, &station, NOISE_DN, seed, 0);
    Picture { cols: side, rows: side, pixels: rendered.pixels }
}

/// Every pixel as a square.
fn enlarged(picture: &Picture) -> Picture {
    let (cols, rows) = (picture.cols * ENLARGED, picture.rows * ENLARGED);
    let pixel = |i: usize| picture.pixels[i / cols / ENLARGED * picture.cols + i % cols / ENLARGED];
    Picture { cols, rows, pixels: (0..cols * rows).map(pixel).collect() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pixel_becomes_a_square() {
        let large = enlarged(&Picture { cols: 2, rows: 2, pixels: vec![1, 2, 3, 4] });
        assert_eq!((large.cols, large.rows), (2 * ENLARGED, 2 * ENLARGED));
        let at = |col: usize, row: usize| large.pixels[row * large.cols + col];
        assert_eq!(
            [at(0, 0), at(ENLARGED, 0), at(ENLARGED - 1, ENLARGED), at(2 * ENLARGED - 1, 2 * ENLARGED - 1)],
            [1, 2, 3, 4]
        );
    }
}
