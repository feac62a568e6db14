//! What tilt costs: the default scene flown level, as it is and tilted by up to 20 degrees, 20 frames each.
//!
//! `cargo run --package plumbline-sim --example tilts`

use plumbline_sim::link::inproc::InProcess;
use plumbline_sim::run::{Keep, fly};
use plumbline_sim::scenario::Scenario;
use plumbline_sim::score::unrectified::Unrectified;
use plumbline_sim::score::{length, score};
use plumbline_sim::setup::Setup;
use std::error::Error;

fn main() -> Result<(), Box<dyn Error>> {
    println!("tilt, degrees  fixes of 20  mean error of a fix, m  of a raw frame's match, m");
    for tilt_max_deg in [0.0, 10.0, 20.0] {
        let mut scenario = Scenario::of_frames(20);
        scenario.vehicle.flight.tilt_max_deg = tilt_max_deg;
        let setup = Setup::prepare(scenario)?;
        let mut link = InProcess::new(&setup.flash)?;
        // It watches the flight, and matches every frame as it comes from the camera.
        let mut unrectified = Unrectified::default();
        let flight = fly(&setup, &mut link, Keep::default(), &mut unrectified).map_err(|aborted| aborted.why)?;
        let scored = score(&setup, &flight, &unrectified);
        let mean = |lengths: Vec<f64>| lengths.iter().sum::<f64>() / lengths.len().max(1) as f64;
        let fixes: Vec<f64> = scored.iter().filter_map(|frame| frame.error_m).map(length).collect();
        let raw =
            scored.iter().filter_map(|frame| frame.raw_px).map(|px| setup.scenario.vehicle.resolution_m * length(px));
        println!("{tilt_max_deg:13}  {:11}  {:22.2}  {:25.2}", fixes.len(), mean(fixes.clone()), mean(raw.collect()));
    }
    Ok(())
}
