//! Whether the autopilot is set so that it uses fixes: its parameters, asked for by name.
//!
//! A pass asks for each that has not answered in this pass, one a beat, in three rounds. The first pass begins once the
//! autopilot is there, the next ones while it is disarmed; after a reboot of the autopilot nothing is known any more. What
//! comes unasked, since somebody has set a parameter, counts as well.

use super::fixes::Form;
use super::wanted::{self, MOST, Ours, Wanted};
use crate::wire::incoming::{AutopilotKind, Parameter};

/// Rounds of a pass: each parameter is asked for three times at most.
const ROUNDS: u8 = 3;
/// Least time of a round, beats: what is not answered within a second is asked for again.
const ROUND_BEATS: u16 = 10;
/// From the end of a pass to the next one, beats: five minutes, and one where something is wrong, which somebody may be setting
/// right.
const REST_BEATS: u16 = 3_000;
const SHORT_REST_BEATS: u16 = 600;
/// Seconds from one telling of all that is wrong to the next, as of what is missing ([`super::readiness`]).
const REPEATED_EVERY: u8 = 10;

/// What the pilot is to be told.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Finding {
    /// A parameter is set to something else than it should be: its name, what it is, and what it should be.
    Wrong(&'static str, f32, f32),
    /// It was asked for and never came.
    Unknown(&'static str),
}

/// How far the check has come.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Checked {
    /// Not through yet.
    NotYet,
    /// Something that is required is wrong.
    Wrong,
    /// Nothing that is required is known to be wrong.
    Right,
}

/// What is known of the parameters, and what is asked for.
#[derive(Debug)]
pub struct Parameters {
    ours: Ours,
    list: &'static [Wanted],
    values: [f32; MOST],
    /// A bit for each parameter: whether its value is known, and whether it came in this pass.
    known: u16,
    answered: u16,
    /// Which is asked for next, in which round, and beats since the round, or the rest behind the last, began.
    place: u8,
    round: u8,
    beats: u16,
    /// Whether a pass is through.
    is_through: bool,
    /// Which is looked at next for the pilot, and seconds since the first was.
    told: u8,
    seconds: u8,
}

impl Parameters {
    /// Nothing known yet.
    pub fn new(ours: Ours) -> Self {
        Parameters {
            ours,
            list: &[],
            values: [0.0; MOST],
            known: 0,
            answered: 0,
            place: 0,
            round: 0,
            beats: 0,
            is_through: false,
            told: 0,
            seconds: 0,
        }
    }

    /// Forgets what was another autopilot's, or the same one's before it rebooted.
    pub fn forget(&mut self) {
        *self = Parameters { list: self.list, ..Parameters::new(self.ours) };
    }

    /// Whose parameters are looked at.
    pub fn of(&mut self, kind: AutopilotKind, form: Form) {
        let list = wanted::of(kind, form);
        if !core::ptr::eq(self.list, list) {
            self.list = list;
            self.forget();
        }
    }

    /// A parameter arrived.
    pub fn arrived(&mut self, parameter: &Parameter, kind: AutopilotKind) {
        let found = self.list.iter().zip(&mut self.values).enumerate();
        let mut found = found.filter(|(_, (wanted, _))| parameter.is_called(wanted.name));
        let Some((place, (wanted, value))) = found.next() else { return };
        let (number, bit) = (parameter.number(kind), 1 << place);
        let is_news = self.known & bit == 0 || number.to_bits() != value.to_bits();
        if is_news && !wanted.right.holds(number, self.ours) {
            // Told at once, not at the end of ten seconds.
            (self.told, self.seconds) = (self.told.min(place as u8), 0);
        }
        *value = number;
        self.known |= bit;
        self.answered |= bit;
    }

    /// To be called on each beat while the autopilot is there: the name of the parameter that is to be asked for.
    pub fn next(&mut self, is_armed: bool) -> Option<&'static str> {
        self.beats = self.beats.saturating_add(1);
        if self.round == ROUNDS {
            let rest = if self.findings().next().is_some() { SHORT_REST_BEATS } else { REST_BEATS };
            if self.beats < rest || is_armed {
                return None;
            }
            (self.round, self.place, self.beats, self.answered) = (0, 0, 0, 0);
        }
        let unanswered = |place: usize| self.answered >> place & 1 == 0;
        if let Some((place, wanted)) =
            self.list.iter().enumerate().skip(self.place.into()).find(|(place, _)| unanswered(*place))
        {
            self.place = place as u8 + 1;
            return Some(wanted.name);
        }
        self.place = self.list.len() as u8;
        let is_complete = (0..self.list.len()).all(|place| !unanswered(place));
        if is_complete || self.beats >= ROUND_BEATS {
            self.round = if is_complete { ROUNDS } else { self.round + 1 };
            (self.place, self.beats) = (0, 0);
            self.is_through |= self.round == ROUNDS;
        }
        None
    }

    /// How far the check has come.
    pub fn checked(&self) -> Checked {
        if !self.is_through {
            return Checked::NotYet;
        }
        let is_wrong =
            |(wanted, finding): (&Wanted, Finding)| wanted.is_required && matches!(finding, Finding::Wrong(..));
        if self.findings().any(is_wrong) { Checked::Wrong } else { Checked::Right }
    }

    /// What there is to be said of a parameter.
    fn finding(&self, place: usize) -> Option<(&'static Wanted, Finding)> {
        let wanted = self.list.get(place)?;
        if self.known >> place & 1 == 0 {
            return self.is_through.then_some((wanted, Finding::Unknown(wanted.name)));
        }
        let value = *self.values.get(place)?;
        let wrong = Finding::Wrong(wanted.name, value, wanted.right.proposed(self.ours));
        (!wanted.right.holds(value, self.ours)).then_some((wanted, wrong))
    }

    fn findings(&self) -> impl Iterator<Item = (&'static Wanted, Finding)> {
        (0..self.list.len()).filter_map(|place| self.finding(place))
    }

    /// To be called once a second: what is to be told. All that is wrong, one a second, when it is found, and every ten
    /// seconds.
    pub fn line(&mut self) -> Option<Finding> {
        self.seconds = self.seconds.saturating_add(1);
        if usize::from(self.told) >= self.list.len() {
            if self.seconds <= REPEATED_EVERY {
                return None;
            }
            (self.told, self.seconds) = (0, 1);
        }
        let from = usize::from(self.told);
        let found = (from..self.list.len()).find_map(|place| self.finding(place).map(|(_, finding)| (place, finding)));
        // What is not known before the pass is through may turn out wrong.
        self.told = match found {
            Some((place, _)) => place as u8 + 1,
            None if self.is_through => self.list.len() as u8,
            None => self.told,
        };
        found.map(|(_, finding)| finding)
    }
}

#[cfg(test)]
mod tests {
    use super::super::fixes::Form;
    use super::super::wanted::{self, Ours};
    use super::{Checked, Finding, Parameters};
    use crate::wire::incoming::{AutopilotKind, Parameter};

    extern crate std;
    use std::collections::BTreeMap;
    use std::vec::Vec;

    const OURS: Ours = Ours { attitude_us: 5_000, sensor_id: 3 };
    const REAL32: u8 = 9;
    const INT32: u8 = 6;

    /// An autopilot with parameters, some of which differ from what is wanted.
    struct Partner {
        kind: AutopilotKind,
        values: BTreeMap<&'static str, f32>,
        asked: Vec<&'static str>,
    }

    impl Partner {
        fn new(kind: AutopilotKind, form: Form, differ: &[(&'static str, f32)]) -> Self {
            let right = wanted::of(kind, form).iter().map(|wanted| (wanted.name, wanted.right.proposed(OURS)));
            Partner { kind, values: right.chain(differ.iter().copied()).collect(), asked: Vec::new() }
        }

        fn parameter(&self, name: &str) -> Option<Parameter> {
            let value = *self.values.get(name)?;
            let mut bytes = [0; 16];
            bytes.iter_mut().zip(name.bytes()).for_each(|(to, from)| *to = from);
            Some(match self.kind {
                AutopilotKind::Px4 => {
                    Parameter { name: bytes, value: f32::from_bits(value as i32 as u32), kind: INT32 }
                }
                _ => Parameter { name: bytes, value, kind: REAL32 },
            })
        }

        /// So many beats; what is told in them, with the beat.
        fn beats(&mut self, parameters: &mut Parameters, count: u32, is_armed: bool) -> Vec<(u32, Finding)> {
            let mut told = Vec::new();
            for beat in 0..count {
                if let Some(name) = parameters.next(is_armed) {
                    self.asked.push(name);
                    if let Some(parameter) = self.parameter(name) {
                        parameters.arrived(&parameter, self.kind);
                    }
                }
                if beat % 10 == 3 {
                    told.extend(parameters.line().map(|finding| (beat, finding)));
                }
            }
            told
        }
    }

    fn ardupilot() -> Parameters {
        let mut parameters = Parameters::new(OURS);
        parameters.of(AutopilotKind::Ardupilot, Form::Odometry);
        parameters
    }

    #[test]
    fn an_autopilot_that_is_set_right_is_asked_once_and_nothing_is_told() {
        let (mut parameters, mut partner) = (ardupilot(), Partner::new(AutopilotKind::Ardupilot, Form::Odometry, &[]));
        assert_eq!(parameters.checked(), Checked::NotYet);
        assert_eq!(partner.beats(&mut parameters, 200, false), []);
        assert_eq!((parameters.checked(), partner.asked.len()), (Checked::Right, wanted::MOST));
        // Again every five minutes, but not while armed.
        partner.beats(&mut parameters, 4_000, true);
        assert_eq!(partner.asked.len(), wanted::MOST);
        partner.beats(&mut parameters, 100, false);
        assert_eq!(partner.asked.len(), 2 * wanted::MOST);
    }

    #[test]
    fn each_wrong_value_is_told_one_a_second_and_every_ten() {
        let differ = [("EK3_SRC2_POSXY", 3.0), ("VISO_POS_M_NSE", 1.5)];
        let (mut parameters, mut partner) =
            (ardupilot(), Partner::new(AutopilotKind::Ardupilot, Form::Odometry, &differ));
        let told = partner.beats(&mut parameters, 250, false);
        let expected = [Finding::Wrong("EK3_SRC2_POSXY", 3.0, 6.0), Finding::Wrong("VISO_POS_M_NSE", 1.5, 0.2)];
        let lines: Vec<_> = told.iter().map(|(_, finding)| *finding).collect();
        assert_eq!(lines, [expected, expected, expected].concat()[..lines.len()], "{told:?}");
        assert!(told.len() >= 4 && told.windows(2).all(|two| two[1].0 - two[0].0 >= 10), "{told:?}");
        assert_eq!(parameters.checked(), Checked::Wrong);
        // Set right, which is told to everybody.
        partner.values.insert("EK3_SRC2_POSXY", 6.0);
        parameters.arrived(&partner.parameter("EK3_SRC2_POSXY").unwrap(), AutopilotKind::Ardupilot);
        // What is left is advice.
        assert_eq!(parameters.checked(), Checked::Right);
        assert_eq!(partner.beats(&mut parameters, 120, false)[0].1, expected[1]);
    }

    #[test]
    fn what_is_never_answered_is_asked_for_three_times_and_told_as_unknown() {
        let (mut parameters, mut partner) = (ardupilot(), Partner::new(AutopilotKind::Ardupilot, Form::Odometry, &[]));
        partner.values.remove("VISO_TYPE");
        let told = partner.beats(&mut parameters, 60, false);
        assert_eq!(partner.asked.iter().filter(|name| **name == "VISO_TYPE").count(), 3);
        assert_eq!(told[0].1, Finding::Unknown("VISO_TYPE"), "{told:?}");
        // An autopilot that answers nothing at all is soon through, too.
        let mut parameters = ardupilot();
        partner.values.clear();
        partner.beats(&mut parameters, 50, false);
        assert_eq!(parameters.checked(), Checked::Right);
    }

    #[test]
    fn px4_sends_the_bits_of_its_integers() {
        let mut parameters = Parameters::new(OURS);
        parameters.of(AutopilotKind::Px4, Form::GlobalPositionSensor);
        let mut partner = Partner::new(AutopilotKind::Px4, Form::GlobalPositionSensor, &[]);
        assert_eq!(partner.beats(&mut parameters, 100, false), []);
        assert_eq!(parameters.checked(), Checked::Right);
        partner.values.insert("EKF2_AGP0_ID", 2.0);
        parameters.forget();
        let told = partner.beats(&mut parameters, 30, false);
        assert_eq!(told[0].1, Finding::Wrong("EKF2_AGP0_ID", 2.0, 3.0));
        assert_eq!(parameters.checked(), Checked::Wrong);
        // A real one comes as it is in either.
        partner.kind = AutopilotKind::Ardupilot;
        parameters.arrived(&partner.parameter("EKF2_AGP0_ID").unwrap(), AutopilotKind::Px4);
    }

    #[test]
    fn of_an_unknown_autopilot_nothing_is_asked() {
        let mut parameters = Parameters::new(OURS);
        parameters.of(AutopilotKind::Other, Form::Odometry);
        assert!((0..100).all(|_| parameters.next(false).is_none()));
        assert_eq!((parameters.checked(), parameters.line()), (Checked::Right, None));
    }
}
