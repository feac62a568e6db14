//! One flight of a campaign, in the process itself, and what is kept of it.

use plumbline_sim::link::inproc::InProcess;
use plumbline_sim::run::{FrameRecord, Keep, fly};
use plumbline_sim::scenario::Scenario;
use plumbline_sim::score::faults::faults;
use plumbline_sim::score::protection::Placed;
use plumbline_sim::score::unrectified::Unrectified;
use plumbline_sim::score::{Scored, length, reason, score};
use plumbline_sim::setup::Setup;

/// A frame against the truth.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    /// Middle of its exposure, seconds of the simulated time.
    pub at_s: f64,
    /// Its fix, where it has one.
    pub fix: Option<Fix>,
    /// Why it has none.
    pub reason: Option<&'static str>,
    /// Where the board's filter believed to be.
    pub place: Option<Placed>,
}

/// A fix against the truth.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fix {
    /// Distance from the antenna's true place, pixels of the reference.
    pub off_px: f64,
    /// Root mean square of the stated sigmas of both axes, pixels.
    pub sigma_px: f64,
    /// Squared error over the stated covariance, two degrees of freedom.
    pub nees: f64,
    /// As `wrong_fixes` of `report.json` counts it.
    pub is_wrong: bool,
    /// Farther off than the protection level of its frame.
    pub is_beyond: bool,
}

/// A flight.
#[derive(Clone, Debug)]
pub struct Flown {
    /// Its seed.
    pub seed: u64,
    /// Ground and reference, where these are not the scenario's.
    pub pair: String,
    /// All frames.
    pub frames: Vec<Frame>,
    /// From the end of each fault that ends before the flight to the first fix, seconds; nothing where there was none.
    pub recovery_s: Vec<Option<f64>>,
}

/// Flies.
///
/// # Errors
/// The scenario cannot be flown, or the board does not boot or answer.
pub fn flown(scenario: Scenario, pair: String) -> Result<Flown, String> {
    let setup = Setup::prepare(scenario).map_err(|error| error.to_string())?;
    let mut link = InProcess::new(&setup.flash).map_err(|error| error.to_string())?;
    let flight = fly(&setup, &mut link, Keep::default(), &mut ()).map_err(|error| error.to_string())?;
    let scored = score(&setup, &flight, &Unrectified::default());
    let resolution_m = setup.scenario.vehicle.resolution_m;
    let last_s = flight.frames.last().map_or(0.0, |record| 1e-6 * record.exposure.mid_us() as f64);
    let ended =
        faults(&setup, &flight, &scored).into_iter().filter(|fault| fault.to_s.is_some_and(|to_s| to_s < last_s));
    Ok(Flown {
        seed: setup.scenario.run.seed,
        pair,
        recovery_s: ended.map(|fault| fault.recovery_s).collect(),
        frames: flight.frames.iter().zip(&scored).map(|(record, scored)| frame(record, scored, resolution_m)).collect(),
    })
}

fn frame(record: &FrameRecord, scored: &Scored, resolution_m: f64) -> Frame {
    let sent = record.report.as_ref().and_then(|report| report.fix);
    let fix = sent.zip(scored.error_m).map(|(sent, error_m)| {
        let variance_m2 = 0.5 * (f64::from(sent.variance_east_m2) + f64::from(sent.variance_north_m2));
        Fix {
            off_px: length(error_m) / resolution_m,
            sigma_px: variance_m2.sqrt() / resolution_m,
            nees: scored.nees.unwrap_or(f64::INFINITY),
            is_wrong: scored.is_wrong(resolution_m),
            is_beyond: scored
                .place
                .is_some_and(|place| length(error_m) > place.protection_m || place.protection_m.is_nan()),
        }
    });
    Frame { at_s: 1e-6 * record.exposure.mid_us() as f64, fix, reason: reason(record), place: scored.place }
}
