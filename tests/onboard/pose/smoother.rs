//! A stream's value at an instant: what is waited for, what serves when the window is short, and which streams have none.

use plumbline_core::pose::noise::{AHEAD, Choices, LAGS, NoiseModel, Wave};
use plumbline_core::pose::{ALPHA_MAX, Estimate, History, Method, Order, PoseError, Smoother, Wait};
use plumbline_core::tilt::Attitude;
use plumbline_core::units::{Micros, Radians};
use plumbline_tests::seeded::Random;

const INTERVAL_US: u64 = 5_000;
const WHITE: f64 = 0.1;

/// Attitude at 200 Hz with a tenth of a degree of noise.
fn smoother() -> Smoother<3> {
    let radians = |degrees: f64| degrees.to_radians() as f32;
    let waves = [Wave { amplitude: radians(10.0), period_s: 4.0 }, Wave { amplitude: radians(0.3), period_s: 0.7 }];
    let model = NoiseModel { interval_us: INTERVAL_US as u32, white: radians(WHITE), waves };
    Smoother::new(&model, [radians(WHITE); 3])
}

/// Heading, pitch and roll of the truth, degrees: a turn through north, the pitch of the model, and the roll with its shake.
fn truth(t_s: f64) -> [f64; 3] {
    let sine = |amplitude: f64, period: f64| amplitude * (std::f64::consts::TAU * t_s / period).sin();
    [350.0 + 20.0 * t_s, sine(10.0, 4.0), sine(-10.0, 4.0) + sine(0.3, 0.7)]
}

fn attitude(degrees: [f64; 3]) -> Attitude {
    let [heading, pitch, roll] = degrees.map(|deg| Radians(deg.to_radians() as f32));
    Attitude { heading: heading.wrapped(), pitch, roll }
}

/// Samples `first` to `last` of a flight, without those that `lost` names, ±`jitter_us` off their times.
fn history(seed: u64, (first, last): (u64, u64), lost: &[u64], jitter_us: f64) -> History<Attitude, 3, 40> {
    let mut random = Random::new(seed);
    let mut history = History::new();
    for i in first..=last {
        let late_us = random.between(0.0, jitter_us.max(1e-9)).floor() as u64;
        let at = 1_000_000 + i * INTERVAL_US + late_us;
        let noisy = truth(at as f64 * 1e-6).map(|angle| angle + WHITE * random.normal());
        if !lost.contains(&i) {
            history.push(Micros(at), attitude(noisy)).expect("forwards");
        }
    }
    history
}

/// Errors of pitch and roll, degrees, and the heading's.
fn errors(estimate: &Estimate<Attitude, 3>, at: Micros) -> [f64; 3] {
    let [heading, pitch, roll] = truth(at.0 as f64 * 1e-6);
    let angles =
        [estimate.value.heading, estimate.value.pitch, estimate.value.roll].map(|a| f64::from(a.0).to_degrees());
    [(angles[0] - heading + 180.0).rem_euclid(360.0) - 180.0, angles[1] - pitch, angles[2] - roll]
}

fn mid(sample: u64) -> Micros {
    Micros(1_000_000 + sample * INTERVAL_US + 1_700)
}

/// The fit is twice as good as the straight way at a lag of two samples, and its sigma is honest, also with jittering
/// stamps and lost samples.
#[test]
fn noise_is_smoothed_and_its_sigma_honest() {
    let smoother = smoother();
    for (name, lost, jitter_us) in
        [("even", vec![], 0.0), ("jitter", vec![], 3_000.0), ("losses", vec![4, 5, 11, 18, 22], 0.0)]
    {
        let (mut fitted, mut straight, mut told, mut rates, mut rates_told) = (0.0, 0.0, 0.0, 0.0, 0.0);
        let flights = 1_500;
        for seed in 0..flights {
            // Times go on, so that every phase of the motion is met.
            let from = seed * 7;
            let lost: Vec<u64> = lost.iter().map(|i| i + from).collect();
            let history = history(seed, (from, from + 26), &lost, jitter_us);
            let at = Micros(mid(from + 23).0 + 3_000);
            let estimate = smoother.at(&history, at, 30_000, Wait::For(3)).expect("an estimate");
            let Method::Fitted { lag: 2, rejected: 0, .. } = estimate.method else { panic!("{:?}", estimate.method) };
            let between = history.at(at, 30_000).expect("between").value;
            let [_, pitch, roll] = errors(&estimate, at);
            fitted += pitch * pitch + roll * roll;
            let [_, pitch, roll] = errors(&Estimate { value: between, ..estimate }, at);
            straight += pitch * pitch + roll * roll;
            told += 2.0 * f64::from(estimate.sigma[1]).to_degrees().powi(2);
            let t_s = at.0 as f64 * 1e-6;
            let rate = (truth(t_s + 1e-4)[2] - truth(t_s - 1e-4)[2]) / 2e-4;
            rates += (f64::from(estimate.rate[2]).to_degrees() - rate).powi(2);
            rates_told += f64::from(estimate.rate_sigma[2]).to_degrees().powi(2);
        }
        let rms = |sum: f64| (sum / (2.0 * flights as f64)).sqrt();
        let (factor, honesty) = (rms(straight) / rms(fitted), fitted / told);
        println!("{name}: {:.4} for {:.4} degrees, {factor:.2} times better, {honesty:.2}", rms(fitted), rms(straight));
        println!(
            "  rate: {:.2} degrees/s, told {:.2}",
            (rates / flights as f64).sqrt(),
            (rates_told / flights as f64).sqrt()
        );
        assert!(factor > 1.9, "{name}: {factor}");
        // 3,000 squares: their mean is good to 5 % at two sigmas, and the motion's part is a model's.
        assert!((0.8..1.15).contains(&honesty), "{name}: {honesty}");
        // Where a quarter of the samples is lost the same stiffness smooths more of the motion away.
        assert!((0.8..1.5).contains(&(rates / rates_told)), "{name}: {}", rates / rates_told);
    }
}

#[test]
fn headings_are_fitted_through_north() {
    // 350 degrees at 0 s, 20 degrees a second: north at 0.5 s, and 1 s is where the window lies.
    let history = history(3, (0, 26), &[], 0.0);
    let mut crossing = History::<Attitude, 3, 40>::new();
    for (at, sample) in history.samples() {
        let turned = Radians(sample.heading.0 - 10.2f32.to_radians()).wrapped();
        crossing.push(at, Attitude { heading: turned, ..sample }).expect("forwards");
    }
    assert!(crossing.samples().any(|(_, a)| a.heading.0 < 0.0) && crossing.samples().any(|(_, a)| a.heading.0 > 0.0));
    let estimate = smoother().at(&crossing, mid(12), 30_000, Wait::For(3)).expect("an estimate");
    let shifted = Estimate {
        value: Attitude { heading: Radians(estimate.value.heading.0 + 10.2f32.to_radians()), ..estimate.value },
        ..estimate
    };
    assert!(errors(&shifted, mid(12))[0].abs() < 0.15, "{shifted:?}");
    assert!((estimate.rate[0].to_degrees() - 20.0).abs() < 5.0, "{estimate:?}");
}

#[test]
fn so_many_later_samples_are_waited_for() {
    let smoother = smoother();
    for later in 0..5u64 {
        let history = history(1, (0, 20 + later), &[], 0.0);
        let at = mid(20);
        let found = smoother.at(&history, at, 30_000, Wait::For(3));
        assert_eq!(found.is_ok(), later >= 3, "{later} later: {found:?}");
        assert!(found.is_ok() || found.err() == Some(PoseError::NotYet));
        // Patience at its end: one is enough, none is not.
        let found = smoother.at(&history, at, 30_000, Wait::No);
        assert_eq!(found.is_ok(), later >= 1, "{later} later: {found:?}");
        if let Ok(Estimate { method: Method::Fitted { lag, .. }, .. }) = found {
            assert_eq!(u64::from(lag), later - 1);
        }
    }
}

#[test]
fn short_windows_are_bridged_straight() {
    let smoother = smoother();
    let short = history(1, (0, 3), &[], 0.0);
    let estimate = smoother.at(&short, mid(1), 30_000, Wait::No).expect("an estimate");
    assert_eq!(estimate.method, Method::Linear);
    assert_eq!(estimate.value, short.at(mid(1), 30_000).expect("between").value);
    let sigma = f64::from(estimate.sigma[1]).to_degrees();
    assert!((0.7 * WHITE..=WHITE).contains(&sigma), "{sigma}");
    // A gap cuts the window: four samples are left on this side of it.
    let cut = history(1, (0, 20), &[10, 11, 12, 13, 14, 15], 0.0);
    let estimate = smoother.at(&cut, mid(17), 10_000, Wait::No).expect("an estimate");
    let Method::Fitted { count: 5, .. } = estimate.method else { panic!("{:?}", estimate.method) };
    // And on the other side: what comes after the gap is not of this window.
    let estimate = smoother.at(&cut, mid(6), 10_000, Wait::No).expect("an estimate");
    let Method::Fitted { count: 10, lag: 2, .. } = estimate.method else { panic!("{:?}", estimate.method) };
    assert_eq!(smoother.at(&cut, mid(12), 10_000, Wait::No).err(), Some(PoseError::Gap));
}

#[test]
fn a_sensor_that_hangs_has_no_value() {
    let smoother = smoother();
    let mut history = History::<Attitude, 3, 40>::new();
    for i in 0..30 {
        history.push(Micros(i * INTERVAL_US), attitude([1.0, 2.0, 3.0])).expect("forwards");
    }
    assert_eq!(smoother.at(&history, Micros(70_000), 30_000, Wait::No).err(), Some(PoseError::Frozen));
    // As soon as it is seen: four later samples that repeat the last good one; and while it is remembered.
    let hung = |from: u64, to: u64| {
        let mut history = History::<Attitude, 3, 40>::new();
        for i in 0..30 {
            let moved = if (from..to).contains(&i) { from } else { i } as f64;
            history
                .push(Micros(i * INTERVAL_US), attitude([0.1, 0.2, 0.3].map(|step| step * moved)))
                .expect("forwards");
        }
        smoother.at(&history, Micros(15 * INTERVAL_US + 2500), 30_000, Wait::No).map(|_| ())
    };
    assert_eq!([hung(15, 20), hung(11, 16), hung(8, 13)], [Err(PoseError::Frozen); 3]);
    assert_eq!([hung(15, 19), hung(12, 16), hung(0, 5)], [Ok(()); 3]);
    // One angle alone, which rounding moves a little.
    for channel in 0..3 {
        let hung = |from: u64, to: u64| {
            let mut history = History::<Attitude, 3, 40>::new();
            for i in 0..30 {
                let mut angles = [0.1, 0.2, 0.3].map(|step| step * i as f64);
                if (from..to).contains(&i) {
                    angles[channel] = 1.0 + 8e-7 * (i % 2) as f64;
                }
                history.push(Micros(i * INTERVAL_US), attitude(angles)).expect("forwards");
            }
            smoother.at(&history, Micros(15 * INTERVAL_US + 2500), 30_000, Wait::No).map(|_| ())
        };
        assert_eq!([hung(12, 20), hung(8, 16)], [Err(PoseError::Frozen); 2]);
        assert_eq!([hung(13, 20), hung(8, 15)], [Ok(()); 2]);
    }
    // Without noise a sensor may say the same.
    let model = NoiseModel { interval_us: 5_000, white: 0.0, waves: [Wave::default(); 2] };
    let still = Smoother::new(&model, [0.0; 3]).at(&history, Micros(70_000), 30_000, Wait::No).expect("an estimate");
    assert_eq!((still.method, still.value), (Method::Linear, attitude([1.0, 2.0, 3.0])));
}

/// A spike in one sample does not reach the pose; two sensors' worth of noise widen the sigma.
#[test]
fn spikes_are_left_out_and_more_noise_is_believed() {
    let smoother = smoother();
    let mut spiked = History::<Attitude, 3, 40>::new();
    for (i, (at, sample)) in history(5, (0, 26), &[], 0.0).samples().enumerate() {
        let off = if i == 22 { 5.0f32.to_radians() } else { 0.0 };
        spiked.push(at, Attitude { pitch: Radians(sample.pitch.0 + off), ..sample }).expect("forwards");
    }
    let estimate = smoother.at(&spiked, mid(23), 30_000, Wait::For(3)).expect("an estimate");
    let Method::Fitted { rejected: 1, .. } = estimate.method else { panic!("{:?}", estimate.method) };
    assert!(errors(&estimate, mid(23))[1].abs() < 0.2, "{estimate:?}");

    let quiet = smoother.at(&history(6, (0, 26), &[], 0.0), mid(23), 30_000, Wait::For(3)).expect("an estimate");
    let mut random = Random::new(9);
    let mut loud = History::<Attitude, 3, 40>::new();
    for (at, sample) in history(6, (0, 26), &[], 0.0).samples() {
        let off = (4.0 * WHITE * random.normal()).to_radians() as f32;
        loud.push(at, Attitude { pitch: Radians(sample.pitch.0 + off), roll: Radians(sample.roll.0 - off), ..sample })
            .expect("forwards");
    }
    let loud = smoother.at(&loud, mid(23), 30_000, Wait::For(3)).expect("an estimate");
    assert!(loud.sigma[1] > 1.8 * quiet.sigma[1], "{loud:?} {quiet:?}");
}

/// A vehicle that hardly moves asks for the stiffest curve of all, which a fit must take: else it falls back in silence.
#[test]
fn no_choice_is_stiffer_than_a_fit_takes() {
    let mut stiffest = 0.0f32;
    for interval_us in [5_000, 10_000, 20_000, 200_000] {
        for white in [1e-6, 1e-4, 1e-2, 1.0] {
            for (amplitude, period_s) in [(0.0, 1.0), (1e-5, 4.0), (1e-3, 600.0), (30.0, 2000.0)] {
                let waves = [Wave { amplitude, period_s }, Wave::default()];
                let choices = Choices::of(&NoiseModel { interval_us, white, waves }, &[Order::Second, Order::Third]);
                let ahead = AHEAD.into_iter().filter_map(|ahead| choices.ahead(ahead));
                for choice in (0..LAGS).map(|lag| choices.at(lag)).chain(ahead) {
                    assert!(choice.alpha <= ALPHA_MAX, "{choice:?} for {white}, {waves:?}");
                    stiffest = stiffest.max(choice.alpha);
                }
            }
        }
    }
    assert_eq!(stiffest, ALPHA_MAX, "none of them needs the limit");
}
