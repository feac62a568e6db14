//! How the camera sits, flown again with what was found until it stays: what a flight with a large tilt shows of it is uncertain by a share of
//! the tilt, and a flight without it shows the rest.

use super::judge::Verdict;
use super::platform::Platform;
use super::words;
use crate::setup::frames::table::Table;
use plumbline_survey::camera_file::CameraFile;

/// Flights with a camera as it was found at most. Chosen: what is left of a tilt falls to a twentieth by each, so that the third of 9 degrees
/// leaves less than counts as settled.
const FLIGHTS_MAX: usize = 3;

/// What the flights say of camera and map, and the last of those with the camera as it was found; nothing where it sits as its file says. `fly`
/// flies with a camera that sits by φ, ω, κ, degrees.
///
/// # Errors
/// Those of `fly`.
pub fn refined<E>(
    (table, camera): (&Table, &CameraFile),
    verdict: &Verdict,
    fly: &mut dyn FnMut([f64; 3]) -> Result<Verdict, E>,
) -> Result<(Platform, Option<Verdict>), E> {
    let told_deg = camera.boresight.unwrap_or_default();
    let first = Platform::of(table, camera, verdict, told_deg);
    let (mut platform, mut flown_deg, mut flown) = (first.clone(), told_deg, None);
    for _ in 0..FLIGHTS_MAX {
        let Some(deg) = platform.to_fly_deg(camera, flown_deg) else { break };
        let again = fly(deg)?;
        let found = Platform::of(table, camera, &again, deg);
        let tells = found.separated;
        if tells {
            platform = found;
        }
        (flown_deg, flown) = (deg, Some(again));
        if !tells {
            break;
        }
    }
    let knows_truth = table.knows_truth();
    let (platform, corrected) = match flown {
        Some(again) if is_better(&again, verdict) && (0..3).any(|k| platform.is_off(k, told_deg)) => {
            (platform, Some(again))
        }
        Some(_) => return Ok((of_no_use(first, told_deg, knows_truth), None)),
        None => (platform, None),
    };
    if !platform.separated {
        return Ok((platform, corrected));
    }
    let says = words::separate(&platform, told_deg, knows_truth);
    Ok((Platform { says, ..platform }, corrected))
}

/// Where a flight with the camera as it was found is no better than with it as its file has it: then the angles are not known so well.
fn of_no_use(platform: Platform, told_deg: [f64; 3], knows_truth: bool) -> Platform {
    let says = words::of_no_use(&platform, told_deg, knows_truth);
    let found_deg = platform.boresight_deg.unwrap_or(told_deg);
    let sd_deg = platform
        .boresight_sd_deg
        .map(|sd_deg| std::array::from_fn(|k| sd_deg[k].map(|sd: f64| sd.max((found_deg[k] - told_deg[k]).abs()))));
    Platform { boresight_sd_deg: sd_deg, says, ..platform }
}

/// Whether fixes are nearer in more than half of the frames that both have, beyond the standard deviation of tossing a coin for each.
fn is_better(with: &Verdict, without: &Verdict) -> bool {
    let both = with.frames.iter().zip(&without.frames);
    let pairs = both.filter_map(|(with, without)| Some((with.fix.as_ref().ok()?, without.fix.as_ref().ok()?)));
    let (nearer, farther) = pairs.fold((0.0, 0.0), |(nearer, farther): (f64, f64), (with, without)| {
        if with.off_m() < without.off_m() { (nearer + 1.0, farther) } else { (nearer, farther + 1.0) }
    });
    nearer - farther > (nearer + farther).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::evaluate::judge::{Fixed, Judged};

    fn verdict(errors_m: &[f64]) -> Verdict {
        let fix = |error_m: &f64| Fixed {
            place_m: [0.0; 2],
            covariance_m2: [1.0, 0.0, 1.0],
            offset_m: [*error_m, 0.0],
            error_m: [*error_m, 0.0],
            rectified_rad: None,
            risk: 1e-4,
        };
        let frames = errors_m.iter().map(|error_m| Judged { fix: Ok(fix(error_m)) }).collect();
        Verdict { frames, median_offset_m: None, resolution_m: 2.0 }
    }

    #[test]
    fn a_correction_is_better_where_most_fixes_are_nearer() {
        let before = verdict(&[4.0; 25]);
        assert!(is_better(&verdict(&[1.0; 25]), &before));
        assert!(!is_better(&verdict(&[5.0; 25]), &before));
        // 15 of 25 are one standard deviation more than half.
        let some = |nearer: usize| verdict(&[vec![3.9; nearer], vec![4.1; 25 - nearer]].concat());
        assert!(!is_better(&some(15), &before) && is_better(&some(16), &before));
        assert!(!is_better(&verdict(&[]), &before));
    }
}
