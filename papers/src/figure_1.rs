//! Figure 1: the frame as it is taken for when nobody rectifies it, and where it really lies on the ground.
//!
//! Pitch 10 and roll 8 degrees at 150 m, as Table 1's header has them (the text beside the paper's figure has them the
//! other way round), with V = 60 degrees. Both outlines are metres on the ground about the nadir, north up, drawn to
//! one scale; the grid lines are lines of frame pixels, carried over by the core.

use super::setting::PITCH_ROLL_DEG;
use plumbline_core::camera::{Camera, CameraError};
use plumbline_core::homography::Homography;
use plumbline_core::tilt::{Attitude, camera_from_local};
use plumbline_core::units::Radians;
use std::fmt::Write;

const HEIGHT_M: f64 = 150.0;
const FOV_DEG: f32 = 60.0;
const SIDE_PX: u16 = 512;
/// Lines of the grid each way, the borders included.
const LINES: usize = 9;
/// What is shown, metres: east from, east to, north from, north to.
const WINDOW_M: [f64; 4] = [-170.0, 110.0, -120.0, 170.0];
const SCALE_PX_PER_M: f64 = 2.4;
const MARGIN_PX: [f64; 2] = [64.0, 56.0];

/// The figure as SVG text.
///
/// # Errors
/// None for this camera; the core's own check is passed on.
pub fn svg() -> Result<String, CameraError> {
    let fov = Radians::from_degrees(FOV_DEG);
    let camera = Camera::new((SIDE_PX, SIDE_PX), (fov, fov), (0.0, 0.0), None)?;
    let [pitch, roll] = PITCH_ROLL_DEG.map(|degrees| Radians::from_degrees(degrees as f32));
    let attitude = Attitude { heading: Radians(0.0), pitch, roll };
    let tilted = Homography::inverse(&camera_from_local(attitude, Radians(0.0)), &camera);
    let metres = f64::from(camera.tangent_per_px().0) * HEIGHT_M;
    let level = move |m: f64, n: f64| [m * metres, n * metres];
    let ground = |m: f64, n: f64| {
        tilted.ideal(m as f32, n as f32).map_or(level(m, n), |(m, n)| level(f64::from(m), f64::from(n)))
    };

    let [west, east, south, north] = WINDOW_M;
    let [left, top] = MARGIN_PX;
    let (width, height) = ((east - west) * SCALE_PX_PER_M, (north - south) * SCALE_PX_PER_M);
    let mut svg = String::new();
    // Writing to a string cannot fail.
    let _ = writeln!(
        svg,
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0:.0}\" height=\"{1:.0}\" viewBox=\"0 0 {0:.0} {1:.0}\" \
         font-family=\"sans-serif\" font-size=\"13\">\n<rect width=\"100%\" height=\"100%\" fill=\"white\"/>",
        width + left + 24.0,
        height + top + 118.0
    );
    text(
        &mut svg,
        [left, 24.0],
        "start",
        "Figure 1: ground under a frame, 150 m, pitch 10\u{b0}, roll 8\u{b0}, V = 60\u{b0}",
    );
    axes(&mut svg);
    grid(&mut svg, &level, "#9a9a9a");
    grid(&mut svg, &ground, "#0b62c4");
    let centre = ground(0.0, 0.0);
    let [[x0, y0], [x1, y1]] = [[0.0, 0.0], centre].map(on_page);
    let _ = writeln!(
        svg,
        "<line x1=\"{x0:.1}\" y1=\"{y0:.1}\" x2=\"{x1:.1}\" y2=\"{y1:.1}\" stroke=\"#d0021b\" stroke-width=\"2.5\"/>\n\
         <circle cx=\"{x1:.1}\" cy=\"{y1:.1}\" r=\"4.5\" fill=\"#d0021b\"/>\n\
         <path d=\"M{a:.1} {y0:.1}H{b:.1}M{x0:.1} {c:.1}V{d:.1}\" stroke=\"black\" stroke-width=\"2\"/>",
        a = x0 - 8.0,
        b = x0 + 8.0,
        c = y0 - 8.0,
        d = y0 + 8.0
    );
    legend(&mut svg, height + top + 62.0, centre);
    svg.push_str("</svg>\n");
    Ok(svg)
}

/// Page position of metres (east, north).
fn on_page([east, north]: [f64; 2]) -> [f64; 2] {
    [MARGIN_PX[0] + (east - WINDOW_M[0]) * SCALE_PX_PER_M, MARGIN_PX[1] + (WINDOW_M[3] - north) * SCALE_PX_PER_M]
}

fn text(svg: &mut String, [x, y]: [f64; 2], anchor: &str, words: &str) {
    let _ = writeln!(svg, "<text x=\"{x:.1}\" y=\"{y:.1}\" text-anchor=\"{anchor}\">{words}</text>");
}

/// The frame's border and inner lines, each a straight line on the ground too.
fn grid(svg: &mut String, ground: &dyn Fn(f64, f64) -> [f64; 2], colour: &str) {
    let half = 0.5 * f64::from(SIDE_PX);
    for line in 0..LINES {
        let at = half * (2.0 * line as f64 / (LINES - 1) as f64 - 1.0);
        let stroke = if line == 0 || line + 1 == LINES { 2.6 } else { 0.8 };
        for [from, to] in [[ground(at, -half), ground(at, half)], [ground(-half, at), ground(half, at)]] {
            let [[x0, y0], [x1, y1]] = [from, to].map(on_page);
            let _ = writeln!(
                svg,
                "<line x1=\"{x0:.1}\" y1=\"{y0:.1}\" x2=\"{x1:.1}\" y2=\"{y1:.1}\" stroke=\"{colour}\" stroke-width=\"{stroke}\"/>"
            );
        }
    }
}

/// Ticks every 50 m, left and below.
fn axes(svg: &mut String) {
    let [west, east, south, north] = WINDOW_M;
    let [[left, top], [right, bottom]] = [[west, north], [east, south]].map(on_page);
    let _ = writeln!(
        svg,
        "<rect x=\"{left:.1}\" y=\"{top:.1}\" width=\"{:.1}\" height=\"{:.1}\" fill=\"none\" stroke=\"#333\"/>",
        right - left,
        bottom - top
    );
    for metres in (-150..=150).step_by(50).map(f64::from) {
        let [x, y] = on_page([metres, metres]);
        if (west..=east).contains(&metres) {
            let _ = writeln!(svg, "<path d=\"M{x:.1} {bottom:.1}v6\" stroke=\"#333\"/>");
            text(svg, [x, bottom + 20.0], "middle", &metres.to_string());
        }
        if (south..=north).contains(&metres) {
            let _ = writeln!(svg, "<path d=\"M{left:.1} {y:.1}h-6\" stroke=\"#333\"/>");
            text(svg, [left - 9.0, y + 4.5], "end", &metres.to_string());
        }
    }
    text(svg, [right, bottom + 38.0], "end", "east of the nadir, m");
    text(svg, [left, top - 9.0], "middle", "north, m");
}

fn legend(svg: &mut String, y: f64, [east, north]: [f64; 2]) {
    let lines = [
        ("#9a9a9a", "frame taken as if the camera looked straight down".to_owned()),
        ("#0b62c4", "where the same frame lies on the ground".to_owned()),
        (
            "#d0021b",
            format!(
                "from the nadir (cross) to the frame's centre: {:.1} m across, {north:.1} m along = {:.1}, {:.1} px of 5 m",
                -east,
                -east / 5.0,
                north / 5.0
            ),
        ),
    ];
    for (index, (colour, words)) in lines.into_iter().enumerate() {
        let y = y + 18.0 * index as f64;
        let x = MARGIN_PX[0];
        let _ = writeln!(svg, "<path d=\"M{x} {:.1}h26\" stroke=\"{colour}\" stroke-width=\"3\"/>", y - 4.5);
        text(svg, [x + 34.0, y], "start", &words);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_outlines_are_drawn_within_the_page_and_the_offset_is_table_1s() {
        let svg = svg().unwrap();
        assert_eq!(svg.matches("#0b62c4").count(), 2 * LINES + 1);
        assert!(svg.contains("= 4.3, 5.3 px of 5 m"), "{svg}");
        let width = (WINDOW_M[1] - WINDOW_M[0]) * SCALE_PX_PER_M + MARGIN_PX[0];
        let ends: Vec<f64> =
            svg.split("x2=\"").skip(1).map(|rest| rest.split('"').next().unwrap().parse().unwrap()).collect();
        assert_eq!(ends.len(), 4 * LINES + 1);
        assert!(ends.iter().all(|x| (MARGIN_PX[0]..=width).contains(x)), "{ends:?}");
    }
}
