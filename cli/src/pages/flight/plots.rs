//! The flight: where the vehicle was, how far off each fix was, how the matching errors are spread, how long frames were exposed
//! where that changed, and the pictures of single frames.

mod exposures;
mod histogram;
mod timeline;
pub(super) mod track;

use super::Report;
use maud::{Markup, html};
use plumbline_charts::plot::PlotError;

/// Most frames that are drawn one by one.
const FRAMES_MAX: usize = 2000;

impl Report<'_> {
    /// All plots with their captions.
    pub(super) fn plots(&self) -> Result<Markup, PlotError> {
        let (track, timeline, histogram) = (self.track()?, self.timeline()?, self.histogram()?);
        let exposures = self.exposures()?;
        let (step, pictured) = (self.step(), self.pictured());
        Ok(html! {
            section {
                h2 { "The flight" }
                div class="flight" {
                    div { (track) }
                    div class="beside" {
                    figure { div id="timeline" class="dots" { (timeline) } figcaption {
                        b { "Ground error. " }
                        span class="key dot k-ours" {} "fix minus true position, horizontal; "
                        span class="key line k-paper" {} "one sigma as the firmware states it, √(σ²" sub { "E" } " + σ²" sub { "N" } "); "
                        span class="key tick k-bad" {} "frames refused."
                    } }
                    figure { (histogram) figcaption {
                        b { "Matching error. " }
                        span class="key box k-raw" {} "unrectified, whole-pixel peak, all frames; "
                        span class="key box k-ours" {} "rectified, sub-pixel, accepted frames. "
                        span class="key line k-paper" {} "The paper’s means (Table 3)."
                    } }
                    @if let Some(exposures) = exposures {
                        figure { (exposures) figcaption {
                            b { "Exposure. " }
                            span class="key dot k-ours" {} "of each frame; "
                            span class="key line k-paper" {} "the longest that keeps the blur at half a pixel, as the firmware reckons it."
                        } }
                    }
                    }
                }
                (self.player(&pictured))
                (self.strip(&pictured))
                (self.table())
                @if step > 1 {
                    p class="note" { "Track, ground error and table show every " (step) "th frame, those without a fix, and those with pictures." }
                }
            }
        })
    }

    /// The frames that are drawn, by their places in the flight: one of [`Self::step`], and those without a fix where they are not too many.
    pub(super) fn drawn(&self) -> Vec<usize> {
        let are_few = self.scored.len().saturating_sub(self.summary.accepted) <= FRAMES_MAX;
        let is_drawn = |index: &usize| index.is_multiple_of(self.step()) || are_few && !self.scored[*index].accepted;
        (0..self.scored.len()).filter(is_drawn).collect()
    }

    /// Of so many frames one is drawn.
    pub(super) fn step(&self) -> usize {
        self.scored.len().div_ceil(FRAMES_MAX).max(1)
    }
}
