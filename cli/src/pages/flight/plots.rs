//! The plots: where the vehicle was, how far off each fix was, how the matching errors are spread, and how long frames were
//! exposed where that changed.

mod exposures;
mod histogram;
mod timeline;
mod track;

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
        let step = self.step();
        Ok(html! {
            section {
                h2 { "The flight" }
                div class="plots" {
                    figure { (track) figcaption {
                        b { "Track. " }
                        span class="key line" style="--c:#969185" {} "true track, "
                        span class="key dot" style="--c:#1f5a8c" {} "fixes, "
                        span class="key ring" style="--c:#b3261e" {} "frames refused, where they truly were. "
                        "Metres from the reference tile’s centre, grid north up, equal axes."
                    } }
                    figure { (timeline) figcaption {
                        b { "Ground error. " }
                        span class="key dot" style="--c:#1f5a8c" {} "fix minus true position, horizontal; "
                        span class="key line" style="--c:#b06a00" {} "one sigma as the firmware states it, √(σ²" sub { "E" } " + σ²" sub { "N" } "); "
                        span class="key tick" style="--c:#b3261e" {} "frames refused."
                    } }
                    figure { (histogram) figcaption {
                        b { "Matching error. " }
                        span class="key box" style="--c:#969185" {} "unrectified, whole-pixel peak, all frames; "
                        span class="key box" style="--c:#1f5a8c" {} "rectified, sub-pixel, accepted frames. "
                        span class="key line" style="--c:#b06a00" {} "The paper’s means (Table 3)."
                    } }
                    @if let Some(exposures) = exposures {
                        figure { (exposures) figcaption {
                            b { "Exposure. " }
                            span class="key dot" style="--c:#1f5a8c" {} "of each frame; "
                            span class="key line" style="--c:#b06a00" {} "the longest that keeps the blur at half a pixel, as the firmware reckons it."
                        } }
                    }
                }
                @if step > 1 {
                    p class="note" { "Track and ground error show every " (step) "th frame." }
                }
            }
        })
    }

    /// Of so many frames one is drawn.
    pub(super) fn step(&self) -> usize {
        self.scored.len().div_ceil(FRAMES_MAX).max(1)
    }
}
