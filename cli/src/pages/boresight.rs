//! `report.html` of a boresight: how the camera is found to sit, how well that is known, and what it takes off the fixes' errors.

use super::scatter::{Offset, along, reach_m, scatter};
use maud::{Markup, html};
use plumbline_charts::format::{NONE, maybe, number, whole};
use plumbline_charts::page::{key, said};
use plumbline_charts::plot::PlotError;
use plumbline_survey::calibrate::boresight::{Boresight, Joined};

/// The angles' names.
pub const NAMES: [&str; 3] = ["phi", "omega", "kappa"];

/// What the page is made of.
#[derive(Clone, Copy, Debug)]
pub struct Page<'a> {
    pub found: &'a Boresight,
    pub joined: &'a Joined,
    /// What the board was configured with.
    pub told_deg: [f64; 3],
    /// What stands in the camera file now.
    pub boresight_deg: [f64; 3],
    /// What a reader has to know.
    pub notes: &'a [String],
}

impl Page<'_> {
    /// The page.
    ///
    /// # Errors
    /// [`PlotError`].
    pub fn html(&self) -> Result<String, PlotError> {
        let plots = self.plots()?;
        let body = html! {
            (self.head())
            @if !self.notes.is_empty() {
                div class="warnings" role="note" {
                    h2 { (self.notes.len()) @if self.notes.len() == 1 { " warning" } @else { " warnings" } }
                    ul { @for note in self.notes { li { (said(note)) } } }
                }
            }
            (plots)
            (self.angles())
        };
        Ok(plumbline_charts::page::page("Plumbline boresight", &body))
    }

    fn head(&self) -> Markup {
        let (found, degrees) = (self.found, |angle: f64| number(angle, 3, "°"));
        let determined = found.determined.iter().filter(|determined| **determined).count();
        let [before, after] = self.rms_m();
        html! {
            header {
                p class="kicker" { "Plumbline " (env!("CARGO_PKG_VERSION")) " · boresight" }
                h1 { "How the camera sits" }
                p class="note" { (whole(self.joined.sightings.len() as u64)) " fixes with a pose" }
                p class="verdict" {
                    @if determined == 3 { span class="good" { "All three angles are determined. " } }
                    @else { span class="warn" { (determined) " of three angles " @if determined == 1 { "is" } @else { "are" } " determined. " } }
                    "The fixes lie " (number(before, 2, "m")) " from the positions (RMS), and " (number(after, 2, "m")) " from where a camera that sits so sees them."
                }
                div class="keys" {
                    @for k in 0..3 {
                        (key(&degrees(self.boresight_deg[k]), &if found.determined[k] { format!("{} ± {}", NAMES[k], degrees(found.sd_rad[k].to_degrees())) } else { format!("{}, as configured", NAMES[k]) }))
                    }
                    (key(&number(found.sigma0, 2, ""), "sigma0 (1 where the fixes’ sigmas are right)"))
                    (key(&whole(found.outliers.len() as u64), "outliers"))
                }
            }
        }
    }

    /// Root mean square length of the fixes' offsets, before and after, without the outliers.
    fn rms_m(&self) -> [f64; 2] {
        let [before, after] = self.offsets();
        [before, after].map(|offsets| {
            let good = || offsets.iter().filter(|(_, is_good)| *is_good);
            (good().map(|([x, y], _)| x * x + y * y).sum::<f64>() / good().count().max(1) as f64).sqrt()
        })
    }

    /// Offsets along the camera's axes: fix less position, and what is left of that.
    fn offsets(&self) -> [Vec<Offset>; 2] {
        let sightings = &self.joined.sightings;
        let mut before = sightings.iter().map(|s| [0, 1].map(|axis| s.fix_m[axis] - s.position_m[axis]));
        let turned = |offsets: &mut dyn Iterator<Item = [f64; 2]>| {
            let of_camera = offsets.zip(sightings).enumerate().map(|(index, (offset, sighting))| {
                let heading_rad = sighting.attitude_rad[0] - sighting.follow_up_rad;
                (along(offset, heading_rad), !self.found.outliers.contains(&index))
            });
            of_camera.collect::<Vec<Offset>>()
        };
        [turned(&mut before), turned(&mut self.found.residuals_m.iter().copied())]
    }

    fn plots(&self) -> Result<Markup, PlotError> {
        let [before, after] = self.offsets();
        let far_m = reach_m(before.iter().chain(&after));
        let (right, forward) = ("to the camera’s right (m)", "forward (m)");
        let [before, after] = [scatter(right, forward, &before, far_m)?, scatter(right, forward, &after, far_m)?];
        Ok(html! {
            section {
                h2 { "Fixes along the camera’s axes" }
                div class="two" {
                    figure { (before) figcaption { b { "As flown: " } "fix less position, " span class="key dot k-ours" {} "used, " span class="key dot k-bad" {} "outliers. A camera that sits otherwise than its file says has them beside the middle." } }
                    figure { (after) figcaption { b { "What is left " } "of each where the camera sits as found" @if self.found.offset.is_some() { ", and the map’s offset is taken off" } "." } }
                }
            }
        })
    }

    fn angles(&self) -> Markup {
        let degrees = |angle: f64| if angle.is_finite() { number(angle, 4, "°") } else { NONE.to_owned() };
        let found = self.found;
        html! {
            section {
                h2 { "Angles" }
                div class="scroll" {
                table {
                    thead { tr { th { "Of the mount from the camera" } th class="r" { "Configured" } th class="r" { "Found" } th class="r" { "Sigma" } th class="r" { "Of it by chance" } th class="r" { "Next flight" } } }
                    tbody { @for (k, name) in NAMES.iter().enumerate() {
                        tr {
                            th { (name) }
                            td class="n" { (degrees(self.told_deg[k])) }
                            td class=(if found.determined[k] { "n strong" } else { "n" }) { @if found.determined[k] { (degrees(self.boresight_deg[k])) } @else { "not determined" } }
                            td class="n" { (degrees(found.sd_rad[k].to_degrees())) }
                            td class="n" { (degrees(found.random_sd_rad[k].to_degrees())) }
                            td class="n" { (maybe(found.next_rad[k].map(f64::to_degrees), 3, "°")) }
                        }
                    } }
                }
                }
                @if let Some(([east, north], [sd_east, sd_north])) = found.offset {
                    p { "Offset of the map: " (number(east, 2, "m")) " east (± " (number(sd_east, 2, "")) "), " (number(north, 2, "m")) " north (± " (number(sd_north, 2, "")) ")." }
                }
                p class="note" { "What is not by chance is a share of the correction: how the matching weighs the parts of a patch is not known. A second flight with the new file takes it off." }
            }
        }
    }
}
