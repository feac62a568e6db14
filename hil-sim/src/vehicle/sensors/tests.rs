//! Bounds are 4 standard errors of the estimate: 1/√(2n) relative for a standard deviation, √(p(1 − p)/n) for a share.

use super::{
    Exposure, LineEdge, Reading, Sample, Streams, TimerModel, exposures, hold_off_us, line_edges, lost_frames,
};
use crate::noise::{GaussMarkov, White};
use crate::scenario::{EdgeSource, FollowUpMode, Mounting, Replay, Scenario, WARM_UP_US};
use crate::vehicle::motion::{Area, AttitudeLog, Motion};
use crate::vehicle::servo::wrapped;

const AREA: Area = Area { centre_east_m: 3000.0, centre_north_m: 7000.0, half_extent_m: 1500.0, base_up_m: 0.0 };

fn deviation(values: &[f64]) -> f64 {
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    (values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / values.len() as f64).sqrt()
}

#[test]
fn white_noise_is_normal_and_named() {
    let mut white = White::new(2.0, 7, "a");
    let values: Vec<f64> = (0..20_000).map(|_| white.draw()).collect();
    assert!((deviation(&values) / 2.0 - 1.0).abs() < 4.0 / 40_000_f64.sqrt());
    assert!(values.iter().sum::<f64>().abs() / 20_000.0 < 4.0 * 2.0 / 20_000_f64.sqrt());
    let beyond = values.iter().filter(|value| value.abs() > 2.0 * 1.959964).count() as f64 / 20_000.0;
    assert!((beyond - 0.05).abs() < 4.0 * (0.05 * 0.95 / 20_000_f64).sqrt(), "{beyond}");
    let first = |seed, name| White::new(2.0, seed, name).draw();
    assert_eq!(first(7, "a"), values[0]);
    assert!(first(7, "b") != values[0] && first(8, "a") != values[0]);
}

/// Over 4000 independent streams: the same spread at every instant, from the first, and e^(−Δt/τ) between two, whether
/// the way there was one step or several of any length.
#[test]
fn gauss_markov_is_exact_for_any_step() {
    let times_us: [u64; 4] = [500_000, 3_500_000, 3_600_000, 43_600_000];
    let (sigma, tau_s) = (0.35, 30.0);
    let runs: Vec<[f64; 4]> = (0..4000)
        .map(|seed| {
            let mut drift = GaussMarkov::new(sigma, tau_s, seed, "drift");
            times_us.map(|t_us| drift.at(t_us))
        })
        .collect();
    for at in 0..4 {
        let values: Vec<f64> = runs.iter().map(|run| run[at]).collect();
        assert!((deviation(&values) / sigma - 1.0).abs() < 4.0 / 8000_f64.sqrt(), "at {at}");
        for to in at + 1..4 {
            let product: f64 = runs.iter().map(|run| run[at] * run[to]).sum();
            let correlation = product / 4000.0 / (sigma * sigma);
            let expected = (-((times_us[to] - times_us[at]) as f64 * 1e-6) / tau_s).exp();
            // The sum of products has a relative variance of (1 + ρ²)/n.
            let allowed = 4.0 * ((1.0 + expected * expected) / 4000.0).sqrt();
            assert!((correlation - expected).abs() < allowed, "{at} {to}: {correlation} {expected}");
        }
    }
}

fn quiet() -> Scenario {
    let mut scenario = Scenario::default();
    scenario.world.timer.pps = true;
    scenario.vehicle.attitude.white_deg = 0.0;
    scenario.vehicle.follow_up.mode = FollowUpMode::Measured;
    scenario.vehicle.follow_up.noise_deg = 0.0;
    scenario.vehicle.range.sigma_m = 0.0;
    scenario.vehicle.position.sigma_m = Some(0.0);
    scenario.vehicle.position.velocity_sigma_m_s = 0.0;
    scenario
}

fn all(scenario: &Scenario, motion: &Motion, convergence_rad: f64, until_us: u64) -> Vec<Sample> {
    let mut streams = Streams::new(scenario, Mounting::default(), convergence_rad);
    std::iter::from_fn(|| streams.next_before(until_us, motion, &|state| Some(state.up_m))).collect()
}

#[test]
fn samples_come_in_the_order_of_arrival_and_stamped_as_their_messages_can() {
    let scenario = quiet();
    let motion = Motion::synthetic(&scenario, &AREA).expect("there is room");
    let samples = all(&scenario, &motion, 0.0, 10_000_000);
    assert!(samples.is_sorted_by_key(|sample| sample.arrived_at_us));
    let count = |wanted: fn(&Reading) -> bool| samples.iter().filter(|sample| wanted(&sample.reading)).count();
    // What arrives within 10 s: the samples whose index/rate + latency is below it.
    assert_eq!(count(|reading| matches!(reading, Reading::Attitude { .. })), 1999);
    assert_eq!(count(|reading| matches!(reading, Reading::FollowUp { .. })), 1000);
    assert_eq!(count(|reading| matches!(reading, Reading::Range { .. })), 500);
    assert_eq!(count(|reading| matches!(reading, Reading::Position { .. })), 50);
    assert_eq!(count(|reading| matches!(reading, Reading::Pps { .. })), 9);
    for sample in &samples {
        let (latency_us, interval_us) = match sample.reading {
            Reading::Pps { second } => {
                assert_eq!(sample.sampled_at_us, second * 1_000_000);
                (0, 1_000_000)
            }
            Reading::Attitude { .. } => (8000, 5_000),
            Reading::FollowUp { .. } => (5000, 10_000),
            Reading::Range { .. } => (10_000, 20_000),
            Reading::Position { .. } => (100_000, 200_000),
        };
        assert_eq!(sample.arrived_at_us - sample.sampled_at_us, latency_us);
        // What a stamp of whole milliseconds cuts off beside, nothing else.
        assert!(sample.sampled_at_us % interval_us < 1000);
    }
    // Cut off is half a millisecond in the mean, evenly.
    let cut: Vec<f64> = samples
        .iter()
        .filter(|sample| matches!(sample.reading, Reading::Range { .. }))
        .map(|sample| (sample.sampled_at_us % 1000) as f64)
        .collect();
    let mean = cut.iter().sum::<f64>() / cut.len() as f64;
    let spread = (cut.iter().map(|us| (us - mean) * (us - mean)).sum::<f64>() / cut.len() as f64).sqrt();
    assert!((mean - 500.0).abs() < 10.0 && (spread - 288.7).abs() < 10.0, "{mean} us, {spread} us");
    // Without latency the pulse and an attitude arrive at 1 s, in their fixed order.
    let mut instant = quiet();
    instant.world.attitude.latency_us = 0;
    let second = all(&instant, &motion, 0.0, 1_000_001);
    let at_once: Vec<_> =
        second.iter().filter(|sample| sample.arrived_at_us == 1_000_000).map(|sample| sample.reading).collect();
    assert!(matches!(at_once[..], [Reading::Pps { second: 1 }, Reading::Attitude { .. }]), "{at_once:?}");
}

#[test]
fn without_noise_the_sensors_tell_the_truth() {
    let scenario = quiet();
    let motion = Motion::synthetic(&scenario, &AREA).expect("there is room");
    let convergence_rad = 0.02;
    for sample in all(&scenario, &motion, convergence_rad, 5_000_000) {
        let state = motion.state(sample.sampled_at_us);
        let [east, north, up] = state.velocity_enu_m_s;
        let check_velocity = |ned: [f64; 3]| {
            // The course and the heading turn alike, the speed stays.
            assert!((wrapped(ned[1].atan2(ned[0]) - east.atan2(north)) - convergence_rad).abs() < 1e-12);
            assert!((ned[0].hypot(ned[1]) - east.hypot(north)).abs() < 1e-12);
            assert_eq!(ned[2], -up);
        };
        match sample.reading {
            Reading::Pps { .. } => {}
            Reading::Attitude { heading_true_rad, pitch_rad, roll_rad, velocity_ned_m_s } => {
                assert!((wrapped(heading_true_rad - state.heading_rad) - convergence_rad).abs() < 1e-12);
                assert_eq!((pitch_rad, roll_rad), (state.pitch_rad, state.roll_rad));
                check_velocity(velocity_ned_m_s);
            }
            Reading::FollowUp { follow_up_rad } => {
                assert!(wrapped(follow_up_rad - state.follow_up_rad).abs() < 1e-12);
            }
            Reading::Range { slant_m } => assert_eq!(slant_m, Some(state.up_m)),
            Reading::Position { east_m, north_m, up_m, velocity_ned_m_s } => {
                assert_eq!((east_m, north_m, up_m), (state.east_m, state.north_m, state.up_m));
                check_velocity(velocity_ned_m_s);
            }
        }
    }
}

#[test]
fn noise_is_as_large_as_the_scenario_says() {
    let mut scenario = Scenario::default();
    scenario.vehicle.attitude.heading_white_deg = Some(0.4);
    scenario.vehicle.follow_up.mode = FollowUpMode::Measured;
    scenario.faults.range.dropout_percent = 20.0;
    let motion = Motion::synthetic(&scenario, &AREA).expect("there is room");
    let (mut heading, mut pitch, mut roll, mut follow_up, mut slant) = (vec![], vec![], vec![], vec![], vec![]);
    let mut lost = 0.0;
    for sample in all(&scenario, &motion, 0.0, 60_000_000) {
        let state = motion.state(sample.sampled_at_us);
        match sample.reading {
            Reading::Attitude { heading_true_rad, pitch_rad, roll_rad, .. } => {
                heading.push(wrapped(heading_true_rad - state.heading_rad).to_degrees());
                pitch.push((pitch_rad - state.pitch_rad).to_degrees());
                roll.push((roll_rad - state.roll_rad).to_degrees());
            }
            Reading::FollowUp { follow_up_rad } => {
                follow_up.push(wrapped(follow_up_rad - state.follow_up_rad).to_degrees());
            }
            Reading::Range { slant_m: Some(slant_m) } => slant.push(slant_m - state.up_m),
            Reading::Range { slant_m: None } => lost += 1.0,
            _ => {}
        }
    }
    for (values, sigma) in [(&heading, 0.4), (&pitch, 0.1), (&roll, 0.1), (&follow_up, 0.05), (&slant, 0.03)] {
        let ratio = deviation(values) / sigma;
        assert!((ratio - 1.0).abs() < 4.0 / (2.0 * values.len() as f64).sqrt(), "{sigma}: {ratio}");
    }
    let product: f64 = pitch.iter().zip(&roll).map(|(pitch, roll)| pitch * roll).sum();
    assert!((product / 0.01).abs() < 4.0 * (pitch.len() as f64).sqrt(), "pitch and roll share a stream");
    let asked = lost + slant.len() as f64;
    assert!((lost / asked - 0.2).abs() < 4.0 * (0.16 / asked).sqrt(), "{lost} of {asked}");
}

/// Identical bytes from one go and from many windows; another seed gives others; a sensor more or less changes no other.
#[test]
fn the_seed_decides_and_windows_do_not() {
    let scenario = Scenario::default();
    let motion = Motion::synthetic(&scenario, &AREA).expect("there is room");
    let whole = all(&scenario, &motion, 0.01, 3_000_000);
    let mut streams = Streams::new(&scenario, Mounting::default(), 0.01);
    let mut pieces = Vec::new();
    for until_us in (0..=3_000_000).step_by(7919).chain([3_000_000]) {
        while let Some(sample) = streams.next_before(until_us, &motion, &|state| Some(state.up_m)) {
            assert!(sample.arrived_at_us < until_us);
            pieces.push(sample);
        }
    }
    assert_eq!(whole, pieces);
    let other = Scenario::seeded(2, 300);
    assert_ne!(whole, all(&other, &motion, 0.01, 3_000_000));
    let mut more = Scenario::default();
    more.vehicle.follow_up.mode = FollowUpMode::Measured;
    more.faults.range.dropout_percent = 50.0;
    let attitudes = |samples: Vec<Sample>| -> Vec<Sample> {
        samples.into_iter().filter(|sample| matches!(sample.reading, Reading::Attitude { .. })).collect()
    };
    assert_eq!(attitudes(whole), attitudes(all(&more, &motion, 0.01, 3_000_000)));
}

#[test]
fn the_attitude_sensor_is_silent_in_a_log_gap() {
    let text = "t_s,roll_deg,pitch_deg,yaw_deg\n0,1,2,3\n1,1,2,3\n1.25,1,2,3\n2,1,2,3\n";
    let rows: String = (1..400).map(|row| format!("{:.2},1,2,3\n", 2.0 + 0.02 * f64::from(row))).collect();
    let log = AttitudeLog::parse(&format!("{text}{rows}"), "a.csv").expect("sound");
    let replay = Some(Replay { att: "".into(), start_s: None, time_scale: 1.0 });
    let scenario = {
        let mut scenario = quiet();
        (scenario.run.frames, scenario.run.replay) = (10, replay);
        scenario
    };
    let motion = Motion::replay(&scenario, &AREA, log).expect("long enough");
    let stamps: Vec<u64> = all(&scenario, &motion, 0.0, 2_500_000)
        .iter()
        .filter(|sample| matches!(sample.reading, Reading::Attitude { .. }))
        .map(|sample| sample.sampled_at_us)
        .collect();
    let silent = |from_us: u64, to_us: u64| stamps.windows(2).any(|pair| pair == [from_us, to_us]);
    assert!(silent(0, 1_000_000) && silent(1_250_000, 2_000_000) && silent(1_100_000, 1_105_000));
}

#[test]
fn frames_open_at_their_interval_and_in_every_phase() {
    let scenario = Scenario::default();
    let flight: Vec<Exposure> = exposures(&scenario).collect();
    assert_eq!(flight.len(), 300);
    let mut phases = [0; 5];
    for (frame, exposure) in flight.iter().enumerate() {
        let late_us = exposure.open_us - WARM_UP_US - frame as u64 * 250_000;
        assert!(late_us < 5000);
        phases[(late_us / 1000) as usize] += 1;
        assert_eq!((exposure.frame as usize, exposure.close_us - exposure.open_us), (frame, 2000));
        assert_eq!(exposure.mid_us(), exposure.open_us + 1000);
        assert!(exposure.readout_start_us > exposure.close_us);
    }
    // 60 each, 4 standard errors.
    assert!(phases.iter().all(|count| (*count as f64 - 60.0).abs() < 4.0 * 48_f64.sqrt()), "{phases:?}");
    // A shorter flight is the beginning of the longer one.
    let short: Vec<Exposure> = exposures(&Scenario::of_frames(10)).collect();
    assert_eq!(short, flight[..10]);
}

#[test]
fn the_timer_drifts_and_wraps() {
    let timer = TimerModel::steady(4_290_000_000, 12.0);
    assert_eq!(timer.ticks(0), 4_290_000_000);
    // 12 ppm: 12 ticks more in each second.
    assert_eq!(timer.ticks(1_000_000), 4_291_000_012);
    assert_eq!(timer.ticks(4_967_236), u32::MAX - 59 + 59);
    assert_eq!(timer.ticks(4_967_237), 0);
    assert_eq!(timer.ticks(10_000_000), 5_032_824);
    // A day later it has wrapped 20 times, and still counts single ticks.
    let day_us = 86_400_000_000;
    assert_eq!(timer.ticks(day_us), ((4_290_000_000_u64 + day_us + 1_036_800) % (1 << 32)) as u32);
    let slow = TimerModel::steady(5, -100.0);
    assert_eq!(slow.ticks(1_000_000), 999_905);
    assert_eq!((slow.ticks(0), slow.ticks(1)), (5, 5));
}

/// Without faults: two edges an exposure, late by their delays and no more than their jitter.
#[test]
fn edges_are_late_by_their_delays() {
    let mut scenario = Scenario::of_frames(2000);
    (scenario.vehicle.shutter.open_delay_us, scenario.vehicle.shutter.close_delay_us) = (30, -7);
    scenario.vehicle.shutter.edge_jitter_us = 2.0;
    let edges = line_edges(&scenario);
    assert!(edges.is_sorted_by_key(LineEdge::seen_us));
    let mut late = [vec![], vec![]];
    for (exposure, pair) in exposures(&scenario).zip(edges.chunks_exact(2)) {
        assert!(pair[0].rising && !pair[1].rising);
        late[0].push(pair[0].at_us - exposure.open_us as f64);
        late[1].push(pair[1].at_us - exposure.close_us as f64);
    }
    for (late, delay) in late.iter().zip([30.0, -7.0]) {
        assert_eq!(late.len(), 2000);
        assert!((deviation(late) / 2.0 - 1.0).abs() < 4.0 / 4000_f64.sqrt());
        assert!((late.iter().sum::<f64>() / 2000.0 - delay).abs() < 4.0 * 2.0 / 2000_f64.sqrt());
    }
    scenario.vehicle.shutter.edges = EdgeSource::One;
    assert_eq!(line_edges(&scenario), edges.iter().copied().filter(|edge| edge.rising).collect::<Vec<_>>());
    scenario.vehicle.shutter.edges = EdgeSource::None;
    assert!(line_edges(&scenario).is_empty());
}

/// Shares as asked for; and what one fault does to an edge, it does to no other.
#[test]
fn edges_and_frames_are_lost_and_added_as_often_as_asked_for() {
    let clean = Scenario::of_frames(5000);
    let mut faulty = clean.clone();
    faulty.faults.shutter.lost_edge_percent = 10.0;
    let (all, left) = (line_edges(&clean), line_edges(&faulty));
    let lost = 1.0 - left.len() as f64 / 10_000.0;
    assert!((lost - 0.1).abs() < 4.0 * (0.09 / 10_000_f64).sqrt(), "{lost}");
    assert!(left.iter().all(|edge| all.contains(edge)));
    faulty.faults.shutter.lost_edge_percent = 0.0;
    faulty.faults.shutter.extra_edge_percent = 10.0;
    let more = line_edges(&faulty);
    assert!(all.iter().all(|edge| more.contains(edge)));
    // Two faults of three are of two edges, one of one.
    let extra = (more.len() - all.len()) as f64 / 10_000.0 * 3.0 / 5.0;
    assert!((extra - 0.1).abs() < 4.0 * (0.1 / 10_000_f64).sqrt(), "{extra}");
    assert_eq!(hold_off_us(&faulty.vehicle), 100);
    faulty.faults.shutter.lost_frame_percent = 20.0;
    let lost = lost_frames(&faulty).filter(|lost| *lost).count() as f64 / 5000.0;
    assert!((lost - 0.2).abs() < 4.0 * (0.16 / 5000_f64).sqrt(), "{lost}");
    assert_eq!(lost_frames(&clean).filter(|lost| *lost).count(), 0);
}

/// Arrivals scatter as asked for and never beyond four sigmas; lengths too, around the exposure.
#[test]
fn exposures_and_arrivals_scatter() {
    let mut scenario = Scenario::of_frames(4000);
    scenario.vehicle.shutter.exposure_jitter_us = 20.0;
    (scenario.vehicle.shutter.arrival_latency_us, scenario.vehicle.shutter.arrival_jitter_us) = (500, 40.0);
    let flight: Vec<Exposure> = exposures(&scenario).collect();
    let lengths: Vec<f64> = flight.iter().map(|e| (e.close_us - e.open_us) as f64).collect();
    let latencies: Vec<f64> = flight.iter().map(|e| (e.readout_start_us - e.close_us) as f64).collect();
    for (values, mean, sigma) in [(&lengths, 2000.0, 20.0), (&latencies, 500.0, 40.0)] {
        assert!((deviation(values) / sigma - 1.0).abs() < 4.0 / 8000_f64.sqrt());
        assert!((values.iter().sum::<f64>() / 4000.0 - mean).abs() < 4.0 * sigma / 4000_f64.sqrt());
    }
    assert!(latencies.iter().all(|latency| (340.0..=660.0).contains(latency)));
    assert!(flight.iter().all(|e| e.mid_exact_us() - e.mid_us() as f64 <= 0.5));
}

/// Over 1000 timers: after t seconds the walk has cost √(q²t³/3) ticks, and the rate is continuous in time.
#[test]
fn the_timers_rate_walks() {
    let mut scenario = Scenario::of_frames(200);
    (scenario.vehicle.timer.rate_walk_ppm, scenario.world.timer.drift_ppm, scenario.world.timer.start_ticks) =
        (3.0, 20.0, 0);
    let gained: Vec<f64> = (0..1000)
        .map(|seed| {
            scenario.run.seed = seed;
            let timer = TimerModel::new(&scenario);
            f64::from(timer.ticks(40_000_000)) - 40_000_800.0
        })
        .collect();
    let expected = 3.0 * (40_f64.powi(3) / 3.0).sqrt();
    let ratio = deviation(&gained) / expected;
    assert!((ratio - 1.0).abs() < 4.0 / 2000_f64.sqrt(), "{ratio}");
    let timer = TimerModel::new(&scenario);
    for step in 0..400_u32 {
        let at_us = f64::from(step) * 100_000.0;
        assert!(timer.latch(at_us + 0.6).wrapping_sub(timer.latch((at_us - 0.6).max(0.0))) <= 2);
    }
    // Captures between whole microseconds.
    let exact = TimerModel::steady(0, 0.0);
    assert_eq!([exact.latch(7.0), exact.latch(7.99), exact.latch(8.0)], [7, 7, 8]);
}

#[test]
fn lost_pulses_are_not_there() {
    let mut scenario = quiet();
    scenario.faults.timer.pps_lost_s = Some([3.0, 6.0]);
    let motion = Motion::synthetic(&scenario, &AREA).expect("there is room");
    let seconds: Vec<u64> = all(&scenario, &motion, 0.0, 8_500_000)
        .iter()
        .filter_map(|sample| if let Reading::Pps { second } = sample.reading { Some(second) } else { None })
        .collect();
    assert_eq!(seconds, [1, 2, 6, 7, 8]);
}
