//! Seams: where and how far the heads are expected to disagree in the virtual image, and how far they did.

use super::Page;
use maud::{Markup, html};
use plumbline_charts::format::{maybe, number, whole};
use std::collections::BTreeMap;
use std::fmt::Write;

/// Colours from the smallest to the largest mismatch.
const COLOURS: [&str; 5] = ["#d3e3f0", "#9fc3df", "#639ac6", "#2f6ca3", "#123f66"];

impl Page<'_> {
    pub(super) fn seams(&self) -> Markup {
        if self.calibration.heads.len() < 2 {
            return html! {};
        }
        html! {
            section {
                h2 { "Seams" }
                div class="two tall" {
                    (self.seam_map())
                    div { (self.seam_tables()) }
                }
            }
        }
    }

    fn seam_tables(&self) -> Markup {
        let mut pairs = self.seams.pairs();
        pairs.extend(self.observed.0.iter().map(|twice| twice.heads));
        pairs.sort_unstable();
        pairs.dedup();
        let pairs: Vec<_> = pairs.into_iter().map(Some).chain([None]).collect();
        let name = |pair: &Option<[usize; 2]>| {
            pair.map_or_else(|| "All".to_owned(), |[a, b]| format!("{} and {}", a + 1, b + 1))
        };
        let both = |value: Option<(f64, f64)>, digits| {
            html! {
                td class="n" { (maybe(value.map(|(rms, _)| rms), digits, "px")) }
                td class="n" { (maybe(value.map(|(_, max)| max), digits, "px")) }
            }
        };
        html! {
            table class="wide" {
                thead { tr { th { "Predicted, heads" } th class="r" { "RMS" } th class="r" { "Largest" } } }
                tbody { @for pair in &pairs { tr { th { (name(pair)) } (both(self.seams.rms_and_max(*pair), 3)) } } }
            }
            p class="note" {
                "Root of the expected square of the mismatch of distant ground: the covariance of the heads’ unknowns, carried on by what "
                "one standard deviation of each does to the virtual image (differences, not derivatives). A turn of all heads together is "
                "no seam. Ground above or below the plane of stitching adds its parallax."
            }
            table class="wide" {
                thead { tr { th { "Observed, heads" } th class="r" { "Points" } th class="n" { "As designed, RMS; largest" } th class="n" { "Calibrated, RMS; largest" } } }
                tbody {
                    @for pair in &pairs {
                        @if let Some((count, [before, after])) = self.observed.of(*pair) {
                            tr {
                                th { (name(pair)) }
                                td class="n" { (whole(count as u64)) }
                                @for (rms, max) in [before, after] { td class="n" { (number(rms, 2, "")) "; " (number(max, 2, "px")) } }
                            }
                        }
                    }
                }
            }
            p class="note" {
                @if self.observed.0.is_empty() { "No point was seen by two heads of one station: nothing shows the seams themselves." }
                @else {
                    "Points seen by two heads of one station: distance of their two places in the virtual image, parallax taken off with the "
                    "adjusted depth. It holds the measuring noise of both, which alone is about 2 sigma0 = "
                    (number(2.0 * self.calibration.sigma0_px, 2, "px")) " RMS on the axis and more towards the borders, where the plane stretches."
                }
            }
        }
    }

    /// The virtual image: heads’ outlines, overlaps in the colour of their mismatch.
    fn seam_map(&self) -> Markup {
        let seams = &self.seams;
        let all = seams.outlines.iter().flatten().chain([&seams.view.half_px]);
        let [x, y] =
            all.fold([0.0_f64, 0.0_f64], |[x, y], [a, b]| [x.max(a.abs()), y.max(b.abs())]).map(|half| 1.02 * half);
        if !(x > 0.0 && y > 0.0) {
            return html! {};
        }
        let classes = self.classes();
        let stroke = |part: f64| format!("{:.0}", part * x);
        let [half_x, half_y] = seams.view.half_px;
        let box_of = |part: f64| format!("{:.0}", part);
        html! {
            figure {
                svg viewBox=(format!("{:.0} {:.0} {:.0} {:.0}", -x, -y, 2.0 * x, 2.0 * y)) role="img" aria-label="Virtual image with the heads’ frames and the predicted mismatch where they overlap" {
                    @for class in &classes { path d=(class.cells) fill=(class.colour) fill-opacity="0.75" {} }
                    @for outline in &seams.outlines { path d=(closed(outline)) fill="none" stroke="#605e57" stroke-width=(stroke(0.004)) {} }
                    rect x=(box_of(-half_x)) y=(box_of(-half_y)) width=(box_of(2.0 * half_x)) height=(box_of(2.0 * half_y))
                        fill="none" stroke="#1d1d1b" stroke-width=(stroke(0.006)) {}
                    @for (head, outline) in seams.outlines.iter().enumerate().filter(|(_, outline)| !outline.is_empty()) {
                        @let count = outline.len() as f64;
                        text x=(box_of(outline.iter().map(|at| at[0]).sum::<f64>() / count)) y=(box_of(-outline.iter().map(|at| at[1]).sum::<f64>() / count))
                            font-size=(stroke(0.075)) text-anchor="middle" fill="#1d1d1b" { "head " (head + 1) }
                    }
                }
                figcaption {
                    b { "Predicted mismatch. " }
                    @if classes.is_empty() { "No two heads see the same direction, or no unknown of a head was estimated." }
                    @for class in &classes {
                        span class="key box" style=(format!("--c:{}", class.colour)) {}
                        (format!("{:.3} to {}", class.from_px, number(class.to_px, 3, "px"))) ", "
                    }
                    "the largest of the pairs that see a place. Thin: the heads’ frames; thick: the virtual image, "
                    (whole((2.0 * half_x).round() as u64)) " × " (whole((2.0 * half_y).round() as u64)) " px, row 0 forward."
                }
            }
        }
    }

    /// Cells of the grid by their mismatch.
    fn classes(&self) -> Vec<Class> {
        let step = self.seams.step_px;
        let mut worst: BTreeMap<[i64; 2], f64> = BTreeMap::new();
        for place in &self.seams.places {
            let cell = place.at_px.map(|at| (at / step).round() as i64);
            let known = worst.entry(cell).or_insert(0.0);
            *known = known.max(place.sigma_px);
        }
        let low = worst.values().copied().fold(f64::INFINITY, f64::min);
        let high = worst.values().copied().fold(0.0, f64::max);
        let width = (high - low) / COLOURS.len() as f64;
        let mut classes: Vec<Class> = COLOURS
            .iter()
            .enumerate()
            .map(|(k, colour)| {
                let [from_px, to_px] = [k, k + 1].map(|border| low + width * border as f64);
                Class { colour, from_px, to_px, cells: String::new() }
            })
            .collect();
        for ([col, row], mismatch) in &worst {
            // A cast from a float saturates: where all are equal 0 / 0 falls into the first class.
            let class = (((mismatch - low) / width) as usize).min(COLOURS.len() - 1);
            let corner = [*col as f64 - 0.5, -(*row as f64) - 0.5].map(|at| at * step);
            let _ = write!(classes[class].cells, "M{:.0} {:.0}h{step:.0}v{step:.0}h-{step:.0}z", corner[0], corner[1]);
        }
        classes.retain(|class| !class.cells.is_empty());
        classes
    }
}

/// Cells of about the same mismatch.
struct Class {
    colour: &'static str,
    from_px: f64,
    to_px: f64,
    /// Path of their squares.
    cells: String,
}

/// A closed line through points whose y runs up.
fn closed(points: &[[f64; 2]]) -> String {
    let mut path = String::new();
    for (k, [x, y]) in points.iter().enumerate() {
        let _ = write!(path, "{}{x:.0} {:.0}", if k == 0 { 'M' } else { 'L' }, -y);
    }
    if !path.is_empty() {
        path.push('z');
    }
    path
}
