//! The heads of a combined camera: several cameras on one platform, whose pictures make one virtual image (paper 002).
//!
//! ```toml
//! [[heads]]
//! cols = 7228
//! rows = 5428
//! f_px = 6911.764705882353             # focal length
//! offset_m_px = 0.0                    # principal point, as the file's own; 0 unless given
//! offset_n_px = 0.0
//! rotation_deg = [-22.0, 18.0, 0.0]    # phi, omega, kappa
//! d_m = [-0.045, 0.06, 0.0]            # its projection centre: right, forward, up of the virtual one
//! [heads.distortion]                   # as the file's own, with x = m / f_px
//! k1 = -0.01
//! ```
//!
//! With heads the six keys describe the *virtual* camera, whose axes are the platform's: x to the right, y forward, z up,
//! and an image point is the vector (x, y, −f). A head's rotation takes its own image vectors into the platform's axes:
//! R = Rφ Rω Rκ, with Rφ = [[c, 0, −s], [0, 1, 0], [s, 0, c]], Rω = [[1, 0, 0], [0, c, −s], [0, s, c]] and
//! Rκ = [[c, −s, 0], [s, c, 0], [0, 0, 1]] (paper 000, eq. 1, its misprint put right; paper 002, section 3.2).

use crate::error::InputError;

use super::keys::Keys;
use super::{CameraFile, Distortion, SIDE_MAX_PX, lens};
use toml::Value;

/// Most columns and most rows of a virtual image, which no frame memory has to hold.
pub const VIRTUAL_SIDE_MAX_PX: u32 = 65_535;
/// Most heads of a file.
pub const HEADS_MAX: usize = 64;
/// Farthest projection centre of a head from the virtual one along an axis, metres: beyond it the heads are no camera.
const ARM_MAX_M: f64 = 100.0;
const KEYS: [&str; 8] = ["cols", "rows", "f_px", "offset_m_px", "offset_n_px", "rotation_deg", "d_m", "distortion"];

/// A head, checked. Angles in degrees, as in the file.
#[derive(Debug, Clone, PartialEq)]
pub struct Head {
    /// Columns of its frame, 1 to [`SIDE_MAX_PX`].
    pub cols: u32,
    /// Rows of its frame, 1 to [`SIDE_MAX_PX`].
    pub rows: u32,
    /// Focal length, pixels, more than 0.
    pub f_px: f64,
    /// Added to a frame point to the right, pixels.
    pub offset_m_px: f64,
    /// Added to a frame point forward, pixels.
    pub offset_n_px: f64,
    /// Lens distortion; absent is none.
    pub distortion: Option<Distortion>,
    /// φ, ω, κ of the platform from the head; its axis looks to the same side as the virtual one.
    pub rotation_deg: [f64; 3],
    /// Its projection centre from the virtual one: right, forward, up, metres.
    pub d_m: [f64; 3],
}

impl Head {
    /// The head as a camera by itself.
    #[must_use]
    pub fn camera(&self) -> CameraFile {
        let fov_deg = |side: u32| 2.0 * (0.5 * f64::from(side) / self.f_px).atan().to_degrees();
        CameraFile {
            offset_m_px: self.offset_m_px,
            offset_n_px: self.offset_n_px,
            distortion: self.distortion,
            ..CameraFile::new((self.cols, self.rows), (fov_deg(self.cols), fov_deg(self.rows)))
        }
    }

    /// The lines of its tables.
    pub(super) fn text(&self) -> String {
        let [phi, omega, kappa] = self.rotation_deg;
        let [right, forward, up] = self.d_m;
        let mut text = format!(
            "\n[[heads]]\ncols = {}\nrows = {}\nf_px = {:?}\noffset_m_px = {:?}\noffset_n_px = {:?}\n\
             rotation_deg = [{phi:?}, {omega:?}, {kappa:?}]\nd_m = [{right:?}, {forward:?}, {up:?}]\n",
            self.cols, self.rows, self.f_px, self.offset_m_px, self.offset_n_px
        );
        if let Some(distortion) = &self.distortion {
            text.push_str(&distortion.text("\n[heads.distortion]"));
        }
        text
    }
}

/// The heads of a file, none where it has no such tables.
pub(super) fn heads(file: &Keys<'_>) -> Result<Vec<Head>, InputError> {
    let tables = match file.table.get("heads") {
        None => return Ok(Vec::new()),
        Some(Value::Array(tables)) if (1..=HEADS_MAX).contains(&tables.len()) => tables,
        Some(_) => return Err(file.wrong("heads", &format!("1 to {HEADS_MAX} tables [[heads]]"))),
    };
    let keys = tables.iter().enumerate().map(|(index, value)| {
        let table = value.as_table().ok_or_else(|| file.wrong("heads", "tables [[heads]]"))?;
        head(&Keys { name: file.name, prefix: format!("head {}: ", index + 1), table })
    });
    keys.collect()
}

fn head(keys: &Keys<'_>) -> Result<Head, InputError> {
    keys.only(&KEYS)?;
    let head = Head {
        cols: keys.side("cols", SIDE_MAX_PX)?,
        rows: keys.side("rows", SIDE_MAX_PX)?,
        f_px: keys.needed_number("f_px")?,
        offset_m_px: keys.number("offset_m_px")?.unwrap_or(0.0),
        offset_n_px: keys.number("offset_n_px")?.unwrap_or(0.0),
        distortion: keys.distortion()?,
        rotation_deg: keys.needed("rotation_deg", keys.triple("rotation_deg")?)?,
        d_m: keys.needed("d_m", keys.triple("d_m")?)?,
    };
    keys.principal_point([head.cols, head.rows], [head.offset_m_px, head.offset_n_px])?;
    // A focal length of less than a pixel sees 180 degrees with any two columns.
    if head.f_px < 1.0 {
        return Err(keys.wrong("f_px", "at least 1"));
    }
    lens::check(keys, head.distortion.as_ref(), 0.5 * f64::from(head.cols.min(head.rows)) / head.f_px)?;
    let [phi, omega, kappa] = head.rotation_deg;
    if [phi, omega].iter().any(|angle| angle.abs() >= 90.0) || kappa.abs() > 360.0 {
        return Err(keys.wrong("rotation_deg", "phi and omega below 90 degrees and kappa up to 360"));
    }
    if head.d_m.iter().any(|arm| arm.abs() > ARM_MAX_M) {
        return Err(keys.wrong("d_m", &format!("within {ARM_MAX_M} m")));
    }
    Ok(head)
}
