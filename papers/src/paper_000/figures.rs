//! Figures 3, 4 and 5 as SVG.

use super::intersection::Sweep;
use super::seeds::seeds;
use plumbline_charts::format::{decimals, nice};
use std::fmt::Write;

/// Inside of a plot, screen pixels, and what is left around it.
const SIZE: [f64; 2] = [560.0, 400.0];
const MARGIN: [f64; 2] = [84.0, 48.0];
/// Ticks of an axis, about.
const TICKS: f64 = 5.0;
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

/// The part of the page that a figure's inside takes, and what it ranges over.
struct Frame {
    /// Width and height, screen pixels.
    size: [f64; 2],
    /// First and last of x, first and last of y.
    range: [[f64; 2]; 2],
}

impl Frame {
    /// Screen pixels of a place.
    fn page(&self, at: [f64; 2]) -> [f64; 2] {
        let [x, y] = [0, 1].map(|axis| {
            let [first, last] = self.range[axis];
            (at[axis] - first) / (last - first)
        });
        [MARGIN[0] + self.size[0] * x, MARGIN[1] + self.size[1] * (1.0 - y)]
    }

    /// Border, ticks at round numbers, and what the axes are, with their units.
    fn axes(&self, svg: &mut String, x_text: &str, y_text: &str) {
        let ([wide, high], [left, top]) = (self.size, MARGIN);
        let bottom = top + high;
        // Writing to a string cannot fail.
        let _ = writeln!(
            svg,
            "<rect x=\"{left:.1}\" y=\"{top:.1}\" width=\"{wide:.1}\" height=\"{high:.1}\" fill=\"none\" stroke=\"#333\"/>"
        );
        for (axis, [first, last]) in self.range.into_iter().enumerate() {
            let step = nice((last - first) / TICKS);
            for k in (first / step - 1e-9).ceil() as i32..=(last / step + 1e-9).floor() as i32 {
                let value = f64::from(k) * step;
                let label = format!("{value:.*}", decimals(step)).replace('-', "\u{2212}");
                let [x, y] = self.page([value; 2]);
                let _ = if axis == 0 {
                    writeln!(
                        svg,
                        "<path d=\"M{x:.1} {bottom:.1}v6\" stroke=\"#333\"/><text x=\"{x:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{label}</text>",
                        bottom + 20.0
                    )
                } else {
                    writeln!(
                        svg,
                        "<path d=\"M{left:.1} {y:.1}h-6\" stroke=\"#333\"/><text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"end\">{label}</text>",
                        left - 10.0,
                        y + 4.0
                    )
                };
            }
        }
        let _ = writeln!(
            svg,
            "<text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{x_text}</text>",
            left + 0.5 * wide,
            bottom + 42.0
        );
        let _ = writeln!(
            svg,
            "<text transform=\"translate({:.1} {:.1}) rotate(-90)\" text-anchor=\"middle\">{y_text}</text>",
            left - 58.0,
            top + 0.5 * high
        );
    }

    /// An empty page for it, with room for so many lines of text below.
    fn open(&self, title: &str, lines: usize) -> String {
        open([self.size[0] + MARGIN[0] + 40.0, self.size[1] + MARGIN[1] + 62.0 + 20.0 * lines as f64], title)
    }

    /// Where a line of text below it stands.
    fn below(&self, line: usize) -> f64 {
        MARGIN[1] + self.size[1] + 66.0 + 20.0 * line as f64
    }
}

/// The 300 points with their motion, 200 times as long.
fn figure_3() -> String {
    /// Screen pixels a millimetre of the image, and how far the motion leads beyond the points.
    const SCALE: f64 = 11.0;
    const REACH_MM: [[f64; 2]; 2] = [[-20.0, 20.0], [-27.0, 25.0]];
    /// Millimetres that a pixel's motion is drawn with: 9e-3 mm a pixel, 200 times.
    const MM_PER_PX: f64 = 1.8;
    let frame = Frame { size: REACH_MM.map(|[first, last]| SCALE * (last - first)), range: REACH_MM };
    let mut svg = frame.open("Figure 3: image motion of 300 points in 5 ms", 2);
    frame.axes(&mut svg, "x (mm)", "y (mm)");
    for seed in seeds() {
        let end = [0, 1].map(|axis| seed.at_mm[axis] + MM_PER_PX * seed.exact_px[axis]);
        let [[x0, y0], [x1, y1]] = [frame.page(seed.at_mm), frame.page(end)];
        let _ = writeln!(
            svg,
            "<path d=\"M{x0:.1} {y0:.1}L{x1:.1} {y1:.1}\" stroke=\"{BLUE}\"/><circle cx=\"{x0:.1}\" cy=\"{y0:.1}\" r=\"1.6\"/>"
        );
    }
    let y = frame.below(0);
    let _ = writeln!(
        svg,
        "<path d=\"M{:.1} {:.1}h{:.1}\" stroke=\"{BLUE}\" stroke-width=\"2\"/>",
        MARGIN[0],
        y - 4.0,
        SCALE * MM_PER_PX
    );
    text(&mut svg, [MARGIN[0] + SCALE * MM_PER_PX + 10.0, y], "motion of one pixel (9 µm), drawn 200 times as long");
    svg + "</svg>\n"
}

/// Curves over the stamp, metres.
fn curves(title: &str, all: &[(Vec<[f64; 2]>, &str, &str)]) -> String {
    let last =
        |index: usize| all.iter().flat_map(|(points, ..)| points.iter().map(move |p| p[index])).fold(1e-9, f64::max);
    let frame = Frame { size: SIZE, range: [[0.0, last(0)], [0.0, last(1)]] };
    let mut svg = frame.open(title, all.len());
    frame.axes(&mut svg, "stamp after the shutter opened (ms)", "RMS error (m)");
    for (index, (points, colour, name)) in all.iter().enumerate() {
        let place = |&point: &[f64; 2]| {
            let [x, y] = frame.page(point);
            format!("{x:.1},{y:.1}")
        };
        let line = points.iter().map(place).collect::<Vec<_>>().join(" ");
        let (left, y) = (MARGIN[0], frame.below(index));
        let _ = writeln!(
            svg,
            "<polyline points=\"{line}\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"2\"/>\
             <path d=\"M{left:.1} {:.1}h24\" stroke=\"{colour}\" stroke-width=\"2\"/>",
            y - 4.0
        );
        text(&mut svg, [left + 32.0, y], name);
    }
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
