//! What options take the place of in a scenario's text, so that files which nobody reads need not be there.

use super::Scenario;
use plumbline_survey::error::InputError;

/// Keys by which a reference that is made of the ground's own picture differs from it.
const MADE_UP: [&str; 6] = ["gamma", "gain", "offset_dn", "noise_dn", "changed_fraction", "other_seed"];

/// What is given beside the scenario.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Instead {
    /// The orthophoto to fly over: its elevation model and reference are the scenario's no more.
    pub ground: bool,
    /// The elevation model.
    pub dem: bool,
    /// The picture that the reference is made of: real differences take the place of made-up ones.
    pub reference: bool,
    /// The attitude log.
    pub replay: bool,
}

impl Scenario {
    /// A scenario's text without what is given `instead`. Where it names an orthophoto to fly over that is not read it names one still.
    ///
    /// # Errors
    /// [`InputError`]: the text itself is wrong.
    pub fn instead(text: &str, file: &str, instead: Instead) -> Result<String, InputError> {
        if instead == Instead::default() {
            return Ok(text.to_owned());
        }
        // What is wrong with the file is told with its line.
        Self::read(text, file)?;
        let mut whole = Self::table(text, file)?;
        if instead.ground {
            let given = toml::Table::from_iter([("ortho".to_owned(), "given by an option".into())]);
            whole.insert("ground".to_owned(), given.into());
        }
        let mut leave_out = |table: &str, keys: &[&str]| {
            if let Some(toml::Value::Table(table)) = whole.get_mut(table) {
                table.retain(|key, _| !keys.contains(&key));
            }
        };
        if instead.dem {
            leave_out("ground", &["dem"]);
        }
        if instead.reference {
            leave_out("ground", &["reference"]);
            leave_out("reference", &MADE_UP);
        }
        if instead.replay {
            whole.remove("replay");
        }
        toml::to_string(&whole).map_err(|error| InputError::new(format!("{file}: {error}")))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scenario::{BUILT_IN, Ground};
    use std::path::Path;

    fn built_in(name: &str, instead: Instead) -> Result<Scenario, String> {
        let (_, text) = BUILT_IN.iter().find(|(own, _)| *own == name).expect("it is built in");
        let text = Scenario::instead(text, name, instead).map_err(|error| error.to_string())?;
        Scenario::parse(&text, name, Path::new(""), None).map_err(|error| error.to_string())
    }

    #[test]
    fn files_that_nobody_reads_need_not_be_there() {
        let ground = Instead { ground: true, ..Instead::default() };
        assert!(built_in("naip", Instead::default()).expect_err("no data").contains("PLUMBLINE_DATA"));
        let naip = built_in("naip", ground).expect("nothing of the data is left");
        assert!(matches!(naip.world.ground, Ground::Ortho { dem: None, reference: None, .. }));
        assert!(built_in("vienna", ground).expect_err("its log").contains("replay.att"));
        let vienna = built_in("vienna", Instead { replay: true, ..ground }).expect("nothing of the data is left");
        assert_eq!(vienna.vehicle.resolution_m, 2.0);
    }

    #[test]
    fn a_real_reference_has_real_differences_alone() {
        let ground = Instead { ground: true, ..Instead::default() };
        let made_up = built_in("naip", ground).expect("sound").world.reference;
        assert_eq!((made_up.gamma, made_up.noise_dn, made_up.changed_fraction), (Some(0.8), Some(3.0), Some(0.1)));
        let real = built_in("naip", Instead { reference: true, ..ground }).expect("sound").world.reference;
        assert_eq!((real.gamma, real.noise_dn, real.changed_fraction), (None, None, None));
        assert_eq!(real.elevation_posts_m, made_up.elevation_posts_m);
    }
}
