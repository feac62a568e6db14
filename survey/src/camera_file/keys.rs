//! The values of one table of a camera file, each checked as it is taken.

use toml::{Table, Value};

use crate::error::InputError;

use super::{Distortion, off_frame};

const DISTORTION_KEYS: [&str; 5] = ["k1", "k2", "k3", "p1", "p2"];

/// One table of the file, with what an error calls it.
pub(super) struct Keys<'a> {
    pub name: &'a str,
    pub prefix: String,
    pub table: &'a Table,
}

impl<'a> Keys<'a> {
    /// Refuses keys that are not in the list.
    pub fn only(&self, known: &[&str]) -> Result<(), InputError> {
        match self.table.keys().find(|key| !known.contains(&key.as_str())) {
            None => Ok(()),
            Some(key) => Err(InputError::new(format!(
                "camera file {}: unknown key {}{key} (known are {}){}",
                self.name,
                self.prefix,
                known.join(", "),
                self.kind()
            ))),
        }
    }

    /// What the file is, if it is none of a camera: keys of scenarios, or of a board's settings, and none that a camera needs.
    fn kind(&self) -> &'static str {
        let has = |keys: &[&str]| keys.iter().any(|key| self.table.contains_key(*key));
        if !self.prefix.is_empty() || has(&["cols", "rows", "fov_h_deg", "fov_v_deg"]) {
            ""
        } else if has(&["frames", "seed", "camera_file", "camera", "flight", "fault", "ground"]) {
            ": this is a scenario, which fly --scenario takes"
        } else if has(&["attitude", "position", "range", "follow_up", "resolution_m", "search_px", "exposure_us"]) {
            ": this is a board's settings, which --settings takes"
        } else {
            ""
        }
    }

    /// A finite number, whole or not; `None` where the key is absent.
    pub fn number(&self, key: &str) -> Result<Option<f64>, InputError> {
        self.table.get(key).map(|value| finite(value).ok_or_else(|| self.wrong(key, "a finite number"))).transpose()
    }

    /// A finite number that has to be there.
    pub fn needed_number(&self, key: &str) -> Result<f64, InputError> {
        self.needed(key, self.number(key)?)
    }

    /// `count` finite numbers; `None` where the key is absent.
    pub fn numbers(&self, key: &str, count: usize) -> Result<Option<Vec<f64>>, InputError> {
        let Some(value) = self.table.get(key) else { return Ok(None) };
        let numbers = row(value).filter(|numbers| numbers.len() == count);
        numbers.map(Some).ok_or_else(|| self.wrong(key, &format!("{count} finite numbers")))
    }

    /// Three finite numbers; `None` where the key is absent.
    pub fn triple(&self, key: &str) -> Result<Option<[f64; 3]>, InputError> {
        Ok(self.numbers(key, 3)?.and_then(|numbers| numbers.try_into().ok()))
    }

    /// A square array of `side` rows; `None` where the key is absent.
    pub fn square(&self, key: &str, side: usize) -> Result<Option<Vec<Vec<f64>>>, InputError> {
        let Some(value) = self.table.get(key) else { return Ok(None) };
        let rows: Option<Vec<_>> = value.as_array().and_then(|rows| rows.iter().map(row).collect());
        let square = rows.filter(|rows| rows.len() == side && rows.iter().all(|row| row.len() == side));
        square.map(Some).ok_or_else(|| self.wrong(key, &format!("{side} rows of {side} finite numbers")))
    }

    /// A whole number of 32 bits, not negative; `None` where the key is absent.
    pub fn unsigned(&self, key: &str) -> Result<Option<u32>, InputError> {
        match self.table.get(key) {
            None => Ok(None),
            Some(Value::Integer(value)) => {
                u32::try_from(*value).map(Some).map_err(|_| self.wrong(key, "a whole number from 0 to 4294967295"))
            }
            Some(_) => Err(self.wrong(key, "a whole number")),
        }
    }

    /// What has to be there.
    pub fn needed<T>(&self, key: &str, value: Option<T>) -> Result<T, InputError> {
        value.ok_or_else(|| {
            InputError::new(format!("camera file {}: the key {}{key} is missing", self.name, self.prefix))
        })
    }

    /// A side of a picture, 1 to `most` pixels.
    pub fn side(&self, key: &str, most: u32) -> Result<u32, InputError> {
        let side = self.needed(key, self.unsigned(key)?)?;
        if (1..=most).contains(&side) { Ok(side) } else { Err(self.wrong(key, &format!("from 1 to {most}"))) }
    }

    /// A full field of view, degrees.
    pub fn field_of_view(&self, key: &str) -> Result<f64, InputError> {
        let angle_deg = self.needed_number(key)?;
        if angle_deg > 0.0 && angle_deg < 180.0 {
            Ok(angle_deg)
        } else {
            Err(self.wrong(key, "more than 0 and less than 180 degrees"))
        }
    }

    /// Refuses a principal point that is not on the frame, as OpenCV's cx and cy would be if they were read as offsets.
    pub fn principal_point(&self, size: [u32; 2], offset: [f64; 2]) -> Result<(), InputError> {
        let keys = ["offset_m_px", "offset_n_px"];
        match off_frame(size, offset) {
            Some(k) => Err(self.wrong(
                keys[k],
                &format!(
                    "less than half of a frame of {} x {}, from whose middle it counts; for OpenCV's cx, cy write offset_m_px = cx - {} and \
                     offset_n_px = {} - cy",
                    size[0],
                    size[1],
                    0.5 * (f64::from(size[0]) - 1.0),
                    0.5 * (f64::from(size[1]) - 1.0)
                ),
            )),
            None => Ok(()),
        }
    }

    /// A table in this one; `None` where the key is absent.
    pub fn inner(&self, key: &str) -> Result<Option<Keys<'a>>, InputError> {
        match self.table.get(key) {
            None => Ok(None),
            Some(Value::Table(table)) => {
                Ok(Some(Keys { name: self.name, prefix: format!("{}{key}.", self.prefix), table }))
            }
            Some(_) => Err(self.wrong(key, "a table")),
        }
    }

    /// The table `distortion`; `None` where there is none.
    pub fn distortion(&self) -> Result<Option<Distortion>, InputError> {
        let Some(keys) = self.inner("distortion")? else { return Ok(None) };
        keys.only(&DISTORTION_KEYS)?;
        let [k1, k2, k3, p1, p2] = DISTORTION_KEYS.map(|key| keys.number(key).map(Option::unwrap_or_default));
        Ok(Some(Distortion { k1: k1?, k2: k2?, k3: k3?, p1: p1?, p2: p2? }))
    }

    /// The sentence about a value that is not what it must be.
    pub fn wrong(&self, key: &str, wanted: &str) -> InputError {
        let value = self.table.get(key).map_or_else(String::new, Value::to_string);
        InputError::new(format!("camera file {}: {}{key} = {value} must be {wanted}", self.name, self.prefix))
    }
}

fn finite(value: &Value) -> Option<f64> {
    match value {
        Value::Float(value) => value.is_finite().then_some(*value),
        Value::Integer(value) => Some(*value as f64),
        _ => None,
    }
}

fn row(value: &Value) -> Option<Vec<f64>> {
    value.as_array()?.iter().map(finite).collect()
}
