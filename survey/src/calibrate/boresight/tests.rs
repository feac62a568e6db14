use super::model::Rays;
use super::*;
use crate::adjust::rotation;
use crate::camera_file::CameraFile;
use nalgebra::{Rotation3, Unit, Vector3};
use rand_chacha::ChaCha12Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use std::f64::consts::TAU;

/// 0.5, -0.3 and 0.2 degrees beyond what the board was configured with.
const CONFIGURED_RAD: [f64; 3] = [0.004, 0.002, -0.005];
const TRUE_RAD: [f64; 3] = [0.004 + 0.008_73, 0.002 - 0.005_24, -0.005 + 0.003_49];

fn footprint(fov_deg: f64) -> Footprint {
    Footprint::new(&CameraFile::new((512, 512), (fov_deg, fov_deg)))
}

/// Numbers that look random between -1 and 1: the fractions of multiples of irrational numbers.
fn spread(index: usize, stream: usize) -> f64 {
    let step = [2.0_f64, 3.0, 5.0, 7.0, 11.0, 13.0][stream].sqrt();
    2.0 * ((index + 1) as f64 * step).fract() - 1.0
}

/// A flight through headings of so much either way, with tilts of so much, over heights from 100 to 150 m; without errors.
fn flight(count: usize, heading_rad: f64, tilt_rad: f64) -> Vec<Sighting> {
    flight_of(TRUE_RAD, count, heading_rad, tilt_rad)
}

/// The flight of a camera that really is mounted so.
fn flight_of(true_rad: [f64; 3], count: usize, heading_rad: f64, tilt_rad: f64) -> Vec<Sighting> {
    flight_with(CONFIGURED_RAD, true_rad, &footprint(60.0), count, heading_rad, tilt_rad)
}

/// That of a board that was configured so, whose matching weighs what `matched` covers.
fn flight_with(
    configured_rad: [f64; 3],
    true_rad: [f64; 3],
    matched: &Footprint,
    count: usize,
    heading_rad: f64,
    tilt_rad: f64,
) -> Vec<Sighting> {
    let sighting = |index| {
        let blank = Sighting {
            fix_m: [0.0; 2],
            sigma_m: [0.2, 0.25],
            position_m: [1000.0 * spread(index, 0), 1000.0 * spread(index, 1)],
            height_m: 125.0 + 25.0 * spread(index, 2),
            attitude_rad: [heading_rad * spread(index, 3), tilt_rad * spread(index, 4), tilt_rad * spread(index, 5)],
            rectified_rad: None,
            follow_up_rad: 0.0,
        };
        let rays = Rays::new(&blank, matched, configured_rad).expect("sees the ground");
        let (mean, _) = rays.displacement(true_rad).expect("sees the ground");
        let fix_m = std::array::from_fn(|axis| blank.position_m[axis] + blank.height_m * mean[axis]);
        Sighting { fix_m, ..blank }
    };
    (0..count).map(sighting).collect()
}

/// With normal errors of 0.3 m in each axis, one sigma.
fn noisy(mut sightings: Vec<Sighting>, seed: u64) -> Vec<Sighting> {
    let mut random = ChaCha12Rng::seed_from_u64(seed);
    let mut uniform = || (random.next_u64() >> 11) as f64 / (1u64 << 53) as f64;
    for sighting in &mut sightings {
        // Box and Muller.
        let (length, (sin, cos)) = ((-2.0 * (1.0 - uniform()).ln()).sqrt(), (TAU * uniform()).sin_cos());
        sighting.fix_m = [sighting.fix_m[0] + 0.3 * length * cos, sighting.fix_m[1] + 0.3 * length * sin];
    }
    sightings
}

fn found(sightings: &[Sighting], with_offset: bool) -> Result<Boresight, BoresightError> {
    estimate(sightings, &footprint(60.0), CONFIGURED_RAD, with_offset)
}

/// Three axes turned one after the other, each about itself, and no rotation matrix: a camera that hardly sees more than the
/// nadir finds it where the believed camera has it.
#[test]
fn the_nadir_by_active_turns() {
    let blank = flight(1, 1.0, 0.1)[0];
    for (attitude_rad, follow_up_rad) in [([0.3, 0.15, -0.1], 0.0), ([2.5, -0.1, 0.17], 2.4), ([-1.0, 0.05, 0.02], 0.3)]
    {
        let turned = |axes: [Vector3<f64>; 3], about: Vector3<f64>, angle: f64| {
            let turn = Rotation3::from_axis_angle(&Unit::new_normalize(about), angle);
            axes.map(|axis| turn * axis)
        };
        // Right, forward, up.
        let level = [Vector3::x(), Vector3::y(), Vector3::z()];
        let headed = turned(level, -level[2], attitude_rad[0]);
        let pitched = turned(headed, headed[0], attitude_rad[1]);
        let rolled = turned(pitched, pitched[1], attitude_rad[2]);
        let mount = turned(rolled, rolled[2], follow_up_rad);
        let camera = |angles_rad| {
            let rotation = rotation::matrix(angles_rad);
            [0, 1, 2].map(|k| mount[0] * rotation[(0, k)] + mount[1] * rotation[(1, k)] + mount[2] * rotation[(2, k)])
        };
        let (configured, truly) = (camera(CONFIGURED_RAD), camera(TRUE_RAD));
        let ray: Vector3<f64> = (0..3).map(|k| truly[k] * -configured[k].z).sum();
        let sighting = Sighting { attitude_rad, follow_up_rad, ..blank };
        let mut narrow = footprint(60.0);
        narrow.patch = [1e-7; 2];
        let (mean, _) = Rays::new(&sighting, &narrow, CONFIGURED_RAD)
            .expect("sees the ground")
            .displacement(TRUE_RAD)
            .expect("sees the ground");
        assert!((mean - ray.xy() / -ray.z).amax() < 1e-9, "{mean} {ray}");
        assert!(mean.norm() > 0.005);
    }
}

/// Tilted by a small angle d, a camera of 60 degrees sees the ground d (1 + tan²(30 degrees) / 3) off in the mean.
#[test]
fn a_patch_moves_farther_than_its_nadir() {
    let level = Sighting { attitude_rad: [0.0; 3], ..flight(1, 1.0, 0.1)[0] };
    let rays = Rays::new(&level, &footprint(60.0), [0.0; 3]).expect("sees the ground");
    let (mean, _) = rays.displacement([0.0, 1e-4, 0.0]).expect("sees the ground");
    // The mean of the squares of twelve middles lacks 1/144 of the integral's.
    let wanted = 1e-4 * (1.0 + (1.0 - 1.0 / 144.0) / 9.0);
    assert!((mean.y - wanted).abs() < 1e-7 && mean.x.abs() < 1e-12, "{mean} {wanted}");
}

#[test]
fn derivatives_are_differences() {
    let sighting = flight(3, 2.0, 0.2)[2];
    let rays = Rays::new(&sighting, &footprint(60.0), CONFIGURED_RAD).expect("sees the ground");
    let (_, derivatives) = rays.displacement(TRUE_RAD).expect("sees the ground");
    for k in 0..3 {
        let moved = |by: f64| {
            let mut angles_rad = TRUE_RAD;
            angles_rad[k] += by;
            rays.displacement(angles_rad).expect("sees the ground").0
        };
        let difference = (moved(1e-5) - moved(-1e-5)) / 2e-5;
        assert!((difference - derivatives.column(k)).amax() < 1e-8, "{k}");
    }
}

#[test]
fn a_flight_without_errors_gives_the_boresight_back() {
    for offset_m in [None, Some([2.5, -1.5])] {
        let mut sightings = flight(40, 3.0, 0.17);
        let [east, north] = offset_m.unwrap_or_default();
        for sighting in &mut sightings {
            sighting.fix_m = [sighting.fix_m[0] + east, sighting.fix_m[1] + north];
        }
        let found = found(&sightings, offset_m.is_some()).expect("found");
        for (k, truth_rad) in TRUE_RAD.into_iter().enumerate() {
            assert!((found.angles_rad[k] - truth_rad).abs() < 1e-9, "{k}: {found:?}");
        }
        assert_eq!(found.determined, [true; 3]);
        assert_eq!(found.offset.is_some(), offset_m.is_some());
        if let (Some((found_m, _)), Some(offset_m)) = (found.offset, offset_m) {
            assert!((found_m[0] - offset_m[0]).hypot(found_m[1] - offset_m[1]) < 1e-7, "{found_m:?}");
        }
    }
}

/// One fix in ten is 20 m off, always to the same side. Each pulls with two sigmas at most, so the mean moves by a fifth of a
/// fix's sigma, 3.5 of the mean's own over 300; with squares it would be off by 2 m / 125 m, a degree.
#[test]
fn wrong_fixes_are_named_and_do_no_harm() {
    let good = noisy(flight(300, 3.0, 0.17), 1);
    let mut spoilt = good.clone();
    spoilt.iter_mut().step_by(10).for_each(|sighting| sighting.fix_m[0] += 20.0);
    let (clean, robust) = (found(&good, false).expect("found"), found(&spoilt, false).expect("found"));
    let wrong: Vec<usize> = (0..300).step_by(10).collect();
    assert!(clean.outliers.len() <= 1 && wrong.iter().all(|index| robust.outliers.contains(index)), "{robust:?}");
    assert!(robust.outliers.len() <= wrong.len() + 1);
    for k in 0..3 {
        let off = (robust.angles_rad[k] - clean.angles_rad[k]).abs() / clean.random_sd_rad[k];
        assert!(off < 6.0, "{k}: {off} sigmas, {robust:?}");
    }
    // 0.3 m of 0.2 m east and 0.25 m north; each of 600 residuals adds 1/600 of relative variance to its square.
    let wanted = (0.5 * ((0.3_f64 / 0.2).powi(2) + (0.3_f64 / 0.25).powi(2))).sqrt();
    assert!((clean.sigma0 / wanted - 1.0).abs() < 0.12, "{} {wanted}", clean.sigma0);
}

/// Squares of the errors over the covariance, of many flights: its diagonal is right to what 30 values tell. With 1,200 fixes a
/// flight the noise leaves 0.1 degrees of kappa and the model another 0.1, so that all angles are determined.
#[test]
fn the_standard_deviations_are_those_of_the_errors() {
    let all = noisy(flight(30 * 1200, 3.0, 0.17), 2);
    let mut squares = [0.0; 3];
    for part in all.chunks(1200) {
        let found = found(part, false).expect("found");
        assert_eq!(found.determined, [true; 3]);
        for k in 0..3 {
            squares[k] += ((found.angles_rad[k] - TRUE_RAD[k]) / found.random_sd_rad[k]).powi(2) / 30.0;
        }
    }
    // Mean squares of 30 normal numbers: one sigma is √(2/30) = 0.26.
    assert!(squares.iter().all(|square| (square - 1.0).abs() < 0.77), "{squares:?}");
}

/// An attitude that is off by 0.2 degrees of pitch and roll, anew every `lasting` fixes or so, moves each fix by 0.4 m along the camera's axes.
fn drifting(mut sightings: Vec<Sighting>, lasting: f64, seed: u64) -> Vec<Sighting> {
    let still = Sighting { fix_m: [0.0; 2], ..sightings[0] };
    // Each a normal number a fix, of which the scale is taken off again.
    let normal: Vec<[f64; 2]> = noisy(vec![still; sightings.len()], seed).iter().map(|one| one.fix_m).collect();
    let (left, mut off_rad) = ((-1.0 / lasting).exp(), [0.0; 2]);
    for (index, (sighting, normal)) in sightings.iter_mut().zip(normal).enumerate() {
        let [keeps, moves] = if index == 0 { [0.0, 1.0] } else { [left, (1.0 - left * left).sqrt()] };
        off_rad = [0, 1].map(|axis| keeps * off_rad[axis] + moves * 0.003_5 * normal[axis] / 0.3);
        let ((sin, cos), [right, forward]) =
            (sighting.attitude_rad[0].sin_cos(), off_rad.map(|rad| rad * sighting.height_m));
        sighting.fix_m =
            [sighting.fix_m[0] + right * cos + forward * sin, sighting.fix_m[1] - right * sin + forward * cos];
    }
    sightings
}

/// Fixes that share an error count for fewer than they are: mean squares of the errors of phi and omega in their standard deviations, 24
/// flights of 80 fixes. One sigma is √(2/48) = 0.2 where the standard deviations are right; those of errors that last for the tenth of a
/// flight may be too large by a half, since errors that last longer look alike. As if all were independent they are 1.4, 3.1 and 8.6.
#[test]
fn errors_that_last_make_the_standard_deviations_larger() {
    for (lasting, at_least) in [(4.0, 0.25), (10.0, 0.25), (25.0, 0.3)] {
        let squares = (0..24).map(|seed| {
            let flown = drifting(noisy(flight(80, 3.0, 0.17), seed), lasting, 100 + seed);
            let found = estimate_to(0.1, &flown, &footprint(60.0), CONFIGURED_RAD, false).expect("found");
            let in_sigmas = |k: usize| (found.angles_rad[k] - TRUE_RAD[k]) / found.random_sd_rad[k];
            0.5 * (in_sigmas(0).powi(2) + in_sigmas(1).powi(2))
        });
        let mean = squares.sum::<f64>() / 24.0;
        println!("errors that last for {lasting} fixes: {mean:.2}");
        assert!((at_least..1.6).contains(&mean), "{lasting}: {mean}");
    }
}

#[test]
fn level_flights_do_not_show_kappa() {
    let found = found(&noisy(flight(100, 3.0, 1e-4), 1), false).expect("found");
    assert_eq!(found.determined, [true, true, false]);
    assert_eq!(found.angles_rad[2], CONFIGURED_RAD[2]);
    assert!(found.sd_rad[2] > SD_MAX_RAD && found.next_rad == [None; 3], "{found:?}");
    for (k, truth_rad) in TRUE_RAD.into_iter().enumerate().take(2) {
        // The kappa that is kept is wrong, but moves nothing.
        assert!((found.angles_rad[k] - truth_rad).abs() < 3.5 * found.sd_rad[k] + 1e-4, "{k}: {found:?}");
    }
}

/// Half of a correction of kappa is uncertain: of one of 0.5 degrees more than the 0.2 that are stated as the most.
#[test]
fn no_angle_is_written_whose_standard_deviation_is_beyond_the_limit() {
    let kappa = |off_deg: f64| [TRUE_RAD[0], TRUE_RAD[1], CONFIGURED_RAD[2] + off_deg.to_radians()];
    let near = found(&flight_of(kappa(0.3), 100, 3.0, 0.17), false).expect("found");
    assert_eq!((near.determined, near.next_rad), ([true; 3], [None; 3]));
    let found = found(&flight_of(kappa(0.5), 100, 3.0, 0.17), false).expect("found");
    assert!(found.random_sd_rad[2] < SD_MAX_RAD && found.sd_rad[2] > SD_MAX_RAD, "{found:?}");
    assert_eq!((found.determined, found.angles_rad[2]), ([true, true, false], CONFIGURED_RAD[2]));
    let half_rad = CONFIGURED_RAD[2] + 0.25_f64.to_radians();
    assert!(found.next_rad[2].is_some_and(|next_rad| (next_rad - half_rad).abs() < 1e-9), "{found:?}");
}

/// Whether the matching weighs the whole patch, as the model has it, or the nadir alone, at the other end.
#[test]
fn a_large_correction_is_found_by_further_flights() {
    let true_rad = [TRUE_RAD[0], TRUE_RAD[1], CONFIGURED_RAD[2] + 1_f64.to_radians()];
    let mut nadir = footprint(60.0);
    nadir.patch = [1e-7; 2];
    for matched in [footprint(60.0), nadir] {
        let (mut mount_rad, mut off_rad) = (CONFIGURED_RAD, 1_f64.to_radians());
        let flights = (1..9).find(|_| {
            let sightings = flight_with(mount_rad, true_rad, &matched, 100, 3.0, 0.17);
            let found = estimate(&sightings, &footprint(60.0), mount_rad, false).expect("found");
            mount_rad = std::array::from_fn(|k| found.next_rad[k].unwrap_or(found.angles_rad[k]));
            let left_rad = (mount_rad[2] - true_rad[2]).abs();
            // Half is left at one end, a tenth on the other side at the other; then the correction is written, share and all.
            assert!(found.determined[2] || left_rad < 0.55 * off_rad, "{left_rad} {off_rad} {found:?}");
            off_rad = left_rad;
            assert!(!found.determined[2] || left_rad < 1.5 * found.sd_rad[2] + 1e-9, "{left_rad} {found:?}");
            found.determined[2]
        });
        assert!(flights.is_some_and(|flights| (2..5).contains(&flights)), "{flights:?}");
    }
}

/// Eight degrees are two fifths of a degree by the model's share, more than what is written, and yet no tilt of the other axis and no offset.
#[test]
fn a_large_tilt_is_shown_where_it_is_too_large_to_be_written() {
    for off_deg in [-8.9_f64, -4.5, 4.5, 8.9] {
        let true_rad = [CONFIGURED_RAD[0], CONFIGURED_RAD[1] + off_deg.to_radians(), CONFIGURED_RAD[2]];
        let found = found(&noisy(flight_of(true_rad, 300, 3.0, 0.17), 3), true).expect("found");
        assert!(!found.determined[1] && found.angles_rad[1] == CONFIGURED_RAD[1], "{found:?}");
        assert!(
            found.next_rad[1]
                .is_some_and(|next_rad| (next_rad - true_rad[1]).abs() < 0.06 * off_deg.to_radians().abs())
        );
        let off_rad = found.shown_rad[1].expect("shown") - true_rad[1];
        assert!(off_rad.abs() < 5.0 * found.random_sd_rad[1], "{off_rad} {found:?}");
        assert!((found.angles_rad[0] - true_rad[0]).abs() < 5.0 * found.sd_rad[0], "{found:?}");
        let (offset_m, sd_m) = found.offset.expect("asked for");
        assert!((0..2).all(|axis| offset_m[axis].abs() < 5.0 * sd_m[axis]), "{found:?}");
    }
}

/// A board that has taken half of the tilt out of the attitude rectifies with what is left, and its fixes are off by that.
#[test]
fn what_the_board_has_learnt_is_put_back() {
    let off_rad = 8.9_f64.to_radians();
    let true_rad = [0.0, off_rad, 0.0];
    let learnt = |index: usize, sighting: Sighting| {
        let [_, pitch, roll] = sighting.attitude_rad;
        let blank =
            Sighting { rectified_rad: Some([pitch + off_rad * (index as f64 / 100.0).min(1.0), roll]), ..sighting };
        let rays = Rays::new(&blank, &footprint(60.0), [0.0; 3]).expect("sees the ground");
        let (mean, _) = rays.displacement(true_rad).expect("sees the ground");
        let fix_m = std::array::from_fn(|axis| blank.position_m[axis] + blank.height_m * mean[axis]);
        Sighting { fix_m, ..blank }
    };
    let flown = flight_with([0.0; 3], true_rad, &footprint(60.0), 200, 3.0, 0.1);
    let sightings: Vec<Sighting> = flown.into_iter().enumerate().map(|(index, one)| learnt(index, one)).collect();
    // Level, it is found nearly where it is, so that this is put back at all.
    let last = &sightings[199];
    let off_m = (last.fix_m[0] - last.position_m[0]).hypot(last.fix_m[1] - last.position_m[1]);
    assert!(off_m < 0.02 * last.height_m, "{off_m}");
    let found = estimate(&sightings, &footprint(60.0), [0.0; 3], true).expect("found");
    assert!((found.shown_rad[1].expect("shown") - off_rad).abs() < 1e-6, "{found:?}");
}

#[test]
fn what_cannot_be_separated_is_refused() {
    for heading_rad in [0.0, 0.1, 0.25] {
        let outcome = found(&noisy(flight(100, heading_rad, 0.17), 1), true);
        assert!(
            matches!(outcome, Err(BoresightError::Inseparable(inflation)) if inflation > INFLATION_MAX),
            "{outcome:?}"
        );
        assert!(found(&noisy(flight(100, heading_rad, 0.17), 1), false).is_ok());
    }
    let apart = found(&noisy(flight(100, 1.0, 0.17), 1), true).expect("57 degrees either way");
    assert!(apart.offset.is_some_and(|(offset_m, sd_m)| offset_m[0].abs() < 4.0 * sd_m[0]));
    assert_eq!(found(&flight(9, 3.0, 0.17), false), Err(BoresightError::TooFew(9)));
    let mut wild = noisy(flight(100, 3.0, 0.17), 1);
    wild.iter_mut().enumerate().for_each(|(index, sighting)| sighting.fix_m[0] += 40.0 * spread(index, 1));
    let outcome = found(&wild[..12], false);
    assert!(matches!(outcome, Err(BoresightError::Undetermined(_) | BoresightError::Diverged)), "{outcome:?}");
}
