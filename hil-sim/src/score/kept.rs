//! What a flight's navigation is worth: where the board and the simulated autopilot believed to be against where the vehicle was, with
//! fixes and without.

use super::protection::{Placed, protection, radii};
use super::statistics::mean;
use crate::live::navigation::Navigation;
use crate::vehicle::aloft::moment::{Moment, ToldOfGnss, Track};
use crate::vehicle::inertial::estimator::FixCounts;
use serde::Serialize;

/// So long after the loss of satellite navigation its last help still lasts, seconds.
const SETTLED_S: f64 = 20.0;
/// Over so many seconds at each end of the span the error's means are taken, of which the drift is the difference.
const ENDS_S: f64 = 10.0;

/// `navigation` of `report.json`.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum Navigated {
    /// Of a real autopilot's flight.
    Live(Navigation),
    /// Of one that was kept by its fixes.
    Kept(Box<Kept>),
}

impl Navigated {
    /// That of a real autopilot.
    #[must_use]
    pub fn live(&self) -> Option<&Navigation> {
        match self {
            Navigated::Live(navigation) => Some(navigation),
            Navigated::Kept(_) => None,
        }
    }

    /// That of a simulated one.
    #[must_use]
    pub fn kept(&self) -> Option<&Kept> {
        match self {
            Navigated::Live(_) => None,
            Navigated::Kept(kept) => Some(kept),
        }
    }
}

/// A flight that was kept by its fixes. The span is from 20 s after the loss of satellite navigation to the end; from 20 s on where it
/// was not lost.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Kept {
    /// Root mean square horizontal error of the board's position in the span, of its own filter, frame by frame.
    pub rms_m: Option<f64>,
    /// Largest.
    pub max_m: Option<f64>,
    /// Normalised error squared of it, a degree of freedom: 1 where the filter knows how wrong it is.
    pub nees: Option<f64>,
    /// Share of these frames in which the error was within the protection level.
    pub protection_held: Option<f64>,
    /// Median of the protection levels.
    pub protection_median_m: Option<f64>,
    /// Share within the radius that holds 95 % of normal errors of the stated sigmas.
    pub protection_95_held: Option<f64>,
    /// Likewise 99 %.
    pub protection_99_held: Option<f64>,
    /// Likewise 99.9 %.
    pub protection_999_held: Option<f64>,
    /// Median of the radii of 95 %.
    pub protection_95_median_m: Option<f64>,
    /// The autopilot's own position.
    pub autopilot: Autopilot,
    /// When satellite navigation was lost, seconds of the simulated time; null where it was not.
    pub gnss_lost_s: Option<f64>,
    /// What the autopilot's error grew by from the span's first 10 s to its last, metres a minute.
    pub drift_m_min: Option<f64>,
    /// Root mean square of the autopilot's horizontal velocity's error in the span.
    pub velocity_rms_m_s: Option<f64>,
    /// Root mean square of its heading's error in the span.
    pub heading_rms_deg: Option<f64>,
    /// How far beside its legs it truly flew in the span, turns onto them left out: root mean square.
    pub across_rms_m: Option<f64>,
    /// Likewise: largest.
    pub across_max_m: Option<f64>,
    /// What the board told the pilot of satellite navigation, in the whole flight.
    pub gnss: ToldOfGnss,
    /// What the autopilot's filter did with the fixes.
    pub fixes: FixCounts,
    /// What would have been of this very flight without a fix since the loss; null without a loss.
    pub without_fixes: Option<Free>,
    /// The flight itself.
    #[serde(skip)]
    pub track: Track,
}

/// Where the simulated autopilot believed to be, over the same span.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Autopilot {
    /// Root mean square horizontal error.
    pub rms_m: Option<f64>,
    /// Largest.
    pub max_m: Option<f64>,
    /// Normalised error squared of its filter's position, a degree of freedom.
    pub nees: Option<f64>,
}

/// A filter that gets no fixes.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Free {
    /// As [`Autopilot::rms_m`].
    pub rms_m: Option<f64>,
    /// As [`Autopilot::max_m`].
    pub max_m: Option<f64>,
    /// As [`Kept::drift_m_min`].
    pub drift_m_min: Option<f64>,
}

/// The figures of a track, and of the board's places along it.
#[must_use]
pub fn kept(track: &Track, places: &[Placed]) -> Kept {
    let from_s = track.gnss_lost_s.unwrap_or(0.0) + SETTLED_S;
    let places: Vec<Placed> = places.iter().filter(|place| place.at_s >= from_s).copied().collect();
    let (board, radii) = (protection(&places), radii(&places));
    let span: Vec<&Moment> = track.moments.iter().filter(|moment| moment.at_s >= from_s).collect();
    let errors: Vec<(f64, f64)> = span.iter().map(|moment| (moment.at_s, moment.error_m())).collect();
    let free: Vec<(f64, f64)> = span.iter().filter_map(|moment| Some((moment.at_s, moment.free_error_m()?))).collect();
    let across: Vec<f64> = span.iter().filter(|moment| !moment.is_turning).map(|moment| moment.across_m).collect();
    let of = |pick: fn(&Moment) -> f64| rms(span.iter().map(|moment| pick(moment)));
    let nees: Vec<f64> = span.iter().filter_map(|moment| moment.nees).map(|nees| 0.5 * nees).collect();
    Kept {
        rms_m: board.map(|board| board.rms_m),
        max_m: largest(places.iter().map(Placed::error_m)),
        nees: board.map(|board| board.nees),
        protection_held: board.map(|board| board.held),
        protection_median_m: board.map(|board| board.median_m),
        protection_95_held: radii.map(|radii| radii.held[0]),
        protection_99_held: radii.map(|radii| radii.held[1]),
        protection_999_held: radii.map(|radii| radii.held[2]),
        protection_95_median_m: radii.map(|radii| radii.median_m),
        autopilot: Autopilot {
            rms_m: rms(errors.iter().map(|(_, error)| *error)),
            max_m: largest(errors.iter().map(|(_, error)| *error)),
            nees: mean(&nees),
        },
        gnss_lost_s: track.gnss_lost_s,
        drift_m_min: drift(&errors),
        velocity_rms_m_s: of(|moment| moment.velocity_error_m_s),
        heading_rms_deg: of(|moment| moment.heading_error_rad.to_degrees()),
        across_rms_m: rms(across.iter().copied()),
        across_max_m: largest(across.iter().map(|across| across.abs())),
        gnss: track.gnss,
        fixes: track.fixes,
        without_fixes: track.gnss_lost_s.map(|_| Free {
            rms_m: rms(free.iter().map(|(_, error)| *error)),
            max_m: largest(free.iter().map(|(_, error)| *error)),
            drift_m_min: drift(&free),
        }),
        track: track.clone(),
    }
}

/// What an error grows by a minute; nothing of a span that is too short to have two ends.
fn drift(errors: &[(f64, f64)]) -> Option<f64> {
    let ((first_s, _), (last_s, _)) = (errors.first()?, errors.last()?);
    let minutes = (last_s - first_s - ENDS_S) / 60.0;
    let of = |from_s: f64, to_s: f64| {
        let within = errors.iter().filter(|(at_s, _)| (from_s..=to_s).contains(at_s));
        mean(&within.map(|(_, error)| *error).collect::<Vec<_>>())
    };
    let (start, end) = (of(*first_s, first_s + ENDS_S)?, of(last_s - ENDS_S, *last_s)?);
    (minutes > ENDS_S / 60.0).then(|| (end - start) / minutes)
}

fn rms(values: impl Iterator<Item = f64>) -> Option<f64> {
    let squares: Vec<f64> = values.map(|value| value * value).collect();
    mean(&squares).map(f64::sqrt)
}

fn largest(values: impl Iterator<Item = f64>) -> Option<f64> {
    values.reduce(f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Lost at 20 s; off by 3 m east and 4 m north ever after, without fixes by 0.5 m a second more. The board is off by 6 m and 8 m until
    /// the span begins, then by 1.5 m, and once by 6 m beyond a protection level of 5 m.
    #[test]
    fn figures_count_from_twenty_seconds_after_the_loss() {
        let moment = |index: u32| {
            let at_s = 0.1 * f64::from(index);
            let off = if at_s < 40.0 { 100.0 } else { 1.0 };
            Moment {
                at_s,
                truth_m: [0.0; 3],
                believed_m: [3.0 * off, 4.0 * off, 9.0],
                free_m: Some([0.5 * (at_s - 40.0), 0.0, 0.0]),
                velocity_error_m_s: 0.2,
                heading_error_rad: 0.0,
                nees: Some(3.0),
                across_m: if index.is_multiple_of(2) { -2.0 } else { 50.0 },
                is_turning: index % 2 == 1,
            }
        };
        let moments = (0..=1200).map(moment).collect();
        let place = |second: u32| {
            let off_m = match second {
                0..40 => [6.0, 8.0],
                100 => [6.0, 0.0],
                _ => [0.0, 1.5],
            };
            Placed { at_s: f64::from(second), off_m, sigma_m: [2.0, 1.0], protection_m: 5.0 }
        };
        let places: Vec<Placed> = (0..120).map(place).collect();
        let kept = kept(&Track { gnss_lost_s: Some(20.0), moments, ..Track::default() }, &places);
        let autopilot = kept.autopilot;
        assert_eq!(
            (autopilot.rms_m, autopilot.max_m, autopilot.nees, kept.across_max_m),
            (Some(5.0), Some(5.0), Some(1.5), Some(2.0))
        );
        // Of 80 places 79 off by 1.5 sigmas north and one by 3 sigmas east, beyond the radius of 95 % and within that of 99 %.
        let mean = |of_79: f64, of_one: f64| (79.0 * of_79 + of_one) / 80.0;
        assert_eq!((kept.rms_m, kept.max_m), (Some(mean(2.25, 36.0).sqrt()), Some(6.0)));
        assert_eq!((kept.nees, kept.protection_held), (Some(mean(1.125, 4.5)), Some(79.0 / 80.0)));
        assert_eq!((kept.protection_95_held, kept.protection_99_held), (Some(79.0 / 80.0), Some(1.0)));
        assert_eq!((kept.protection_999_held, kept.protection_median_m), (Some(1.0), Some(5.0)));
        assert!((kept.protection_95_median_m.unwrap() - 4.8955).abs() < 1e-3);
        assert_eq!(kept.drift_m_min, Some(0.0));
        let free = kept.without_fixes.unwrap();
        assert!(
            (free.drift_m_min.unwrap() - 30.0).abs() < 1e-6 && (free.max_m.unwrap() - 40.0).abs() < 1e-9,
            "{free:?}"
        );
        assert!((free.rms_m.unwrap() - 40.0 / 3f64.sqrt()).abs() < 0.05);
    }
}
