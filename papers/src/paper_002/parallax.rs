//! What terrain and centres off the plane do to the virtual image (sections 2.2 and 3.1.1).

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

/// The rows of both sections.
#[must_use]
pub fn rows() -> Vec<Row> {
    let mut rows = parallaxes();
    rows.extend(shifts());
    rows
}

fn row(table: &'static str, quantity: &str, paper: Option<f64>, ours: f64, difference: Option<&str>) -> Row {
    Row {
        decimals: None,
        table,
        quantity: quantity.to_owned(),
        paper,
        ours: Some(ours),
        difference: difference.map(str::to_owned),
    }
}

/// Section 2.2.
fn parallaxes() -> Vec<Row> {
    let [across, along] = [CENTRES_M[0][0].abs(), CENTRES_M[0][1].abs()];
    let row = |quantity, paper, ours, difference| row("Section 2.2, figure 3", quantity, paper, ours, difference);
    let rounded =
        "the paper takes its rounded 0.276 px times the ground sample distance at the plane; 0.276471 px give 2.000";
    let centre = "the centres' distances are lost; 0.06 m in y is what the printed parallax takes, 0.045 m in x makes the \
                  diagonal the printed 0.15 m";
    let bound =
        "the paper says \"above or below\"; below the plane the ground is farther away, so that it is a bound only";
    let [y_500, y_750] = [500.0, 750.0].map(|height_m| parallax_px(along, height_m, 0.25));
    let x_500 = parallax_px(across, 500.0, 0.25);
    let below = parallax_px(along, 500.0, -0.25).abs();
    vec![
        row("y, h 500 m, ground 1/4 h above, px", Some(0.276), y_500, None),
        row("y, h 750 m, ground 1/4 h above, px", Some(0.184), y_750, None),
        row("the same on the ground at 500 m, cm", Some(1.997), 100.0 * y_500 * 500.0 / F_PX, Some(rounded)),
        row("x, h 500 m, ground 1/4 h above, px", None, x_500, Some(centre)),
        row("y, h 500 m, ground 1/4 h below, px", Some(0.276), below, Some(bound)),
    ]
}

/// Section 3.1.1.
fn shifts() -> Vec<Row> {
    let row = |quantity: &str, paper, ours, difference| row("Section 3.1.1", quantity, Some(paper), ours, difference);
    let heights = "the printed figures are those of H = 1000 m (or of 7 mm at 700 m), not of the stated 700 m";
    let corner = 1.11f64.hypot(0.75);
    let mut rows = Vec::new();
    for (name, tangent, paper) in [("long side", 1.11, 0.52), ("narrow side", 0.75, 0.35), ("corner", corner, 0.63)] {
        for (height_m, difference) in [(700.0, Some(heights)), (1000.0, None)] {
            let quantity = format!("{name}, H {height_m} m, centre 10 mm off, um");
            rows.push(row(&quantity, paper, shift_um(tangent, height_m, 0.01), difference));
        }
    }
    rows.push(row(
        "corner, H 700 m, centre 10 mm off, px (paper: below)",
        0.1,
        shift_um(corner, 700.0, 0.01) / 6.8,
        Some("at the stated height it is above a tenth of a pixel; what it does to the angles is still harmless"),
    ));
    rows
}
