//! Whole flights in-process against the truth and against each other: mounted cameras, stamps, and what goes wrong.

mod heads;
mod mount;
mod paired;
mod trouble;

use plumbline_firmware::stores::configuration::Configuration;
use plumbline_firmware::wire::telemetry::Health;
use plumbline_sim::link::inproc::InProcess;
use plumbline_sim::run::{FrameRecord, Keep, fly};
use plumbline_sim::scenario::{Camera, Scenario};
use plumbline_sim::score::unrectified::Unrectified;
use plumbline_sim::score::{Scored, score};
use plumbline_sim::setup::Setup;

/// A finished flight, each frame scored.
#[derive(Debug)]
struct Flown {
    frames: Vec<FrameRecord>,
    scored: Vec<Scored>,
    health: Health,
    resolution_m: f64,
}

/// The default scene seen by a camera of a sixteenth of the pixels, which is rendered in as much less time: a pixel of the
/// reference still spans four of the frame's, and fixes are as good.
fn scenario(seed: u64, frames: u32) -> Scenario {
    let mut scenario = Scenario::seeded(seed, frames);
    scenario.camera = Camera::of_size(128, 128);
    scenario
}

/// Flies a scenario whose firmware is told what `told` makes of its configuration.
fn flown_told(scenario: Scenario, told: impl FnOnce(&mut Configuration)) -> Flown {
    let mut setup = Setup::prepare(scenario).expect("it can be flown");
    told(&mut setup.flash.configuration);
    let mut link = InProcess::new(&setup.flash).expect("it boots");
    let mut unrectified = Unrectified::default();
    let flight = fly(&setup, &mut link, Keep::default(), &mut unrectified).expect("it flies");
    let scored = score(&setup, &flight, &unrectified);
    let resolution_m = setup.scenario.vehicle.resolution_m;
    Flown { frames: flight.frames, scored, health: flight.health, resolution_m }
}

fn flown(scenario: Scenario) -> Flown {
    flown_told(scenario, |_| {})
}

impl Flown {
    fn accepted(&self) -> usize {
        self.scored.iter().filter(|scored| scored.accepted).count()
    }

    /// Root mean square distance of the fixes from the antenna, metres.
    fn rms_m(&self) -> f64 {
        let squares = self.scored.iter().filter_map(|scored| scored.error_m).map(|[e, n]| e * e + n * n);
        mean(squares).sqrt()
    }

    fn nees(&self) -> f64 {
        mean(self.scored.iter().filter_map(|scored| scored.nees))
    }
}

fn mean(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0), |(sum, count), value| (sum + value, count + 1));
    sum / f64::from(count)
}
