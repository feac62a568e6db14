//! Frame, patch, reference, overlay and score surface of some frames.

use super::surface::Surface;
use super::{Report, overlay};
use crate::dump::{Rectified, Views, views};
use maud::{Markup, html};
use plumbline_charts::format::{number, short};
use plumbline_sim::run::FrameRecord;
use plumbline_sim::score::{Scored, length, reason};

/// Frames with a fix that are shown, and frames without one: 60 of some 60 KB each keep the page below four megabytes.
const FRAMES_MAX: usize = 24;
pub const REFUSED_MAX: usize = 36;

impl Report<'_> {
    /// The frames that are shown, by their places in the flight.
    pub(super) fn pictured(&self) -> Vec<usize> {
        let kept = (0..self.flight.frames.len()).filter(|&index| self.flight.frames[index].frame.is_some());
        let (fixed, refused): (Vec<usize>, Vec<usize>) = kept.partition(|&index| self.scored[index].accepted);
        let mut shown: Vec<usize> = [(fixed, FRAMES_MAX), (refused, REFUSED_MAX)]
            .iter()
            .flat_map(|(kept, most)| spread(kept.len(), *most).filter_map(|place| kept.get(place).copied()))
            .collect();
        shown.sort_unstable();
        shown
    }

    /// A card for each of them; a script shows one at a time.
    pub(super) fn strip(&self, pictured: &[usize]) -> Markup {
        let shown = pictured.iter().filter_map(|&index| {
            let record = &self.flight.frames[index];
            Some((record, &self.scored[index], views(self.setup, record)?))
        });
        html! {
            (self.pictures_kept(pictured))
            div id="pictures" class="cards" { @for (record, scored, views) in shown { (self.card(record, scored, &views)) } }
            p class="note" {
                "Frame: row 0 forward. Patch: rectified on board, grid north up, " (short(self.setup.scenario.vehicle.resolution_m))
                " m a pixel. Reference: where the patch was matched, to the nearest whole pixel. Overlay: patch red, reference cyan, both brought to one contrast; where they agree it is grey. "
                "Scores: correlation of patch and reference for each shift of a pixel, from dark to bright; a ring where it was matched, a cross where the vehicle truly was."
            }
        }
    }

    /// Of which frames there are pictures.
    fn pictures_kept(&self, pictured: &[usize]) -> Markup {
        let refused = self.scored.iter().filter(|scored| !scored.accepted).count();
        let shown = pictured.iter().filter(|index| !self.scored[**index].accepted).count();
        html! {
            p class="note" {
                "Pictures: of " (pictured.len()) " of the " (self.scored.len()) " frames, "
                @match (refused, shown) {
                    (0, _) => { "spread over the flight." }
                    (refused, shown) if refused == shown => { (pictured.len() - shown) " spread over the flight and every one without a fix (" (refused) ")." }
                    (refused, shown) => { (pictured.len() - shown) " spread over the flight and " (shown) " of the " (refused) " without a fix." }
                }
            }
        }
    }

    fn card(&self, record: &FrameRecord, scored: &Scored, views: &Views) -> Markup {
        let frame = scored.frame;
        let picture = |name: &str, uri: Option<String>| {
            html! {
                div {
                    @if let Some(uri) = uri { img class=(name) src=(uri) alt=(format!("{name} of frame {frame}")); }
                    @else { div class="missing" { "none" } }
                    span { (name) }
                }
            }
        };
        let rectified = views.rectified.as_ref();
        let reference = rectified.and_then(|r| r.reference.as_ref());
        html! {
            figure class="card" data-frame=(frame) {
                div class="five" {
                    (picture("frame", Some(overlay::frame(&views.frame))))
                    (picture("patch", rectified.map(overlay::patch)))
                    (picture("reference", reference.map(overlay::reference)))
                    (picture("overlay", rectified.zip(reference).map(|(r, reference)| overlay::overlay(r, reference))))
                    (self.scores(record, scored, rectified))
                }
                figcaption { b { "Frame " (frame) } " · " (self.attitude(record)) " · " (self.outcome(record, scored)) }
            }
        }
    }

    /// The score surface with its range.
    fn scores(&self, record: &FrameRecord, scored: &Scored, rectified: Option<&Rectified>) -> Markup {
        let surface = record.report.as_ref().zip(rectified).and_then(|(r, rectified)| Surface::new(self, r, rectified));
        let found = record.report.and_then(|report| report.matched);
        html! {
            div {
                @if let Some(surface) = surface {
                    @let (low, high) = surface.range();
                    (surface.svg(scored.frame, found.map(|m| [m.d_col, m.d_row].map(f64::from)), scored.truth_px))
                    span { "scores, " (number(low.into(), 2, "")) " to " (number(high.into(), 2, "")) }
                } @else {
                    div class="missing" { "none" }
                    span { "scores" }
                }
            }
        }
    }

    /// The truth at mid-exposure.
    fn attitude(&self, record: &FrameRecord) -> String {
        let truth = &record.truth;
        let degrees = |angle_rad: f64, digits| format!("{}°", number(angle_rad.to_degrees(), digits, ""));
        format!(
            "heading {}, pitch {}, roll {}, {} above ground",
            degrees(truth.heading_rad.rem_euclid(std::f64::consts::TAU), 0),
            degrees(truth.pitch_rad, 1),
            degrees(truth.roll_rad, 1),
            number(truth.up_m - self.setup.ground.height(truth.east_m, truth.north_m), 0, "m"),
        )
    }

    /// What became of the frame.
    fn outcome(&self, record: &FrameRecord, scored: &Scored) -> Markup {
        let error = scored.error_px.map(|px| number(length(px), 2, "px"));
        match (reason(record), scored.error_m) {
            (None, Some(error_m)) => html! {
                @if self.is_wrong(scored) { span class="bad" { "accepted, but wrong" } }
                @else { span class="good" { "accepted" } }
                ", " (error.unwrap_or_default()) " or " (number(length(error_m), 2, "m")) " off"
            },
            (reason, _) => html! {
                span class="bad" { "refused: " (reason.unwrap_or("no fix").replace('_', " ")) }
                @if let Some(error) = error { ", the match would have been " (error) " off" }
            },
        }
    }
}

/// Up to `most` of `count` places, evenly from the first to the last.
fn spread(count: usize, most: usize) -> impl Iterator<Item = usize> {
    let shown = count.min(most);
    (0..shown).map(move |place| place * count.saturating_sub(1) / shown.saturating_sub(1).max(1))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_frames_shown_reach_from_first_to_last() {
        let of = |count| spread(count, FRAMES_MAX).collect::<Vec<_>>();
        assert!(of(0).is_empty());
        assert_eq!((of(1), of(3)), (vec![0], vec![0, 1, 2]));
        assert_eq!(of(FRAMES_MAX), (0..FRAMES_MAX).collect::<Vec<_>>());
        let last = 3 * (FRAMES_MAX - 1);
        assert_eq!(of(last + 1), (0..=last).step_by(3).collect::<Vec<_>>());
    }
}
