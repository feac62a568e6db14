//! What a flight is worth: every frame against the truth, and the figures of `report.json`.

pub mod blur;
mod as_flown;
mod cost;
pub mod exposure;
pub mod faults;
pub mod fixes;
pub mod frames;
pub mod globe;
pub mod kept;
mod matching;
pub mod navigation;
pub mod plan;
pub mod pose;
pub mod protection;
mod shifted;
pub mod signing;
pub mod stamps;
mod statistics;
pub mod unrectified;
pub mod wrong;

use crate::link::{Account, LinkTrouble, WorkCost};
use crate::live::report::Live;
use crate::run::{Flight, FrameRecord};
use crate::setup::Setup;
use crate::vehicle::mount::antenna;
use as_flown::{null_without_pulses, scenario_as_flown};
use cost::Costs;
pub use cost::{Cost, Stages};
use kept::Navigated;
pub use matching::{MatchRate, MatchingError, length};
use matching::{lengths, match_rate, matching_error};
use plan::{Flown, flown};
use plumbline_firmware::serial::message::Counts;
use plumbline_firmware::wire::telemetry::{FixReport, SituationReport, StampHealth};
use plumbline_survey::error::InputError;
use protection::{Placed, Protection, protection};
use serde::Serialize;
use shifted::Shifted;
use statistics::{mean, percentile};
use std::collections::BTreeMap;
use unrectified::Unrectified;

/// A frame against the truth, pixels of the reference and metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scored {
    /// Number of the frame.
    pub frame: u32,
    /// Whether there is a fix.
    pub accepted: bool,
    /// True nadir relative to the predicted position, (columns, rows).
    pub truth_px: Option<[f64; 2]>,
    /// Matched centre minus true nadir, (columns, rows), accepted or not.
    pub error_px: Option<[f64; 2]>,
    /// Whole-pixel peak minus true nadir, (columns, rows).
    pub integer_px: Option<[f64; 2]>,
    /// Whole-pixel peak of the raw frame minus true nadir, (columns, rows).
    pub raw_px: Option<[f64; 2]>,
    /// Fix minus the antenna's true position, (east, north) metres.
    pub error_m: Option<[f64; 2]>,
    /// Normalised estimation error squared, 2 degrees of freedom.
    pub nees: Option<f64>,
    /// Error of the pose the firmware used: what the attitude alone does to the nadir, (columns, rows) pixels.
    pub attitude_px: Option<[f64; 2]>,
    /// Where the board believed to be by its filter.
    pub place: Option<Placed>,
    /// Instructions or cycles from edge to fix; `None` where the link cannot tell.
    pub cost: Option<u64>,
}

/// Scores the frames of a flight. `unrectified` watched it; without, nothing is known of the baseline.
pub fn score(setup: &Setup, flight: &Flight, unrectified: &Unrectified) -> Vec<Scored> {
    let raw_px = |record: &FrameRecord| unrectified.errors_px.get(&record.exposure.frame).copied();
    flight.frames.iter().map(|record| score_frame(setup, record, raw_px(record))).collect()
}

fn score_frame(setup: &Setup, record: &FrameRecord, raw_px: Option<[f64; 2]>) -> Scored {
    let resolution = setup.scenario.vehicle.resolution_m;
    let truth = &record.truth;
    // Truth relative to the tile's centre.
    let true_m = [truth.east_m - setup.tile_centre[0], truth.north_m - setup.tile_centre[1]];
    let report = record.report.as_ref();
    let truth_px = report.and_then(|report| fixes::truth_px(report, true_m, resolution));
    let against = |d: [f32; 2]| truth_px.map(|t| [f64::from(d[0]) - t[0], f64::from(d[1]) - t[1]]);
    let matched = report.and_then(|r| r.matched);
    let fix = report.and_then(|r| r.fix);
    let [east_m, north_m, _] = antenna(truth, &setup.payload.mount);
    let antenna_m = [east_m - setup.tile_centre[0], north_m - setup.tile_centre[1]];
    let error_m = fix.map(|fix| {
        [f64::from(fix.east_m) + setup.tile_centre[0] - east_m, f64::from(fix.north_m) + setup.tile_centre[1] - north_m]
    });
    let nees = fix.zip(error_m).map(|(fix, error_m)| squared_sigmas(&fix, error_m));
    let cost = report.map(|r| r.instructions.iter().map(|&i| u64::from(i)).sum()).filter(|&sum| sum > 0);
    Scored {
        frame: record.exposure.frame,
        accepted: fix.is_some(),
        truth_px,
        error_px: matched.and_then(|m| against([m.d_col, m.d_row])),
        integer_px: matched.and_then(|m| against([m.peak_col, m.peak_row])),
        raw_px,
        error_m,
        nees,
        attitude_px: report.and_then(|r| r.situation).map(|s| attitude_part(setup, truth, &s)),
        place: protection::placed(record, antenna_m),
        cost,
    }
}

/// Squared error over its covariance, 2 degrees of freedom.
fn squared_sigmas(fix: &FixReport, [e, n]: [f64; 2]) -> f64 {
    let [ee, en, nn] = [fix.variance_east_m2, fix.covariance_m2, fix.variance_north_m2].map(f64::from);
    (e * e * nn - 2.0 * e * n * en + n * n * ee) / (ee * nn - en * en)
}

/// Where the nadir would be sought with the pose that the firmware used, in pixels off the true one: the tilt's error
/// turned to the ground, heading and height having no effect at the nadir itself. Columns east, rows south.
fn attitude_part(setup: &Setup, truth: &crate::vehicle::motion::TrueState, used: &SituationReport) -> [f64; 2] {
    use crate::oracle::matrix_a;
    let [height, heading, pitch, roll] =
        [used.height_m, used.heading_rad, used.pitch_rad, used.roll_rad].map(f64::from);
    // Plumb line in the body by truth, brought to the ground by the pose used.
    let plumb = matrix_a(truth.heading_rad, truth.pitch_rad, truth.roll_rad, 0.0).map(|row| -row[1]);
    let used = matrix_a(heading, pitch, roll, 0.0);
    let ground: [f64; 3] = std::array::from_fn(|axis| (0..3).map(|row| used[row][axis] * plumb[row]).sum());
    let resolution = setup.scenario.vehicle.resolution_m;
    let metres = |component: f64| height * component / -ground[1];
    // The camera is believed to look elsewhere, so the match lands on the other side.
    [-metres(ground[2]) / resolution, metres(ground[0]) / resolution]
}

/// Mean and 95th percentile.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Spread {
    /// Mean.
    pub mean: Option<f64>,
    /// 95th percentile.
    pub p95: Option<f64>,
}

/// `report.json`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Summary {
    /// Version of this layout.
    pub schema: u32,
    /// The scenario with every key, also those that it leaves to their defaults.
    pub scenario: serde_json::Value,
    /// The reference system of the grid that fixes and positions are on.
    pub epsg: u32,
    /// What every random number came from.
    pub seed: u64,
    /// `inproc`, `qemu` or `serial`.
    pub link: String,
    /// Of the image flown; null in-process and on a line.
    pub firmware_sha256: Option<String>,
    /// Digest of the numbers that the risks are made of.
    pub risk_coefficients: String,
    /// Name and firmware version of the board on a line; null elsewhere.
    pub board: Option<String>,
    /// Frames exposed.
    pub frames: usize,
    /// Frames with a fix.
    pub accepted: usize,
    /// See [`MatchRate`].
    pub match_rate: MatchRate,
    /// See [`MatchingError`].
    pub matching_error_px: MatchingError,
    /// Fix minus true position, accepted frames.
    pub ground_error_m: Spread,
    /// Mean normalised estimation error squared, 2 degrees of freedom.
    pub nees_mean: Option<f64>,
    /// Fixes that are off by more than 3 pixels, or by more than 5 of their own sigmas and 1.5 pixels.
    pub wrong_fixes: usize,
    /// What the same fixes are against the map as it lies; left out where it lies right.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub shifted: Option<Shifted>,
    /// Stamps against the true middles of the exposures, all frames.
    pub stamps: stamps::Stamps,
    /// See [`pose::Poses`].
    pub poses: pose::Poses,
    /// See [`blur::Blur`].
    pub blur: blur::Blur,
    /// See [`exposure::Exposures`].
    pub exposure_us: exposure::Exposures,
    /// Edge to fix; null where instructions are not counted.
    pub instructions_per_frame: Cost,
    /// Mean instructions of each stage by its name; null where they are not counted.
    pub instructions_by_stage: Option<Stages>,
    /// Edge to fix; null where cycles are not counted.
    pub cycles_per_frame: Cost,
    /// Mean cycles of each stage by its name; null where they are not counted.
    pub cycles_by_stage: Option<Stages>,
    /// What the board's work came to, step by step, in what it counts; null but on a line.
    pub work_per_step: Option<WorkCost>,
    /// Clock of the board's core, where it reported one.
    pub core_clock_hz: Option<u32>,
    /// Static memory and the stack's high-water mark; null in-process.
    pub ram_bytes: Option<u64>,
    /// Frames without a fix, by reason.
    pub refused: BTreeMap<String, usize>,
    /// Rows lost to overruns.
    pub overruns: u32,
    /// What went wrong on the line; null on a link on which nothing can.
    pub link_faults: Option<LinkTrouble>,
    /// What the firmware counted on its link.
    pub link_health: LinkHealth,
    /// What was refused for its signature; left out where messages are not signed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub signing: Option<signing::Signing>,
    /// What it counted of edges and pulses.
    #[serde(serialize_with = "null_without_pulses")]
    pub stamp_health: StampHealth,
    /// Root mean square of the servo commands off the exact angle when they arrived, degrees.
    pub servo_rms_deg: f64,
    /// Results of the plan; null without one.
    pub plan: Option<Flown>,
    /// Positions against the truth; left out but of live flights and of those that fixes keep.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub navigation: Option<Navigated>,
    /// What the board's own filter is worth over all frames with a place; left out where there is none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub protection: Option<Protection>,
    /// What is told of a live flight beside; left out of others.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub live: Option<Live>,
    /// What each timed fault did to the fixes; empty without one.
    pub faults: Vec<faults::FaultScore>,
    /// Why the flight ended early; left out where it did not.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub aborted: Option<String>,
}

impl Summary {
    /// Name of the scenario.
    #[must_use]
    pub fn name(&self) -> &str {
        self.scenario.get("name").and_then(serde_json::Value::as_str).unwrap_or_default()
    }

    /// Edge to fix and each stage's part, in what the board counts and what that is called; `None` where it counts nothing.
    pub fn cost(&self) -> Option<(f64, u64, Stages, &'static str)> {
        let counted = [
            (&self.instructions_per_frame, self.instructions_by_stage, "instructions"),
            (&self.cycles_per_frame, self.cycles_by_stage, "cycles"),
        ];
        counted.into_iter().find_map(|(cost, stages, name)| Some((cost.mean?, cost.max?, stages?, name)))
    }
}

/// What the firmware counted on its link.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct LinkHealth {
    /// Good messages.
    pub messages: u32,
    /// Failed checksums.
    pub bad_checksum: u32,
    /// Unknown ids.
    pub unknown_id: u32,
    /// Bytes that belonged to no message.
    pub skipped_bytes: u32,
    /// Samples whose stamp ran backwards.
    pub backwards: u32,
    /// Samples out of range.
    pub invalid: u32,
}

/// How the flight was linked.
#[derive(Clone, Debug, PartialEq)]
pub struct Linked {
    /// Name of the link.
    pub name: String,
    /// SHA-256 of the image.
    pub firmware_sha256: Option<String>,
    /// What the link reports of itself.
    pub account: Account,
}

/// The figures of a flight.
pub fn summarise(setup: &Setup, flight: &Flight, scored: &[Scored], linked: &Linked) -> Summary {
    let accepted: Vec<&Scored> = scored.iter().filter(|s| s.accepted).collect();
    let ground = lengths(&accepted, |s| s.error_m);
    let costs = Costs::of(flight, &accepted);
    // What was counted stands under its own name, and nothing under another.
    let counted = |counts| if linked.account.counts == counts { costs } else { Costs::default() };
    let [instructions, cycles] = [counted(Counts::Instructions), counted(Counts::Cycles)];
    let health = &flight.health;
    let places: Vec<Placed> = scored.iter().filter_map(|scored| scored.place).collect();
    let ram = u64::from(health.memory.0) + u64::from(health.memory.1);
    Summary {
        schema: 1,
        scenario: scenario_as_flown(setup),
        epsg: setup.flash.head.georeference.epsg,
        seed: setup.scenario.run.seed,
        link: linked.name.clone(),
        firmware_sha256: linked.firmware_sha256.clone(),
        risk_coefficients: crate::coefficients::of_flight(),
        board: linked.account.board.clone(),
        frames: scored.len(),
        accepted: accepted.len(),
        match_rate: match_rate(scored),
        matching_error_px: matching_error(scored, &accepted),
        ground_error_m: Spread { mean: mean(&ground), p95: percentile(&ground, 0.95) },
        nees_mean: mean(&accepted.iter().filter_map(|s| s.nees).collect::<Vec<_>>()),
        wrong_fixes: accepted.iter().filter(|scored| scored.is_wrong(setup.scenario.vehicle.resolution_m)).count(),
        shifted: shifted::shifted(setup, flight, scored),
        stamps: stamps::stamps(&flight.frames),
        poses: pose::poses(&flight.frames),
        blur: blur::blur(&flight.frames),
        exposure_us: exposure::exposures(&flight.frames),
        instructions_per_frame: instructions.per_frame,
        instructions_by_stage: instructions.by_stage,
        cycles_per_frame: cycles.per_frame,
        cycles_by_stage: cycles.by_stage,
        work_per_step: linked.account.work,
        core_clock_hz: linked.account.core_clock_hz,
        ram_bytes: (ram > 0).then_some(ram),
        refused: refusals(flight),
        overruns: health.overruns,
        link_faults: linked.account.trouble,
        link_health: LinkHealth {
            messages: health.messages,
            bad_checksum: health.bad_checksum,
            unknown_id: health.unknown_id,
            skipped_bytes: health.skipped_bytes,
            backwards: health.backwards,
            invalid: health.invalid,
        },
        signing: flight.signing.map(signing::Signing::from),
        stamp_health: health.stamps,
        servo_rms_deg: flight.servo.1.to_degrees(),
        plan: flown(setup, flight),
        navigation: flight.track.as_ref().map(|track| Navigated::Kept(Box::new(kept::kept(track, &places)))),
        protection: protection(&places),
        live: None,
        faults: faults::faults(setup, flight, scored),
        aborted: None,
    }
}

/// How many frames have no fix, by the reason.
fn refusals(flight: &Flight) -> BTreeMap<String, usize> {
    let mut refused = BTreeMap::new();
    for reason in flight.frames.iter().filter_map(reason) {
        *refused.entry(reason.to_owned()).or_insert(0) += 1;
    }
    refused
}

/// Why a frame has no fix; `None` where it has one.
pub fn reason(record: &FrameRecord) -> Option<&'static str> {
    fixes::reason(record.report.as_ref())
}

/// `fixes.csv` of a flight.
pub fn fixes_csv(setup: &Setup, flight: &Flight, scored: &[Scored]) -> String {
    let rows = flight.frames.iter().zip(scored).map(|(record, scored)| fixes::Row {
        frame: scored.frame,
        report: record.report,
        instant: record.instant,
        truth_px: scored.truth_px,
    });
    fixes::csv(setup.tile_centre, rows)
}

/// What a flight leaves behind: `fixes.csv`, `poses.csv`, `report.json`, `fixes.geojson` and `track.kml`.
///
/// # Errors
/// Figures that JSON cannot hold, a place that the grid cannot express.
pub fn files(
    setup: &Setup,
    flight: &Flight,
    scored: &[Scored],
    summary: &Summary,
) -> Result<[(&'static str, String); 5], InputError> {
    let json = serde_json::to_string_pretty(summary)
        .map_err(|error| InputError::new(format!("the report cannot be written: {error}")))?;
    Ok([
        ("fixes.csv", fixes_csv(setup, flight, scored)),
        ("poses.csv", navigation::csv(setup, flight)),
        ("report.json", json),
        ("fixes.geojson", globe::geojson(setup, flight)?),
        ("track.kml", globe::kml(setup, flight)?),
    ])
}
