//! `poses.csv`: what an independent navigation without error would have logged at the board's stamps. It is the truth.
//!
//! A row a frame that has a stamp: the antenna, which fixes are the place of, on their grid; the camera's height above the
//! ground; heading from grid north, pitch, roll and follow-up angle.

use crate::run::Flight;
use crate::setup::Setup;
use crate::vehicle::motion::Motion;
use crate::vehicle::mount::antenna;
use std::fmt::Write;

/// The table of a flight.
#[must_use]
pub fn csv(setup: &Setup, flight: &Flight) -> String {
    let mut csv = "mid_exposure_us,east_m,north_m,height_m,heading_deg,pitch_deg,roll_deg,follow_up_deg\n".to_owned();
    let flown = flight.motion.clone().map(Motion::recorded);
    let motion = flown.as_ref().unwrap_or(&setup.motion);
    let stamps = flight.frames.iter().filter_map(|record| Some(record.report?.mid_exposure_us));
    // A frame without a stamp is reported as 0.
    for at_us in stamps.filter(|at_us| *at_us > 0) {
        let state = motion.state(at_us);
        let [east_m, north_m, _] = antenna(&state, &setup.payload.mount);
        let height_m = state.up_m - setup.ground.height(state.east_m, state.north_m);
        let angles = [state.heading_rad, state.pitch_rad, state.roll_rad, state.follow_up_rad].map(f64::to_degrees);
        let [heading, pitch, roll, follow_up] = angles;
        // Writing to a string cannot fail.
        let _ = writeln!(csv, "{at_us},{east_m},{north_m},{height_m},{heading},{pitch},{roll},{follow_up}");
    }
    csv
}
