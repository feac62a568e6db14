//! Fixes over a map that lies beside the ground as a whole. No single frame can know of it: each such fix is off by the map's
//! shift, and counts as wrong where that is more than a fix may be off. What the matching did is seen against the map as it lies.

use super::statistics::mean;
use super::{Scored, squared_sigmas};
use crate::run::{Flight, FrameRecord};
use crate::setup::Setup;
use serde::Serialize;

/// `shifted` of `report.json`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Shifted {
    /// What the map is off by, `reference.bias_m`.
    pub bias_m: [f64; 2],
    /// As [`super::Summary::wrong_fixes`], against the truth plus the shift.
    pub wrong_fixes: usize,
    /// As [`super::Summary::nees_mean`], likewise.
    pub nees_mean: Option<f64>,
}

/// Counts the fixes of a flight; `None` where the map lies right.
pub(super) fn shifted(setup: &Setup, flight: &Flight, scored: &[Scored]) -> Option<Shifted> {
    let bias_m = setup.scenario.world.reference.bias_m;
    if bias_m == [0.0; 2] {
        return None;
    }
    let against_map = |(record, scored): (&FrameRecord, &Scored)| {
        let fix = record.report?.fix?;
        let [east_m, north_m] = scored.error_m?;
        let error_m = [east_m - bias_m[0], north_m - bias_m[1]];
        Some(Scored { error_m: Some(error_m), nees: Some(squared_sigmas(&fix, error_m)), ..*scored })
    };
    let beside: Vec<Scored> = flight.frames.iter().zip(scored).filter_map(against_map).collect();
    let resolution_m = setup.scenario.vehicle.resolution_m;
    Some(Shifted {
        bias_m,
        wrong_fixes: beside.iter().filter(|scored| scored.is_wrong(resolution_m)).count(),
        nees_mean: mean(&beside.iter().filter_map(|scored| scored.nees).collect::<Vec<_>>()),
    })
}
