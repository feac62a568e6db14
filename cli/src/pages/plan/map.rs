//! The map: terrain, area, strips with their directions, photos and a few footprints; and the frame that other maps share.

use super::Page;
use super::relief::{self, Relief, TINTS};
use maud::{Markup, html};
use plumbline_charts::format::{decimals, nice, number};
use plumbline_survey::plan::export::Outputs;
use plumbline_survey::plan::flown::Leg;
use plumbline_survey::plan::footprint::Sight;
use plumbline_survey::plan::lines::Strip;
use std::fmt::Write;

/// Drawing units across.
const WIDTH: f64 = 1000.0;
/// Tallest map, drawing units.
const HEIGHT_MAX: f64 = 1100.0;
/// Room around what is drawn, as a share of its longer side.
const MARGIN: f64 = 0.03;
/// Margin around a part, and a part's shorter side as a share of the longer at least.
const PART_MARGIN: f64 = 0.06;
const NARROW: f64 = 0.4;
/// Most lines that are drawn: more would cover the ground.
const LINES_MAX: usize = 40;
/// Room for coordinates beside and below the map, drawing units.
const ASIDE: f64 = 130.0;
const FOOT: f64 = 64.0;
/// Width and height that a strip's number takes where the page is narrow (`.numbers` in the style).
const APART: [f64; 2] = [62.0, 30.0];
/// Coordinates along an edge, about.
const TICKS: f64 = 5.0;
/// Width of a digit of a coordinate, drawing units.
const DIGIT: f64 = 11.0;
/// Length of the scale bar as a share of the width.
const BAR: f64 = 0.25;

/// Working metres on drawing units.
#[derive(Debug)]
pub struct Map {
    west_m: f64,
    north_m: f64,
    units_per_m: f64,
    /// Drawing units, down.
    height: f64,
    /// The terrain's picture.
    relief: Relief,
}

impl Map {
    /// Shows the area, the strips with their leads, the footprints of all photos and the place of the least clearance.
    pub fn new(outputs: &Outputs<'_>) -> Self {
        let layout = &outputs.planned.layout;
        let aside_m = 0.5 * layout.view.footprint_m[1];
        let ends = outputs.legs().flat_map(|leg| {
            outputs
                .led(&leg)
                .map(|along| [[along, leg.strip.across_m - aside_m], [along, leg.strip.across_m + aside_m]])
        });
        let nearest = outputs.planned.checks.nearest.map(|nearest| [nearest.x, nearest.y]);
        let places = ends.flatten().map(|at| layout.axes.point(at)).chain(outputs.area()).chain(nearest);
        let [x0, y0, x1, y1] = places
            .fold([f64::INFINITY, f64::INFINITY, f64::NEG_INFINITY, f64::NEG_INFINITY], |b, [x, y]| {
                [b[0].min(x), b[1].min(y), b[2].max(x), b[3].max(y)]
            });
        let margin_m = MARGIN * (x1 - x0).max(y1 - y0);
        let [mut x0, y0, mut x1, y1] = [x0 - margin_m, y0 - margin_m, x1 + margin_m, y1 + margin_m];
        // A tall map is made wider rather than higher than a screen.
        let lacking_m = ((y1 - y0) * WIDTH / HEIGHT_MAX - (x1 - x0)).max(0.0);
        (x0, x1) = (x0 - 0.5 * lacking_m, x1 + 0.5 * lacking_m);
        let units_per_m = WIDTH / (x1 - x0);
        Map {
            west_m: x0,
            north_m: y1,
            units_per_m,
            height: (y1 - y0) * units_per_m,
            relief: relief::picture(layout.terrain.dem(), [x0, y0, x1, y1]),
        }
    }

    /// Drawing units, to the right and down.
    pub fn at(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        [(x - self.west_m) * self.units_per_m, (self.north_m - y) * self.units_per_m]
    }

    /// Drawing units of a length.
    pub fn units(&self, metres: f64) -> f64 {
        metres * self.units_per_m
    }

    /// A line through places.
    pub fn path(&self, places: &[[f64; 2]]) -> String {
        let mut path = String::new();
        for (index, place) in places.iter().enumerate() {
            let [right, down] = self.at(*place);
            // Writing to a string cannot fail.
            let _ = write!(path, "{}{right:.1} {down:.1}", if index == 0 { 'M' } else { 'L' });
        }
        path
    }

    /// Everything there is: left, top, width and height in drawing units.
    pub fn whole(&self) -> [f64; 4] {
        [0.0, 0.0, WIDTH, self.height]
    }

    /// A part, given by its corners, with room around it and not too narrow either way.
    pub fn part(&self, [left, top]: [f64; 2], [right, foot]: [f64; 2]) -> [f64; 4] {
        let (width, height) = (right - left, foot - top);
        let room = 2.0 * PART_MARGIN * width.max(height);
        let (wide, high) = (width + room, height + room);
        let (wide, high) = (wide.max(NARROW * high), high.max(NARROW * wide));
        [0.5 * (left + right - wide), 0.5 * (top + foot - high), wide, high]
    }

    /// A map of a part, with `over` drawn on the terrain. The first has the terrain's picture in it, the others refer to it.
    pub fn svg(&self, label: &str, is_first: bool, part: [f64; 4], over: &Markup) -> Markup {
        let [left, top, width, height] = part;
        // Bar and arrow have the same size whatever the part.
        let scale = width / WIDTH;
        let bar_m = nice(BAR * width / self.units_per_m);
        let foot = height / scale - 24.0;
        let bar = format!("M24 {foot:.1}v-12M24 {foot:.1}h{:.1}v-12", self.units(bar_m) / scale);
        let text = if bar_m >= 1000.0 { number(bar_m / 1000.0, 0, "km") } else { number(bar_m, decimals(bar_m), "m") };
        let [view_left, view_top, view_width, view_height] =
            if is_first { [left - ASIDE, top, width + ASIDE, height + FOOT] } else { part };
        let arrow = format!("M{} 20l11 34l-11 -8l-11 8z", WIDTH - 34.0);
        html! {
            svg class="relief" viewBox=(format!("{view_left:.1} {view_top:.1} {view_width:.1} {view_height:.1}")) role="img" aria-label=(label) {
                @if is_first {
                    image id="relief" href=(self.relief.uri) width=(WIDTH) height=(format!("{:.1}", self.height)) preserveAspectRatio="none" {}
                } @else { use href="#relief" {} }
                (over)
                @if is_first { (self.coordinates()) }
                g class="scale" transform=(format!("translate({left:.1} {top:.1}) scale({scale:.4})")) font-size="26" fill="#1d1d1b" stroke="#fdfcf9" stroke-width="5" paint-order="stroke" {
                    path d=(bar) fill="none" stroke-width="9" {}
                    path d=(bar) fill="none" stroke="#1d1d1b" stroke-width="4" {}
                    text x="28" y=(format!("{:.1}", foot - 22.0)) { (text) }
                    path d=(arrow) {}
                    text x=(WIDTH - 34.0) y="82" text-anchor="middle" { "N" }
                }
            }
        }
    }

    /// From tick to tick: about as many as are wished for, and so far apart that their numbers keep apart.
    fn tick_step_m(&self) -> f64 {
        let apart = |step_m: f64| {
            let text = |x: f64| number(x, decimals(step_m), "").chars().count();
            let longest = text(self.west_m).max(text(self.west_m + WIDTH / self.units_per_m));
            self.units(step_m) >= 2.0 * DIGIT * longest as f64
        };
        let mut step_m = nice(WIDTH / self.units_per_m / TICKS);
        while !apart(step_m) && self.units(step_m) < WIDTH {
            // The next one of 1, 2, 5.
            step_m = nice(2.6 * step_m);
        }
        step_m
    }

    /// Coordinates beside the left and below the lower edge of the whole map, with their ticks.
    fn coordinates(&self) -> Markup {
        let step_m = self.tick_step_m();
        let digits = decimals(step_m);
        // Of every other one the number is left out where the page is narrow.
        let ticks = |from_m: f64, to_m: f64| {
            let first = (from_m / step_m).ceil() as i64;
            (first..=(to_m / step_m).floor() as i64).map(move |k| (k as f64 * step_m, (k % 2 != 0).then_some("odd")))
        };
        let columns = ticks(self.west_m, self.west_m + WIDTH / self.units_per_m)
            .map(|(x, class)| (x, class, self.at([x, 0.0])[0]));
        let rows = ticks(self.north_m - self.height / self.units_per_m, self.north_m)
            .map(|(y, class)| (y, class, self.at([0.0, y])[1]));
        html! {
            g font-size="18" class="soft" {
                @for (x, class, at) in columns {
                    path d=(format!("M{at:.1} {:.1}v8", self.height)) stroke="currentColor" stroke-width="2" {}
                    text class=[class] x=(format!("{:.1}", at.clamp(30.0, WIDTH - 48.0))) y=(format!("{:.1}", self.height + 28.0)) text-anchor="middle" { (number(x, digits, "")) }
                }
                @for (y, class, at) in rows {
                    path d=(format!("M0 {at:.1}h-8")) stroke="currentColor" stroke-width="2" {}
                    text class=[class] x="-12" y=(format!("{:.1}", at.clamp(14.0, self.height - 2.0) + 6.0)) text-anchor="end" { (number(y, digits, "")) }
                }
                text x=(0.5 * WIDTH) y=(format!("{:.1}", self.height + 56.0)) text-anchor="middle" { "x (m)" }
                text class="title" transform=(format!("translate({:.1} {:.1}) rotate(-90)", -ASIDE + 18.0, 0.5 * self.height)) text-anchor="middle" { "y (m)" }
            }
        }
    }

    /// The tints of the relief with the heights they stand for.
    fn legend(&self) -> Markup {
        let Some([low, high]) = self.relief.heights_m else { return html! {} };
        let colours = TINTS.map(|[r, g, b]| format!("rgb({r:.0} {g:.0} {b:.0})")).join(", ");
        // Over level ground so many decimals that they differ.
        let digits = if high - low < 5.0 { 1 } else { 0 };
        html! {
            div class="ramp" {
                div style=(format!("background:linear-gradient(to right, {colours})")) {}
                span { (number(low, digits, "m")) } span { (number(0.5 * (low + high), digits, "m")) } span { (number(high, digits, "m")) }
            }
        }
    }

    /// The area's outline on a part.
    pub fn outline(&self, outputs: &Outputs<'_>, part: [f64; 4]) -> Markup {
        let path = format!("{}Z", self.path(&outputs.area()));
        let wide = |units: f64| format!("{:.2}", units * part[2] / WIDTH);
        html! {
            path d=(path) fill="none" stroke="#fdfcf9" stroke-width=(wide(7.0)) stroke-linejoin="round" {}
            path d=(path) fill="none" stroke="#1d1d1b" stroke-width=(wide(3.0)) stroke-linejoin="round" {}
        }
    }
}

/// Which of these places have room for a number as large as on a narrow page, each beside those before it that have.
fn apart(places: impl Iterator<Item = [f64; 2]>) -> Vec<bool> {
    let mut kept: Vec<[f64; 2]> = Vec::new();
    let has_room = |[right, down]: [f64; 2]| {
        let is_free = !kept.iter().any(|[x, y]| (x - right).abs() < APART[0] && (y - down).abs() < APART[1]);
        kept.extend(is_free.then_some([right, down]));
        is_free
    };
    places.map(has_room).collect()
}

impl Page<'_> {
    pub(super) fn plan(&self) -> Markup {
        let (outputs, map) = (self.outputs, &self.map);
        let point = |along_m: f64, across_m: f64| outputs.planned.layout.axes.point([along_m, across_m]);
        // An odd step shows lines of both directions.
        let every_line = self.lines().div_ceil(LINES_MAX) | 1;
        let shown: Vec<Leg<'_>> = outputs.legs().filter(|leg| leg.strip.line.is_multiple_of(every_line)).collect();
        let density = self.density();
        let (mut strips, mut dots, mut arrows, mut way) = (String::new(), String::new(), String::new(), Vec::new());
        for leg in &shown {
            let across_m = leg.strip.across_m;
            let ends = [leg.from_m(), leg.to_m()].map(|along_m| point(along_m, across_m));
            strips.push_str(&map.path(&ends));
            let leads = outputs.led(leg).map(|along_m| point(along_m, across_m));
            arrows.push_str(&arrow(map.at(ends[0]), map.at(leads[1])));
            way.extend(leads);
            for along_m in leg.strip.along_m.iter().filter(|_| density.is_none()) {
                let [right, down] = map.at(point(*along_m, across_m));
                let _ = write!(dots, "M{right:.1} {down:.1}h0");
            }
        }
        if every_line > 1 {
            way.clear();
        }
        let over = html! {
            @if let Some((picture, _)) = &density { (picture) }
            (map.outline(outputs, map.whole()))
            path d=(self.footprints()) fill="#b06a00" fill-opacity="0.12" stroke="#b06a00" stroke-width="3" stroke-linejoin="round" {}
            path d=(map.path(&way)) fill="none" stroke="#1f5a8c" stroke-width="2" stroke-dasharray="3 7" stroke-linejoin="round" {}
            path d=(strips) fill="none" stroke="#1f5a8c" stroke-width="3" {}
            path d=(arrows) fill="#1f5a8c" {}
            path d=(dots) fill="none" stroke="#b3261e" stroke-width="8" stroke-linecap="round" {}
            (self.numbers(every_line))
            (self.nearest_ring())
        };
        html! {
            section {
                h2 { "The plan" }
                figure {
                    div class="pan" { (map.svg("Map of the terrain with area, strips, photos and footprints", true, map.whole(), &over)) }
                    (map.legend())
                    @if let Some((_, legend)) = &density { (legend) }
                    figcaption {
                        "Terrain by its height above the datum. "
                        span class="key line k-ink" {} "Area; "
                        span class="key line k-ours" {} "strips, "
                        @if every_line > 1 { "one line of " (every_line) ", arrows in the direction of flight; " }
                        @else { "arrows in the direction of flight, dashed from each end point to the next lead-in; " }
                        @if density.is_none() { span class="key dot k-bad" {} "photos; " }
                        span class="key box k-paper" {} "footprints of three photos of a strip and one of the next, on the terrain. "
                        @if let Some(said) = self.nearest_words() { span class="key dot k-bad" {} "in a ring: the least clearance, " (said) ". " }
                        "Numbers: strips in the order of flight. Coordinates in metres: the elevation model’s, or from the area’s centre where it has degrees. Grid north up, light from the north-west; where the elevation model ends the ground is plain."
                    }
                }
            }
        }
    }

    /// The strips' numbers, where they begin, of one line of `every_line`.
    fn numbers(&self, every_line: usize) -> Markup {
        let outputs = self.outputs;
        let legs = outputs.legs().enumerate().filter(|(_, leg)| leg.strip.line.is_multiple_of(every_line));
        // On the lead-in, away from the photos.
        let place =
            |leg: &Leg<'_>| self.map.at(outputs.planned.layout.axes.point([outputs.led(leg)[0], leg.strip.across_m]));
        let places: Vec<(usize, [f64; 2])> = legs
            .map(|(index, leg)| (index + 1, place(&leg)))
            .map(|(number, [right, down])| (number, [right.clamp(20.0, WIDTH - 20.0), down]))
            .collect();
        let kept = apart(places.iter().map(|(_, place)| *place));
        html! {
            g class="numbers" font-size="18" font-weight="600" fill="#1f5a8c" stroke="#fdfcf9" stroke-width="5" paint-order="stroke" text-anchor="middle" {
                @for ((number, [right, down]), is_kept) in places.iter().zip(kept) {
                    text class=[(!is_kept).then_some("odd")] x=(format!("{right:.1}")) y=(format!("{:.1}", down + 6.0)) { (number) }
                }
            }
        }
    }

    /// Three photos in the middle of the middle strip, and the nearest of the next line.
    fn footprints(&self) -> String {
        let strips = &self.outputs.planned.strips;
        let Some(middle) = strips.get(strips.len().saturating_sub(1) / 2) else { return String::new() };
        let sight = Sight::new(&self.outputs.planned.layout);
        let first = (middle.along_m.len() / 2).saturating_sub(1);
        let mut photos: Vec<(&Strip, f64)> =
            middle.along_m.iter().skip(first).take(3).map(|along_m| (middle, *along_m)).collect();
        if let (Some(next), Some((_, along_m))) =
            (strips.iter().find(|strip| strip.line == middle.line + 1), photos.get(1))
        {
            let nearest = next.along_m.iter().min_by(|a, b| (*a - along_m).abs().total_cmp(&(*b - along_m).abs()));
            photos.extend(nearest.map(|nearest| (next, *nearest)));
        }
        let closed = |(strip, along_m): (&Strip, f64)| format!("{}Z", self.map.path(&sight.corners(strip, along_m)));
        photos.into_iter().map(closed).collect()
    }
}

/// An arrow's head at the end of a line, drawing units.
fn arrow(from: [f64; 2], to: [f64; 2]) -> String {
    let (right, down) = (to[0] - from[0], to[1] - from[1]);
    let length = right.hypot(down);
    if length == 0.0 {
        return String::new();
    }
    let (u, v) = (right / length, down / length);
    let back = |along: f64, aside: f64| [to[0] - along * u - aside * v, to[1] - along * v + aside * u];
    let ([a, b], [c, d]) = (back(20.0, 9.0), back(20.0, -9.0));
    format!("M{:.1} {:.1}L{a:.1} {b:.1}L{c:.1} {d:.1}Z", to[0], to[1])
}

#[cfg(test)]
mod tests {
    use super::apart;

    /// Numbers over each other, beside each other, and each far enough from the last that was kept.
    #[test]
    fn numbers_keep_apart() {
        let places = [[20.0, 500.0], [980.0, 490.0], [20.0, 480.0], [20.0, 460.0], [20.0, 445.0]];
        assert_eq!(apart(places.into_iter()), [true, true, false, true, false]);
    }
}
