//! An attitude that is off by more than it is stated to be, from the beginning to the end.

use super::{in_process, scenario};
use plumbline_sim::setup::Setup;

/// Pitch and roll one degree off, stated to 0.2: after turns fixes hold it.
#[test]
fn turns_find_a_constant_attitude_error() {
    for seed in [2, 8] {
        let mut scenario = scenario(&["attitude.drift_deg=0.2"]);
        scenario.run.seed = seed;
        scenario.run.frames = 254;
        scenario.faults.timed.push("attitude.bias=1".parse().expect("a fault"));
        let flown = in_process(&Setup::prepare(scenario).expect("it can be flown"));
        let columns = ["mid_exposure_us", "d_col", "true_col", "sigma_east_m", "d_row", "true_row", "sigma_north_m"];
        let fixes = flown.fixes(columns);
        let late: Vec<&[f64; 7]> = fixes.iter().filter(|fix| fix[0] * 1e-6 >= 100.0).collect();
        let mean = |of: fn(&[f64; 7]) -> f64| late.iter().map(|fix| of(fix)).sum::<f64>() / late.len() as f64;
        // Two metres a pixel.
        let squares_m2 = mean(|fix| 4.0 * ((fix[1] - fix[2]).powi(2) + (fix[4] - fix[5]).powi(2)));
        let squares =
            mean(|fix| (2.0 * (fix[1] - fix[2]) / fix[3]).powi(2) + (2.0 * (fix[4] - fix[5]) / fix[6]).powi(2));
        // One degree of both angles 120 m up is 3 m. Of two degrees of freedom the squares are to be two.
        assert!(squares_m2.sqrt() < 1.5 && squares < 4.0, "{seed}: {} m, {squares}", squares_m2.sqrt());
        assert!(flown.summary.accepted >= 240, "{seed}: {}", flown.summary.accepted);
    }
}
