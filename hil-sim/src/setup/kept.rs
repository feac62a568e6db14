//! Where a flight goes that is kept by its fixes.

use crate::scenario::Scenario;
use crate::vehicle::aloft::Course;
use crate::vehicle::motion::{Area, TrueState};
use plumbline_survey::error::InputError;

/// Of the area that can be flown over, the sides of the rectangle that is flown where no waypoints are given: 2 to 3, and so much of
/// the area that turns, in wind too, stay inside. Chosen.
const LONG: f64 = 0.7;
const SHORT: f64 = 0.5;

/// The waypoints on the grid, and the height in the middle of the scenario's.
///
/// # Errors
/// One sentence for a waypoint beyond the area that can be flown over.
pub(super) fn course(scenario: &Scenario, area: &Area) -> Result<Option<Course>, InputError> {
    let Some(navigation) = &scenario.world.navigation else { return Ok(None) };
    if let Some(replay) = &scenario.run.replay {
        return Err(InputError::new(format!(
            "{}: a recorded attitude cannot be replayed with [navigation], which decides the attitude itself",
            replay.att.display()
        )));
    }
    let half_m = area.half_extent_m;
    if let Some([east, north]) = navigation.waypoints.iter().find(|point| point.iter().any(|m| m.abs() > half_m)) {
        return Err(InputError::new(format!(
            "{}: navigation.waypoints has [{east}, {north}], but frames see beyond the ground further than {half_m:.0} m east, \
             north, south or west of the middle",
            scenario.file
        )));
    }
    let (east, north) = (LONG * half_m, SHORT * half_m);
    let rectangle = vec![[-east, -north], [-east, north], [east, north], [east, -north]];
    let points = if navigation.waypoints.is_empty() { &rectangle } else { &navigation.waypoints };
    let [low_m, high_m] = scenario.run.flight.height_m;
    Ok(Some(Course {
        waypoints: points.iter().map(|[e, n]| [area.centre_east_m + e, area.centre_north_m + n]).collect(),
        up_m: area.base_up_m + 0.5 * (low_m + high_m),
        base_up_m: area.base_up_m,
    }))
}

/// Where it begins.
pub(super) fn start(course: &Course) -> TrueState {
    let [east_m, north_m] = course.waypoints.first().copied().unwrap_or_default();
    TrueState { east_m, north_m, up_m: course.up_m, ..TrueState::default() }
}
