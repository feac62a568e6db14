//! One window: golden values of the reference (adjustment, 1.5), single precision against double, errors, mistakes.

use super::dense::{Uniform, between, fitted};
use crate::pose::band::WINDOW;
use crate::pose::fit::{FitError, Fitted, Samples};
use crate::pose::penalty::{ALPHA_MAX, Order};
use proptest::prelude::{prop_assert, proptest};
use proptest::test_runner::{Config, RngSeed};
use std::println;
use std::vec;
use std::vec::Vec;

/// Sigma of uniform noise within ±0.25 m, the reference's.
const NOISE: f64 = 0.144_337_567;

fn order(number: usize) -> Order {
    if number == 2 { Order::Second } else { Order::Third }
}

/// The core's fit of `values` at unit spacing, at `at` samples from the first.
fn fit(values: &[f64], number: usize, alpha: f64, at: f64) -> Result<Fitted<1>, FitError> {
    let mut samples = Samples::<1>::new();
    for (i, value) in values.iter().enumerate() {
        samples.push((i as f64 - at) as f32, [*value as f32], 1.0)?;
    }
    samples.fit(order(number), alpha as f32, [0.0])
}

#[test]
fn seven_samples_have_the_reference_s_curve() {
    let samples = [0.0, 1.0, 0.0, 1.0, 0.0, 3.0, 2.0];
    let golden = [
        (2, [0.169990308, 0.364327880, 0.473670299, 0.730858469, 1.131898147, 1.807365855, 2.321889042]),
        (3, [0.258953046, 0.337692563, 0.432938047, 0.674166020, 1.118652333, 1.766263992, 2.411333998]),
    ];
    for (number, curve) in golden {
        for (i, g) in curve.iter().enumerate() {
            let ours = fit(&samples, number, 2.0, i as f64).expect("a fit");
            // A few units in the last place of numbers up to 3.
            assert!((f64::from(ours.value[0]) - g).abs() < 2e-6, "order {number}, sample {i}: {ours:?} for {g}");
        }
    }
}

#[test]
fn eleven_samples_have_the_reference_s_weights() {
    // α = 10, two samples behind the newest, half-way to the one before.
    let golden = [
        -0.027383943,
        -0.014070134,
        0.001982069,
        0.024918074,
        0.058685082,
        0.104738487,
        0.158665172,
        0.205578175,
        0.208474015,
        0.166041393,
        0.112371610,
    ];
    for (k, weight) in golden.iter().enumerate() {
        let impulse: Vec<f64> = (0..golden.len()).map(|i| f64::from(u8::from(i == k))).collect();
        let ours = fit(&impulse, 2, 10.0, 7.5).expect("a fit");
        assert!((f64::from(ours.value[0]) - weight).abs() < 1e-6, "weight {k}: {ours:?} for {weight}");
        let length = golden.iter().map(|w| w * w).sum::<f64>().sqrt();
        assert!((f64::from(ours.gain) - length).abs() < 1e-6, "{} for {length}", ours.gain);
    }
}

/// The reference's heights: 500 m + a wave of 20 s + noise, and how they begin and end.
fn heights() -> Vec<f64> {
    let mut noise = Uniform(1);
    let w = std::f64::consts::TAU / 20.0;
    let z: Vec<f64> =
        (0..301).map(|i| 500.0 + 10.0 / w * (0.7 + w * 0.2 * f64::from(i)).sin() + noise.noise()).collect();
    assert!((z[0] - 520.539366658).abs() < 1e-8 && (z[300] - 520.615683202).abs() < 1e-8, "{} {}", z[0], z[300]);
    z
}

#[test]
fn the_judge_has_the_reference_s_curve() {
    let z = heights();
    for (number, alpha, golden) in [
        (2, 10.0, [520.797963458, 479.464873804, 520.704711723]),
        (2, 1000.0, [523.867274777, 479.803588307, 521.178707734]),
        (3, 1000.0, [520.521668242, 479.495815958, 520.777227569]),
    ] {
        let g = fitted(&z, &[1.0; 301], number, alpha);
        for (at, golden) in [0, 150, 300].into_iter().zip(golden) {
            assert!((g[at] - golden).abs() < 1e-8, "order {number}, alpha {alpha}, sample {at}: {}", g[at]);
        }
    }
}

/// Single precision is off by no more than a thousandth of the noise, whatever the window, the lag, and α up to its limit.
#[test]
fn single_precision_is_a_thousandth_of_the_noise() {
    let z = heights();
    for number in [2, 3] {
        let largest = f64::from(ALPHA_MAX);
        for alpha in [1.0, 10.0, 100.0, 1000.0, largest] {
            let mut worst = 0.0f64;
            for window in z.windows(WINDOW).step_by(5) {
                let judge = fitted(window, &[1.0; WINDOW], number, alpha);
                for at in [2.3, 10.0, 15.5, 17.5, 19.0, 20.0] {
                    let ours = fit(&window.iter().map(|v| v - window[10]).collect::<Vec<_>>(), number, alpha, at);
                    let ours = f64::from(ours.expect("a fit").value[0]) + window[10];
                    worst = worst.max((ours - between(&judge, at)).abs());
                }
            }
            println!("order {number}, alpha {alpha}: {worst:.2e} m, {:.1e} of the noise", worst / NOISE);
            assert!(worst <= 1e-3 * NOISE, "order {number}, alpha {alpha}: {worst} m");
        }
    }
}

#[test]
fn bad_windows_are_refused_by_name() {
    let few = [1.0, 2.0, 3.0, 4.0];
    assert_eq!(fit(&few, 2, 1.0, 2.0).err(), Some(FitError::TooFew));
    assert_eq!(fit(&few[..1], 2, 1.0, 0.0).err(), Some(FitError::TooFew));
    let five = [1.0, 2.0, 4.0, 3.0, 5.0];
    assert!(fit(&five, 2, 1.0, 2.0).is_ok());
    assert_eq!(fit(&five, 3, 1.0, 2.0).err(), Some(FitError::TooFew));
    for alpha in [0.0, -1.0, f64::NAN, f64::INFINITY, 1e9] {
        assert_eq!(fit(&five, 2, alpha, 2.0).err(), Some(FitError::Alpha), "{alpha}");
    }
    for at in [-0.1, 6.1] {
        assert_eq!(fit(&five, 2, 1.0, at).err(), Some(FitError::Outside), "{at}");
    }
    assert_eq!(fit(&[0.0; 22], 2, 1.0, 2.0).err(), Some(FitError::TooMany));
    let mut samples = Samples::<1>::new();
    samples.push(-1.0, [0.0], 1.0).expect("a sample");
    assert_eq!(samples.push(-1.0, [0.0], 1.0), Err(FitError::Backwards));
    assert_eq!(samples.push(-2.0, [0.0], 1.0), Err(FitError::Backwards));
    for (time, value, weight) in
        [(f32::NAN, 0.0, 1.0), (0.0, f32::INFINITY, 1.0), (0.0, 0.0, -1.0), (0.0, 0.0, f32::NAN)]
    {
        assert_eq!(samples.push(time, [value], weight), Err(FitError::NotANumber), "{time} {value} {weight}");
    }
    // Weights of zero do not count: a channel of them is of no rank.
    let mut hollow = Samples::<1>::new();
    for i in 0..9 {
        hollow.push(i as f32 - 4.0, [1.0], f32::from(u8::from(i % 4 == 0))).expect("a sample");
    }
    assert_eq!(hollow.fit(Order::Second, 1.0, [1.0]).err(), Some(FitError::TooFew));
}

/// A sample far off the others is left out, and the curve is that of a window in which it has no weight.
#[test]
fn mistakes_are_left_out() {
    let mut noise = Uniform(7);
    for bad in [0, 3, 9, 14, 20] {
        for size in [3.0, 30.0, 3000.0] {
            let mut values: Vec<f64> = (0..WINDOW).map(|i| 0.3 * i as f64 + noise.noise()).collect();
            values[bad] += size;
            let mut weights = [1.0; WINDOW];
            weights[bad] = 0.0;
            let judge = between(&fitted(&values, &weights, 2, 30.0), 16.5);
            let mut samples = Samples::<1>::new();
            for (i, value) in values.iter().enumerate() {
                samples.push(i as f32 - 16.5, [*value as f32], 1.0).expect("a sample");
            }
            let ours = samples.fit(Order::Second, 30.0, [NOISE as f32]).expect("a fit");
            assert_eq!(ours.rejected, 1, "sample {bad} off by {size} m");
            assert!((f64::from(ours.value[0]) - judge).abs() < 1e-3 * NOISE, "{ours:?} for {judge}");
        }
    }
}

#[test]
fn good_samples_are_not_left_out() {
    let mut noise = Uniform(8);
    let mut rejected = 0u32;
    for _ in 0..2000 {
        let mut samples = Samples::<1>::new();
        for i in 0..WINDOW {
            samples.push(i as f32 - 16.5, [noise.noise() as f32], 1.0).expect("a sample");
        }
        let ours = samples.fit(Order::Second, 30.0, [NOISE as f32]).expect("a fit");
        rejected += u32::from(ours.rejected);
        // The largest uniform number is at 1.73 sigmas, a normal one's median at 0.67.
        assert!((0.0..2.57).contains(&ours.scale), "{ours:?}");
    }
    assert_eq!(rejected, 0, "uniform noise ends at 1.7 sigma");
}

proptest! {
    #![proptest_config(Config { cases: 500, rng_seed: RngSeed::Fixed(11), failure_persistence: None, ..Config::default() })]

    /// What the penalty does not see comes back as it was, at any spacing: lines with second differences, parabolas with
    /// third ones; value and rate.
    #[test]
    fn polynomials_pass(steps in proptest::collection::vec(0.3f64..3.0, 6..20), at in 0.0f64..1.0, log_alpha in -2.0f64..3.0,
                        a in -5.0f64..5.0, b in -5.0f64..5.0, c in -1.0f64..1.0) {
        let mut times = vec![0.0];
        for step in &steps {
            times.push(times[times.len() - 1] + step);
        }
        let at = at * times[times.len() - 1];
        for number in [2, 3] {
            let c = if number == 3 { c } else { 0.0 };
            let mut samples = Samples::<1>::new();
            for t in &times {
                let t = t - at;
                prop_assert!(samples.push(t as f32, [(a + b * t + c * t * t) as f32], 1.0).is_ok());
            }
            let ours = samples.fit(order(number), 10f64.powf(log_alpha) as f32, [0.0]);
            let Ok(ours) = ours else { return Err(proptest::test_runner::TestCaseError::fail("no fit")) };
            let size = times.iter().map(|t| (a + b * (t - at) + c * (t - at) * (t - at)).abs()).fold(1.0, f64::max);
            // Rounding of the values, 6e-8 of the largest, which the system's condition enlarges.
            prop_assert!((f64::from(ours.value[0]) - a).abs() < 2e-4 * size, "{ours:?} for {a}");
            prop_assert!((f64::from(ours.rate[0]) - b).abs() < 1e-3 * size, "{ours:?} for {b}");
        }
    }
}

/// Samples that follow each other at once, as after a jam on the link, make a stiff curve's equations too ill for single
/// precision. What is given is a mean of samples all the same, at most a sample's noise; else it is refused.
#[test]
fn bunched_samples_are_fitted_well_or_not_at_all() {
    let mut random = Uniform(1);
    let (mut fits, mut refused) = (0, 0);
    for spacing in [0.5, 0.2, 0.05, 0.01] {
        for (number, alpha) in [(2, 1.0), (2, 100.0), (2, 1e4), (3, 1.0), (3, 100.0), (3, 1e4)] {
            for _ in 0..200 {
                let (mut samples, mut time) = (Samples::<1>::new(), -10.3);
                for _ in 0..WINDOW {
                    samples.push(time as f32, [0.0], 1.0).expect("in order");
                    time += if random.unit() < 0.2 { spacing } else { 0.8 + 0.4 * random.unit() };
                }
                match samples.fit(order(number), alpha as f32, [1.0]) {
                    Ok(fitted) => {
                        assert!(fitted.gain < 1.0 && fitted.rate_gain < 1.0, "{spacing} {number} {alpha}: {fitted:?}");
                        fits += 1;
                    }
                    Err(error) => {
                        assert!(matches!(error, FitError::Condition | FitError::TooFew), "{error:?}");
                        refused += 1;
                    }
                }
            }
        }
    }
    assert!(fits > 2000 && refused > 500, "{fits} fits, {refused} refused");
}
