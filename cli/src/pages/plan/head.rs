//! Title, verdict and the figures that matter.

use super::Page;
use maud::{Markup, html};
use plumbline_charts::format::{NONE, maybe, number, short, whole};
use plumbline_charts::page::{key, said};

impl Page<'_> {
    pub(super) fn head(&self) -> Markup {
        let file = self.outputs.file;
        let accuracy = file.accuracy.as_ref();
        let least = |share: Option<f64>| share.map_or_else(|| NONE.to_owned(), |share| number(100.0 * share, 1, ""));
        let system = file.epsg.map_or_else(|| "local metres".to_owned(), |epsg| format!("EPSG:{epsg}"));
        html! {
            header {
                p class="kicker" { "Plumbline " (env!("CARGO_PKG_VERSION")) " · flight plan" }
                h1 { (photos(file.photo_count)) " on " (lines(self.lines())) }
                @for danger in file.checks.dangers() {
                    p class="verdict bad" { strong { "Not safe to fly: " } (said(&danger)) }
                }
                @for question in self.questions {
                    p class="verdict bad" { strong { "Look at this first: " } (said(question)) }
                }
                p class="note" {
                    (self.outputs.dem_name()) " (" (system) ") · " (number(self.area_km2(), 2, "km²")) " · strips heading "
                    (number(file.strip_heading_deg, 1, "")) "° of grid north · " (number(file.height_m, 1, "m"))
                    @if let Some(follow) = &file.follow {
                        " above the ground, followed within " (number(follow.tolerance_m, 0, "m")) ": flown at altitudes of " (self.altitudes())
                        ", " (number(follow.above_ground_min_m, 0, "")) " to " (number(follow.above_ground_max_m, 0, "m")) " above the ground straight below"
                    }
                    @else { " above the base plane at " (number(file.base_height_m, 1, "m")) }
                    " · seed " (accuracy.map_or(0, |accuracy| accuracy.seed))
                }
                p class="verdict" { (self.verdict()) }
                @if let Some(gaps) = self.gaps() {
                    p class="verdict bad" { (whole(gaps as u64)) " cells are seen by fewer than two photos of one strip." }
                }
                div class="keys" {
                    (key(&whole(file.photo_count as u64), "photos"))
                    (key(&file.gsd_text("\u{202f}m"), if file.follow.is_some() { "ground sample distance, straight below the strips" } else { "ground sample distance, base plane" }))
                    (key(&format!("{} / {}", least(file.overlap_min.forward), number(100.0 * file.overlap_min.side.unwrap_or(f64::NAN), 1, "%")), "least overlap on commonly seen ground, forward / side"))
                    (key(&maybe(accuracy.map(|accuracy| accuracy.plan_m), 3, "m"), "predicted horizontal error, RMS"))
                    (key(&maybe(accuracy.map(|accuracy| accuracy.height_m), 3, "m"), "predicted height error, RMS"))
                    (key(&number(file.checks.flight_time_s / 60.0, 1, "min"), "flight, strips and turns"))
                }
            }
        }
    }

    /// The lowest and the highest of photos and waypoints, above the height datum.
    fn altitudes(&self) -> String {
        let points = self.outputs.file.strips.iter().flat_map(|strip| strip.photos.iter().chain(&strip.way));
        let [low, high] = points
            .map(|point| point.z)
            .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], up_m| [low.min(up_m), high.max(up_m)]);
        format!("{} to {}", number(low, 0, ""), number(high, 0, "m"))
    }

    /// One line: what was asked for, what comes of it, what the terrain was worth.
    fn verdict(&self) -> String {
        let file = self.outputs.file;
        let share = |share: f64| number(100.0 * share, 0, "");
        let wanted =
            format!("{}/{}", share(file.overlap_wanted.forward), number(100.0 * file.overlap_wanted.side, 0, "%"));
        let tilt = if file.tilt_deg > 0.0 {
            format!(" and at a tilt of up to {}°", short(file.tilt_deg))
        } else {
            String::new()
        };
        let chosen = if file.combinations.is_empty() { "asked for" } else { "chosen" };
        let of = if file.follow.is_some() { "constant bases at one height" } else { "constant bases" };
        let saved = match file.constant_base.map_or(0, |constant| constant.photos_saved) {
            _ if file.constant_base.is_none() => {
                format!("where no {of} of fewer than half a million photos give the same guarantee")
            }
            0 => format!("as many as {of} with the same guarantee need"),
            saved if saved > 0 => {
                format!("{} fewer than {of} with the same guarantee need", whole(saved as u64))
            }
            more => format!("{} more than {of} with the same guarantee need", whole(more.unsigned_abs())),
        };
        let known = if file.checks.photos_beyond_dem > 0 { " that the elevation model knows" } else { "" };
        format!(
            "Overlap {wanted}, {chosen}, is kept everywhere on the ground{known}{tilt} by bases{} that follow the terrain: {}, {saved}.",
            if file.follow.is_some() { " and heights" } else { "" },
            photos(file.photo_count)
        )
    }

    /// Lines of the plan.
    pub(super) fn lines(&self) -> usize {
        self.outputs.file.lines()
    }

    /// Cells without a stereo pair, where there are any.
    fn gaps(&self) -> Option<usize> {
        let gaps = self.outputs.planned.known.iter().filter(|known| known.is_gap()).count();
        (gaps > 0).then_some(gaps)
    }

    fn area_km2(&self) -> f64 {
        self.outputs.planned.layout.area.size_m2() * 1e-6
    }
}

fn photos(count: usize) -> String {
    format!("{} {}", whole(count as u64), if count == 1 { "photo" } else { "photos" })
}

fn lines(count: usize) -> String {
    format!("{} {}", whole(count as u64), if count == 1 { "line" } else { "lines" })
}
