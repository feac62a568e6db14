//! Positions propagated to the exposure.

use plumbline_core::pose::noise::{NoiseModel, Wave};
use plumbline_core::pose::position::{PositionSigmas, PositionState, Predicted, Predictor};
use plumbline_core::pose::{History, Method, PoseError};
use plumbline_core::units::Micros;
use plumbline_tests::seeded::Random;
use std::f64::consts::TAU;

const INTERVAL_US: u64 = 200_000;

/// A weave of 10 m/s in 20 s, east; 30 m/s north.
fn truth(t_s: f64, phase: f64) -> ([f64; 2], [f64; 2]) {
    let w = TAU / 20.0;
    ([10.0 / w * (w * t_s + phase).sin(), 30.0 * t_s], [10.0 * (w * t_s + phase).cos(), 30.0])
}

/// Errors of predictions 0.1 s to 0.3 s ahead of the newest of eleven positions, root mean square a horizontal axis, sigma
/// told, and the share of fits.
fn flown(white_m: f64, velocity_m_per_s: f64) -> (f64, f64, f64) {
    let wave = Wave { amplitude: (10.0 * 20.0 / TAU) as f32, period_s: 20.0 };
    let model = NoiseModel { interval_us: INTERVAL_US as u32, white: white_m as f32, waves: [wave, Wave::default()] };
    let predictor = Predictor::new(&model, PositionSigmas { drift_m: 0.0, velocity_m_per_s: velocity_m_per_s as f32 });
    let (mut error, mut told, mut fits) = (0.0, 0.0, 0);
    let flights = 3_000;
    for seed in 0..flights {
        let mut random = Random::new(seed);
        let phase = TAU * random.uniform();
        let mut history = History::<PositionState, 4, 11>::new();
        for i in 0..11 {
            let at_us = i * INTERVAL_US;
            let (place, velocity) = truth(at_us as f64 * 1e-6, phase);
            let [e, n] = place.map(|p| (p + white_m * random.normal()) as f32);
            let [ve, vn] = velocity.map(|v| (v + velocity_m_per_s * random.normal()) as f32);
            let sample = PositionState { east_m: e, north_m: n, east_m_per_s: ve, north_m_per_s: vn };
            history.push(Micros(at_us), sample).expect("forwards");
        }
        let at = Micros(10 * INTERVAL_US + 100_000 + (random.uniform() * 200_000.0) as u64);
        let Predicted { state, sigma_m, method } = predictor.at(&history, at, 1_000_000).expect("a prediction");
        let ([east, north], _) = truth(at.0 as f64 * 1e-6, phase);
        error += (f64::from(state.east_m) - east).powi(2) + (f64::from(state.north_m) - north).powi(2);
        told += 2.0 * f64::from(sigma_m).powi(2);
        fits += u64::from(matches!(method, Method::Fitted { .. }));
    }
    let count = 2.0 * flights as f64;
    ((error / count).sqrt(), (told / count).sqrt(), fits as f64 / flights as f64)
}

/// With velocities the newest position is propagated; with bad ones the fit over the last positions serves. The sigma is
/// that of what was chosen. (The weave is east only, so half of the errors have no part of its acceleration.)
#[test]
fn the_nearer_of_both_ways_is_taken() {
    let (error, told, fits) = flown(0.144, 0.1);
    println!("good velocities: {error:.3} m, told {told:.3} m, {fits:.2} fitted");
    assert!(error < 0.16 && fits < 0.6, "{error} {fits}");
    assert!((0.8..1.1).contains(&(error / told)), "{error} for {told}");
    // With neither noise the acceleration is all that is left, of one axis of both.
    let (error, told, _) = flown(1e-3, 1e-3);
    println!("no noise: {error:.4} m, told {told:.4} m");
    assert!((0.5..1.0).contains(&(error / told)), "{error} for {told}");
    let (error, told, fits) = flown(0.144, 3.0);
    println!("bad velocities: {error:.3} m, told {told:.3} m, {fits:.2} fitted");
    // The reference's table, one and two tenths of a second ahead: 0.16 m with third differences.
    assert!(error < 0.2 && fits > 0.9, "{error} {fits}");
    assert!((0.75..1.1).contains(&(error / told)), "{error} for {told}");
}

#[test]
fn old_positions_are_refused() {
    let model = NoiseModel { interval_us: 200_000, white: 0.1, waves: [Wave::default(); 2] };
    let predictor = Predictor::new(&model, PositionSigmas { drift_m: 10.0, velocity_m_per_s: 0.1 });
    let mut history = History::<PositionState, 4, 11>::new();
    assert_eq!(predictor.at(&history, Micros(5), 1_000_000).err(), Some(PoseError::TooOld));
    history.push(Micros(2_000_000), PositionState { east_m_per_s: 3.0, ..PositionState::default() }).expect("forwards");
    for (at, east) in [(1_000_000, -3.0), (2_000_000, 0.0), (3_000_000, 3.0)] {
        let found = predictor.at(&history, Micros(at), 1_000_000).expect("a prediction");
        assert!((found.state.east_m - east).abs() < 1e-5, "{found:?}");
        assert!(found.sigma_m >= 10.0 && found.method == Method::Propagated);
    }
    for at in [999_999, 3_000_001] {
        assert_eq!(predictor.at(&history, Micros(at), 1_000_000).err(), Some(PoseError::TooOld));
    }
}
