//! Photos to the square kilometre over the map: of many photos each one for itself says nothing.

use super::Page;
use maud::{Markup, html};
use plumbline_charts::format::{number, whole};
use plumbline_charts::png::{Colour, encode, uri};

/// Photos that are drawn one by one at most: more lie on each other at the map's size.
pub(super) const PHOTOS_MAX: usize = 2000;
/// Photos to a cell on average, so that neighbours differ by the plan and not by chance; cells across at most.
const PHOTOS_A_CELL: f64 = 6.0;
const CELLS_MAX: f64 = 100.0;
/// Of a cell with the most photos, and how much of the terrain it hides.
const COLOUR: [u8; 3] = [179, 38, 30];
const OPACITY_MAX: f64 = 215.0;

impl Page<'_> {
    /// The picture over the map, and what its colours mean; `None` of a plan whose photos are drawn themselves.
    pub(super) fn density(&self) -> Option<(Markup, Markup)> {
        let planned = self.outputs.planned;
        if self.outputs.file.photo_count <= PHOTOS_MAX {
            return None;
        }
        let [_, _, width, height] = self.map.whole();
        let across = (width * (self.outputs.file.photo_count as f64 / PHOTOS_A_CELL / (width * height)).sqrt())
            .clamp(1.0, CELLS_MAX);
        let cell = width / across.floor();
        let [cols, rows] = [width, height].map(|side| (side / cell).ceil() as usize);
        let mut counts = vec![0u32; cols * rows];
        for strip in &planned.strips {
            for along_m in &strip.along_m {
                let [right, down] = self.map.at(planned.layout.axes.point([*along_m, strip.across_m]));
                // A cast from a float saturates.
                let (col, row) = ((right / cell) as usize, (down / cell) as usize);
                counts[row.min(rows - 1) * cols + col.min(cols - 1)] += 1;
            }
        }
        let most = counts.iter().copied().max().unwrap_or(0).max(1);
        let opacity = |count: u32| (OPACITY_MAX * f64::from(count) / f64::from(most)) as u8;
        let [r, g, b] = COLOUR;
        let pixels: Vec<u8> = counts.iter().flat_map(|count| [r, g, b, opacity(*count)]).collect();
        let cell_km2 = (cell / self.map.units(1000.0)).powi(2);
        let picture = html! {
            image href=(uri(&encode(cols, rows, Colour::Rgba, &pixels))) width=(format!("{:.1}", cell * cols as f64))
                height=(format!("{:.1}", cell * rows as f64)) preserveAspectRatio="none" style="image-rendering:pixelated" {}
        };
        let legend = html! {
            div class="ramp" {
                div style=(format!("background:linear-gradient(to right, transparent, rgb({r} {g} {b} / {:.2}))", OPACITY_MAX / 255.0)) {}
                span { "0" } span {} span { (whole((f64::from(most) / cell_km2).round() as u64)) " photos a km²" }
            }
            p class="note" { "Density of the photos in squares of " (number(1000.0 * cell_km2.sqrt(), 0, "m")) "." }
        };
        Some((picture, legend))
    }
}
