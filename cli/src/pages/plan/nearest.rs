//! Where the flight comes nearest to the terrain, on the map and in words.

use super::Page;
use maud::{Markup, html};
use plumbline_charts::format::number;
use plumbline_survey::io::raster::for_people;

impl Page<'_> {
    /// A ring on the map, its place in working metres.
    pub(super) fn nearest_ring(&self) -> Markup {
        let Some(nearest) = self.outputs.planned.checks.nearest else { return html! {} };
        let [right, down] = self.map.at([nearest.x, nearest.y]).map(|unit| format!("{unit:.1}"));
        html! {
            g id="nearest" fill="none" {
                circle cx=(right) cy=(down) r="20" stroke="#fdfcf9" stroke-width="9" {}
                circle cx=(right) cy=(down) r="20" stroke="#b3261e" stroke-width="4" {}
                circle cx=(right) cy=(down) r="4" fill="#b3261e" {}
            }
        }
    }

    /// How much, on which part of the flight and where in the elevation model's own x and y.
    pub(super) fn nearest_words(&self) -> Option<String> {
        let nearest = self.outputs.file.checks.nearest?;
        Some(format!(
            "{} on {} at x {}, y {}, over ground of {}",
            number(nearest.flown_m - nearest.ground_m, 1, "m"),
            nearest.part(),
            for_people(nearest.x),
            for_people(nearest.y),
            number(nearest.ground_m, 1, "m")
        ))
    }
}
