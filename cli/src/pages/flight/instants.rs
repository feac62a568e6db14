//! What was known of the instant of exposure: stamp, pose, and how far the picture moved.

use super::Report;
use maud::{Markup, html};
use plumbline_charts::format::{maybe, whole};

impl Report<'_> {
    pub(super) fn instants(&self) -> Markup {
        let (stamps, poses, blur) = (&self.summary.stamps, &self.summary.poses, &self.summary.blur);
        let sources = listed(stamps.sources.iter().map(|(name, frames)| (name.replace('_', " "), *frames)));
        let methods = listed(poses.methods.iter().map(|(name, frames)| ((*name).to_owned(), *frames)));
        let row = |name: &str, what: &str, value: String| {
            html! { tr { th { (name) small { (what) } } td class="n" { (value) } } }
        };
        let longest = blur.exposure_max_us.map(|us| f64::from(us) * 1e-3);
        html! {
            section class="two" {
                div {
                    h2 { "Mid-exposure" }
                    table {
                        thead { tr { th { "All frames with a stamp" } th class="r" { "Value" } } }
                        tbody {
                            (row("Stamp less truth, RMS", &format!("Source, frames: {sources}."), maybe(stamps.rms_us, 2, "µs")))
                            (row("… in its own sigmas", "Mean square; 1 where the sigmas are right.", maybe(stamps.nees_mean, 2, "")))
                            (row("Image motion, mean", "Longest displacement in a frame during its exposure, frame pixels.", maybe(blur.mean_px, 2, "px")))
                            (row("… largest", &format!("{} frames above half a pixel.", whole(blur.blurred as u64)), maybe(blur.max_px, 2, "px")))
                            (row("Longest sharp exposure", "That would have kept every frame at half a pixel.", maybe(longest, 1, "ms")))
                        }
                    }
                }
                div {
                    h2 { "Pose at that instant" }
                    table {
                        thead { tr { th { "All frames with a pose" } th class="r" { "Value" } } }
                        tbody {
                            (row("Pitch and roll less truth, RMS", &format!("Method, frames: {methods}."), maybe(poses.tilt_rms_deg, 4, "°")))
                            (row("… in their own sigmas", "Mean square; 1 where the sigmas are right.", maybe(poses.nees_mean, 2, "")))
                            (row("Outliers", "Attitude samples that the fit rejected.", whole(poses.rejected_samples as u64)))
                        }
                    }
                    p class="note" { "Method: a fit that keeps the second or third differences small, or linear interpolation between two samples (straight)." }
                }
            }
        }
    }
}

/// Names with their counts, those of none left out.
fn listed(counts: impl Iterator<Item = (String, usize)>) -> String {
    let some: Vec<String> =
        counts.filter(|(_, frames)| *frames > 0).map(|(name, frames)| format!("{name} {frames}")).collect();
    if some.is_empty() { "nothing".to_owned() } else { some.join(", ") }
}
