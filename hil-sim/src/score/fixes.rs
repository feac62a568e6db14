//! `fixes.csv`: a row a frame, nothing in it that depends on the link.

use plumbline_firmware::wire::telemetry::{FrameReport, InstantReport, PositionReport, Risk};
use std::fmt::Write;

/// What a row is made of.
#[derive(Clone, Copy, Debug)]
pub struct Row {
    /// Number of the frame.
    pub frame: u32,
    /// What the firmware said of it.
    pub report: Option<FrameReport>,
    /// What it said of the instant of its exposure.
    pub instant: Option<InstantReport>,
    /// True nadir relative to the predicted position, (columns, rows), where the truth is known.
    pub truth_px: Option<[f64; 2]>,
}

/// Why a frame has no fix; `None` where it has one.
pub fn reason(report: Option<&FrameReport>) -> Option<&'static str> {
    match report {
        None => Some("lost"),
        Some(report) => report.reason().map(|refusal| refusal.name()),
    }
}

/// The true place, metres from the tile's centre, in pixels from the predicted one.
pub fn truth_px(report: &FrameReport, true_m: [f64; 2], resolution_m: f64) -> Option<[f64; 2]> {
    let PositionReport { east_m, north_m } = report.predicted?;
    let [east, north] = [east_m, north_m].map(f64::from);
    Some([(true_m[0] - east) / resolution_m, -(true_m[1] - north) / resolution_m])
}

/// What a risk in decibels below 1 is.
#[must_use]
pub fn probability(risk: Risk) -> f64 {
    10f64.powf(-0.1 * f64::from(risk.0))
}

/// The table; `tile_centre` is what fixes are relative to.
pub fn csv(tile_centre: [f64; 2], rows: impl Iterator<Item = Row>) -> String {
    let mut csv = String::from(
        "frame,mid_exposure_us,accepted,reason,d_col,d_row,true_col,true_row,east_m,north_m,sigma_east_m,sigma_north_m,score,second_peak,risk,protection_m\n",
    );
    for row in rows {
        let report = row.report.as_ref();
        let mid = report.map_or(0, |r| r.mid_exposure_us);
        let matched = report.and_then(|r| r.matched);
        let fix = report.and_then(|r| r.fix);
        let place = row.instant.and_then(|instant| instant.place);
        let number = |value: Option<f64>| value.map_or_else(String::new, |v| v.to_string());
        let single = |value: Option<f32>| value.map_or_else(String::new, |v| v.to_string());
        // Writing to a string cannot fail.
        let _ = writeln!(
            csv,
            "{},{mid},{},{},{},{},{},{},{},{},{},{},{},{},{},{}",
            row.frame,
            u8::from(fix.is_some()),
            reason(report).unwrap_or(""),
            single(matched.map(|m| m.d_col)),
            single(matched.map(|m| m.d_row)),
            number(row.truth_px.map(|t| t[0])),
            number(row.truth_px.map(|t| t[1])),
            number(fix.map(|f| tile_centre[0] + f64::from(f.east_m))),
            number(fix.map(|f| tile_centre[1] + f64::from(f.north_m))),
            number(fix.map(|f| f64::from(f.variance_east_m2).sqrt())),
            number(fix.map(|f| f64::from(f.variance_north_m2).sqrt())),
            single(matched.map(|m| m.correlation)),
            single(matched.map(|m| m.second_correlation)),
            number(fix.and(report).map(|report| probability(report.risk))),
            // A radius that is not finite says nothing.
            single(place.map(|place| place.protection_m).filter(|radius_m| radius_m.is_finite())),
        );
    }
    csv
}
