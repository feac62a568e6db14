//! Every timed fault over a firmware in this process, with what reaches it written down.

use super::{Keep, fly};
use crate::link::inproc::InProcess;
use crate::link::{Event, Flash, Link, LinkError, Moving};
use crate::scenario::{Camera, Fault, FollowUpMode, KINDS, Navigation, Scenario};
use crate::setup::Setup;

/// A firmware and all that it got: when, microseconds of its timer since the start, and what.
struct Recorder {
    inner: InProcess,
    start_ticks: u32,
    events: Vec<(u32, String)>,
    /// What it was shown, where it looks.
    shown: Option<Vec<Moving>>,
}

impl Link for Recorder {
    fn step(&mut self, timer: u32, event: Event<'_>) -> Result<Vec<u8>, LinkError> {
        self.events.push((timer.wrapping_sub(self.start_ticks), format!("{event:?}")));
        self.inner.step(timer, event)
    }

    fn reboot(&mut self, flash: &Flash) -> Result<(), LinkError> {
        self.events.push((u32::MAX, "boot".to_owned()));
        self.inner.reboot(flash)
    }

    fn show(&mut self, moving: &dyn Fn() -> Moving) {
        if let Some(shown) = &mut self.shown {
            shown.push(moving());
        }
    }
}

/// 4.5 s, of which the last two and a half may be faulty.
fn flown(word: Option<&str>) -> Vec<(u32, String)> {
    flown_by(word, None)
}

fn flown_by(word: Option<&str>, navigation: Option<Navigation>) -> Vec<(u32, String)> {
    recorded(word, navigation, false).0
}

/// And what one who watches is shown.
fn recorded(word: Option<&str>, navigation: Option<Navigation>, watches: bool) -> (Vec<(u32, String)>, Vec<Moving>) {
    let mut scenario = Scenario { camera: Camera::of_size(96, 96), ..Scenario::of_frames(14) };
    scenario.vehicle.follow_up.mode = FollowUpMode::Measured;
    scenario.world.timer.pps = true;
    scenario.world.navigation = navigation;
    scenario.faults.timed = word.map(|word| word.parse::<Fault>().expect(word)).into_iter().collect();
    scenario.check().expect("sound");
    let setup = Setup::prepare(scenario).expect("it can be flown");
    let inner = InProcess::new(&setup.flash).expect("a firmware");
    let start_ticks = setup.scenario.world.timer.start_ticks;
    let mut link = Recorder { inner, start_ticks, events: Vec::new(), shown: watches.then(Vec::new) };
    fly(&setup, &mut link, Keep::default(), &mut ()).expect("a flight");
    (link.events, link.shown.unwrap_or_default())
}

/// A vehicle that navigates is integrated as far as somebody asks: who watches must not ask ahead.
#[test]
fn whoever_watches_is_shown_how_the_vehicle_moves_and_changes_no_byte() {
    let navigates = || Some(Navigation { bank_max_deg: 10.0, ..Navigation::default() });
    for navigation in [None, navigates()] {
        let is_kept = navigation.is_some();
        let (events, shown) = recorded(None, navigation.clone(), true);
        assert_eq!(events, flown_by(None, navigation));
        // Fifty attitudes a second at least.
        assert!(shown.len() > 200, "{}", shown.len());
        assert_eq!(shown[0].waypoint, is_kept.then_some(1));
        let turns = shown.iter().filter(|moving| moving.rates_rad_s.iter().any(|rate| rate.abs() > 1e-3));
        assert!(turns.count() > shown.len() / 2, "it turns");
    }
}

#[test]
fn no_fault_changes_a_byte_before_it_begins_and_each_changes_some_after() {
    let navigates = || Some(Navigation { bank_max_deg: 10.0, ..Navigation::default() });
    let (given, kept) = (flown(None), flown_by(None, navigates()));
    for kind in KINDS {
        let value = kind.value.map(|value| match value.unit {
            "times" | "s" => "=0.5".to_owned(),
            _ => format!("={}", value.high.min(50.0)),
        });
        let word = format!("{}.{}{}@4..5.5", kind.unit, kind.name, value.unwrap_or_default());
        let is_kept = kind.unit == "gnss";
        let good = if is_kept { &kept } else { &given };
        let bad = flown_by(Some(&word), navigates().filter(|_| is_kept));
        // The timer is 20 ppm fast.
        let before = |events: &[(u32, String)]| events.iter().take_while(|(at, _)| *at < 4_000_000).count();
        let count = before(good);
        assert_eq!((before(&bad), &bad[..count]), (count, &good[..count]), "{word}");
        assert!(bad != *good, "{word} did nothing");
    }
}

/// Nothing is delivered without power; before the first step after it the board boots, once.
#[test]
fn a_board_without_power_gets_nothing_and_boots() {
    let bad = flown(Some("power.off@4..5.5"));
    assert!(bad.iter().all(|(at, _)| !(4_000_100..5_500_000).contains(at)));
    let boots: Vec<usize> = (0..bad.len()).filter(|index| bad[*index].1 == "boot").collect();
    let [boot] = boots[..] else { panic!("{} boots", boots.len()) };
    assert!(bad[boot - 1].0 < 4_000_100 && bad[boot + 1].0 >= 5_500_000, "{:?}", &bad[boot - 1..boot + 2]);
    assert!(bad[boot..].iter().any(|(_, event)| event.starts_with("Frame")));
}

/// The board hears the autopilot, and beside each of its streams the stranger.
#[test]
fn a_second_sender_has_a_component_of_its_own() {
    let bytes = |word: Option<&str>| -> Vec<(u32, String)> {
        flown(word).into_iter().filter(|(_, event)| event.starts_with("Bytes([253")).collect()
    };
    // The sixth and seventh byte are system and component.
    let is_strange = |event: &str| event.split(", ").nth(6) == Some("25");
    let (good, bad) = (bytes(None), bytes(Some("link.second_sender@4..5.5")));
    assert!(good.iter().all(|(_, event)| !is_strange(event)));
    let count = |own: bool| {
        let during = bad.iter().filter(|(at, _)| (4_200_000..5_500_000).contains(at));
        during.filter(|(_, event)| is_strange(event) == own).count()
    };
    assert!(count(true) > 100 && count(true).abs_diff(count(false)) < 40, "{} {}", count(true), count(false));
}
