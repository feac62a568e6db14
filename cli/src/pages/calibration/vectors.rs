//! Before and after: the residuals of every head as vectors over its frame.
//!
//! The vectors are two SVG paths a picture instead of a chart; the frame's border has its coordinates.

use super::{Page, rms};
use maud::{Markup, html};
use plumbline_charts::format::{decimals, maybe, nice, number, whole};
use std::fmt::Write;

/// Most vectors of a picture.
const VECTORS_MAX: usize = 1500;
/// Length of an average vector and of the scale bar, as shares of the frame's width.
const VECTOR: f64 = 0.05;
const BAR: f64 = 0.3;
/// Height of the coordinates' letters, of half the frame's width: to be read on a narrow page and on paper.
const LETTERS: f64 = 0.13;

/// Share of the vectors that end inside their frame; what is longer ends at its border. Chosen: outliers would make all others dots.
const INSIDE: f64 = 0.95;

/// A residual and where it is, pixels.
type Vector = ([f64; 2], [f64; 2]);

/// How vectors are drawn: how much they are enlarged, and what the scale bar means, pixels.
#[derive(Clone, Copy, Debug)]
struct Scale {
    factor: f64,
    bar_px: f64,
}

impl Page<'_> {
    pub(super) fn before_and_after(&self) -> Markup {
        let half_px = self.seams.view.head_half_px;
        let heads = 0..self.calibration.heads.len();
        let after: Vec<_> = self.calibration.residuals.iter().map(|residual| Some(residual.v_px)).collect();
        let [before, after] = [self.before.shown(), &after]
            .map(|all| heads.clone().map(|head| self.of_head(all, head)).collect::<Vec<Vec<Vector>>>());
        let scales = [&before, &after].map(|all| Scale::new(all, half_px));
        html! {
            section {
                h2 { "Before and after" }
                figure {
                div class="four" {
                    @for head in heads.clone() {
                        (picture(head, "before", &before[head], half_px, scales[0]))
                        (picture(head, "after", &after[head], half_px, scales[1]))
                    }
                }
                figcaption {
                    "Residuals, observed minus computed, each from the dot where the point was observed, over the head’s frame (row 0 "
                    "forward). Before, enlarged " (enlarged(scales[0])) ": "
                    @if self.before.designed.is_some() {
                        "stations and points adjusted to heads that stay as the block’s start values have them."
                    } @else { "at the block’s start values." }
                    " After, enlarged " (enlarged(scales[1])) ". The bars are so many pixels long. Vectors that are longer than the frame has room for end at its border."
                    @if before.iter().chain(&after).any(|of| of.len() > VECTORS_MAX) { " At most " (VECTORS_MAX) " are drawn." }
                }
                }
                (self.rms_table())
            }
        }
    }

    fn of_head(&self, residuals: &[Option<[f64; 2]>], head: usize) -> Vec<Vector> {
        let seen = self.observations.seen.iter().zip(residuals).filter(|(seen, _)| seen.head == head);
        seen.filter_map(|(seen, residual)| Some((seen.image_px, (*residual)?))).collect()
    }

    fn rms_table(&self) -> Markup {
        let after: Vec<_> = self.calibration.residuals.iter().map(|residual| Some(residual.v_px)).collect();
        let row = |name: &str, is_in: &dyn Fn(usize) -> bool, strong: bool| {
            let of = |all: &[Option<[f64; 2]>]| {
                let of = self.observations.seen.iter().zip(all).filter(|(seen, _)| is_in(seen.head));
                maybe(rms(of.filter_map(|(_, residual)| residual.as_ref())), 2, "px")
            };
            let count = self.observations.seen.iter().filter(|seen| is_in(seen.head)).count();
            html! {
                tr {
                    th { (name) }
                    td class="n" { (whole(count as u64)) }
                    td class="n" { (of(&self.before.at_start)) }
                    td class="n" { (self.before.designed.as_ref().map_or_else(|| maybe(None, 2, "px"), |all| of(all))) }
                    td class=(if strong { "n strong" } else { "n" }) { (of(&after)) }
                }
            }
        };
        html! {
            table class="wide" {
                thead { tr { th { "RMS of a coordinate" } th class="n" { "Observa­tions" } th class="n" { "Start values" } th class="n" { "Heads as designed" } th class="n" { "Cali­brated" } } }
                tbody {
                    @for head in 0..self.calibration.heads.len() { (row(&format!("Head {}", head + 1), &|of| of == head, false)) }
                    (row("All", &|_| true, true))
                }
            }
            p class="note" { "Start values: heads, stations and points all as the block has them. Heads as designed: stations and points adjusted." }
        }
    }
}

impl Scale {
    /// One scale for all heads: the average vector has the length that is wished for, or less, so that most end inside the frame.
    fn new(heads: &[Vec<Vector>], half_px: [f64; 2]) -> Self {
        let width = 2.0 * half_px[0];
        let wished = rms(heads.iter().flatten().map(|(_, vector)| vector)).map_or(1.0, |rms| VECTOR * width / rms);
        let factor = nice(wished.min(room(heads.iter().flatten(), half_px)));
        Scale { factor, bar_px: nice(BAR * width / factor) }
    }
}

/// The factor at which [`INSIDE`] of the vectors end inside the frame.
fn room<'v>(vectors: impl Iterator<Item = &'v Vector>, half_px: [f64; 2]) -> f64 {
    let of_axis = |at: f64, part: f64, half: f64| {
        if part == 0.0 { f64::INFINITY } else { (half - at * part.signum()).max(0.0) / part.abs() }
    };
    let mut factors: Vec<f64> =
        vectors.map(|(at, v)| of_axis(at[0], v[0], half_px[0]).min(of_axis(at[1], v[1], half_px[1]))).collect();
    factors.sort_by(f64::total_cmp);
    factors
        .get(((1.0 - INSIDE) * factors.len() as f64) as usize)
        .copied()
        .filter(|factor| *factor > 0.0)
        .unwrap_or(f64::INFINITY)
}

fn enlarged(scale: Scale) -> String {
    format!("{} times", scale.factor)
}

/// One head's frame with its vectors; y runs down in a picture.
fn picture(head: usize, when: &str, vectors: &[Vector], [x, y]: [f64; 2], scale: Scale) -> Markup {
    let (mut lines, mut dots) = (String::new(), String::new());
    for ([right, up], residual) in vectors.iter().step_by(vectors.len().div_ceil(VECTORS_MAX).max(1)) {
        let [dx, dy] = residual.map(|part| part * scale.factor);
        // Writing to a string cannot fail.
        let _ = write!(lines, "M{right:.0} {:.0}l{dx:.0} {:.0}", -up, -dy);
        let _ = write!(dots, "M{right:.0} {:.0}h0", -up);
    }
    let (name, clip) = (head + 1, format!("{when}-{head}"));
    let (edge, aside, foot) = (0.05 * x, 0.46 * x, 2.4 * LETTERS * x);
    let view = format!("{:.0} {:.0} {:.0} {:.0}", -x - aside, -y - edge, 2.0 * x + aside + edge, 2.0 * y + edge + foot);
    let bar = format!("M{:.0} {:.0}h{:.0}", -x, y + 0.8 * foot, scale.bar_px * scale.factor);
    let rms = maybe(rms(vectors.iter().map(|(_, residual)| residual)), 2, "px");
    let border = || html! { rect x=(format!("{:.0}", -x)) y=(format!("{:.0}", -y)) width=(format!("{:.0}", 2.0 * x)) height=(format!("{:.0}", 2.0 * y)) {} };
    html! {
        div {
            svg viewBox=(view) role="img" aria-label=(format!("Residuals of head {name} {when} the calibration")) {
                clipPath id=(clip) { (border()) }
                g fill="#f4f2ec" stroke="#d6d3cb" stroke-width=(format!("{:.0}", 0.008 * x)) { (border()) }
                g clip-path=(format!("url(#{clip})")) fill="none" {
                    path d=(dots) stroke="#969185" stroke-width=(format!("{:.0}", 0.025 * x)) stroke-linecap="round" {}
                    path d=(lines) stroke=(if when == "before" { "#b06a00" } else { "#1f5a8c" }) stroke-width=(format!("{:.0}", 0.01 * x)) {}
                }
                path d=(bar) stroke="#1d1d1b" stroke-width=(format!("{:.0}", 0.03 * x)) fill="none" {}
                (coordinates([x, y]))
            }
            span { b { "Head " (name) " " (when) } ", RMS " (rms) "; bar " (number(scale.bar_px, decimals(scale.bar_px), "px")) }
        }
    }
}

/// Pixels from the frame's middle, along its lower and its left border.
fn coordinates([x, y]: [f64; 2]) -> Markup {
    let size = LETTERS * x;
    let label = |value: f64| number(value, 0, "");
    html! {
        g font-size=(format!("{size:.0}")) fill="#605e57" text-anchor="middle" {
            @for at in [-x, 0.0, x] {
                text x=(format!("{:.0}", at.clamp(-0.78 * x, 0.78 * x))) y=(format!("{:.0}", y + 1.2 * size)) { (label(at)) @if at > 0.0 { " px" } }
            }
        }
        g font-size=(format!("{size:.0}")) fill="#605e57" text-anchor="end" {
            @for at in [-y, 0.0, y] {
                text x=(format!("{:.0}", -x - 0.3 * size)) y=(format!("{:.0}", (0.35 * size - at).clamp(0.8 * size - y, y))) { (label(at)) }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// All but one have room for three times their length, and one in forty does not count.
    #[test]
    fn most_vectors_end_inside_their_frame() {
        let mut vectors: Vec<Vector> = (0..39).map(|_| ([70.0, 0.0], [10.0, 0.0])).collect();
        vectors.push(([0.0, 0.0], [0.0, 5000.0]));
        assert_eq!(room(vectors.iter(), [100.0, 80.0]), 3.0);
        assert_eq!(room([([0.0, -60.0], [1.0, -2.0])].iter(), [100.0, 80.0]), 10.0);
        assert_eq!(room([].iter(), [100.0, 80.0]), f64::INFINITY);
    }
}
