//! Table 2: error, time and memory of the three kernels.
//!
//! The errors are a Monte Carlo on the [`Setting`]: the root mean square distance between where a kernel puts a point
//! of the frame and where it is, over the imaged area and all trials. Once as the model gives it, and once after the
//! point has gone into the nearest cell of the 5 m output, which alone costs 5 / sqrt(6) = 2.04 m. The paper does not
//! say which of the two it measured.

use super::baselines::{Polynomial, resect};
use super::kernel::Kernel;
use super::row::{Row, same_digit};
use super::setting::{
    ATTITUDE_SIGMA_DEG, CELL_M, FOV_DEG, GROUND_SIGMA_M, HEIGHT_M, IMAGE_SIGMA_PX, PITCH_ROLL_DEG, Setting,
};
use super::{memory, timing};
use plumbline_core::camera::CameraError;
use plumbline_core::homography::Homography;
use plumbline_core::tilt::camera_from_local;
use plumbline_core::units::Radians;
use rayon::prelude::*;

const TABLE: &str = "Table 2";
/// Trials of the Monte Carlo: the automatic kernel's error is then known to 0.01 m.
pub const TRIALS: usize = 10_000;

/// A root mean square over all trials, and its standard error.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rms {
    /// Metres.
    pub value_m: f64,
    /// Of the value: from the scatter of the trials' mean squares s, sd(s) / sqrt(trials) / (2 value).
    pub standard_error_m: f64,
}

/// Error of one kernel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Errors {
    /// As the model gives it.
    pub without_cells: Rms,
    /// After the nearest cell.
    pub with_cells: Rms,
}

/// The errors of the three kernels, in the order of [`Kernel::ALL`]. Same seed, same figures, on any number of threads.
///
/// # Errors
/// None for this camera; the core's own check is passed on.
pub fn errors(seed: u64, trials: usize) -> Result<[Errors; 3], CameraError> {
    let setting = Setting::new()?;
    // A trial's mean squares: kernel, then without and with cells.
    let squares: Vec<[[f64; 2]; 3]> =
        (0..trials).into_par_iter().map(|trial| trial_squares(&setting, seed, trial as u64)).collect();
    let rms = |kernel: usize, cells: usize| {
        let count = squares.len() as f64;
        let mean = squares.iter().map(|s| s[kernel][cells]).sum::<f64>() / count;
        let variance = squares.iter().map(|s| (s[kernel][cells] - mean).powi(2)).sum::<f64>() / (count - 1.0);
        Rms { value_m: mean.sqrt(), standard_error_m: (variance / count).sqrt() / (2.0 * mean.sqrt()) }
    };
    Ok([0, 1, 2].map(|kernel| Errors { without_cells: rms(kernel, 0), with_cells: rms(kernel, 1) }))
}

/// Mean squared error of each kernel in one trial. A kernel that fails has an infinite one; with this noise none does.
fn trial_squares(setting: &Setting, seed: u64, trial: u64) -> [[f64; 2]; 3] {
    let observed = setting.observe(seed, trial);
    let (k, _) = setting.camera.tangent_per_px();
    let (k, height) = (f64::from(k), HEIGHT_M);
    let metres = |image: Option<(f32, f32)>| image.map(|(m, n)| [m, n].map(|px| f64::from(px) * k * height));
    let by_map = |map: Homography| move |[m, n]: [f64; 2]| metres(map.ideal(m as f32, n as f32));
    let automatic = Homography::inverse(&camera_from_local(observed.attitude(), Radians(0.0)), &setting.camera);
    let polynomial = Polynomial::fit(&observed.control);
    let collinearity = resect(observed.rotation(), &observed.control, height, k)
        .map(|rotation| Homography::inverse(&rotation.map(|element| element as f32), &setting.camera));
    let none = [f64::INFINITY; 2];
    [
        mean_squares(setting, by_map(automatic)),
        polynomial.map_or(none, |p| mean_squares(setting, |frame| Some(p.ground_m(frame)))),
        collinearity.map_or(none, |map| mean_squares(setting, by_map(map))),
    ]
}

/// Mean squared distance of `ground_m` from the truth over the checks, without and with cells.
fn mean_squares(setting: &Setting, ground_m: impl Fn([f64; 2]) -> Option<[f64; 2]>) -> [f64; 2] {
    let cell = |metres: f64| ((metres / CELL_M).floor() + 0.5) * CELL_M;
    let mut sums = [0.0; 2];
    for check in &setting.checks {
        let Some(found) = ground_m(check.frame_px) else { return [f64::INFINITY; 2] };
        let square = |at: [f64; 2]| (at[0] - check.ground_m[0]).powi(2) + (at[1] - check.ground_m[1]).powi(2);
        sums[0] += square(found);
        sums[1] += square(found.map(cell));
    }
    sums.map(|sum| sum / setting.checks.len() as f64)
}

/// All rows of the table.
///
/// # Errors
/// As [`errors`].
pub fn rows(seed: u64) -> Result<Vec<Row>, CameraError> {
    let errors = errors(seed, TRIALS)?;
    let mut rows = Vec::new();
    for (kernel, error) in Kernel::ALL.into_iter().zip(errors) {
        rows.push(error_row(kernel, true, error.with_cells));
    }
    for (kernel, error) in Kernel::ALL.into_iter().zip(errors) {
        rows.push(error_row(kernel, false, error.without_cells));
    }
    for kernel in Kernel::ALL {
        rows.extend(memory_rows(kernel));
    }
    for kernel in Kernel::ALL {
        rows.push(Row {
decimals: None,            table: TABLE,
            quantity: format!("time, {}, ms", kernel.name()),
            paper: Some(kernel.paper().0),
            ours: None,
            difference: Some(
                "measured on the paper's TMS320C6701; a host has no milliseconds of a board to set beside it, ratios follow".to_owned(),
            ),
        });
    }
    rows.extend(time_rows()?);
    Ok(rows)
}

fn error_row(kernel: Kernel, cells: bool, rms: Rms) -> Row {
    let (_, _, paper) = kernel.paper();
    let ours = rms.value_m;
    let [pitch_deg, roll_deg] = PITCH_ROLL_DEG;
    let off = 100.0 * (ours / paper - 1.0);
    let difference = if !cells {
        Some(format!(
            "{off:+.0} %: this row measures the model alone; the paper does not say whether its figures include the cells of \
             its {CELL_M} m output, under the same assumptions they do"
        ))
    } else if same_digit(paper, ours) {
        None
    } else {
        Some(format!(
            "{off:+.0} %: the paper states the height, the rest is assumed: V = {FOV_DEG} degrees, pitch {pitch_deg}, roll \
             {roll_deg}, attitude noise {ATTITUDE_SIGMA_DEG} degrees, control points good to {IMAGE_SIGMA_PX} px and \
             {GROUND_SIGMA_M} m"
        ))
    };
    let cells = if cells { "with 5 m cells" } else { "without cells" };
    Row {
        decimals: None,
        table: TABLE,
        quantity: format!("error, {}, {cells}, m RMS (+- {:.3})", kernel.name(), rms.standard_error_m),
        paper: Some(paper),
        ours: Some(ours),
        difference,
    }
}

fn memory_rows(kernel: Kernel) -> [Row; 2] {
    let (_, paper, _) = kernel.paper();
    let code = if kernel == Kernel::Automatic {
        "code size is in the linker map of the image (cargo xtask build prints it)"
    } else {
        "no image holds this kernel: it runs on the host only"
    };
    [
        Row {
decimals: None,            table: TABLE,
            quantity: format!("memory, {}, KB", kernel.name()),
            paper: Some(paper),
            ours: Some(memory::working_set(kernel) as f64 / 1024.0),
            difference: Some(
                "working memory only, without the frame or what is kept of it, from the sizes of the buffers and types \
                 on board; the paper counts the program too"
                    .to_owned(),
            ),
        },
        Row {
decimals: None,            table: TABLE,
            quantity: format!("code and constants, {}, KB", kernel.name()),
            paper: None,
            ours: None,
            difference: Some(code.to_owned()),
        },
    ]
}

fn time_rows() -> Result<Vec<Row>, CameraError> {
    let mut rows = Vec::new();
    let (automatic_ms, _, _) = Kernel::Automatic.paper();
    for side in [timing::CELLS_SIDE, timing::FRAME_SIDE] {
        let ratios = timing::ratios(side)?;
        for (kernel, ours) in [Kernel::Polynomial, Kernel::Collinearity].into_iter().zip(ratios) {
            rows.push(Row {
                decimals: None,
                table: TABLE,
                quantity: format!("time, {} / automatic, {side} x {side} cells", kernel.name()),
                paper: Some(kernel.paper().0 / automatic_ms),
                ours: Some(ours),
                difference: Some(
                    "median wall time on this host, one nearest-neighbour loop for all three: it changes from run to \
                     run and with the number of cells, of which the paper says nothing"
                        .to_owned(),
                ),
            });
        }
    }
    Ok(rows)
}

#[cfg(test)]
mod tests;
