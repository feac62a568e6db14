//! What each timed fault did to the fixes: `faults` of `report.json`.

use super::Scored;
use crate::run::Flight;
use crate::scenario::Fault;
use crate::setup::Setup;
use serde::Serialize;

/// How long after a fault it is told how many fixes came again, microseconds.
const AFTER_US: u64 = 10_000_000;

/// One fault and the frames in and after it, by the middle of their exposures.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FaultScore {
    /// The fault in a word, as `--fault` takes it.
    pub spec: String,
    /// Its first second.
    pub from_s: f64,
    /// Its end; null where it lasted to the end of the flight.
    pub to_s: Option<f64>,
    /// Frames in it.
    pub frames: usize,
    /// Fixes in it.
    pub accepted: usize,
    /// Fixes in it that were wrong, as `wrong_fixes` counts them.
    pub wrong: usize,
    /// Frames in the ten seconds after it.
    pub frames_after: usize,
    /// Fixes in the ten seconds after it.
    pub accepted_after: usize,
    /// Of these wrong ones.
    pub wrong_after: usize,
    /// Seconds from its end to the first fix; null where there was none, or no end.
    pub recovery_s: Option<f64>,
}

/// Every fault of a flight, in the order in which they were given.
pub fn faults(setup: &Setup, flight: &Flight, scored: &[Scored]) -> Vec<FaultScore> {
    let frames: Vec<(u64, &Scored)> = flight.frames.iter().map(|record| record.exposure.mid_us()).zip(scored).collect();
    let resolution_m = setup.scenario.vehicle.resolution_m;
    setup.scenario.faults.timed.all().iter().map(|fault| of_frames(fault, &frames, resolution_m)).collect()
}

fn of_frames(fault: &Fault, frames: &[(u64, &Scored)], resolution_m: f64) -> FaultScore {
    let (from_us, to_us) = (fault.from_us(), fault.to_us());
    let count = |begin_us: u64, end_us: u64, wanted: &dyn Fn(&Scored) -> bool| {
        frames.iter().filter(|(at_us, scored)| (begin_us..end_us).contains(at_us) && wanted(scored)).count()
    };
    let [during, after] = [(from_us, to_us), (to_us, to_us.saturating_add(AFTER_US))].map(|(begin_us, end_us)| {
        let fixes = count(begin_us, end_us, &|scored| scored.accepted);
        let wrong = count(begin_us, end_us, &|scored| scored.accepted && scored.is_wrong(resolution_m));
        (count(begin_us, end_us, &|_| true), fixes, wrong)
    });
    let first = frames.iter().find(|(at_us, scored)| *at_us >= to_us && scored.accepted);
    FaultScore {
        spec: fault.to_string(),
        from_s: fault.from_s,
        to_s: fault.to_s,
        frames: during.0,
        accepted: during.1,
        wrong: during.2,
        frames_after: after.0,
        accepted_after: after.1,
        wrong_after: after.2,
        recovery_s: first.map(|(at_us, _)| 1e-6 * (at_us - to_us) as f64),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scored(accepted: bool, off_m: f64) -> Scored {
        Scored {
            frame: 0,
            accepted,
            truth_px: None,
            error_px: None,
            integer_px: None,
            raw_px: None,
            error_m: accepted.then_some([off_m, 0.0]),
            nees: accepted.then_some(1.0),
            attitude_px: None,
            place: None,
            cost: None,
        }
    }

    /// A frame a second; pixels of a metre.
    #[test]
    fn frames_count_where_their_middles_lie() {
        let all: Vec<Scored> = (0..30)
            .map(|second| scored(!(10..20).contains(&second) || second == 12, if second == 12 { 9.0 } else { 0.1 }))
            .collect();
        let frames: Vec<(u64, &Scored)> = (0..).step_by(1_000_000).zip(&all).collect();
        let score = |word: &str| of_frames(&word.parse().expect("a fault"), &frames, 1.0);
        let of = score("range.off@10..15.5");
        assert_eq!((of.frames, of.accepted, of.wrong), (6, 1, 1));
        assert_eq!((of.frames_after, of.accepted_after, of.wrong_after, of.recovery_s), (10, 6, 0, Some(4.5)));
        let whole = score("range.off");
        assert_eq!((whole.frames, whole.accepted, whole.recovery_s, whole.frames_after), (30, 21, None, 0));
        assert_eq!((whole.spec.as_str(), whole.to_s), ("range.off@0..", None));
    }
}
