//! Fields that are an attitude together.

use crate::logs::Series;

/// Their names.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Fields {
    /// Real part, then the parts along forward, right and down.
    Quaternion([&'static str; 4]),
    /// Roll, pitch, yaw, degrees.
    Degrees([&'static str; 3]),
    /// Roll, pitch, yaw, radians.
    Radians([&'static str; 3]),
}

/// How far off 1 the length of a quaternion may be: they are logged in single precision, and one of zeros is none.
const LENGTH_OFF_MAX: f64 = 0.05;

impl Fields {
    /// Roll, pitch and yaw of each sample, radians; a sample that is no attitude is not a number. `None`: a field is missing, or
    /// there is no sample.
    pub fn rows(self, series: &Series) -> Option<Vec<[f64; 3]>> {
        if series.t_s.is_empty() {
            return None;
        }
        match self {
            Fields::Quaternion(names) => Some(zipped(series, names)?.into_iter().map(angles).collect()),
            Fields::Radians(names) => zipped(series, names),
            Fields::Degrees(names) => {
                Some(zipped(series, names)?.into_iter().map(|angles| angles.map(f64::to_radians)).collect())
            }
        }
    }
}

/// Rows of columns.
fn zipped<const N: usize>(series: &Series, names: [&str; N]) -> Option<Vec<[f64; N]>> {
    let columns: Vec<Vec<f64>> = names.iter().map(|name| series.column(name)).collect::<Option<_>>()?;
    Some((0..series.t_s.len()).map(|row| std::array::from_fn(|column| columns[column][row])).collect())
}

/// Roll, pitch and yaw of the rotation from the body to north, east, down; not numbers where it is none.
pub(super) fn angles([w, x, y, z]: [f64; 4]) -> [f64; 3] {
    let length = (w * w + x * x + y * y + z * z).sqrt();
    let is_rotation = (length - 1.0).abs() <= LENGTH_OFF_MAX;
    if !is_rotation {
        return [f64::NAN; 3];
    }
    let [w, x, y, z] = [w, x, y, z].map(|part| part / length);
    let roll = (2.0 * (w * x + y * z)).atan2(1.0 - 2.0 * (x * x + y * y));
    let pitch = (2.0 * (w * y - z * x)).clamp(-1.0, 1.0).asin();
    let yaw = (2.0 * (w * z + x * y)).atan2(1.0 - 2.0 * (y * y + z * z));
    [roll, pitch, yaw]
}
