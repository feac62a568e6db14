//! What a plan may be and nobody means, and what it rests on unseen: told on stderr and on the page, whatever is planned.

use super::request::Prepared;
use plumbline_survey::plan::PlanFile;

/// Highest flight over the base plane that is not asked about: above it a vehicle of this kind is rarely let fly.
const HEIGHT_M: f64 = 1000.0;
/// Pixels on the ground between which nothing is asked, metres.
const GSD_M: [f64; 2] = [0.003, 10.0];

/// A question a line, each with what else may have been meant.
pub fn questions(prepared: &Prepared, plan: &PlanFile) -> Vec<String> {
    let mut questions: Vec<String> = prepared.camera.doubt().into_iter().collect();
    if plan.height_m > HEIGHT_M {
        questions.push(format!(
            "{:.0} m above the {}: is that meant? --gsd-m is metres a pixel, --scale the denominator alone, and the camera file has degrees",
            plan.height_m,
            if plan.follow.is_some() { "ground" } else { "base plane" }
        ));
    }
    if let Some([height_m, _]) = prepared.dem.range_m()
        && prepared.dem.is_level()
        && prepared.heights_doubt.is_none()
    {
        questions.push(format!(
            "the elevation model has the height {height_m} m throughout: is that meant? An empty export has one height, too"
        ));
    }
    // Where the ground there may be too near, it is a danger.
    if plan.checks.leaves_model && plan.checks.strips_off_dem == 0 && plan.checks.near_beyond_m().is_none() {
        questions.push(
            "the ends of strips or the turns reach beyond the elevation model: the clearance there is not known; a larger elevation model, a \
             smaller area or, for narrower turns, a lower --speed-m-s tells it"
                .to_owned(),
        );
    }
    if plan.gsd_m < GSD_M[0] || plan.gsd_m > GSD_M[1] {
        questions.push(format!(
            "a pixel is {:.4} m on the ground: is that meant? --gsd-m and --height-m are metres",
            plan.gsd_m
        ));
    }
    questions
}
