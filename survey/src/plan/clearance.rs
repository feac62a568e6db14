//! Where a flight comes nearest to the terrain.

use super::file::Nearest;
use super::lines::Layout;
use super::terrain::Zone;

/// A part of the way.
pub(super) struct Part {
    /// Where the aircraft may be.
    pub zone: Zone,
    /// How low at least.
    pub up_m: f64,
    /// The strip in the order of flight, from 0; of a turn the one before it.
    pub leg: usize,
    /// Whether it is a turn.
    pub is_turn: bool,
}

/// Of all parts of a flight; `None` where nothing is known below any of them. Working metres.
pub(super) fn nearest(layout: &Layout<'_>, parts: &[Part]) -> Option<Nearest> {
    let above = parts.iter().filter_map(|part| {
        let highest_m = layout.terrain.highest_in(&layout.axes, &part.zone)?;
        Some((part.up_m - highest_m, highest_m, part))
    });
    let (_, ground_m, part) = above.min_by(|a, b| a.0.total_cmp(&b.0))?;
    let [x, y] = post(layout, &part.zone, ground_m)?;
    Some(Nearest { x, y, ground_m, flown_m: part.up_m, strip: part.leg + 1, is_turn: part.is_turn })
}

/// The post of a height that lies nearest to the middle of a zone, of those in the cells that the zone touches.
fn post(layout: &Layout<'_>, zone: &Zone, height_m: f64) -> Option<[f64; 2]> {
    let dem = layout.terrain.dem();
    let half = |[from, to]: [f64; 2]| [0.5 * (from + to), 0.5 * (to - from)];
    let ([along, half_along], [across, half_across]) = (half(zone.along), half(zone.across));
    // A cell that the zone touches reaches a cell's diagonal beyond it.
    let cell_m = dem.step_m[0].hypot(dem.step_m[1]);
    let beyond_m = |index: &usize| {
        let place = [
            dem.west_m + (index % dem.cols) as f64 * dem.step_m[0],
            dem.south_m + (index / dem.cols) as f64 * dem.step_m[1],
        ];
        let [at_along, at_across] = layout.axes.of(place);
        let out = [(at_along - along).abs() - half_along, (at_across - across).abs() - half_across];
        (place, out[0].max(out[1]).max(0.0), (at_along - along).hypot(at_across - across))
    };
    let of_height =
        (0..dem.heights.len()).filter(|index| dem.heights[*index] == height_m).map(|index| beyond_m(&index));
    // Beside the model the terrain is that of its border.
    let found: Vec<_> = of_height.collect();
    let inside = found.iter().filter(|(_, out_m, _)| *out_m <= cell_m).min_by(|a, b| a.2.total_cmp(&b.2));
    inside.or_else(|| found.iter().min_by(|a, b| a.1.total_cmp(&b.1))).map(|(place, ..)| *place)
}
