//! Whether sigma is what the fit is off by.

use super::{fitted, near};
use plumbline_survey::smooth::Alpha;
use plumbline_tests::seeded::Random;

/// Curves whose second differences are as random as the penalty takes them to be: for these sigma is exact, at samples
/// and between. Mean of (error / sigma)² over 200 curves of 120 samples, whose errors are independent over some 5 of them,
/// so that it scatters by √(2 / 5000) = 0.02.
#[test]
fn squares_of_errors_are_sigma_squared() {
    let mut random = Random::new(21);
    let alpha = 4.0f64;
    let (mut at_samples, mut between, mut sigma0s) = (0.0, 0.0, 0.0);
    let runs = 200;
    for _ in 0..runs {
        let (mut value, mut slope) = (0.0, 0.0);
        let mut truth = Vec::new();
        for _ in 0..120 {
            truth.push(value);
            slope += random.normal() / alpha.sqrt();
            value += slope;
        }
        let t_s: Vec<f64> = (0..120).map(f64::from).collect();
        let observed: Vec<f64> = truth.iter().map(|truth| truth + random.normal()).collect();
        let fit = fitted(&t_s, &observed, 2, Alpha::Given(alpha));
        sigma0s += fit.sigma0 * fit.sigma0 / f64::from(runs);
        // The curve between its samples, where second differences are all there is: the spline through the true values.
        let exact = fitted(&t_s, &truth, 2, Alpha::Given(1e-9));
        for (i, truth) in truth.iter().enumerate().take(115).skip(5) {
            let here = fit.at_sample(i);
            at_samples += ((here.value - truth) / here.sigma).powi(2) / 110.0 / f64::from(runs);
            let t = i as f64 + 0.5;
            let here = fit.at(t).expect("inside");
            between +=
                ((here.value - exact.at(t).expect("inside").value) / here.sigma).powi(2) / 110.0 / f64::from(runs);
        }
    }
    near(at_samples, 1.0, 0.06, "at samples");
    near(between, 1.0, 0.06, "between");
    near(sigma0s, 1.0, 0.03, "sigma0");
}
