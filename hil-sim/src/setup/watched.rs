//! What whoever watches a flight may ask of it.

use super::Setup;
use crate::link::mirror::{Knowledge, Waypoint};
use crate::vehicle::autopilot::parameters::Parameters;

impl Setup {
    /// The waypoints of a flight along a plan or kept by its fixes, where the grid can say where on Earth they are, and the simulated
    /// autopilot's parameters.
    #[must_use]
    pub fn knowledge(&self) -> Knowledge {
        let (points, is_round) = match (&self.plan, &self.course) {
            (Some(plan), _) => (plan.lines.iter().flat_map(|line| line.way()).collect(), false),
            (None, Some(course)) => (course.waypoints.iter().map(|[e, n]| [*e, *n, course.up_m]).collect(), true),
            (None, None) => (Vec::new(), false),
        };
        let waypoint = |[east, north, up]: [f64; 3]| {
            let (lat, lon) = self.crs.to_wgs84(east, north).ok()?;
            Some(Waypoint { place_e7: [lat, lon].map(|deg| (deg * 1e7).round() as i32), up_m: up as f32 })
        };
        let waypoints: Option<Vec<Waypoint>> = points.into_iter().map(waypoint).collect();
        let autopilot = &self.scenario.world.autopilot;
        let parameters =
            Parameters::new(autopilot.loop_rate_hz, &self.scenario.faults.autopilot_faults.parameters).all();
        Knowledge { waypoints: waypoints.unwrap_or_default(), is_round, parameters }
    }
}
