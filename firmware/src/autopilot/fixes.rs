//! What is sent of the fixes: which of them, in which message, and with which covariance.
//!
//! What is sent is a match, of its frame or between years of several, never our filter's estimate: the autopilot's filter is the
//! one that smooths. Its filter takes the errors of successive fixes for independent. Some are not: those of a tilt that drifts,
//! and of a map that lies beside the ground, are the same for many fixes, and a filter that averages n of them believes to have
//! taken them off. So only some fixes are sent, and the part of their covariance that they share is sent n times: R = white + n
//! correlated with n = max(1, 2 f τ), the number of fixes at the rate f within the time constant of an error that is correlated
//! over τ. The white part is the match's own and that of the stamp; the correlated one that of the tilt's drift
//! ([`Fix::tilt_drift_covariance`]), of a map of another year ([`Fix::map_variance_m2`]), and the map's offset, which the settings have.

use crate::wire::fix_message::SentFix;
use crate::wire::incoming::AutopilotKind;
use plumbline_core::fix::Fix;
use plumbline_core::math;
use plumbline_core::pose::History;
use plumbline_core::tile::Geographic;
use plumbline_core::tilt::Attitude;
use plumbline_core::units::Micros;

/// In which message fixes are sent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Form {
    /// ODOMETRY: ArduPilot.
    Odometry,
    /// GLOBAL_POSITION_SENSOR: PX4.
    GlobalPositionSensor,
    /// VISION_POSITION_ESTIMATE.
    VisionPosition,
}

impl Form {
    /// What an autopilot takes, unless the settings say so.
    pub fn of(kind: AutopilotKind) -> Self {
        match kind {
            AutopilotKind::Ardupilot => Form::Odometry,
            AutopilotKind::Px4 | AutopilotKind::Other => Form::GlobalPositionSensor,
        }
    }

    /// Whether it is in metres of the autopilot's local frame.
    pub fn is_local(self) -> bool {
        self != Form::GlobalPositionSensor
    }
}

/// How fixes are sent.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FixSettings {
    /// The message; `None` is chosen by the autopilot's heartbeat.
    pub form: Option<Form>,
    /// GLOBAL_POSITION_SENSOR.id, at least 1.
    pub sensor_id: u8,
    /// Least time from one fix to the next, microseconds.
    pub interval_us: u32,
    /// How long errors stay alike, seconds: τ.
    pub correlation_s: f32,
    /// What the map may lie beside the ground, one sigma of each axis, metres.
    pub map_sigma_m: f32,
    /// Whether the autopilot is to begin anew from a fix that found a lost position.
    pub resets_on_reacquisition: bool,
}

/// Longest gap between two heights to interpolate in, and oldest height that is still taken, microseconds. Heights come ten
/// times a second; a vehicle that climbs at 5 m/s is 5 m off after a second, which the autopilot does not use.
const HEIGHT_GAP_US: u32 = 500_000;
const HEIGHT_AGE_US: i32 = 1_000_000;

/// State of the fixes that are sent.
#[derive(Debug)]
pub struct Fixes {
    settings: FixSettings,
    /// Where the autopilot's local frame begins.
    pub origin: Option<Geographic>,
    down: History<f32, 1, 16>,
    /// Newest velocity to true north and east, m/s, as the autopilot has it.
    pub velocity_m_per_s: [f32; 2],
    newest_at: Option<Micros>,
    /// The number that has the autopilot begin anew from the next fix when it changes.
    resets: u8,
}

impl Fixes {
    /// None sent yet.
    pub fn new(settings: FixSettings) -> Self {
        Fixes { settings, origin: None, down: History::new(), velocity_m_per_s: [0.0; 2], newest_at: None, resets: 0 }
    }

    /// What was sent as the reset counter before this board started anew: it goes on from there.
    pub fn go_on_from(&mut self, resets: u8) {
        self.resets = resets;
    }

    /// A fix found the position `off_px` beside the prediction, (columns, rows), where `near_px` are searched as a rule. The
    /// number that is sent from now on, where it changes: a position that the ordinary search would not have found is one that
    /// the autopilot's filter would hold off.
    pub fn found(&mut self, off_px: [f32; 2], near_px: u16) -> Option<u8> {
        let is_far = off_px.iter().any(|off| off.abs() > f32::from(near_px));
        if !(is_far && self.settings.resets_on_reacquisition) {
            return None;
        }
        self.resets = self.resets.wrapping_add(1);
        Some(self.resets)
    }

    /// In which message fixes are sent to an autopilot of this kind.
    pub fn form(&self, kind: AutopilotKind) -> Form {
        self.settings.form.unwrap_or(Form::of(kind))
    }

    /// One sigma of the map, each axis, metres.
    pub fn map_sigma_m(&self) -> f32 {
        self.settings.map_sigma_m
    }

    /// GLOBAL_POSITION_SENSOR.id.
    pub fn sensor_id(&self) -> u8 {
        self.settings.sensor_id
    }

    /// The vehicle's distance below the origin, metres. One whose stamp runs backwards is of a clock that is no more.
    pub fn down(&mut self, at: Micros, down_m: f32) {
        if self.down.push(at, down_m).is_err() {
            self.down = History::new();
            let _ = self.down.push(at, down_m);
        }
    }

    /// The vehicle's distance below the origin at an instant, as the autopilot itself has it.
    pub fn down_at(&self, at: Micros) -> Option<f32> {
        if let Ok(between) = self.down.at(at, HEIGHT_GAP_US) {
            return Some(between.value);
        }
        let (newest_at, newest_m) = self.down.newest()?;
        (0..=HEIGHT_AGE_US).contains(&at.since(newest_at)).then_some(newest_m)
    }

    /// Whether there is a height.
    pub fn has_height(&self) -> bool {
        self.down.newest().is_some()
    }

    /// Forgets what belongs to a clock that is no more, and the origin: an autopilot that has rebooted chooses another.
    pub fn clear(&mut self) {
        (self.down, self.newest_at, self.origin) = (History::new(), None, None);
    }

    /// The fix of a frame exposed at `at` as it is sent; nothing where it comes too soon after the last. `attitude`: of the
    /// vehicle, from true north.
    pub fn take(&mut self, fix: &Fix, at: Micros, attitude: Attitude) -> Option<SentFix> {
        let FixSettings { interval_us, correlation_s, map_sigma_m, .. } = self.settings;
        // Frames may come a little early: half of their own interval would still be a rate, a tenth is none.
        let least_us = (interval_us - interval_us / 10) as i32;
        if self.newest_at.is_some_and(|newest| (0..least_us).contains(&at.since(newest))) {
            return None;
        }
        self.newest_at = Some(at);
        let alike = (2e6 * correlation_s / interval_us.max(1) as f32).max(1.0);
        let enlarged = |row: usize, col: usize| {
            let (of_year, map) = if row == col { (fix.map_variance_m2, map_sigma_m * map_sigma_m) } else { (0.0, 0.0) };
            fix.covariance[(row, col)] + (alike - 1.0) * (fix.tilt_drift_covariance[(row, col)] + of_year) + alike * map
        };
        let (east, north, cross) = (enlarged(0, 0), enlarged(1, 1), enlarged(0, 1));
        let half = 0.5 * (east - north);
        Some(SentFix {
            at,
            position: fix.position,
            variance_m2: [east, north],
            largest_m2: 0.5 * (east + north) + math::sqrt(half * half + cross * cross),
            attitude,
            velocity_m_per_s: self.velocity_m_per_s,
            resets: self.resets,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::{FixSettings, Fixes};
    use plumbline_core::fix::Fix;
    use plumbline_core::tile::{Geographic, Local};
    use plumbline_core::tilt::Attitude;
    use plumbline_core::units::Micros;

    const SETTINGS: FixSettings = FixSettings {
        form: None,
        sensor_id: 1,
        interval_us: 500_000,
        correlation_s: 5.0,
        map_sigma_m: 0.0,
        resets_on_reacquisition: false,
    };

    fn fix(covariance: [[f32; 2]; 2], tilt_drift_covariance: [[f32; 2]; 2]) -> Fix {
        let position = Geographic { lat_e7: 1, lon_e7: 2 };
        Fix {
            position,
            local: Local::default(),
            covariance: covariance.into(),
            tilt_drift_covariance: tilt_drift_covariance.into(),
            map_variance_m2: 0.0,
        }
    }

    /// Frames at 4 Hz, some a little early: two a second are sent, however the frames fall.
    #[test]
    fn as_many_are_sent_as_the_settings_say() {
        let mut fixes = Fixes::new(SETTINGS);
        let one = fix([[1.0, 0.0], [0.0, 1.0]], [[0.0; 2]; 2]);
        let sent = (0..400u64).filter(|frame| {
            let at = Micros(10_000_000 + 250_000 * frame - frame % 7 * 1_000);
            fixes.take(&one, at, Attitude::default()).is_some()
        });
        assert_eq!(sent.count(), 200);
        // After the autopilot has booted anew its clock begins at zero.
        assert!(fixes.take(&one, Micros(5_000), Attitude::default()).is_some());
    }

    /// R = white + n correlated, n = 2 f τ = 20, and the map's offset n times.
    #[test]
    fn what_fixes_share_is_sent_as_often_as_they_share_it() {
        let mut fixes = Fixes::new(FixSettings { map_sigma_m: 0.5, ..SETTINGS });
        // White 1 and 2 without a cross term; shared 0.3 and 0.4 with one of 0.1.
        let one = fix([[1.3, 0.1], [0.1, 2.4]], [[0.3, 0.1], [0.1, 0.4]]);
        let sent = fixes.take(&one, Micros(0), Attitude::default()).unwrap();
        let expected = [1.0 + 20.0 * 0.3 + 20.0 * 0.25, 2.0 + 20.0 * 0.4 + 20.0 * 0.25];
        assert!(sent.variance_m2.iter().zip(expected).all(|(found, wanted)| (found - wanted).abs() < 1e-4));
        // What a map of another year makes, on both axes alike.
        let of_year = Fix { map_variance_m2: 0.2, ..one };
        let later = fixes.take(&of_year, Micros(1_000_000), Attitude::default()).unwrap();
        let wider = [expected[0] + 19.0 * 0.2, expected[1] + 19.0 * 0.2];
        assert!(later.variance_m2.iter().zip(wider).all(|(found, wanted)| (found - wanted).abs() < 1e-4));
        // Eigenvalue of [[12, 2], [2, 15]].
        assert!((sent.largest_m2 - (13.5 + 6.25f32.sqrt())).abs() < 1e-4, "{}", sent.largest_m2);
        // One fix a minute shares nothing with the next.
        let mut rare = Fixes::new(FixSettings { interval_us: 60_000_000, ..SETTINGS });
        let sent = rare.take(&one, Micros(0), Attitude::default()).unwrap();
        assert_eq!(sent.variance_m2, [1.3, 2.4]);
    }

    /// A change makes the autopilot jump: it survives a start of ours, and comes of nothing but a far search, where that is set.
    #[test]
    fn the_reset_counter_changes_only_where_a_lost_position_was_found() {
        let one = fix([[1.0, 0.0], [0.0, 1.0]], [[0.0; 2]; 2]);
        let resets = |fixes: &mut Fixes, at: u64| fixes.take(&one, Micros(at), Attitude::default()).unwrap().resets;
        let mut fixes = Fixes::new(SETTINGS);
        fixes.go_on_from(7);
        assert_eq!((fixes.found([40.0, 0.0], 10), resets(&mut fixes, 0)), (None, 7));
        let mut fixes = Fixes::new(FixSettings { resets_on_reacquisition: true, ..SETTINGS });
        fixes.go_on_from(u8::MAX);
        assert_eq!((fixes.found([-10.0, 9.5], 10), resets(&mut fixes, 0)), (None, u8::MAX));
        assert_eq!((fixes.found([3.0, -10.5], 10), resets(&mut fixes, 1_000_000)), (Some(0), 0));
        assert_eq!(resets(&mut fixes, 2_000_000), 0);
    }

    #[test]
    fn the_height_is_that_of_the_autopilot_at_the_fix() {
        let mut fixes = Fixes::new(SETTINGS);
        assert_eq!(fixes.down_at(Micros(5_000_000)), None);
        fixes.down(Micros(4_900_000), -50.0);
        fixes.down(Micros(5_000_000), -52.0);
        assert_eq!(fixes.down_at(Micros(4_950_000)), Some(-51.0));
        assert_eq!((fixes.down_at(Micros(5_900_000)), fixes.down_at(Micros(6_100_000))), (Some(-52.0), None));
        // A clock that begins anew.
        fixes.down(Micros(10_000), 1.0);
        assert_eq!((fixes.down_at(Micros(20_000)), fixes.down_at(Micros(5_000_000))), (Some(1.0), None));
    }
}
