//! A problem of Bundle Adjustment in the Large, where the shared data hold it.

use plumbline_survey::adjust::bal::Bal;
use plumbline_survey::adjust::{Adjustment, Loss, Options};
use plumbline_survey::io::data;

#[test]
fn sixteen_cameras() {
    let Some(problem) = data::for_test("sixteen_cameras", "ba/problem-16-22106-pre.txt") else { return };
    let bal = Bal::read(&problem).expect("a problem");
    let adjustment = Adjustment::new(&bal, Loss::Squares).expect("laid out");
    let options = Options { damping: 1e-4, gain_min: 1e-6, ..Options::default() };
    let solution = adjustment.solve(bal.start(), &options, &mut |_, _| {}).expect("solved");
    assert!((solution.cost_start / 4.185660e6 - 1.0).abs() < 1e-6, "{}", solution.cost_start);
    // Ceres' documents end at 1.803391e4, scipy's trust region at 1.803396e4.
    assert!(solution.cost_end <= 1.80340e4, "{}", solution.cost_end);
    assert!(solution.iterations < 20, "{}", solution.iterations);
}
