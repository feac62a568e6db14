//! Overlap and accuracy of each cell, over the map.

use super::Page;
use super::relief::TINTS;
use maud::{Markup, html};
use plumbline_charts::format::{number, whole};
use plumbline_charts::png::{Colour, encode, uri};
use plumbline_survey::plan::cells::Known;

/// From few to many, from coarse to fine.
const COLOURS: [[u8; 3]; 5] = [[211, 227, 240], [159, 195, 223], [99, 154, 198], [47, 108, 163], [18, 63, 102]];
/// No stereo pair, or not determined.
const GAP: [u8; 3] = [179, 38, 30];
/// How much of the terrain the cells hide.
const OPACITY: u8 = 215;

/// Classes of a quantity: upper limits, ascending, and what each class is called.
struct Classes {
    limits: Vec<f64>,
    names: Vec<String>,
    /// Whether small values are the good ones, and dark.
    is_small_good: bool,
}

impl Classes {
    /// Of counts from the least that there is.
    fn counts(least: u32, most: u32) -> Self {
        let most = most.max(least);
        let width = (most - least + 1).div_ceil(COLOURS.len() as u32);
        let lows: Vec<u32> = (least..=most).step_by(width as usize).collect();
        let name = |low: u32| {
            let high = (low + width - 1).min(most);
            if high == low {
                whole(u64::from(low))
            } else {
                format!("{} to {}", whole(u64::from(low)), whole(u64::from(high)))
            }
        };
        Classes {
            limits: lows.iter().map(|low| f64::from(low + width - 1)).collect(),
            names: lows.iter().map(|low| name(*low)).collect(),
            is_small_good: false,
        }
    }

    /// Of standard deviations, as many cells in each: between quantiles, so that a few bad cells do not take all colours.
    fn lengths(values: impl Iterator<Item = f64>) -> Self {
        let mut values: Vec<f64> = values.collect();
        values.sort_by(f64::total_cmp);
        let last = values.len().saturating_sub(1);
        let quantile = |k: usize| values.get(last * k / COLOURS.len()).copied();
        let mut limits: Vec<f64> = (1..=COLOURS.len()).filter_map(quantile).collect();
        // Where many are equal, quantiles are.
        limits.dedup();
        let lows = values.first().copied().into_iter().chain(limits.iter().copied());
        Classes {
            names: lows.zip(&limits).map(|(low, high)| format!("{low:.3} to {}", number(*high, 3, "m"))).collect(),
            limits,
            is_small_good: true,
        }
    }

    fn colour(&self, class: usize) -> [u8; 3] {
        let last = self.limits.len().saturating_sub(1);
        let class = class.min(last);
        let place = if self.is_small_good { last - class } else { class };
        // Few classes take colours from the whole ramp.
        COLOURS[(place * (COLOURS.len() - 1)).checked_div(last).unwrap_or(COLOURS.len() - 1)]
    }

    fn of(&self, value: f64) -> [u8; 3] {
        self.colour(self.limits.iter().take_while(|limit| value > **limit).count())
    }

    /// A bar of the classes' colours with their names, and the colour of what has none.
    fn legend(&self, gap: &str) -> Markup {
        let style = |colour: [u8; 3]| {
            let [r, g, b] = on_ground(colour);
            format!("--c:#{r:02x}{g:02x}{b:02x}")
        };
        html! {
            span class="steps" {
                @for (class, name) in self.names.iter().enumerate() { span style=(style(self.colour(class))) { (name) } }
            }
            span class="class" { span class="key box" style=(style(GAP)) {} (gap) }
        }
    }
}

/// A colour as it is seen on the map, over level ground of middle height.
fn on_ground(colour: [u8; 3]) -> [u8; 3] {
    let hides = f64::from(OPACITY) / 255.0;
    std::array::from_fn(|k| (hides * f64::from(colour[k]) + (1.0 - hides) * TINTS[1][k]).round() as u8)
}

impl Page<'_> {
    pub(super) fn coverage(&self) -> Markup {
        let known = &self.outputs.planned.known;
        let seen = || known.iter().filter(|cell| !cell.is_gap()).map(|cell| cell.photos);
        let counts = Classes::counts(seen().min().unwrap_or(2), seen().max().unwrap_or(2));
        let sd = |axis: usize| Classes::lengths(known.iter().filter_map(move |cell| cell.sd_m.map(|sd| sd[axis])));
        let [plan, height] = [sd(0), sd(1)];
        let of_sd = |classes: &Classes, axis: usize| {
            self.cells("standard deviation", &|cell| cell.sd_m.map_or(GAP, |sd| classes.of(sd[axis])))
        };
        let overlap =
            self.cells("photos a cell", &|cell| if cell.is_gap() { GAP } else { counts.of(f64::from(cell.photos)) });
        html! {
            section {
                h2 { "Coverage and accuracy" }
                div class="plots" {
                    figure { (overlap) figcaption {
                        b { "Photos that see a cell. " } (counts.legend("fewer than two of one strip"))
                    } }
                    figure { (of_sd(&plan, 0)) figcaption {
                        b { "Horizontal standard deviation, " } "√(σ²" sub { "E" } " + σ²" sub { "N" } "). " (plan.legend("not determined"))
                    } }
                    figure { (of_sd(&height, 1)) figcaption {
                        b { "Height standard deviation. " } (height.legend("not determined"))
                    } }
                }
                p class="note" {
                    "Classes of standard deviations have as many cells each. " (whole(known.len() as u64)) " cells of " (number(self.outputs.planned.cells.step_m, 1, "m"))
                    ", at their centres: photos that see it with no terrain between, and the covariance of the point that they all intersect."
                }
            }
        }
    }

    /// Cells over the map in their colours.
    fn cells(&self, label: &str, colour: &dyn Fn(&Known) -> [u8; 3]) -> Markup {
        let (planned, map) = (self.outputs.planned, &self.map);
        let cells = &planned.cells;
        let mut pixels = vec![0; 4 * cells.cols * cells.rows];
        for (cell, known) in cells.inside.iter().zip(&planned.known) {
            let index = 4 * ((cells.rows - 1 - cell.row) * cells.cols + cell.col);
            let [r, g, b] = colour(known);
            pixels[index..index + 4].copy_from_slice(&[r, g, b, OPACITY]);
        }
        let half_m = 0.5 * cells.step_m;
        let [west_m, north_m] = cells.centre(0, cells.rows - 1);
        let [left, top] = map.at([west_m - half_m, north_m + half_m]);
        let [wide, high] = [cells.cols, cells.rows].map(|count| map.units(count as f64 * cells.step_m));
        let part = map.part([left, top], [left + wide, top + high]);
        let over = html! {
            image href=(uri(&encode(cells.cols, cells.rows, Colour::Rgba, &pixels))) x=(format!("{left:.1}")) y=(format!("{top:.1}"))
                width=(format!("{wide:.1}")) height=(format!("{high:.1}")) preserveAspectRatio="none" style="image-rendering:pixelated" {}
            (map.outline(self.outputs, part))
        };
        map.svg(&format!("Map of the cells: {label}"), false, part, &over)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_fall_into_classes_of_equal_width() {
        let few = Classes::counts(2, 4);
        assert_eq!(few.names, ["2", "3", "4"]);
        assert_eq!([few.of(2.0), few.of(3.0), few.of(4.0)], [COLOURS[0], COLOURS[2], COLOURS[4]]);
        // No class below the least count.
        let high = Classes::counts(10, 18);
        assert_eq!(high.names, ["10 to 11", "12 to 13", "14 to 15", "16 to 17", "18"]);
        assert_eq!([high.of(10.0), high.of(18.0)], [COLOURS[0], COLOURS[4]]);
        assert_eq!(Classes::counts(7, 7).names, ["7"]);
        let many = Classes::counts(2, 14);
        assert_eq!(many.names, ["2 to 4", "5 to 7", "8 to 10", "11 to 13", "14"]);
        assert_eq!([many.of(4.0), many.of(5.0), many.of(14.0)], [COLOURS[0], COLOURS[1], COLOURS[4]]);
    }

    #[test]
    fn the_finest_are_the_darkest() {
        // Of eleven values two are in each class, one more in the first, however far away the last is.
        let values = (1..=10).map(|k| 0.1 * f64::from(k)).chain([50.0]);
        let classes = Classes::lengths(values);
        assert_eq!((classes.names.len(), classes.names[0].as_str()), (5, "0.100 to 0.300\u{202f}m"));
        assert_eq!([classes.of(0.1), classes.of(0.6), classes.of(50.0)], [COLOURS[4], COLOURS[2], COLOURS[0]]);
        assert_eq!(Classes::lengths([0.2, 0.2, 0.2, 0.2, 0.2, 0.3].into_iter()).names.len(), 2);
        assert_eq!(Classes::lengths([0.2].into_iter()).of(0.2), COLOURS[4]);
        assert!(Classes::lengths([].into_iter()).names.is_empty());
    }
}
