//! From a camera file's text to its checked content.

use toml::{Table, Value};

use crate::error::InputError;

use super::{CameraFile, Distortion, SIDE_MAX_PX, checksum};

/// Every key a file may have at its top.
const KEYS: [&str; 14] = [
    "cols",
    "rows",
    "fov_h_deg",
    "fov_v_deg",
    "offset_m_px",
    "offset_n_px",
    "pixel_mm",
    "distortion",
    "version",
    "crc32",
    "boresight",
    "heads",
    "lever_arms",
    "covariance",
];
const DISTORTION_KEYS: [&str; 5] = ["k1", "k2", "k3", "p1", "p2"];

pub(super) fn camera_file(text: &str, name: &str) -> Result<CameraFile, InputError> {
    let table: Table = toml::from_str(text).map_err(|error| {
        let line =
            error.span().and_then(|span| text.get(..span.start)).map_or(1, |before| before.matches('\n').count() + 1);
        InputError::new(format!("camera file {name}, line {line}, is not TOML: {}", error.message()))
    })?;
    let file = Keys { name, prefix: "", table: &table };
    file.only(&KEYS)?;
    let camera = CameraFile {
        cols: file.side("cols")?,
        rows: file.side("rows")?,
        fov_h_deg: file.field_of_view("fov_h_deg")?,
        fov_v_deg: file.field_of_view("fov_v_deg")?,
        offset_m_px: file.needed("offset_m_px", file.number("offset_m_px")?)?,
        offset_n_px: file.needed("offset_n_px", file.number("offset_n_px")?)?,
        pixel_mm: file.number("pixel_mm")?,
        distortion: distortion(&file)?,
        version: file.unsigned("version")?,
        crc32: file.unsigned("crc32")?,
        boresight: file.kept("boresight")?,
        heads: file.kept("heads")?,
        lever_arms: file.kept("lever_arms")?,
        covariance: file.kept("covariance")?,
    };
    if camera.pixel_mm.is_some_and(|side_mm| side_mm <= 0.0) {
        return Err(file.wrong("pixel_mm", "more than 0"));
    }
    if let Some(stated) = camera.crc32 {
        match checksum::of_text_with_line(text) {
            Some(found) if found == stated => {}
            Some(found) => {
                return Err(InputError::new(format!(
                    "camera file {name}: crc32 is {stated:#010x} but the text has {found:#010x}, so it was altered or damaged"
                )));
            }
            None => {
                return Err(file.wrong("crc32", "on a line of its own before the first table"));
            }
        }
    }
    Ok(camera)
}

fn distortion(file: &Keys<'_>) -> Result<Option<Distortion>, InputError> {
    let table = match file.table.get("distortion") {
        None => return Ok(None),
        Some(Value::Table(table)) => table,
        Some(_) => return Err(file.wrong("distortion", "a table")),
    };
    let keys = Keys { name: file.name, prefix: "distortion.", table };
    keys.only(&DISTORTION_KEYS)?;
    let coefficient = |key| Ok(keys.number(key)?.unwrap_or(0.0));
    Ok(Some(Distortion {
        k1: coefficient("k1")?,
        k2: coefficient("k2")?,
        k3: coefficient("k3")?,
        p1: coefficient("p1")?,
        p2: coefficient("p2")?,
    }))
}

/// One table of the file, with what an error calls it.
struct Keys<'a> {
    name: &'a str,
    prefix: &'a str,
    table: &'a Table,
}

impl Keys<'_> {
    /// Refuses keys that are not in the list.
    fn only(&self, known: &[&str]) -> Result<(), InputError> {
        match self.table.keys().find(|key| !known.contains(&key.as_str())) {
            None => Ok(()),
            Some(key) => Err(InputError::new(format!(
                "camera file {}: unknown key {}{key} (known are {})",
                self.name,
                self.prefix,
                known.join(", ")
            ))),
        }
    }

    /// A finite number, whole or not; `None` where the key is absent.
    fn number(&self, key: &str) -> Result<Option<f64>, InputError> {
        match self.table.get(key) {
            None => Ok(None),
            Some(Value::Float(value)) if value.is_finite() => Ok(Some(*value)),
            Some(Value::Integer(value)) => Ok(Some(*value as f64)),
            Some(_) => Err(self.wrong(key, "a finite number")),
        }
    }

    /// A whole number of 32 bits, not negative; `None` where the key is absent.
    fn unsigned(&self, key: &str) -> Result<Option<u32>, InputError> {
        match self.table.get(key) {
            None => Ok(None),
            Some(Value::Integer(value)) => {
                u32::try_from(*value).map(Some).map_err(|_| self.wrong(key, "a whole number from 0 to 4294967295"))
            }
            Some(_) => Err(self.wrong(key, "a whole number")),
        }
    }

    fn needed<T>(&self, key: &str, value: Option<T>) -> Result<T, InputError> {
        value.ok_or_else(|| {
            InputError::new(format!("camera file {}: the key {}{key} is missing", self.name, self.prefix))
        })
    }

    fn side(&self, key: &str) -> Result<u32, InputError> {
        let side = self.needed(key, self.unsigned(key)?)?;
        if (1..=SIDE_MAX_PX).contains(&side) {
            Ok(side)
        } else {
            Err(self.wrong(key, &format!("from 1 to {SIDE_MAX_PX}")))
        }
    }

    fn field_of_view(&self, key: &str) -> Result<f64, InputError> {
        let angle_deg = self.needed(key, self.number(key)?)?;
        if angle_deg > 0.0 && angle_deg < 180.0 {
            Ok(angle_deg)
        } else {
            Err(self.wrong(key, "more than 0 and less than 180 degrees"))
        }
    }

    /// A table or an array, as it stands.
    fn kept(&self, key: &str) -> Result<Option<Value>, InputError> {
        match self.table.get(key) {
            None => Ok(None),
            Some(value @ (Value::Table(_) | Value::Array(_))) => Ok(Some(value.clone())),
            Some(_) => Err(self.wrong(key, "a table or an array")),
        }
    }

    fn wrong(&self, key: &str, wanted: &str) -> InputError {
        let value = self.table.get(key).map_or_else(String::new, Value::to_string);
        InputError::new(format!("camera file {}: {}{key} = {value} must be {wanted}", self.name, self.prefix))
    }
}
