//! With exact observations the two perspective kernels are one, and agree with the oracle's remap.

use super::*;
use crate::baselines::ControlPoint;
use crate::setting::oracle_camera;
use plumbline_sim::oracle::{Grid, Image, Kernel as OracleKernel, matrix_a, remap};

const SIDE: u16 = 48;
const CELLS: Cells = Cells { side: SIDE, cell_m: 5.0, samples: 1 };

fn exact() -> (Setting, Observed, Picture) {
    let setting = Setting::new().unwrap();
    let observed = Observed { angles_rad: setting.angles_rad, control: setting.control };
    let pixels = (0..512 * 512).map(|i| (i / 512 * 31 + i % 512 * 17) as u8).collect();
    (setting, observed, Picture { cols: 512, rows: 512, pixels })
}

fn patch_of(kernel: Kernel) -> Vec<u8> {
    let (setting, observed, frame) = exact();
    let mut patch = vec![0; 48 * 48];
    rectify_into(kernel, &setting, &observed, &frame, CELLS, &mut patch).unwrap();
    patch
}

#[test]
fn automatic_and_collinearity_meet_the_oracle() {
    let (setting, _, frame) = exact();
    let [heading, pitch, roll] = setting.angles_rad;
    let image = Image::new(512, 512, frame.pixels.iter().map(|&p| f64::from(p)).collect()).unwrap();
    let grid = Grid { cols: 48, rows: 48, resolution_m: 5.0, height_m: 191.0 };
    let a = matrix_a(heading, pitch, roll, 0.0);
    let expected = remap(&image, &a, &oracle_camera(), &grid, OracleKernel::Nearest);
    for kernel in [Kernel::Automatic, Kernel::Collinearity] {
        let patch = patch_of(kernel);
        let compared: Vec<bool> = expected
            .iter()
            .zip(&patch)
            .filter_map(|(expected, &got)| expected.map(|value| value == f64::from(got)))
            .collect();
        let same = compared.iter().filter(|&&same| same).count();
        // Single precision decides differently where a position lies within 1e-4 px of a pixel's border: in about
        // 4e-4 of the 1600 cells.
        assert!(compared.len() > 1500 && same + 4 >= compared.len(), "{kernel:?}: {same} of {}", compared.len());
    }
}

#[test]
fn without_tilt_the_polynomial_is_exact_and_with_it_it_is_not() {
    let (setting, _, frame) = exact();
    let (k, _) = setting.camera.tangent_per_px();
    let level = |point: ControlPoint| ControlPoint {
        frame_px: point.ground_m.map(|metres| metres / (HEIGHT_M * f64::from(k))),
        ..point
    };
    let observed = Observed { angles_rad: [0.0; 3], control: setting.control.map(level) };
    let patch_of_level = |kernel| {
        let mut patch = vec![0; 48 * 48];
        rectify_into(kernel, &setting, &observed, &frame, CELLS, &mut patch).unwrap();
        patch
    };
    let differing = |a: &[u8], b: &[u8]| a.iter().zip(b).filter(|(a, b)| a != b).count();
    // Rounding decides at pixels' borders, as above.
    let level = differing(&patch_of_level(Kernel::Automatic), &patch_of_level(Kernel::Polynomial));
    assert!(level <= 4, "{level}");
    let tilted = differing(&patch_of(Kernel::Automatic), &patch_of(Kernel::Polynomial));
    assert!(tilted > 1000, "{tilted}");
}
