//! `--set KEY=VALUE`: single keys over a scenario's text.

use super::{Scenario, lay_over};
use plumbline_survey::error::InputError;
use std::str::FromStr;

/// A key and what it is set to.
#[derive(Debug, Clone, PartialEq)]
pub struct Setting {
    /// The parts of the dotted key.
    key: Vec<String>,
    value: toml::Value,
}

impl FromStr for Setting {
    type Err = String;

    /// `KEY=VALUE`; a value that is no TOML is a string.
    fn from_str(text: &str) -> Result<Self, String> {
        let Some((key, value)) = text.split_once('=') else { return Err("it is no KEY=VALUE".to_owned()) };
        let key: Vec<String> = key.split('.').map(|part| part.trim().to_owned()).collect();
        let is_bare = |part: &String| {
            !part.is_empty() && part.bytes().all(|byte| byte.is_ascii_alphanumeric() || b"_-".contains(&byte))
        };
        if !key.iter().all(is_bare) {
            return Err("its key is no dotted key of a scenario, as range.sigma_m is one".to_owned());
        }
        let value = value.trim();
        if value.is_empty() {
            return Err("it lacks a value".to_owned());
        }
        let parsed: Option<toml::Table> = toml::from_str(&format!("value = {value}")).ok();
        // More than one key is a line break within the value.
        let parsed = parsed.filter(|table| table.len() == 1).and_then(|mut table| table.remove("value"));
        Ok(Setting { key, value: parsed.unwrap_or_else(|| toml::Value::String(value.to_owned())) })
    }
}

impl Setting {
    fn key(&self) -> String {
        self.key.join(".")
    }

    /// The tables that lead to the value.
    fn table(&self) -> toml::Table {
        let mut parts = self.key.iter().rev();
        let last = parts.next().map(|part| toml::Table::from_iter([(part.clone(), self.value.clone())]));
        parts.fold(last.unwrap_or_default(), |inner, part| {
            toml::Table::from_iter([(part.clone(), toml::Value::Table(inner))])
        })
    }
}

impl Scenario {
    /// A scenario's text with single keys laid over it, and what messages call it then: `file` and the keys.
    ///
    /// # Errors
    /// [`InputError`]: the text itself is wrong, or it is no key of a scenario, or a value of another type.
    pub fn set(text: &str, file: &str, settings: &[Setting]) -> Result<(String, String), InputError> {
        if settings.is_empty() {
            return Ok((text.to_owned(), file.to_owned()));
        }
        // What is wrong with the file is told with its line.
        Self::read(text, file)?;
        let (mut whole, mut text, mut name) = (Self::table(text, file)?, text.to_owned(), file.to_owned());
        for setting in settings {
            let called = format!("--set {}", setting.key());
            lay_over(&mut whole, setting.table());
            text = toml::to_string(&whole).map_err(|error| InputError::new(format!("{called}: {error}")))?;
            Self::read_unlined(&text, &format!("{called}={}", setting.value))?;
            name = format!("{name} with {called}");
        }
        Ok((text, name))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    fn set(text: &str, words: &[&str]) -> Result<Scenario, String> {
        let settings: Vec<Setting> = words.iter().map(|word| word.parse()).collect::<Result<_, _>>()?;
        Scenario::set(text, "a.toml", &settings)
            .and_then(|(text, name)| Scenario::parse(&text, &name, Path::new(""), None))
            .map_err(|error| error.to_string())
    }

    #[test]
    fn keys_lie_over_the_text() {
        let text = "frames = 5\n[range]\nsigma_m = 0.5\ndropout_percent = 3.0\n";
        let words = ["range.sigma_m=0.25", "name=evening", "flight.height_m=[50, 60]", "timer.pps=true"];
        let scenario = set(text, &words).expect("sound");
        assert_eq!((scenario.run.frames, scenario.vehicle.range.sigma_m), (5, 0.25));
        assert_eq!((scenario.faults.range.dropout_percent, scenario.run.name.as_str()), (3.0, "evening"));
        assert_eq!((scenario.run.flight.height_m, scenario.world.timer.pps), ([50.0, 60.0], true));
        let last = set("", &["frames=3", "frames = 4"]).expect("sound");
        assert_eq!(last.run.frames, 4);
        let quoted = set("", &["name=\"a = b\"", "follow_up.mode=measured"]).expect("sound");
        assert_eq!(quoted.run.name, "a = b");
        let faults = set("", &["fault=[{ unit = \"range\", type = \"off\", from_s = 3 }]"]).expect("sound");
        assert_eq!(faults.faults.timed.all().len(), 1);
        assert_eq!(set("frames = 7", &[]), Ok(Scenario { file: "a.toml".into(), ..Scenario::of_frames(7) }));
    }

    #[test]
    fn what_is_wrong_is_named() {
        for (words, names) in [
            (["flihgt=3"].as_slice(), ["--set flihgt=3: flihgt is no key of a scenario"].as_slice()),
            (&["flight.tilt_deg=3"], &["--set flight.tilt_deg=3", "flight.tilt_deg is no key"]),
            (&["frames=many"], &["--set frames=\"many\"", "invalid type"]),
            (&["frames=5", "range.sigma_m=[1, 2"], &["--set range.sigma_m", "invalid type"]),
            (&["frames.first=5"], &["--set frames.first=5", "invalid type"]),
            (&["frames=3\nseed = 4"], &["--set frames", "invalid type"]),
            (&["frames=0"], &["a.toml with --set frames: frames = 0 is not between"]),
            (&["frames"], &["KEY=VALUE"]),
            (&["=3"], &["dotted key"]),
            (&["a..b=3"], &["dotted key"]),
            (&["frames="], &["lacks a value"]),
        ] {
            let why = set("", words).expect_err(words[0]);
            assert!(!why.contains('\n'), "{why}");
            names.iter().for_each(|name| assert!(why.contains(name), "{words:?}: {why:?} without {name:?}"));
        }
        let file = set("frames = \"x\"", &["frames=3"]).expect_err("the file is wrong");
        assert!(file.contains("a.toml, line 1"), "{file}");
    }
}
