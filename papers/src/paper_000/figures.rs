//! Figures 3, 4 and 5 as SVG.

use super::intersection::Sweep;
use super::seeds::seeds;
use std::fmt::Write;

/// Inside of a plot, screen pixels, and what is left around it.
const SIZE: [f64; 2] = [560.0, 400.0];
const MARGIN: [f64; 2] = [84.0, 48.0];
const BLUE: &str = "#0b62c4";
const RED: &str = "#d0021b";

/// Name and SVG text of each figure.
pub fn figures(sweep: &[Sweep]) -> Vec<(&'static str, String)> {
    let of = |axis: usize, both: bool| -> Vec<[f64; 2]> {
        sweep.iter().map(|s| [s.stamp_ms, if both { s.both_rms_m[axis] } else { s.one_rms_m[axis] }]).collect()
    };
    let height =
        [(of(2, true), BLUE, "Z, both photos by this stamp"), (of(2, false), RED, "Z, one photo, the other by 2.5 ms")];
    let plan =
        [(of(0, true), BLUE, "X, both photos by this stamp"), (of(1, true), RED, "Y, both photos by this stamp")];
    vec![
        ("figure_3.svg", figure_3()),
        ("figure_4.svg", curves("Figure 4: height against the stamp, RMS", &height)),
        ("figure_5.svg", curves("Figure 5: planimetry against the stamp, RMS", &plan)),
    ]
}

/// The 300 points with their motion, 200 times as long.
fn figure_3() -> String {
    const SCALE: f64 = 9.0;
    let page = |[x, y]: [f64; 2]| [MARGIN[0] + SCALE * (x + 24.0), MARGIN[1] + SCALE * (22.0 - y)];
    let mut svg =
        open([MARGIN[0] + SCALE * 44.0, MARGIN[1] + SCALE * 64.0], "Figure 3: image motion of 300 points in 5 ms");
    for seed in seeds() {
        let [[x0, y0], [x1, y1]] = [
            page(seed.at_mm),
            // 9e-3 mm a pixel, 200 times.
            page([seed.at_mm[0] + 1.8 * seed.exact_px[0], seed.at_mm[1] + 1.8 * seed.exact_px[1]]),
        ];
        let _ = writeln!(
            svg,
            "<path d=\"M{x0:.1} {y0:.1}L{x1:.1} {y1:.1}\" stroke=\"{BLUE}\"/><circle cx=\"{x0:.1}\" cy=\"{y0:.1}\" r=\"1.6\"/>"
        );
    }
    text(&mut svg, [MARGIN[0], MARGIN[1] + SCALE * 60.0], "x to the right, y up, mm; motion 200 times as long");
    svg + "</svg>\n"
}

/// Curves over the stamp, metres.
fn curves(title: &str, all: &[(Vec<[f64; 2]>, &str, &str)]) -> String {
    let last =
        |index: usize| all.iter().flat_map(|(points, ..)| points.iter().map(move |p| p[index])).fold(1e-9, f64::max);
    let (x_last, y_last) = (last(0), last(1));
    let page = |[x, y]: [f64; 2]| [MARGIN[0] + SIZE[0] * x / x_last, MARGIN[1] + SIZE[1] * (1.0 - y / y_last)];
    let mut svg = open([SIZE[0] + MARGIN[0] + 30.0, SIZE[1] + MARGIN[1] + 110.0], title);
    for tick in 0..=5 {
        let part = f64::from(tick) / 5.0;
        let [x, y] = page([part * x_last, part * y_last]);
        let [left, bottom] = page([0.0, 0.0]);
        let _ = writeln!(
            svg,
            "<path d=\"M{x:.1} {bottom:.1}v6M{left:.1} {y:.1}h-6\" stroke=\"#333\"/>\
             <text x=\"{x:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{:.1}</text>\
             <text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"end\">{:.3}</text>",
            bottom + 20.0,
            part * x_last,
            left - 10.0,
            y + 4.0,
            part * y_last
        );
    }
    let [left, bottom] = page([0.0, 0.0]);
    let _ = writeln!(
        svg,
        "<path d=\"M{left:.1} {:.1}V{bottom:.1}H{:.1}\" stroke=\"#333\" fill=\"none\"/>",
        MARGIN[1],
        left + SIZE[0]
    );
    for (index, (points, colour, name)) in all.iter().enumerate() {
        let place = |&point: &[f64; 2]| {
            let [x, y] = page(point);
            format!("{x:.1},{y:.1}")
        };
        let line = points.iter().map(place).collect::<Vec<_>>().join(" ");
        let y = bottom + 46.0 + 20.0 * index as f64;
        let _ = writeln!(
            svg,
            "<polyline points=\"{line}\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"2\"/>\
             <path d=\"M{left:.1} {:.1}h24\" stroke=\"{colour}\" stroke-width=\"2\"/>",
            y - 4.0
        );
        text(&mut svg, [left + 32.0, y], name);
    }
    text(&mut svg, [left + 300.0, bottom + 46.0], "stamp, ms after the shutter opened; metres up");
    svg + "</svg>\n"
}

fn open([width, height]: [f64; 2], title: &str) -> String {
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width:.0}\" height=\"{height:.0}\" \
         viewBox=\"0 0 {width:.0} {height:.0}\" font-family=\"sans-serif\" font-size=\"13\">\n\
         <rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n"
    );
    text(&mut svg, [MARGIN[0], 28.0], title);
    svg
}

fn text(svg: &mut String, [x, y]: [f64; 2], words: &str) {
    // Writing to a string cannot fail.
    let _ = writeln!(svg, "<text x=\"{x:.1}\" y=\"{y:.1}\">{words}</text>");
}
