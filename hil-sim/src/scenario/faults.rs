//! What goes wrong.

use super::bounds::Bounded;
use super::timed::FaultList;
use serde::{Deserialize, Serialize};

/// Start and end, seconds of the flight; the end is excluded.
pub type Seconds = [f64; 2];

/// Whether there is an interval, and an instant lies in it.
pub fn is_during(interval: Option<Seconds>, at_s: f64) -> bool {
    interval.is_some_and(|[from_s, to_s]| (from_s..to_s).contains(&at_s))
}

/// No faults by default.
#[derive(Debug, Clone, PartialEq, Default, Deserialize, Serialize)]
#[serde(default)]
pub struct Faults {
    /// The autopilot.
    pub autopilot_faults: AutopilotFaults,
    /// The attitude sensor.
    pub attitude_faults: AttitudeFaults,
    /// The link.
    pub link_faults: LinkFaults,
    /// The laser rangefinder.
    pub range: Range,
    /// The shutter's line and the frames.
    pub shutter: Shutter,
    /// The pulse per second.
    pub timer: Timer,
    /// What fails for a time, `[[fault]]`.
    #[serde(rename = "fault")]
    pub timed: FaultList,
}

/// What is wrong with the autopilot.
#[derive(Debug, Clone, Copy, PartialEq, Default, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct AutopilotFaults {
    /// When satellite navigation has a position; never unless given, which is what fixes are for.
    pub gnss_s: Option<Seconds>,
    /// It denies to take another set of sources.
    pub denies_source_set: bool,
    /// It knows neither origin nor position until it is given the one, and a fix.
    pub knows_no_place: bool,
    /// Parameters that are set to something else than they should be.
    pub parameters: WrongParameters,
}

/// Parameters that differ from the documented ones, by their names; what is `nan` is never answered.
#[derive(Debug, Clone, Copy, PartialEq, Default, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default, rename_all = "SCREAMING_SNAKE_CASE")]
#[allow(missing_docs, reason = "the autopilot's own names")]
pub struct WrongParameters {
    pub viso_type: Option<f32>,
    pub viso_delay_ms: Option<f32>,
    pub viso_pos_m_nse: Option<f32>,
    pub ek3_src2_posxy: Option<f32>,
    pub ek3_src2_velxy: Option<f32>,
    pub ek3_src2_posz: Option<f32>,
    pub ek3_src2_velz: Option<f32>,
    pub ek3_src2_yaw: Option<f32>,
    pub ek3_glitch_rad: Option<f32>,
}

/// What the attitude sensor does wrong, and when.
#[derive(Debug, Clone, Copy, PartialEq, Default, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct AttitudeFaults {
    /// It is silent.
    pub gap_s: Option<Seconds>,
    /// It hangs: its last value goes on, with fresh stamps.
    pub stuck_s: Option<Seconds>,
    /// Its stamps run backwards from the first of these seconds.
    pub backwards_s: Option<Seconds>,
    /// Its values are no numbers.
    pub nan_s: Option<Seconds>,
}

/// What goes wrong on the link, all in percent. See [`crate::fault`].
#[derive(Debug, Clone, Copy, PartialEq, Default, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct LinkFaults {
    /// Share of all bits that arrive flipped. A message has some 300 bits.
    pub bit_error_percent: f64,
    /// Share of the messages of which the end, or all, is missing.
    pub cut_percent: f64,
    /// Share of the messages before which one of an unknown kind arrives.
    pub unknown_percent: f64,
}

/// What the laser does wrong.
#[derive(Debug, Clone, Copy, PartialEq, Default, Deserialize, Serialize)]
#[serde(default)]
pub struct Range {
    /// Share of the samples without an echo.
    pub dropout_percent: f64,
    /// It measures 0, as on the ground.
    pub zero_s: Option<Seconds>,
}

/// What the shutter's line and the frames do wrong.
#[derive(Debug, Clone, Copy, PartialEq, Default, Deserialize, Serialize)]
#[serde(default)]
pub struct Shutter {
    /// Share of the edges that are lost.
    pub lost_edge_percent: f64,
    /// Share of the edges beside which a bounce, a short pulse or a stray edge is put.
    pub extra_edge_percent: f64,
    /// The lens is covered: frames are black, but for their noise.
    pub covered_s: Option<Seconds>,
    /// Share of the frames that never arrive, though the shutter opened.
    pub lost_frame_percent: f64,
}

/// What the pulse per second does wrong.
#[derive(Debug, Clone, Copy, PartialEq, Default, Deserialize, Serialize)]
#[serde(default)]
pub struct Timer {
    /// When there are no pulses.
    pub pps_lost_s: Option<Seconds>,
}

impl Faults {
    /// Each value that has bounds.
    pub(super) fn ranges(&self) -> Vec<Bounded> {
        let shares = [
            ("range.dropout_percent", self.range.dropout_percent, 100.0),
            ("shutter.lost_edge_percent", self.shutter.lost_edge_percent, 100.0),
            ("shutter.extra_edge_percent", self.shutter.extra_edge_percent, 100.0),
            ("shutter.lost_frame_percent", self.shutter.lost_frame_percent, 100.0),
            ("link_faults.bit_error_percent", self.link_faults.bit_error_percent, 50.0),
            ("link_faults.cut_percent", self.link_faults.cut_percent, 100.0),
            ("link_faults.unknown_percent", self.link_faults.unknown_percent, 100.0),
        ];
        let shares = shares.into_iter().map(|(key, percent, most)| (key, percent, 0.0, most));
        let seconds = self.intervals().flat_map(|(key, interval)| interval.map(|s| (key, s, 0.0, 1e9)));
        shares.chain(seconds).collect()
    }

    /// Every interval of trouble that is given, by its key.
    pub(super) fn intervals(&self) -> impl Iterator<Item = (&'static str, Seconds)> + use<> {
        let attitude = &self.attitude_faults;
        let all = [
            ("timer.pps_lost_s", self.timer.pps_lost_s),
            ("range.zero_s", self.range.zero_s),
            ("shutter.covered_s", self.shutter.covered_s),
            ("autopilot_faults.gnss_s", self.autopilot_faults.gnss_s),
            ("attitude_faults.gap_s", attitude.gap_s),
            ("attitude_faults.stuck_s", attitude.stuck_s),
            ("attitude_faults.backwards_s", attitude.backwards_s),
            ("attitude_faults.nan_s", attitude.nan_s),
        ];
        all.into_iter().filter_map(|(key, interval)| Some((key, interval?)))
    }
}
