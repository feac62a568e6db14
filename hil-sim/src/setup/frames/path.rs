//! Where the vehicle is between the frames of a table: on a smooth way through their places, turning smoothly from one attitude to the
//! next.

use super::table::{Row, Table};
use crate::vehicle::motion::{Recorded, TrueState};
use crate::vehicle::servo::wrapped;

/// From one sample to the next, microseconds. What lies between is on a cubic (`vehicle/motion/recorded.rs`).
const STEP_US: u64 = 20_000;
/// What each angle goes up and down by, so that the same value sent again and again is not taken for a sensor that hangs: twenty seconds of arc,
/// chosen far below any sensor's noise and far above a message's rounding; and its period, seconds: so short that no motion between frames
/// cancels it over several samples, and no multiple of a usual interval between these.
const ALIVE_RAD: f64 = 1e-4;
const ALIVE_S: f64 = 0.073;

/// Samples from 0 to `end_us`, with the frames' states at `frames_us`. `up_m`: height of the ground below a place.
pub(crate) fn through(table: &Table, frames_us: &[u64], end_us: u64, up_m: &dyn Fn([f64; 2]) -> f64) -> Vec<Recorded> {
    let knots: Vec<(f64, TrueState)> = table
        .rows
        .iter()
        .zip(frames_us)
        .enumerate()
        .map(|(index, (row, at_us))| {
            let state = TrueState { velocity_enu_m_s: velocity(table, frames_us, index), ..state(row, up_m) };
            (*at_us as f64, state)
        })
        .collect();
    (0..=end_us / STEP_US + 1).map(|index| (index * STEP_US) as f64).map(|at_us| (at_us, at(&knots, at_us))).collect()
}

fn state(row: &Row, up_m: &dyn Fn([f64; 2]) -> f64) -> TrueState {
    let ([east_m, north_m], [heading_rad, pitch_rad, roll_rad]) = (row.place_m, row.attitude_rad);
    let up_m = up_m(row.place_m) + row.height_m;
    TrueState { east_m, north_m, up_m, heading_rad, pitch_rad, roll_rad, ..TrueState::default() }
}

/// At a frame, that from the one before to the one after; level, since the ground's height is in no position.
fn velocity(table: &Table, frames_us: &[u64], index: usize) -> [f64; 3] {
    let (before, after) = (index.saturating_sub(1), (index + 1).min(table.rows.len() - 1));
    let seconds = 1e-6 * (frames_us[after] as f64 - frames_us[before] as f64);
    let [a, b] = [table.rows[before].place_m, table.rows[after].place_m];
    [(b[0] - a[0]) / seconds, (b[1] - a[1]) / seconds, 0.0]
}

/// Before the first frame and behind the last one it goes straight on.
fn at(knots: &[(f64, TrueState)], at_us: f64) -> TrueState {
    let after = knots.partition_point(|(knot_us, _)| *knot_us <= at_us);
    let state = match (after.checked_sub(1).map(|before| &knots[before]), knots.get(after)) {
        (Some(before), Some(after)) => between(before, after, at_us),
        (Some(end), None) | (None, Some(end)) => straight(end, at_us),
        (None, None) => TrueState::default(),
    };
    // Each angle on its own: one that hangs alone is found out, too.
    let alive_rad = |phase: f64| ALIVE_RAD * (2.0 * (1e-6 * at_us / ALIVE_S + phase).fract() - 1.0).abs();
    TrueState {
        heading_rad: wrapped(state.heading_rad + alive_rad(0.0)),
        pitch_rad: state.pitch_rad + alive_rad(0.3),
        roll_rad: wrapped(state.roll_rad + alive_rad(0.6)),
        ..state
    }
}

fn straight((knot_us, state): &(f64, TrueState), at_us: f64) -> TrueState {
    let seconds = 1e-6 * (at_us - knot_us);
    let [east, north, _] = state.velocity_enu_m_s;
    TrueState { east_m: state.east_m + seconds * east, north_m: state.north_m + seconds * north, ..*state }
}

/// The place on the cubic through both with their velocities; the attitude at rest in both.
fn between((from_us, from): &(f64, TrueState), (to_us, to): &(f64, TrueState), at_us: f64) -> TrueState {
    let (span_s, p) = (1e-6 * (to_us - from_us), (at_us - from_us) / (to_us - from_us));
    let (p2, p3) = (p * p, p * p * p);
    let smooth = 3.0 * p2 - 2.0 * p3;
    let cubic = |a: f64, b: f64, axis: usize| {
        let (va, vb) = (span_s * from.velocity_enu_m_s[axis], span_s * to.velocity_enu_m_s[axis]);
        let place = a + smooth * (b - a) + (p3 - 2.0 * p2 + p) * va + (p3 - p2) * vb;
        let speed = (6.0 * (p - p2) * (b - a) + (3.0 * p2 - 4.0 * p + 1.0) * va + (3.0 * p2 - 2.0 * p) * vb) / span_s;
        (place, speed)
    };
    let turned = |a: f64, b: f64| wrapped(a + smooth * wrapped(b - a));
    let ((east_m, east), (north_m, north)) = (cubic(from.east_m, to.east_m, 0), cubic(from.north_m, to.north_m, 1));
    let (up_m, up) = cubic(from.up_m, to.up_m, 2);
    TrueState {
        east_m,
        north_m,
        up_m,
        heading_rad: turned(from.heading_rad, to.heading_rad),
        pitch_rad: from.pitch_rad + smooth * (to.pitch_rad - from.pitch_rad),
        roll_rad: turned(from.roll_rad, to.roll_rad),
        follow_up_rad: 0.0,
        velocity_enu_m_s: [east, north, up],
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::PathBuf;

    fn row(east_m: f64, north_m: f64, heading_deg: f64) -> Row {
        Row {
            file: PathBuf::new(),
            place_m: [east_m, north_m],
            height_m: 100.0,
            attitude_rad: [heading_deg.to_radians(), 0.1, 0.0],
            truth_m: None,
        }
    }

    /// Whether an angle stays within what the board calls rounding for so many samples that it is taken to hang.
    fn hangs(samples: &[Recorded]) -> bool {
        const ANGLES: [fn(&TrueState) -> f64; 3] = [|s| s.heading_rad, |s| s.pitch_rad, |s| s.roll_rad];
        let spread = |some: &[Recorded], angle: fn(&TrueState) -> f64| {
            let ends = some.iter().map(|(_, state)| angle(state));
            ends.clone().fold(f64::NEG_INFINITY, f64::max) - ends.fold(f64::INFINITY, f64::min)
        };
        samples.windows(8).any(|some| ANGLES.iter().any(|angle| spread(some, *angle) < 1e-5))
    }

    /// An attitude that changes by next to nothing from frame to frame.
    #[test]
    fn no_angle_seems_to_hang_however_slowly_it_changes() {
        for step_deg in [0.0, 0.001, 0.002, 0.005, 0.01, 0.02, 0.05] {
            let heading_deg = |index: usize| 90.0 + step_deg * (index % 5) as f64;
            let rows: Vec<Row> = (0..20).map(|index| row(30.0 * index as f64, 0.0, heading_deg(index))).collect();
            let table =
                Table { name: String::new(), lines: (2..22).collect(), rows, doubt: None, columns: [1, 2, 3, 4, 5, 6] };
            let frames_us: Vec<u64> = (0..20).map(|index| 3_001_000 + 1_000_000 * index).collect();
            assert!(!hangs(&through(&table, &frames_us, 24_000_000, &|_| 20.0)), "{step_deg}");
        }
    }

    #[test]
    fn it_passes_through_the_frames_and_its_velocity_is_its_derivative() {
        let rows = vec![row(0.0, 0.0, 170.0), row(30.0, 5.0, -170.0), row(60.0, 0.0, -175.0), row(60.0, -40.0, 90.0)];
        let table =
            Table { name: String::new(), lines: vec![2, 3, 4, 5], rows, doubt: None, columns: [1, 2, 3, 4, 5, 6] };
        let frames_us = [3_001_000, 5_001_000, 7_001_000, 9_001_000];
        let samples = through(&table, &frames_us, 10_000_000, &|_| 20.0);
        for pair in samples.windows(2) {
            let [(a_us, a), (b_us, b)] = [pair[0], pair[1]];
            let seconds = 1e-6 * (b_us - a_us);
            let mean = 0.5 * (a.velocity_enu_m_s[0] + b.velocity_enu_m_s[0]);
            assert!(((b.east_m - a.east_m) / seconds - mean).abs() < 0.05, "{a_us}");
            assert!(wrapped(b.heading_rad - a.heading_rad).abs() < 0.05, "{a_us}");
        }
        assert!(!hangs(&samples));
        let nearest =
            |at_us: u64| samples.iter().min_by_key(|(s, _)| (*s as i64 - at_us as i64).abs()).expect("some").1;
        for (row, at_us) in table.rows.iter().zip(frames_us) {
            let state = nearest(at_us);
            assert!((state.east_m - row.place_m[0]).hypot(state.north_m - row.place_m[1]) < 0.2, "{state:?}");
            assert!(wrapped(state.heading_rad - row.attitude_rad[0]).abs() < 1e-3, "{state:?}");
            assert_eq!(state.up_m, 120.0);
        }
    }
}
