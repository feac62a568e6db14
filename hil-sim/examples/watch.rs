//! A scenario from text, and its frames as they are finished: when each was exposed, and its fix or why there is none.
//!
//! `cargo run --package plumbline-sim --example watch`

use plumbline_sim::link::inproc::InProcess;
use plumbline_sim::run::{FrameRecord, Keep, Observer, fly};
use plumbline_sim::scenario::Scenario;
use plumbline_sim::score::reason;
use plumbline_sim::setup::Setup;
use std::error::Error;
use std::path::Path;

const SCENARIO: &str = "
frames = 16
[attitude]
drift_deg = 0.35
[attitude_faults]
gap_s = [4.0, 5.0]
";

struct Print;

impl Observer for Print {
    fn finished(&mut self, setup: &Setup, record: &FrameRecord) {
        let [east_m, north_m] = setup.tile_centre;
        match record.report.and_then(|report| report.fix) {
            Some(fix) => println!(
                "frame {:2}: east {:.1} m, north {:.1} m, sigmas {:.2} and {:.2} m",
                record.exposure.frame,
                east_m + f64::from(fix.east_m),
                north_m + f64::from(fix.north_m),
                fix.variance_east_m2.sqrt(),
                fix.variance_north_m2.sqrt()
            ),
            None => println!("frame {:2}: no fix, {}", record.exposure.frame, reason(record).unwrap_or("lost")),
        }
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let setup = Setup::prepare(Scenario::parse(SCENARIO, "the example", Path::new(""), None)?)?;
    let mut link = InProcess::new(&setup.flash)?;
    let flight = fly(&setup, &mut link, Keep::default(), &mut Print).map_err(|aborted| aborted.why)?;
    println!("{} frames, {} messages received by the firmware", flight.frames.len(), flight.health.messages);
    Ok(())
}
