//! The autopilot's own position against the truth, and since when it has had no satellite navigation.

use super::messages::OwnPosition;
use super::truth::{STAMP_CUT_US, Truth};
use plumbline_survey::crs::Crs;
use serde::Serialize;
use std::collections::BTreeMap;

/// GPS_RAW_INT's kinds of fix below this are none.
const FIX_MIN: u8 = 2;
/// Seconds after the loss at which the error is told.
const MARKS_S: [u32; 5] = [10, 30, 60, 90, 120];
/// Seconds after the loss that the mean is over.
const SPAN_S: [f64; 2] = [20.0, 90.0];

/// The autopilot's position error at an instant.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ErrorAt {
    /// Since the first exposure, seconds.
    pub at_s: f64,
    /// Horizontal, metres.
    pub error_m: f64,
    /// Horizontal, metres a second.
    pub velocity_error_m_s: f64,
}

/// `navigation` of `report.json`.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Navigation {
    /// Root mean square horizontal error from the first exposure to the end.
    pub rms_m: f64,
    /// Likewise of the velocity.
    pub velocity_rms_m_s: f64,
    /// When satellite navigation was lost for good, seconds after the first exposure; null where it was not.
    pub gnss_lost_at_s: Option<f64>,
    /// For how long until the end.
    pub gnss_lost_s: Option<f64>,
    /// The error so many seconds after the loss.
    pub error_after_loss_m: BTreeMap<u32, f64>,
    /// Root mean square from 20 to 90 s after the loss.
    pub rms_20_90_s_m: Option<f64>,
    /// Likewise of the velocity.
    pub velocity_rms_20_90_s_m_s: Option<f64>,
    /// The error over time.
    #[serde(skip)]
    pub errors: Vec<ErrorAt>,
}

/// What the autopilot said of itself.
#[derive(Debug, Default)]
pub struct NavigationLog {
    positions: Vec<OwnPosition>,
    /// Since when satellite navigation has been lost, microseconds.
    lost_us: Option<f64>,
}

impl NavigationLog {
    /// A position.
    pub fn position(&mut self, position: OwnPosition) {
        self.positions.push(position);
    }

    /// The kind of fix at `now_us`.
    pub fn gnss(&mut self, fix: u8, now_us: f64) {
        self.lost_us = if fix >= FIX_MIN { None } else { self.lost_us.or(Some(now_us)) };
    }

    /// The figures of what was flown since `begin_us`; `None` where nothing can be compared.
    pub fn navigation(&self, truth: &Truth, crs: &Crs, begin_us: f64) -> Option<Navigation> {
        let since = |at_us: f64| (at_us - begin_us) * 1e-6;
        let error = |position: &OwnPosition| {
            let at_us = f64::from(position.time_boot_ms) * 1000.0 + STAMP_CUT_US;
            let state = truth.at(at_us).filter(|_| at_us >= begin_us)?;
            let [lat, lon] = position.place_e7.map(|e7| f64::from(e7) * 1e-7);
            let (east_m, north_m) = crs.from_wgs84(lat, lon).ok()?;
            let convergence_rad = crs.convergence_rad(state.east_m, state.north_m).ok()?;
            let (sin, cos) = convergence_rad.sin_cos();
            let [north, east, _] = position.velocity_ned_m_s;
            let [true_east, true_north, _] = state.velocity_enu_m_s;
            let velocity_error_m_s =
                (east * cos - north * sin - true_east).hypot(north * cos + east * sin - true_north);
            let error_m = (east_m - state.east_m).hypot(north_m - state.north_m);
            Some(ErrorAt { at_s: since(at_us), error_m, velocity_error_m_s })
        };
        let errors: Vec<ErrorAt> = self.positions.iter().filter_map(error).collect();
        let end_s = errors.last()?.at_s;
        // A loss before the first exposure counts from there.
        let lost_at_s = self.lost_us.map(|at_us| since(at_us).max(0.0)).filter(|at_s| *at_s < end_s);
        let all = [0.0, f64::INFINITY];
        let after = lost_at_s.map(|at_s| SPAN_S.map(|s| at_s + s)).filter(|[_, to_s]| *to_s <= end_s);
        Some(Navigation {
            rms_m: rms(&errors, all, |error| error.error_m)?,
            velocity_rms_m_s: rms(&errors, all, |error| error.velocity_error_m_s)?,
            gnss_lost_at_s: lost_at_s,
            gnss_lost_s: lost_at_s.map(|at_s| end_s - at_s),
            error_after_loss_m: lost_at_s.map_or_else(BTreeMap::new, |at_s| marks(&errors, at_s)),
            rms_20_90_s_m: after.and_then(|span_s| rms(&errors, span_s, |error| error.error_m)),
            velocity_rms_20_90_s_m_s: after.and_then(|span_s| rms(&errors, span_s, |error| error.velocity_error_m_s)),
            errors,
        })
    }
}

/// The errors nearest to the marks that were reached.
fn marks(errors: &[ErrorAt], lost_at_s: f64) -> BTreeMap<u32, f64> {
    let at = |mark: u32| {
        let mark_s = lost_at_s + f64::from(mark);
        let later = errors.iter().find(|error| error.at_s >= mark_s)?;
        Some((mark, later.error_m))
    };
    MARKS_S.into_iter().filter_map(at).collect()
}

fn rms(errors: &[ErrorAt], [from_s, to_s]: [f64; 2], of: fn(&ErrorAt) -> f64) -> Option<f64> {
    let within = errors.iter().filter(|error| (from_s..=to_s).contains(&error.at_s));
    let (sum, count) = within.fold((0.0, 0), |(sum, count), error| (sum + of(error) * of(error), count + 1));
    (count > 0).then(|| (sum / f64::from(count)).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vehicle::motion::TrueState;

    const PLACE: [f64; 2] = [560_000.0, 5_330_000.0];

    /// Two minutes at 10 Hz of a vehicle that stands and believes to drift east by 0.1 m/s from second 10 on; satellite
    /// navigation goes then, and once before for a moment.
    fn flown(lost: bool) -> Option<Navigation> {
        let crs = Crs::from_epsg(32633).unwrap();
        let (mut truth, mut log) = (Truth::default(), NavigationLog::default());
        for index in 0..1250_u32 {
            let (time_boot_ms, at_s) = (5000 + 100 * index, 0.1 * f64::from(index));
            let state = TrueState { east_m: PLACE[0], north_m: PLACE[1], ..TrueState::default() };
            truth.attitude(time_boot_ms, [1.0, 0.0, 0.0, 0.0], at_s);
            truth.state([1.0, 0.0, 0.0, 0.0], state, at_s);
            truth.stamp(f64::from(time_boot_ms) * 1000.0 + 500.0);
            let (lat, lon) = crs.to_wgs84(PLACE[0] + 0.1 * (at_s - 10.0).max(0.0), PLACE[1]).unwrap();
            let place_e7 = [lat, lon].map(|degrees| (degrees * 1e7).round() as i32);
            let velocity_ned_m_s = [0.0, if at_s > 10.0 { 0.1 } else { 0.0 }, 0.0];
            log.position(OwnPosition { time_boot_ms, place_e7, alt_m: 0.0, above_home_m: 0.0, velocity_ned_m_s });
            let is_lost = index == 50 || at_s > 10.0 && lost;
            log.gnss(if is_lost { 1 } else { 3 }, 1000.0 * f64::from(time_boot_ms));
        }
        truth.settle();
        log.navigation(&truth, &crs, 5e6)
    }

    #[test]
    fn errors_count_from_the_loss() {
        let navigation = flown(true).unwrap();
        let lost_at_s = navigation.gnss_lost_at_s.unwrap();
        assert!((lost_at_s - 10.1).abs() < 0.01, "{lost_at_s}");
        assert!((navigation.gnss_lost_s.unwrap() - 114.7).abs() < 0.2);
        for (mark, error_m) in &navigation.error_after_loss_m {
            assert!((error_m - 0.1 * f64::from(*mark) - 0.01).abs() < 0.03, "{mark}: {error_m}");
        }
        let marks: Vec<u32> = navigation.error_after_loss_m.keys().copied().collect();
        assert_eq!(marks, [10, 30, 60, 90]);
        // The root mean square of 0.1 t from 20 to 90: 0.1 sqrt((90³ − 20³) / (3 · 70)).
        let expected_m = 0.1 * ((90f64.powi(3) - 20f64.powi(3)) / 210.0).sqrt();
        assert!((navigation.rms_20_90_s_m.unwrap() - expected_m).abs() < 0.05);
        assert!((navigation.velocity_rms_20_90_s_m_s.unwrap() - 0.1).abs() < 1e-3);
    }

    #[test]
    fn without_a_loss_there_is_the_error_alone() {
        let navigation = flown(false).unwrap();
        assert!(navigation.rms_m > 5.0 && navigation.gnss_lost_at_s.is_none() && navigation.gnss_lost_s.is_none());
        assert!(navigation.error_after_loss_m.is_empty() && navigation.rms_20_90_s_m.is_none());
        assert_eq!(NavigationLog::default().navigation(&Truth::default(), &Crs::from_epsg(32633).unwrap(), 0.0), None);
    }
}
