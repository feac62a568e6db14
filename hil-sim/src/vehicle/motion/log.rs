//! A recorded attitude.

use crate::camera::render::Station;
use crate::scenario::footprint::{footprint_margin_at_m, half_tangents};
use crate::scenario::{FollowUpMode, Payload, Scenario};
use crate::vehicle::servo::{follow_up_exact, wrapped};
use plumbline_survey::error::{InputError, counted};
use plumbline_survey::logs::attitude::Attitude;
use plumbline_survey::logs::units::check_gimbal;
use std::path::Path;

/// Rows farther apart than this, in seconds of the log, have a gap between them.
const GAP_S: f64 = 0.3;
/// So have those of a log with few rows a second that are farther apart than so many usual steps.
const GAP_STEPS: f64 = 3.0;
/// With longer steps than this, in seconds, a log does not show how a vehicle moves: multirotors turn at up to some hertz.
const SPARSE_S: f64 = 0.25;

/// An attitude log, read and checked: finite, strictly forward in time, at least two rows.
#[derive(Debug)]
pub struct AttitudeLog {
    /// What messages call it.
    name: String,
    rows: Vec<Row>,
    /// The usual step of its time, the median.
    step_s: f64,
    notes: Vec<String>,
}

#[derive(Debug)]
struct Row {
    t_s: f64,
    /// Heading, pitch, roll, without jumps at ±180°.
    angles_rad: [f64; 3],
}

/// A frame is steep that sees further than 75 degrees from the nadir: nearly four heights.
const STEEP: f64 = 3.732;

impl AttitudeLog {
    /// Reads a table (CSV) or a flight log.
    ///
    /// # Errors
    /// As [`Attitude::read`]; fewer than two rows.
    pub fn load(path: &Path) -> Result<Self, InputError> {
        Self::of(Attitude::read(path)?)
    }

    /// As [`AttitudeLog::load`], from a table's text.
    ///
    /// # Errors
    /// As [`Attitude::of_table`]; fewer than two rows.
    pub fn parse(text: &str, name: &str) -> Result<Self, InputError> {
        Self::of(Attitude::of_table(text, name)?)
    }

    fn of(Attitude { name, samples, notes }: Attitude) -> Result<Self, InputError> {
        let mut rows: Vec<Row> = Vec::with_capacity(samples.len());
        for sample in &samples {
            let mut angles_rad = [sample.yaw_rad, sample.pitch_rad, sample.roll_rad];
            if let Some(before) = rows.last() {
                for (angle, before) in angles_rad.iter_mut().zip(before.angles_rad) {
                    *angle = before + wrapped(*angle - before);
                }
            }
            rows.push(Row { t_s: sample.t_s, angles_rad });
        }
        let mut steps: Vec<f64> = rows.windows(2).map(|pair| pair[1].t_s - pair[0].t_s).collect();
        steps.sort_by(f64::total_cmp);
        match steps.get(steps.len() / 2) {
            Some(&step_s) => Ok(AttitudeLog { name, rows, step_s, notes }),
            None => {
                Err(InputError::new(format!("{name}: the attitude log has {} rows, which is no flight", rows.len())))
            }
        }
    }

    /// What a user has to know of the log and of the part that the scenario flies.
    ///
    /// # Errors
    /// [`InputError`] when the log does not cover the flight.
    pub fn notes(&self, scenario: &Scenario) -> Result<Vec<String>, InputError> {
        let mut notes = self.notes.clone();
        if self.step_s > SPARSE_S {
            notes.push(format!(
                "{}: one attitude in {:.3} s; what the vehicle did in between is not in the log",
                self.name, self.step_s
            ));
        }
        let pairs = self.flown(scenario)?.windows(2).filter(|pair| pair[1].t_s - pair[0].t_s > self.gap_s());
        let gaps: Vec<f64> = pairs.clone().map(|pair| pair[1].t_s - pair[0].t_s).collect();
        if let Some(first) = pairs.clone().next() {
            notes.push(format!(
                "{}: {}, the first at {:.3} s, the longest of {:.3} s; frames in them have no attitude and get no fix",
                self.name,
                counted(gaps.len(), "gap"),
                first[0].t_s,
                gaps.iter().fold(0.0, |most: f64, gap| most.max(*gap))
            ));
        }
        Ok(notes)
    }

    /// Rows farther apart than this have a gap between them.
    fn gap_s(&self) -> f64 {
        GAP_S.max(GAP_STEPS * self.step_s)
    }

    /// Largest angle between the body's up axis and the vertical while the scenario flies, radians. With pitch and roll
    /// it is that of the camera's axis too.
    ///
    /// # Errors
    /// [`InputError`] when the log does not cover the flight.
    pub fn largest_tilt_rad(&self, scenario: &Scenario) -> Result<f64, InputError> {
        let tilt = |row: &Row| (row.angles_rad[1].cos() * row.angles_rad[2].cos()).acos();
        Ok(self.flown(scenario)?.iter().map(tilt).fold(0.0, f64::max))
    }

    /// How far east, west, north or south of the nadir frames reach at most while the scenario flies, per metre of height above
    /// level ground; steep frames, which show the horizon or nearly, are left out: the board refuses them. A camera whose servo lags
    /// looks anywhere around its axis.
    ///
    /// # Errors
    /// [`InputError`] when the log does not cover the flight.
    pub fn reach(&self, scenario: &Scenario, payload: &Payload) -> Result<f64, InputError> {
        let [across, along] = half_tangents(&payload.camera);
        let is_fixed = scenario.vehicle.follow_up.mode == FollowUpMode::Fixed;
        if !is_fixed && scenario.world.follow_up.servo_lag_s > 0.0 {
            let reach = footprint_margin_at_m(scenario, payload, self.largest_tilt_rad(scenario)?);
            return Ok((reach / scenario.run.flight.height_m[1]).min(STEEP));
        }
        let reach = |row: &Row| {
            let [heading_rad, pitch_rad, roll_rad] = row.angles_rad;
            let follow_up_rad = if is_fixed { 0.0 } else { follow_up_exact(heading_rad, pitch_rad, roll_rad) };
            let boresight_rad = payload.mount.true_boresight_rad;
            let station =
                Station { heading_rad, pitch_rad, roll_rad, follow_up_rad, boresight_rad, ..Station::default() };
            let axes = station.axes();
            let corners = [[across, along], [across, -along], [-across, along], [-across, -along]];
            let farthest = corners.map(|[right, forward]| {
                let ray: [f64; 3] =
                    std::array::from_fn(|i| axes.down[i] + right * axes.right[i] + forward * axes.forward[i]);
                if ray[2] < 0.0 { ray[0].abs().max(ray[1].abs()) / -ray[2] } else { f64::INFINITY }
            });
            farthest.into_iter().fold(0.0, f64::max)
        };
        let flown = self.flown(scenario)?;
        check_gimbal(&self.name, "frame", flown.iter().map(|row| row.angles_rad[1]))?;
        Ok(flown.iter().map(reach).filter(|reach| *reach <= STEEP).fold(0.0, f64::max))
    }

    /// The rows about the scenario's flight.
    fn flown(&self, scenario: &Scenario) -> Result<&[Row], InputError> {
        let (start_s, time_scale) = self.span(scenario)?;
        let end_s = start_s + time_scale * scenario.run.duration_us() as f64 * 1e-6;
        Ok(&self.rows[self.index_before(start_s)..=self.index_before(end_s) + 1])
    }

    /// Where in the log the scenario's flight starts, and the seconds of the log in a second of it.
    pub(super) fn span(&self, scenario: &Scenario) -> Result<(f64, f64), InputError> {
        let (first_s, last_s) = (self.rows[0].t_s, self.rows[self.rows.len() - 1].t_s);
        let (start_s, time_scale) = match &scenario.run.replay {
            Some(replay) => (replay.start_s.unwrap_or(first_s), replay.time_scale),
            None => (first_s, 1.0),
        };
        let end_s = start_s + time_scale * scenario.run.duration_us() as f64 * 1e-6;
        if start_s < first_s || end_s > last_s {
            let fitting = if start_s < first_s { 0 } else { fitting(scenario, (last_s - start_s) / time_scale) };
            let advice = if fitting > 0 { format!("; --frames {fitting} fits") } else { String::new() };
            return Err(InputError::new(format!(
                "{}: the attitude log holds {first_s:.3} s to {last_s:.3} s, but {} frames need {start_s:.3} s to \
                 {end_s:.3} s{advice}",
                self.name, scenario.run.frames
            )));
        }
        Ok((start_s, time_scale))
    }

    /// Index of the row at or before `t_s` that has a row after it.
    fn index_before(&self, t_s: f64) -> usize {
        self.rows.partition_point(|row| row.t_s <= t_s).saturating_sub(1).min(self.rows.len() - 2)
    }

    /// Whether `t_s` lies strictly between two rows that have a gap between them.
    pub(super) fn in_gap(&self, t_s: f64) -> bool {
        let index = self.index_before(t_s);
        let (before, after) = (self.rows[index].t_s, self.rows[index + 1].t_s);
        after - before > self.gap_s() && before < t_s && t_s < after
    }

    /// Heading within (−π, π], pitch and roll at `t_s`, by cubic Hermite interpolation. The rate is continuous, as a
    /// real body's is.
    pub(super) fn at(&self, t_s: f64) -> [f64; 3] {
        let index = self.index_before(t_s);
        let (before, after) = (&self.rows[index], &self.rows[index + 1]);
        let span_s = after.t_s - before.t_s;
        let u = ((t_s - before.t_s) / span_s).clamp(0.0, 1.0);
        let [slope_before, slope_after] = [self.slope(index), self.slope(index + 1)];
        let angles: [f64; 3] = std::array::from_fn(|axis| {
            let (a, b) = (before.angles_rad[axis], after.angles_rad[axis]);
            let (slope_a, slope_b) = (span_s * slope_before[axis], span_s * slope_after[axis]);
            let bend = u * (1.0 - u);
            a + (b - a) * u * u * (3.0 - 2.0 * u) + bend * (slope_a * (1.0 - u) - slope_b * u)
        });
        [wrapped(angles[0]), angles[1], angles[2]]
    }

    /// Radians a second at a row: of the parabola through it and its neighbours, or of the one chord at either end.
    fn slope(&self, index: usize) -> [f64; 3] {
        let chord =
            |from: &Row, to: &Row, axis: usize| (to.angles_rad[axis] - from.angles_rad[axis]) / (to.t_s - from.t_s);
        let (before, here, after) = (index.checked_sub(1), &self.rows[index], self.rows.get(index + 1));
        std::array::from_fn(|axis| match (before.map(|before| &self.rows[before]), after) {
            (Some(before), Some(after)) => {
                // The nearer neighbour's chord counts more.
                let nearness = (here.t_s - before.t_s) / (after.t_s - before.t_s);
                (1.0 - nearness) * chord(before, here, axis) + nearness * chord(here, after, axis)
            }
            (Some(before), None) => chord(before, here, axis),
            (None, Some(after)) => chord(here, after, axis),
            (None, None) => 0.0,
        })
    }
}

/// How many frames a flight of so many seconds has.
fn fitting(scenario: &Scenario, seconds: f64) -> u64 {
    let interval_us = scenario.run.frame_interval_us();
    let before_and_after_us = scenario.run.duration_us() - u64::from(scenario.run.frames) * interval_us;
    // A negative number of microseconds becomes 0.
    ((seconds * 1e6) as u64).saturating_sub(before_and_after_us) / interval_us
}
