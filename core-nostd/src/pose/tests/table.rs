//! How much is smoothed: the reference's table for a lag of two samples (adjustment, 1.4), found by flying, not by formula.

use super::dense::Uniform;
use crate::pose::band::WINDOW;
use crate::pose::fit::Samples;
use crate::pose::noise::{Choice, Choices, ModelError, NoiseModel, Wave};
use crate::pose::penalty::Order;
use std::f64::consts::TAU;
use std::println;

/// Sigma of a uniform number of width 1.
const UNIFORM: f64 = 0.288_675_134_6;

/// A sensor of the reference: interval, width of its uniform noise, motions (amplitude, period).
struct Sensor {
    interval_s: f64,
    width: f64,
    waves: [(f64, f64); 2],
}

impl Sensor {
    /// Paper 001's positions: 5 Hz, ±0.25 m, speeds of ±10 m/s with a period of `period_s`.
    fn position(period_s: f64) -> Self {
        Sensor { interval_s: 0.2, width: 0.5, waves: [(10.0 * period_s / TAU, period_s), (0.0, 1.0)] }
    }

    /// The reference's attitude: 100 Hz, ±0.05 degrees, 3 degrees in 6 s and 0.3 degrees in 0.7 s.
    fn attitude() -> Self {
        Sensor { interval_s: 0.01, width: 0.1, waves: [(3.0, 6.0), (0.3, 0.7)] }
    }

    fn model(&self) -> NoiseModel {
        NoiseModel {
            interval_us: (self.interval_s * 1e6).round() as u32,
            white: (self.width * UNIFORM) as f32,
            waves: self.waves.map(|(a, t)| Wave { amplitude: a as f32, period_s: t as f32 }),
        }
    }

    /// Root mean square error of the core's estimates, lagging by `lag` samples, over many windows of noise and phase; and
    /// that of the sigma that goes with them.
    fn flown(&self, choice: Choice, lag: usize) -> (f64, f64) {
        let mut random = Uniform(3);
        let (mut error, mut sigma) = (0.0, 0.0);
        let windows = 20_000;
        for _ in 0..windows {
            let phases = [TAU * random.unit(), TAU * random.unit()];
            let truth = |i: f64| {
                let wave = |((a, t), phase): (&(f64, f64), &f64)| a * (TAU * i * self.interval_s / t + phase).sin();
                self.waves.iter().zip(&phases).map(wave).sum::<f64>()
            };
            let at = (WINDOW - 1 - lag) as f64 - random.unit();
            let mut samples = Samples::<1>::new();
            for i in 0..WINDOW {
                let value = truth(i as f64) - truth(at) + self.width * (random.unit() - 0.5);
                samples.push((i as f64 - at) as f32, [value as f32], 1.0).expect("a sample");
            }
            let fitted = samples.fit(choice.order, choice.alpha, [0.0]).expect("a fit");
            error += f64::from(fitted.value[0]).powi(2);
            let noise = f64::from(fitted.gain) * self.width * UNIFORM;
            sigma += noise * noise + f64::from(choice.bias).powi(2);
        }
        ((error / f64::from(windows)).sqrt(), (sigma / f64::from(windows)).sqrt())
    }
}

/// Lag 2 and W = 21: within 5 % of the reference's analytic root mean squares, and the sigma stated is the error's.
#[test]
fn a_lag_of_two_samples_gives_the_reference_s_errors() {
    for (name, sensor, table) in [
        ("positions, 20 s", Sensor::position(20.0), [0.074, 0.060]),
        ("positions, 5 s", Sensor::position(5.0), [0.093, 0.084]),
        ("attitude", Sensor::attitude(), [0.0109, 0.0108]),
    ] {
        for (order, table) in [Order::Second, Order::Third].into_iter().zip(table) {
            let choice = Choices::of(&sensor.model(), &[order]).at(2);
            let (error, sigma) = sensor.flown(choice, 2);
            println!("{name}, {order:?}: {error:.4} for {table}, alpha {:.3}, sigma {sigma:.4}", choice.alpha);
            assert!(error <= 1.05 * table, "{name}, {order:?}: {error} for {table}");
            assert!((sigma / error - 1.0).abs() < 0.05, "{name}, {order:?}: {sigma} stated, {error} true");
        }
        // Left free, the better of the two.
        let free = sensor.flown(Choices::of(&sensor.model(), &[Order::Second, Order::Third]).at(2), 2).0;
        assert!(free <= 1.05 * table[0].min(table[1]), "{name}: {free}");
    }
}

/// α that is best for a whole flight is dangerous at the window's newest sample: 0.557 m instead of 0.096 m.
#[test]
fn an_alpha_of_the_middle_is_dangerous_at_the_edge() {
    let sensor = Sensor::position(20.0);
    let batch = Choice { order: Order::Second, alpha: 100.0, bias: 0.0, rate_bias: 0.0 };
    let (dangerous, _) = sensor.flown(batch, 0);
    let chosen = Choices::of(&sensor.model(), &[Order::Second]).at(0);
    let (safe, _) = sensor.flown(chosen, 0);
    println!("alpha 100: {dangerous:.3} m; alpha {:.2}: {safe:.3} m", chosen.alpha);
    // The reference's figures are for instants within the newest interval.
    assert!((dangerous / 0.557 - 1.0).abs() < 0.1, "{dangerous}");
    assert!(safe < 1.06 * 0.096, "{safe}");
    assert!(Choices::of(&sensor.model(), &[Order::Second]).at(10).alpha > 3.0 * chosen.alpha);
}

#[test]
fn predictions_have_alphas_of_their_own() {
    let model = Sensor::position(20.0).model();
    let choices = Choices::of(&model, &[Order::Second]);
    assert!(choices.ahead(1.0).expect("one interval").alpha < choices.at(2).alpha);
    assert_eq!(choices.ahead(2.5), None);
}

#[test]
fn impossible_models_are_refused_by_name() {
    let good = Sensor::attitude().model();
    assert_eq!(good.check(), Ok(()));
    assert_eq!(NoiseModel { interval_us: 0, ..good }.check(), Err(ModelError::Interval));
    for white in [-1.0, f32::NAN, f32::INFINITY] {
        assert_eq!(NoiseModel { white, ..good }.check(), Err(ModelError::White), "{white}");
    }
    for (amplitude, period_s) in [(-1.0, 1.0), (f32::NAN, 1.0), (1.0, 0.0), (1.0, 0.019), (1.0, f32::NAN)] {
        let waves = [Wave { amplitude, period_s }, Wave::default()];
        assert_eq!(NoiseModel { waves, ..good }.check(), Err(ModelError::Wave), "{amplitude} {period_s}");
    }
}
