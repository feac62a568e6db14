//! A scenario with every key that it leaves to its default, as data.

use super::{Camera, Scenario};
use serde::Serialize;
use serde_json::{Map, Value};

impl Scenario {
    /// All its keys as a file would have them; `null` is a key that is not given and has no default.
    #[must_use]
    pub fn resolved(&self) -> Value {
        let mut whole = Map::new();
        match &self.camera {
            Camera::Keys(frame) => whole.insert("camera".to_owned(), value(frame)),
            Camera::File(path) => whole.insert("camera_file".to_owned(), value(path)),
        };
        for part in [value(&self.vehicle), value(&self.world), value(&self.run), value(&self.faults)] {
            lay_into(&mut whole, part);
        }
        Value::Object(whole)
    }
}

/// A path that is no text is `null`.
fn value<T: Serialize>(part: &T) -> Value {
    serde_json::to_value(part).unwrap_or_default()
}

/// Tables of one name become one, as the parts share them in the file.
fn lay_into(whole: &mut Map<String, Value>, part: Value) {
    let Value::Object(part) = part else { return };
    for (key, value) in part {
        match (whole.get_mut(&key), value) {
            (Some(Value::Object(below)), value @ Value::Object(_)) => lay_into(below, value),
            (_, value) => {
                whole.insert(key, value);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    /// What it says is a scenario, and the one that it was.
    #[test]
    fn it_can_be_read_again() {
        let text = "name = \"x\"\nframes = 9\n[range]\ndropout_percent = 3.0\nsigma_m = 0.5\n[ground]\northo = \"o.tif\"\n\
                    [[fault]]\nunit = \"range\"\ntype = \"scale\"\nvalue = 2.0\nfrom_s = 3.0\n";
        let scenario = Scenario::parse(text, "a.toml", Path::new(""), None).expect("sound");
        let resolved = scenario.resolved();
        assert_eq!((&resolved["name"], &resolved["fault"][0]["type"]), (&"x".into(), &"scale".into()));
        let text = toml::to_string(&without_nulls(resolved)).expect("TOML");
        assert_eq!(Scenario::parse(&text, "a.toml", Path::new(""), None), Ok(scenario));
    }

    fn without_nulls(value: Value) -> Value {
        match value {
            Value::Object(map) => {
                let kept = map.into_iter().filter(|(_, value)| !value.is_null());
                Value::Object(kept.map(|(key, value)| (key, without_nulls(value))).collect())
            }
            other => other,
        }
    }
}
