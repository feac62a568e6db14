//! The keys of a block file: which there are, which are needed, and what a misspelt one was meant to be.

use crate::error::InputError;
use crate::misspelt;
use serde_json::{Map, Value};

/// Keys that mean something here.
const KEYS: [&str; 24] = [
    "f_px",
    "pixel_mm",
    "cols",
    "rows",
    "virtual_cols",
    "virtual_rows",
    "virtual_f_px",
    "heads_d_m",
    "head_start_rad",
    "heads_interior",
    "fixed_points",
    "fixed_stations",
    "station_start",
    "station_rates",
    "point_start",
    "sigma_px",
    "interior_free",
    "interior_sigma",
    "heads_d_sigma_m",
    "head_sync_sigma_s",
    "station_priors",
    "point_priors",
    "huber_sigmas",
    "name",
];

/// Keys of blocks that were generated, with the answer that was known: nothing is read of them, and nothing said.
const ANSWERS: [&str; 2] = ["solution", "truth_heads_rad"];
/// Keys that are written for others: `weights` for what `sigma_px` says.
const MEANT: [(&str, &str); 6] = [
    ("weights", "sigma_px, the standard deviation of an image coordinate (weight 1 / sigma_px^2)"),
    ("weight", "sigma_px, the standard deviation of an image coordinate (weight 1 / sigma_px^2)"),
    ("sigma", "sigma_px, the standard deviation of an image coordinate"),
    ("f_mm", "f_px, the focal length in pixels (f_mm / pixel_mm)"),
    ("gcps", "fixed_points, indices into point_start"),
    ("distortion", "heads_interior, a table a head with any of xp, yp, k1, k2, k3, p1, p2"),
];

/// Keys that a block cannot be without.
const NEEDED: [&str; 6] = ["f_px", "heads_d_m", "head_start_rad", "station_start", "point_start", "fixed_points"];

/// Refuses keys that mean nothing, since one that is misspelt would silently be left out of the adjustment, and names all that are missing.
pub(super) fn check_keys(block: &Map<String, Value>, name: &str) -> Result<(), InputError> {
    let unknown = block.keys().find(|key| !KEYS.contains(&key.as_str()) && !ANSWERS.contains(&key.as_str()));
    if let Some(key) = unknown {
        let meant = meant(key)
            .map_or_else(|| format!("known are {}", KEYS.join(", ")), |meant| format!("what was meant is {meant}"));
        return Err(InputError::new(format!("{name}: the key {key} means nothing here; {meant}")));
    }
    let missing: Vec<&str> = NEEDED.into_iter().filter(|key| block.get(*key).is_none_or(Value::is_null)).collect();
    match missing.as_slice() {
        [] => Ok(()),
        [one] => Err(InputError::new(format!("{name}: {one} is missing"))),
        several => Err(InputError::new(format!("{name}: the keys {} are missing", several.join(", ")))),
    }
}

/// What a key was meant to be: by another program's name, or the nearest of ours.
fn meant(key: &str) -> Option<&'static str> {
    let other = MEANT.iter().find(|(other, _)| key == *other).map(|(_, meant)| *meant);
    other.or_else(|| misspelt::meant(key, KEYS))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn error(text: &str) -> String {
        let block: Value = serde_json::from_str(text).expect("JSON");
        check_keys(block.as_object().expect("an object"), "b.json").expect_err(text).to_string()
    }

    #[test]
    fn misspelt_and_missing_keys_are_named() {
        assert!(error(r#"{"sigma_pix": 0.4}"#).ends_with("what was meant is sigma_px"));
        assert!(error(r#"{"sigma": 0.4}"#).contains("standard deviation"));
        assert!(error(r#"{"colour": 1}"#).contains("known are f_px"));
        let missing = error(
            r#"{"pixel_mm": 0.0068, "head_start_rad": [], "fixed_points": [], "solution": 1, "truth_heads_rad": 1}"#,
        );
        assert!(missing.contains("f_px, heads_d_m, station_start, point_start are missing"), "{missing}");
    }
}
