//! A built-in scenario for a test.

use plumbline_sim::scenario::{BUILT_IN, Scenario, Setting};
use plumbline_survey::io::data::shared_data;
use std::path::Path;

/// The built-in scenario of that name, with keys laid over it.
pub fn scenario(name: &str, keys: &[&str]) -> Scenario {
    let text = BUILT_IN.iter().find(|(built_in, _)| *built_in == name).expect("it is built in").1;
    let settings: Vec<Setting> = keys.iter().map(|key| key.parse().expect("a key")).collect();
    let (text, called) = Scenario::set(text, name, &settings).expect("its keys");
    Scenario::parse(&text, &called, Path::new(""), shared_data().as_deref()).expect("sound")
}
