//! What is beyond the paper: priors of stations, lever arms known to so much, heads that are not released together.

use plumbline_papers::paper_002::world::{InteriorError, NOISE_PX, World};
use plumbline_sim::noise::{normal, stream};
use plumbline_survey::adjust::rig::TIME;
use plumbline_survey::calibrate::{Block, Calibration, Observations, StationPrior};

const NONE: InteriorError = InteriorError { linear_px: 0.0, radial_px: 0.0 };
/// Speed of the flight, m/s.
const SPEED_M_S: f64 = 60.0;
/// How well the heads' release is known beforehand, s.
const KNOWN_S: f64 = 2e-3;

fn block(world: &World, seed: u64) -> (Block, Observations) {
    let mut rng = stream(seed, "beyond");
    let observations = world.observed(&mut rng, NOISE_PX);
    (world.start(&mut rng), observations)
}

fn calibrated(block: &Block, observations: &Observations) -> Calibration {
    Calibration::new(block, observations, &mut |_, _| {}).expect("calibrated")
}

/// Largest error of an angle of heads 2 to 4, in its standard deviations, and root mean square in arc seconds.
fn errors(world: &World, calibration: &Calibration) -> (f64, f64) {
    let (mut worst, mut squares) = (0.0_f64, 0.0);
    for unknown in calibration.unknowns.iter().filter(|unknown| unknown.number < 3) {
        let error = unknown.value - world.heads[unknown.head][unknown.number];
        worst = worst.max((error / unknown.sigma).abs());
        squares += (error.to_degrees() * 3600.0).powi(2) / 9.0;
    }
    (worst, squares.sqrt())
}

/// No known point at all: projection centres from GNSS to 5 cm hold the block.
#[test]
fn stations_hold_the_block() {
    let world = World::calibration(3, 500, NONE);
    let (mut block, observations) = block(&world, 3);
    block.points.iter_mut().for_each(|point| point.is_free = true);
    let refused = Calibration::new(&block, &observations, &mut |_, _| {}).expect_err("nothing holds it").to_string();
    assert!(refused.contains("position (3 of 3) and orientation (3 of 3)"), "{refused}");
    let mut rng = stream(3, "gnss");
    for (station, truth) in world.stations.iter().enumerate() {
        let target = truth.values.map(|value| value + 0.05 * normal(&mut rng));
        let rows = (3..6).map(|k| (0..6).map(|j| if j == k { 20.0 } else { 0.0 }).collect()).collect();
        block.station_priors.push(StationPrior { station, target, rows });
    }
    let calibration = calibrated(&block, &observations);
    let (worst, rms) = errors(&world, &calibration);
    assert!(worst < 4.0 && rms < 2.0, "{worst} {rms}");
    assert!((0.9..1.1).contains(&calibration.sigma0), "{}", calibration.sigma0);
    // The points come out where they are, to what the adjustment says of them.
    let mut pooled = 0.0;
    for (point, truth) in world.points.iter().enumerate() {
        for (k, truth) in truth.iter().enumerate() {
            pooled += ((calibration.points[point][k] - truth) / calibration.point_sigmas_m[point][k]).powi(2);
        }
    }
    // A shift of all points by the stations' mean is one error in all of them: the ratio scatters more than 1 / sqrt(n).
    let ratio = (pooled / (3.0 * world.points.len() as f64)).sqrt();
    assert!((0.6..1.6).contains(&ratio), "{ratio}");
}

/// A head that is released a millisecond late is six tenths of a pixel off: unknown it spoils the angles, estimated it is
/// found.
#[test]
fn heads_that_are_not_released_together() {
    let mut world = World::calibration(4, 500, NONE);
    let late_s = [0.0, 1.0e-3, -0.5e-3, 0.3e-3];
    for station in &mut world.stations {
        let heading = station.values[2];
        // Along the picture's y axis: R_kappa of (0, 1).
        (station.rates[3], station.rates[4]) = (-SPEED_M_S * heading.sin(), SPEED_M_S * heading.cos());
        station.rates[2] = 0.01;
    }
    for (head, late_s) in world.heads.iter_mut().zip(late_s) {
        head[TIME] = late_s;
    }
    let (mut block, observations) = block(&world, 4);
    let (worst_ignored, rms_ignored) = errors(&world, &calibrated(&block, &observations));
    for head in 1..4 {
        block.heads[head].free.push(TIME);
        block.head_priors.push((head, TIME, 0.0, KNOWN_S));
    }
    let calibration = calibrated(&block, &observations);
    let (worst, rms) = errors(&world, &calibration);
    assert!(worst < 4.0, "{worst} {rms}");
    assert!(worst_ignored > 2.0 * worst && rms_ignored > 2.0 * rms, "{worst_ignored} {rms_ignored}");
    for (head, late_s) in late_s.iter().enumerate().skip(1) {
        let sigma = calibration.sigma(head, TIME).expect("an unknown");
        let error = calibration.heads[head][TIME] - late_s;
        // A fifth of what was known beforehand: the flight's directions tell time from angle.
        assert!(error.abs() < 4.0 * sigma && sigma < 0.2 * KNOWN_S, "head {head}: {error:e} {sigma:e}");
    }
}

/// Lever arms off by 10 mm in depth: held they spoil seams, known to 10 mm they do not harm the angles' honesty.
#[test]
fn lever_arms_that_are_known_to_so_much() {
    let mut world = World::calibration(5, 500, NONE);
    let mut rng = stream(5, "arms");
    for head in &mut world.heads {
        head[5] += 0.010 * normal(&mut rng);
    }
    let (mut block, observations) = block(&world, 5);
    let (_, held) = errors(&world, &calibrated(&block, &observations));
    for head in 0..4 {
        for number in 3..6 {
            block.heads[head].free.push(number);
            let value = block.heads[head].values[number];
            let sigma = if number == 5 { 0.010 } else { 0.002 };
            block.head_priors.push((head, number, value, sigma));
        }
        block.heads[head].free.sort_unstable();
    }
    let calibration = calibrated(&block, &observations);
    let (worst, rms) = errors(&world, &calibration);
    assert!(worst < 4.0 && rms < 2.5, "{worst} {rms} {held}");
    for head in 0..4 {
        let error = calibration.heads[head][5] - world.heads[head][5];
        assert!(error.abs() < 4.0 * calibration.sigma(head, 5).expect("an unknown"), "{error}");
    }
}
