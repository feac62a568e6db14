//! How the camera sits in the vehicle, and how well its heads are known.
//!
//! ```toml
//! [boresight]                          # vehicle from camera, phi omega kappa as a head's
//! phi_deg = 0.1
//! omega_deg = -0.05
//! kappa_deg = 0.3
//!
//! [lever_arms]
//! antenna_to_camera_m = [0.0, 0.5, -1.0]   # right, forward, up along the vehicle's axes
//!
//! [covariance]                         # of phi, omega, kappa of heads 2, 3 and so on; head 1 is held fixed
//! head_sd_arcsec = [0.7, 0.9, 1.4]
//! head_arcsec2 = [[0.49, 0.0, 0.0], [0.0, 0.81, 0.0], [0.0, 0.0, 1.96]]
//! ```

use crate::error::InputError;

use super::keys::Keys;

/// Standard deviations and covariance of the heads' angles, of [φ, ω, κ] of head 2, then of head 3 and so on: 3 (h − 1)
/// values for h heads, since head 1 is what the others are measured against.
#[derive(Debug, Clone, PartialEq)]
pub struct Covariance {
    /// Standard deviations, arc seconds: the roots of the diagonal below.
    pub head_sd_arcsec: Vec<f64>,
    /// The full matrix, square arc seconds, row by row.
    pub head_arcsec2: Vec<Vec<f64>>,
}

impl Covariance {
    /// A covariance matrix with its standard deviations.
    #[must_use]
    pub fn new(head_arcsec2: Vec<Vec<f64>>) -> Self {
        let head_sd_arcsec = head_arcsec2.iter().enumerate().map(|(i, row)| row[i].sqrt()).collect();
        Covariance { head_sd_arcsec, head_arcsec2 }
    }

    pub(super) fn text(&self) -> String {
        let rows: Vec<_> = self.head_arcsec2.iter().map(|row| format!("    {row:?},\n")).collect();
        let (sds, rows) = (&self.head_sd_arcsec, rows.concat());
        format!("\n[covariance]\nhead_sd_arcsec = {sds:?}\nhead_arcsec2 = [\n{rows}]\n")
    }
}

/// Relative difference of numbers that should be equal but were computed in two ways.
const EQUAL: f64 = 1e-9;
/// Relative tolerance for numbers typed by hand.
const TYPED: f64 = 1e-2;
/// Largest angle of a boresight, degrees: what leans more is a head.
pub const BORESIGHT_MAX_DEG: f64 = 10.0;
/// Largest lever arm, metres.
pub const ARM_MAX_M: f64 = 100.0;

/// φ, ω, κ of the vehicle from the camera, degrees.
pub(super) fn boresight(file: &Keys<'_>) -> Result<Option<[f64; 3]>, InputError> {
    const KEYS: [&str; 3] = ["phi_deg", "omega_deg", "kappa_deg"];
    let Some(keys) = file.inner("boresight")? else { return Ok(None) };
    keys.only(&KEYS)?;
    let mut angles = [0.0; 3];
    for (angle, key) in angles.iter_mut().zip(KEYS) {
        *angle = keys.needed_number(key)?;
        if angle.abs() > BORESIGHT_MAX_DEG {
            return Err(keys.wrong(key, &format!("within {BORESIGHT_MAX_DEG} degrees")));
        }
    }
    Ok(Some(angles))
}

/// From the antenna to the camera: right, forward, up along the vehicle's axes, metres.
pub(super) fn lever_arms(file: &Keys<'_>) -> Result<Option<[f64; 3]>, InputError> {
    const KEY: &str = "antenna_to_camera_m";
    let Some(keys) = file.inner("lever_arms")? else { return Ok(None) };
    keys.only(&[KEY])?;
    let arm = keys.needed(KEY, keys.triple(KEY)?)?;
    if arm.iter().any(|length| length.abs() > ARM_MAX_M) {
        return Err(keys.wrong(KEY, &format!("within {ARM_MAX_M} m")));
    }
    Ok(Some(arm))
}

/// The covariance of so many heads' angles.
pub(super) fn covariance(file: &Keys<'_>, heads: usize) -> Result<Option<Covariance>, InputError> {
    const KEYS: [&str; 2] = ["head_sd_arcsec", "head_arcsec2"];
    let Some(keys) = file.inner("covariance")? else { return Ok(None) };
    keys.only(&KEYS)?;
    if heads < 2 {
        return Err(file.wrong("covariance", "that of two heads or more, which are not in the file"));
    }
    let count = 3 * (heads - 1);
    let sds = keys.needed(KEYS[0], keys.numbers(KEYS[0], count)?)?;
    let matrix = keys.needed(KEYS[1], keys.square(KEYS[1], count)?)?;
    if sds.iter().any(|sd| *sd < 0.0) {
        return Err(keys.wrong(KEYS[0], "at least 0"));
    }
    let is_near = |a: f64, b: f64, size: f64, tolerance: f64| (a - b).abs() <= tolerance * size;
    for (i, row) in matrix.iter().enumerate() {
        if !(row[i] >= 0.0 && is_near(row[i].sqrt(), sds[i], sds[i], TYPED)) {
            let what = format!("the squares of {} on its diagonal", KEYS[0]);
            return Err(keys.wrong(KEYS[1], &what));
        }
        for (j, &entry) in row.iter().enumerate() {
            let most = (row[i] * matrix[j][j]).sqrt();
            if !(is_near(entry, matrix[j][i], most, EQUAL) && entry.abs() <= most * (1.0 + EQUAL)) {
                return Err(keys.wrong(KEYS[1], "symmetric, with correlations within -1 and 1"));
            }
        }
    }
    Ok(Some(Covariance { head_sd_arcsec: sds, head_arcsec2: matrix }))
}
