//! Flights that end early: what there is of them stays.

use plumbline_sim::link::inproc::InProcess;
use plumbline_sim::link::{Event, Link, LinkError};
use plumbline_sim::run::{FrameRecord, Keep, Observer, fly};
use plumbline_sim::scenario::{Camera, Scenario};
use plumbline_sim::score::unrectified::Unrectified;
use plumbline_sim::score::{fixes_csv, score};
use plumbline_sim::setup::Setup;

const KEEP: Keep = Keep { first: 0, every: 0, refused: 0 };

fn setup() -> Setup {
    let mut scenario = Scenario::of_frames(12);
    scenario.camera = Camera::of_size(128, 128);
    Setup::prepare(scenario).expect("it can be flown")
}

/// The rows of `fixes.csv` of a flight that nobody disturbs.
fn whole(setup: &Setup) -> Vec<String> {
    let flight = fly(setup, &mut InProcess::new(&setup.flash).expect("it boots"), KEEP, &mut ()).expect("it flies");
    let csv = fixes_csv(setup, &flight, &score(setup, &flight, &Unrectified::default()));
    csv.lines().map(str::to_owned).collect()
}

/// A link that is lost when it is given its frame number `frames`.
struct Lost {
    link: InProcess,
    frames: u32,
}

impl Link for Lost {
    fn step(&mut self, timer: u32, event: Event<'_>) -> Result<Vec<u8>, LinkError> {
        match event {
            Event::Frame(frame) if frame.sequence == self.frames => Err(LinkError::Lost("unplugged".to_owned())),
            _ => self.link.step(timer, event),
        }
    }
}

/// Ends the flight once frame `last` is finished.
struct Until {
    last: u32,
    is_over: bool,
}

impl Observer for Until {
    fn finished(&mut self, _: &Setup, record: &FrameRecord) {
        self.is_over |= record.exposure.frame == self.last;
    }

    fn is_interrupted(&self) -> bool {
        self.is_over
    }
}

#[test]
fn frames_that_were_finished_before_the_link_was_lost_are_kept() {
    let setup = setup();
    let mut link = Lost { link: InProcess::new(&setup.flash).expect("it boots"), frames: 8 };
    let aborted = fly(&setup, &mut link, KEEP, &mut ()).expect_err("the link is lost");
    assert_eq!(aborted.to_string(), "the firmware was lost: unplugged");
    let flight = &aborted.flight;
    assert_eq!(flight.frames.len(), 8);
    let csv = fixes_csv(&setup, flight, &score(&setup, flight, &Unrectified::default()));
    assert_eq!(csv.lines().map(str::to_owned).collect::<Vec<_>>(), whole(&setup)[..9]);
}

#[test]
fn an_observer_ends_the_flight() {
    let setup = setup();
    let mut link = InProcess::new(&setup.flash).expect("it boots");
    let aborted = fly(&setup, &mut link, KEEP, &mut Until { last: 4, is_over: false }).expect_err("it is ended");
    assert!(matches!(aborted.why, LinkError::Interrupted), "{aborted}");
    // Frame 4 is finished when frame 5 has been handed over; its report is in at once.
    assert!((5..7).contains(&aborted.flight.frames.len()), "{}", aborted.flight.frames.len());
}
