//! What the observations say before the heads are calibrated.

use plumbline_survey::adjust::rig::{HEAD, Rig, Station, project};
use plumbline_survey::adjust::{Adjustment, Options};
use plumbline_survey::calibrate::{Block, Observations};

/// Observed minus computed, x right and y up, pixels, one an observation; `None` where the point is not in front of the head.
pub type Residuals = Vec<Option<[f64; 2]>>;

/// Residuals before the calibration.
#[derive(Clone, Debug)]
pub struct Before {
    /// At the block's start values, all of them.
    pub at_start: Residuals,
    /// Stations and points adjusted to heads that stay as they were designed: what a camera that was never calibrated leaves.
    /// `None` where that adjustment does not come to an end.
    pub designed: Option<Residuals>,
}

impl Before {
    /// Projects the block at its start values, and adjusts it without any unknown of a head.
    #[must_use]
    pub fn new(block: &Block, observations: &Observations) -> Self {
        let mut rigid = block.clone();
        rigid.heads.iter_mut().for_each(|head| head.free.clear());
        let rig = rigid.rig(&observations.seen);
        let start = rig.start();
        let at_start = residuals(&rig, &start);
        let designed = if start.is_empty() { Some(start) } else { adjusted(&rig, block, start) };
        Before { at_start, designed: designed.map(|x| residuals(&rig, &x)) }
    }

    /// Those that show what the design does.
    #[must_use]
    pub fn shown(&self) -> &Residuals {
        self.designed.as_ref().unwrap_or(&self.at_start)
    }
}

fn adjusted(rig: &Rig, block: &Block, start: Vec<f64>) -> Option<Vec<f64>> {
    let options = Options { loss: block.loss, ..Options::default() };
    let solution = Adjustment::new(rig, block.loss).ok()?.solve(start, &options, &mut |_, _| {});
    solution.ok().map(|solution| solution.x)
}

fn residuals(rig: &Rig, x: &[f64]) -> Residuals {
    let heads: Vec<[f64; HEAD]> = (0..rig.heads.len()).map(|head| rig.head(x, head)).collect();
    let residual = |seen: &plumbline_survey::adjust::rig::Observation| {
        let station = Station { values: rig.station(x, seen.station), ..rig.stations[seen.station] };
        let computed = project(&heads[seen.head], &station, rig.point(x, seen.point))?;
        Some([0, 1].map(|k| seen.image_px[k] - computed[k]))
    };
    rig.observations.iter().map(residual).collect()
}
