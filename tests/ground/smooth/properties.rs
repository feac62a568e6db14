//! What holds whatever the samples are.

use super::{fitted, near, order_of};
use plumbline_survey::smooth::{Alpha, Epochs, Fit, Options, smooth};
use plumbline_tests::seeded::{Random, config};
use proptest::prelude::{Strategy, any, prop_assert, proptest};

/// Uneven or even instants and noisy samples, a weight each of which some are 0.
#[derive(Clone, Debug)]
struct Case {
    t_s: Vec<f64>,
    values: Vec<f64>,
    weights: Vec<f64>,
    d: usize,
    alpha: f64,
}

impl Case {
    fn fit(&self) -> Fit {
        let epochs = Epochs::new(self.t_s.clone()).expect("forward");
        let options = Options { gap_s: Some(1e3), ..Options::new(order_of(self.d), Alpha::Given(self.alpha)) };
        smooth(&epochs, &self.values, &self.weights, &options).expect("good samples")
    }
}

fn case() -> impl Strategy<Value = Case> {
    (any::<u64>(), 8usize..60, any::<bool>(), 2usize..4, -2.0..4.0).prop_map(
        |(seed, n, uniform, d, log_alpha): (u64, usize, bool, usize, f64)| {
            let mut random = Random::new(seed);
            let mut t = random.between(-50.0, 50.0);
            let mut next = || {
                t += if uniform { 0.25 } else { random.between(0.05, 0.5) };
                t
            };
            let t_s: Vec<f64> = (0..n).map(|_| next()).collect();
            let values = (0..n).map(|_| 10.0 * random.normal()).collect();
            // No more than every second one is missing.
            let weight = |i: usize| if i % 2 == 1 && random.uniform() < 0.3 { 0.0 } else { random.between(0.2, 5.0) };
            let weights = (0..n).map(weight).collect();
            Case { t_s, values, weights, d, alpha: 10f64.powf(log_alpha) }
        },
    )
}

/// 60 samples at a condition number below 64e4, uneven spacings 10^5 worse: 1e11 2^-53 of 30 at the very worst, of which
/// the worst case here needs a hundredth.
const ROUNDING: f64 = 1e-6;

proptest! {
    #![proptest_config(config(31, 200))]

    #[test]
    fn a_shift_a_slope_and_a_scale_go_through(case in case(), shift in -1e3..1e3f64, slope in -10.0..10.0f64, scale in 0.1..10.0f64) {
        let line = |t: f64| shift + slope * t;
        let moved = Case {
            values: case.values.iter().zip(&case.t_s).map(|(value, t)| scale * value + line(*t)).collect(),
            ..case.clone()
        };
        let (a, b) = (case.fit(), moved.fit());
        for (i, t) in case.t_s.iter().enumerate() {
            prop_assert!((scale * a.values[i] + line(*t) - b.values[i]).abs() < ROUNDING * scale.max(1.0));
        }
        prop_assert!((a.edf - b.edf).abs() < 1e-9 && (scale * a.sigma0 - b.sigma0).abs() < ROUNDING * scale.max(1.0));
    }

    #[test]
    fn polynomials_below_the_order_stay(case in case(), c in [-5.0..5.0f64, -5.0..5.0, -5.0..5.0]) {
        let middle = case.t_s[0];
        let polynomial = |t: f64| {
            let x = t - middle;
            c[0] + x * (c[1] + if case.d == 3 { x * c[2] } else { 0.0 })
        };
        let fit = Case { values: case.t_s.iter().map(|t| polynomial(*t)).collect(), ..case.clone() }.fit();
        for (i, t) in case.t_s.iter().enumerate() {
            let (estimate, wanted) = (fit.at_sample(i), polynomial(*t));
            prop_assert!((estimate.value - wanted).abs() < 1e-9, "{i}: {estimate:?} {wanted}");
        }
    }

    #[test]
    fn time_may_begin_anywhere_and_run_backwards(case in case(), shift in -1e4..1e4f64) {
        let a = case.fit();
        let mut mirrored = case.clone();
        mirrored.t_s = case.t_s.iter().rev().map(|t| shift - t).collect();
        mirrored.values.reverse();
        mirrored.weights.reverse();
        let b = mirrored.fit();
        let n = case.t_s.len();
        for i in 0..n {
            // Instants are rounded to 1e-12 s by the shift, slopes reach 1e3.
            prop_assert!((a.values[i] - b.values[n - 1 - i]).abs() < 1e-6);
            let (forth, back) = (a.at_sample(i), b.at_sample(n - 1 - i));
            prop_assert!((forth.rate + back.rate).abs() < 1e-4 && (forth.sigma - back.sigma).abs() < 1e-6);
        }
    }

    #[test]
    fn values_sigmas_and_rates_run_on_between_samples(case in case(), at in 0.0..1.0f64) {
        let fit = case.fit();
        let (first, last) = (case.t_s[0], case.t_s[case.t_s.len() - 1]);
        let step = 1e-6;
        let t = first + step + at * (last - first - 2.0 * step);
        let [before, here, after] = [t - step, t, t + step].map(|t| fit.at(t).expect("inside"));
        prop_assert!(here.sigma > 0.0 && (after.sigma - before.sigma).abs() < 1e-3 * here.sigma.max(1.0));
        prop_assert!(((after.value - before.value) / (2.0 * step) - here.rate).abs() < 1e-3 * (1.0 + here.rate.abs()));
    }

    #[test]
    fn more_smoothing_leaves_fewer_parameters_and_larger_residuals(case in case()) {
        let (a, b) = (case.fit(), Case { alpha: 2.0 * case.alpha, ..case.clone() }.fit());
        prop_assert!(a.edf > b.edf && a.vpv < b.vpv && b.edf > case.d as f64 - 1e-9);
    }
}

/// A weight of two is two samples at one place, half as uncertain; the residuals' own scatter is in sigma0.
#[test]
fn weights_scale_with_alpha() {
    let case = Case {
        t_s: (0..20).map(|i| 0.1 * f64::from(i)).collect(),
        values: (0..20).map(|i| f64::from(i * i % 7)).collect(),
        weights: vec![1.0; 20],
        d: 2,
        alpha: 3.0,
    };
    let heavier = Case { weights: vec![4.0; 20], alpha: 12.0, ..case.clone() };
    let (a, b) = (case.fit(), heavier.fit());
    for i in 0..20 {
        near(a.values[i], b.values[i], 1e-12, "value");
        near(a.at_sample(i).sigma, b.at_sample(i).sigma, 1e-12, "sigma");
    }
    near(2.0 * a.sigma0, b.sigma0, 1e-12, "sigma0");
}

/// GCV of noise about a line usually smooths all it can, and says so; now and then chance looks like a curve.
#[test]
fn gcv_at_its_bounds() {
    let t_s: Vec<f64> = (0..200).map(f64::from).collect();
    let fits = (0..21).map(|seed| {
        let mut random = Random::new(seed);
        let noise: Vec<f64> = t_s.iter().map(|t| 0.1 * t + random.normal()).collect();
        fitted(&t_s, &noise, 2, Alpha::Gcv)
    });
    let fits: Vec<Fit> = fits.collect();
    let at_bound: Vec<&Fit> = fits.iter().filter(|fit| fit.alpha_at_bound).collect();
    assert!(fits.iter().filter(|fit| fit.edf < 4.0).count() > 10);
    assert!(!at_bound.is_empty() && at_bound.iter().all(|fit| fit.edf < 2.01));
    // Deviation 1 / √(2 200 21) over all.
    let mean = fits.iter().map(|fit| fit.sigma0).sum::<f64>() / 21.0;
    assert!((mean - 1.0).abs() < 0.04, "{mean}");
}
