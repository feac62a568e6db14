//! What the frames cost.

use super::Scored;
use super::statistics::mean;
use crate::run::Flight;
use plumbline_firmware::wire::telemetry::STAGES;
use serde::{Serialize, Serializer};

/// Mean and maximum.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Cost {
    /// Mean.
    pub mean: Option<f64>,
    /// Maximum.
    pub max: Option<u64>,
}

/// Instructions or cycles of the stages that the firmware counts apart, in their order; see
/// [`STAGES`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stages(pub [f64; STAGES.len()]);

impl Serialize for Stages {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_map(STAGES.iter().zip(&self.0))
    }
}

/// What accepted frames cost, in whatever unit the board counts.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Costs {
    pub per_frame: Cost,
    pub by_stage: Option<Stages>,
}

impl Costs {
    pub fn of(flight: &Flight, accepted: &[&Scored]) -> Self {
        let costs: Vec<u64> = accepted.iter().filter_map(|s| s.cost).collect();
        let by_stage = (!costs.is_empty()).then(|| {
            let reports: Vec<_> = flight.frames.iter().filter_map(|f| f.report).filter(|r| r.fix.is_some()).collect();
            Stages(std::array::from_fn(|stage| {
                reports.iter().map(|r| f64::from(r.instructions[stage])).sum::<f64>() / reports.len().max(1) as f64
            }))
        });
        let mean = mean(&costs.iter().map(|&cost| cost as f64).collect::<Vec<_>>());
        Costs { per_frame: Cost { mean, max: costs.iter().copied().max() }, by_stage }
    }
}
