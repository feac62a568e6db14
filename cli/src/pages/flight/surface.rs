//! The score surface of a frame: how well patch and reference agree at each whole-pixel shift around the prediction.

use super::Report;
use crate::dump::{Rectified, predicted_corner};
use maud::{Markup, html};
use plumbline_charts::png::{Colour, encode, uri};
use plumbline_core::image::{Run, View};
use plumbline_core::matching::grey_correlation;
use plumbline_firmware::wire::telemetry::FrameReport;

/// Most pixels to each side that are shown of a wider search. Chosen: 49 squares still are seen one by one.
const RADIUS_MAX: u16 = 24;
/// From the worst shift to the best: stops of the colour map viridis (van der Walt and Smith, 2015).
const COLOURS: [[f64; 3]; 5] =
    [[68.0, 1.0, 84.0], [59.0, 82.0, 139.0], [33.0, 145.0, 140.0], [94.0, 201.0, 98.0], [253.0, 231.0, 37.0]];

/// Normalised cross-correlation of the greys over the shifts.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Surface {
    /// Shifts to each side.
    radius: u16,
    /// What the middle is off the prediction, (columns, rows): the rest of a pixel, and more where the match lies far from it.
    middle_px: [f32; 2],
    /// Row-major from the upper left shift.
    scores: Vec<f32>,
}

impl Surface {
    /// `None` where it leaves the tile.
    pub(super) fn new(report: &Report<'_>, frame: &FrameReport, rectified: &Rectified) -> Option<Self> {
        let flash = &report.setup.flash;
        let patch = &rectified.patch;
        let radius = report.setup.scenario.vehicle.search_px.min(RADIUS_MAX);
        // Around the match where it lies beyond what is shown around the prediction.
        let shift = frame.matched.map_or([0.0; 2], |matched| [matched.d_col, matched.d_row]);
        let is_far = shift.iter().any(|shift| shift.abs() > f32::from(radius) - 1.0);
        let around = if is_far { shift } else { [0.0; 2] };
        let size = (u16::try_from(patch.cols).ok()?, u16::try_from(patch.rows).ok()?);
        let exact = predicted_corner(report.setup, frame, size)?;
        let corner = [0, 1].map(|axis| (exact[axis] + around[axis]).round());
        let wide = (size.0 + 2 * radius, size.1 + 2 * radius);
        let origin = corner.map(|at| at as i32 - i32::from(radius));
        let window = View::new(&flash.tile, flash.head.size)?.window(origin[0], origin[1], wide)?;
        let (view, runs) = (View::new(&patch.pixels, size)?, runs(&rectified.mask.pixels, patch.cols));
        let far = radius as i16;
        let shifts = (-far..=far).flat_map(|row| (-far..=far).map(move |col| (col, row)));
        let scores = shifts.map(|shift| grey_correlation(&view, &runs, &window, radius, shift)).collect();
        Some(Surface { radius, middle_px: [corner[0] - exact[0], corner[1] - exact[1]], scores })
    }

    /// As a picture with its marks: a ring where the match was found, a cross where the truth is, both relative to the prediction.
    pub(super) fn svg(&self, frame: u32, found_px: Option<[f64; 2]>, truth_px: Option<[f64; 2]>) -> Markup {
        let side = 2 * usize::from(self.radius) + 1;
        let (low, high) = self.range();
        let pixels: Vec<u8> =
            self.scores.iter().flat_map(|score| colour((score - low) / (high - low).max(f32::EPSILON))).collect();
        let picture = uri(&encode(side, side, Colour::Rgb, &pixels));
        let at = |shift: [f64; 2]| {
            let place = |axis: usize| shift[axis] - f64::from(self.middle_px[axis]) + f64::from(self.radius) + 0.5;
            [place(0), place(1)]
        };
        let inside = |[x, y]: &[f64; 2]| (0.0..side as f64).contains(x) && (0.0..side as f64).contains(y);
        let (found, truth) = (found_px.map(at).filter(inside), truth_px.map(at).filter(inside));
        let thin = side as f64 / 70.0;
        html! {
            svg class="relief" viewBox=(format!("0 0 {side} {side}")) role="img" aria-label=(format!("score surface of frame {frame}")) {
                image width=(side) height=(side) href=(picture) style="image-rendering:pixelated" {}
                @for (stroke, wide) in [("#ffffff", 3.0 * thin), ("#b3261e", thin)] {
                    @if let Some([x, y]) = truth {
                        path d=(format!("M{:.2} {y:.2}h{w:.2}M{x:.2} {:.2}v{w:.2}", x - 3.0 * thin, y - 3.0 * thin, w = 6.0 * thin)) fill="none" stroke=(stroke) stroke-width=(format!("{wide:.2}")) {}
                    }
                    @if let Some([x, y]) = found {
                        circle cx=(format!("{x:.2}")) cy=(format!("{y:.2}")) r=(format!("{:.2}", 4.0 * thin)) fill="none" stroke=(stroke) stroke-width=(format!("{wide:.2}")) {}
                    }
                }
            }
        }
    }

    /// Lowest and highest score.
    pub(super) fn range(&self) -> (f32, f32) {
        let fold = |pick: fn(f32, f32) -> f32, from| self.scores.iter().copied().fold(from, pick);
        (fold(f32::min, f32::INFINITY), fold(f32::max, f32::NEG_INFINITY))
    }
}

/// Of 0 to 1.
fn colour(share: f32) -> [u8; 3] {
    let place = f64::from(share.clamp(0.0, 1.0)) * (COLOURS.len() - 1) as f64;
    let lower = (place as usize).min(COLOURS.len() - 2);
    let part = place - lower as f64;
    std::array::from_fn(|k| (COLOURS[lower][k] + part * (COLOURS[lower + 1][k] - COLOURS[lower][k])) as u8)
}

/// The valid pixels of a mask, row by row.
fn runs(mask: &[u8], cols: usize) -> Vec<Run> {
    let mut runs = Vec::new();
    for (row, valid) in mask.chunks(cols.max(1)).enumerate() {
        let mut start = 0;
        for piece in valid.chunk_by(|a, b| (*a != 0) == (*b != 0)) {
            let end = start + piece.len();
            if piece[0] != 0 {
                runs.push(Run { row: row as u16, start: start as u16, end: end as u16 });
            }
            start = end;
        }
    }
    runs
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dump::views;
    use crate::pages::flight::tests::flown;

    #[test]
    fn runs_are_what_is_valid() {
        let of = |row, start, end| Run { row, start, end };
        assert_eq!(runs(&[0, 9, 9, 0, 9, 9, 9, 9, 0, 0, 0, 0], 4), [of(0, 1, 3), of(1, 0, 4)]);
        assert!(runs(&[], 0).is_empty());
    }

    /// At the firmware's whole-pixel peak the surface has the score that the firmware reports.
    #[test]
    fn the_surface_has_the_firmwares_score_at_its_peak() {
        let flown = flown();
        let report = flown.report();
        let mut compared = 0;
        for record in &flown.flight.frames {
            let Some(rectified) = views(&flown.setup, record).and_then(|views| views.rectified) else { continue };
            let Some((frame, matched)) = record.report.and_then(|r| Some((r, r.matched?))) else { continue };
            let surface = Surface::new(&report, &frame, &rectified).expect("inside the tile");
            let side = 2 * usize::from(surface.radius) + 1;
            let index = |axis: usize, peak: f32| (peak - surface.middle_px[axis]).round() as usize;
            let far = f32::from(surface.radius);
            let at = index(1, matched.peak_row + far) * side + index(0, matched.peak_col + far);
            assert!((surface.scores[at] - matched.correlation).abs() < 1e-5, "frame {}", record.exposure.frame);
            compared += 1;
        }
        assert!(compared >= 3, "{compared} frames compared");
    }

    #[test]
    fn the_colours_go_from_dark_to_bright() {
        assert_eq!([colour(0.0), colour(0.5), colour(1.0)], [[68, 1, 84], [33, 145, 140], [253, 231, 37]]);
    }
}
