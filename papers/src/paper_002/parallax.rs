//! What relief and centres off the plane do to the virtual image (sections 2.2 and 3.1.1).

use super::super::Row;
use super::world::{CENTRES_M, F_MM, F_PX};

/// Parallax in the virtual image, px, of ground that stands `rise` of the height `height_m` above the plane it is
/// rectified to, seen from `offset_m` beside the virtual centre: f d/h rise/(1 - rise). The paper's formula is lost.
#[must_use]
pub fn parallax_px(offset_m: f64, height_m: f64, rise: f64) -> f64 {
    F_PX * offset_m / height_m * rise / (1.0 - rise)
}

/// Shift of an image point, um, whose ray has the tangent `tangent`, when the centre stands `rise_m` above the plane:
/// f (P/H) dS/(H + dS).
#[must_use]
pub fn shift_um(tangent: f64, height_m: f64, rise_m: f64) -> f64 {
    1e3 * F_MM * tangent * rise_m / (height_m + rise_m)
}

const SECTION_2_2: &str = "Section 2.2, figure 3";
const SECTION_3_1: &str = "Section 3.1.1";

/// The rows of both sections.
#[must_use]
pub fn rows() -> Vec<Row> {
    let [across, along] = [CENTRES_M[0][0].abs(), CENTRES_M[0][1].abs()];
    let row = |table, quantity: String, paper, ours, difference: Option<&str>| Row {
        table,
        quantity,
        paper,
        ours: Some(ours),
        difference: difference.map(str::to_owned),
    };
    let centre = "the centres' distances are lost; 0.06 m in y is what the printed parallax takes, 0.045 m in x makes the \
                  diagonal the printed 0.15 m";
    let mut rows = vec![
        row(
            SECTION_2_2,
            "y, h 500 m, ground 1/4 h above, px".to_owned(),
            Some(0.276),
            parallax_px(along, 500.0, 0.25),
            None,
        ),
        row(
            SECTION_2_2,
            "y, h 750 m, ground 1/4 h above, px".to_owned(),
            Some(0.184),
            parallax_px(along, 750.0, 0.25),
            None,
        ),
        row(
            SECTION_2_2,
            "the same on the ground at 500 m, cm".to_owned(),
            Some(1.997),
            100.0 * parallax_px(along, 500.0, 0.25) * 500.0 / F_PX,
            Some(
                "the paper takes its rounded 0.276 px times the ground sample distance at the plane; 0.276471 px give 2.000",
            ),
        ),
        row(
            SECTION_2_2,
            "x, h 500 m, ground 1/4 h above, px".to_owned(),
            None,
            parallax_px(across, 500.0, 0.25),
            Some(centre),
        ),
        row(
            SECTION_2_2,
            "y, h 500 m, ground 1/4 h below, px".to_owned(),
            Some(0.276),
            parallax_px(along, 500.0, -0.25).abs(),
            Some(
                "the paper says \"above or below\"; below the plane the ground is farther away, so that it is a bound only",
            ),
        ),
    ];
    let heights = "the printed figures are those of H = 1000 m (or of 7 mm at 700 m), not of the stated 700 m";
    for (name, tangent, paper) in
        [("long side", 1.11, 0.52), ("narrow side", 0.75, 0.35), ("corner", 1.11f64.hypot(0.75), 0.63)]
    {
        let ours = shift_um(tangent, 700.0, 0.01);
        rows.push(row(SECTION_3_1, format!("{name}, H 700 m, centre 10 mm off, um"), Some(paper), ours, Some(heights)));
        rows.push(row(
            SECTION_3_1,
            format!("{name}, H 1000 m, centre 10 mm off, um"),
            Some(paper),
            shift_um(tangent, 1000.0, 0.01),
            None,
        ));
    }
    let corner_px = shift_um(1.11f64.hypot(0.75), 700.0, 0.01) / 6.8;
    rows.push(row(
        SECTION_3_1,
        "corner, H 700 m, centre 10 mm off, px (paper: below)".to_owned(),
        Some(0.1),
        corner_px,
        Some("at the stated height it is above a tenth of a pixel; what it does to the angles is still harmless"),
    ));
    rows
}
