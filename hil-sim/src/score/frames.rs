//! `flown_frames.csv`: the frames of a flight as `plumbline evaluate` takes them, each where the board's navigation had it and
//! turned as its attitude says, with the truth beside it.

use crate::oracle::{Matrix3, matrix_a};
use crate::run::FrameRecord;
use crate::setup::Setup;
use plumbline_firmware::wire::telemetry::{PositionReport, SituationReport};
use std::fmt::Write;

/// The table of `records`, whose pictures lie beside it under the name that `picture` gives each. A frame that the board refused
/// before it knew place and attitude is left out.
#[must_use]
pub fn csv<'r>(
    setup: &Setup,
    records: impl Iterator<Item = &'r FrameRecord>,
    picture: impl Fn(&FrameRecord) -> String,
) -> String {
    let mut csv = "file,east_m,north_m,height_m,heading_deg,pitch_deg,roll_deg,true_east_m,true_north_m\n".to_owned();
    for record in records {
        let report = record.report.as_ref();
        let known = report.and_then(|report| Some((report.situation?, report.predicted?)));
        let Some((situation, PositionReport { east_m, north_m })) = known else { continue };
        let [heading, pitch, roll] = camera_deg(&situation);
        let [east_m, north_m] = [setup.tile_centre[0] + f64::from(east_m), setup.tile_centre[1] + f64::from(north_m)];
        let (truth, file) = (&record.truth, picture(record));
        // Writing to a string cannot fail.
        let _ = writeln!(
            csv,
            "{file},{east_m:.3},{north_m:.3},{:.3},{heading:.5},{pitch:.5},{roll:.5},{:.3},{:.3}",
            situation.height_m, truth.east_m, truth.north_m
        );
    }
    csv
}

/// Heading, pitch and roll of the camera itself, degrees: what a vehicle's attitude and the servo's angle make of it together.
fn camera_deg(situation: &SituationReport) -> [f64; 3] {
    let SituationReport { heading_rad, pitch_rad, roll_rad, follow_up_rad, .. } = *situation;
    let [heading, pitch, roll, follow_up] = [heading_rad, pitch_rad, roll_rad, follow_up_rad].map(f64::from);
    angles(matrix_a(heading, pitch, roll, follow_up)).map(f64::to_degrees)
}

/// The angles of which eq. 1 without a follow-up angle makes this rotation.
fn angles([forward, up, right]: Matrix3) -> [f64; 3] {
    [forward[2].atan2(forward[0]), forward[1].clamp(-1.0, 1.0).asin(), (-right[1]).atan2(up[1])]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_camera_that_follows_has_the_angles_that_make_its_rotation() {
        for [heading, pitch, roll, follow_up] in
            [[0.3, 0.1, -0.2, 0.0], [2.9, -0.15, 0.1, 2.8], [-1.2, 0.2, 0.15, -1.0], [0.0, 0.0, 0.0, 3.0]]
        {
            let wanted = matrix_a(heading, pitch, roll, follow_up);
            let [h, p, r] = angles(wanted);
            let found = matrix_a(h, p, r, 0.0);
            let off = (0..9).map(|k| (wanted[k / 3][k % 3] - found[k / 3][k % 3]).abs()).fold(0.0, f64::max);
            assert!(off < 1e-12, "{heading} {pitch} {roll} {follow_up}: {off}");
        }
    }
}
