//! Overlaps, constant bases, checks and noise.

use super::Page;
use maud::{Markup, html};
use plumbline_charts::format::{NONE, maybe, number, whole};
use plumbline_survey::plan::checks::SHARP_PX;
use plumbline_survey::plan::lines::line_count;

impl Page<'_> {
    pub(super) fn overlaps(&self) -> Markup {
        let file = self.outputs.file;
        let percent = |share: f64| number(100.0 * share, 2, "%");
        let mut counts: Vec<u32> = self.outputs.planned.known.iter().map(|cell| cell.photos).collect();
        counts.sort_unstable();
        let count = |place: usize| counts.get(place).map_or_else(|| NONE.to_owned(), |count| whole(u64::from(*count)));
        let row = |name: &str, wanted: f64, least: Option<f64>| {
            html! {
                tr {
                    th { (name) }
                    td class="n" { (percent(wanted)) }
                    td class="n" { (least.map_or_else(|| NONE.to_owned(), percent)) }
                    td { (kept(least.is_none_or(|least| least >= wanted), "kept", "not kept")) }
                }
            }
        };
        html! {
            section {
                h2 { "Overlap on the ground" }
                div class="two" {
                    div {
                        table {
                            thead { tr { th { "Overlap" } th class="r" { "Wanted" } th class="r" { "Least" } th {} } }
                            tbody {
                                (row("Forward, photo to next photo", file.overlap_wanted.forward, file.overlap_min.forward))
                                (row("Side, line to next line", file.overlap_wanted.side, file.overlap_min.side))
                            }
                        }
                        p class="note" { "Of every pair on commonly seen ground, at the highest terrain in the overlap of its own two footprints. A dash: there is no such pair."
                            @if let Some(share) = file.swath_min.side {
                                " The least width that two strips truly see in common is " (percent(share)) " of a swath."
                            }
                        }
                    }
                    div {
                        table {
                            thead { tr { th { "Photos that see a cell" } th class="r" { "Least" } th class="r" { "Median" } th class="r" { "Most" } } }
                            tbody { tr {
                                th { "Of " (whole(counts.len() as u64)) " cells" }
                                td class="n" { (count(0)) } td class="n" { (count(counts.len() / 2)) } td class="n" { (count(counts.len().wrapping_sub(1))) }
                            } }
                        }
                    }
                }
            }
        }
    }

    pub(super) fn constant(&self) -> Markup {
        let (file, planned) = (self.outputs.file, self.outputs.planned);
        let constant = file.constant_base.as_ref();
        let across = plumbline_survey::plan::overlap::lines(&planned.strips);
        let spacings = across.windows(2).map(|pair| pair[1] - pair[0]);
        let range = |values: &mut dyn Iterator<Item = f64>| {
            let [low, high] =
                values.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], value| [low.min(value), high.max(value)]);
            match high - low {
                apart if apart >= 0.05 => format!("{low:.1} to {}", number(high, 1, "m")),
                apart if apart >= 0.0 => number(high, 1, "m"),
                _ => NONE.to_owned(),
            }
        };
        let mut bases = planned.strips.iter().flat_map(|strip| strip.along_m.windows(2).map(|pair| pair[1] - pair[0]));
        let count = |count: usize| whole(count as u64);
        html! {
            section {
                h2 { "Variable and constant bases" }
                table {
                    thead { tr { th {} th class="r" { "Photos" } th class="r" { "Lines" } th class="n" { "Base along a strip" } th class="n" { "Distance of lines" } } }
                    tbody {
                        tr {
                            th { "Variable (this plan)" }
                            td class="n strong" { (count(file.photo_count)) }
                            td class="n" { (count(line_count(&planned.strips))) }
                            td class="n" { (range(&mut bases)) }
                            td class="n" { (range(&mut spacings.into_iter())) }
                        }
                        @if let Some(constant) = constant {
                            tr {
                                th { "Constant" small { "the cheapest " @if file.follow.is_some() { "at one height " } "that guarantees the same overlap everywhere" } }
                                td class="n" { (count(constant.photos)) }
                                td class="n" { (count(constant.lines)) }
                                td class="n" { (number(constant.base_m, 1, "m")) }
                                td class="n" { (number(constant.spacing_m, 1, "m")) }
                            }
                        }
                    }
                }
                p {
                    @match constant.map(|constant| (constant.photos_saved, constant.photos.max(1))) {
                        Some((saved, of)) if saved >= 0 => { "Variable bases save " (whole(saved as u64)) " photos, " (number(100.0 * saved as f64 / of as f64, 1, "%")) "." },
                        Some((more, _)) => { "Here constant bases need " (whole(more.unsigned_abs())) " photos fewer." },
                        None => { "No constant bases of fewer than half a million photos give the same guarantee." },
                    }
                }
            }
        }
    }

    pub(super) fn checks(&self) -> Markup {
        let (file, checks) = (self.outputs.file, &self.outputs.file.checks);
        let milliseconds = |seconds: f64, digits| number(1000.0 * seconds, digits, "ms");
        let row = |name: &str, value: String, against: String, verdict: Markup| {
            html! { tr { th { (name) } td class="n" { (value) } td { (against) } td { (verdict) } } }
        };
        let is_high = checks.clearance_min_m >= checks.clearance_wanted_m;
        let interval_s = Some(file.interval_min_s).filter(|interval_s| interval_s.is_finite());
        html! {
            section {
                h2 { "Checks" }
                table class="wide" {
                    thead { tr { th {} th class="r" { "This plan" } th { "Against" } th {} } }
                    tbody {
                        (row("Least height above the terrain", number(checks.clearance_min_m, 1, "m"), format!("{} at least, strips and turns, a turn’s radius to both sides{}", number(checks.clearance_wanted_m, 0, "m"), self.nearest_words().map_or_else(String::new, |said| format!("; {said}"))),
                            kept(is_high && checks.is_clearance_known(), "clear", if is_high { "not known everywhere" } else { "too low" })))
                        @if let Some(follow) = &file.follow {
                            (row("Height above the ground straight below the strips", format!("{} to {}", number(follow.above_ground_min_m, 0, ""), number(follow.above_ground_max_m, 0, "m")),
                                format!("{} at least; more than {} only where the climb allowed does not get down in time", number(file.height_m - follow.tolerance_m, 0, "m"), number(file.height_m + follow.tolerance_m, 0, "m")),
                                kept(follow.above_ground_min_m >= file.height_m - follow.tolerance_m - 0.01, "kept", "too low")))
                            (row("Steepest climb or descent, strips and turns", number(checks.climb_percent, 1, "%"), format!("{} at most", number(checks.climb_wanted_percent, 1, "%")),
                                kept(checks.climb_percent <= checks.climb_wanted_percent * 1.000_001, "kept", "too steep")))
                        }
                        (row("Shortest interval between exposures", maybe(interval_s, 3, "s"), format!("{} at least", number(file.min_interval_s, 3, "s")),
                            kept(interval_s.is_none_or(|interval_s| interval_s >= file.min_interval_s), "kept", "too short")))
                        (row("Smear over the highest ground", number(checks.smear_px, 2, "px"),
                            format!("half a pixel at most; in {}", milliseconds(checks.exposure_s, 2)),
                            kept(checks.smear_px <= SHARP_PX, "sharp", &format!("expose {} at most", milliseconds(checks.exposure_max_s, 2)))))
                        (row("Photos that look beyond the elevation model", whole(checks.photos_beyond_dem as u64), format!("of {}", whole(file.photo_count as u64)),
                            kept(checks.photos_beyond_dem == 0, "none", "overlap not guaranteed there")))
                        (row("Length of strips and turns", number(checks.length_m / 1000.0, 1, "km"), format!("turns of {} radius", number(checks.turn_radius_m, 0, "m")), html! {}))
                        (row("Time of flight", number(checks.flight_time_s / 60.0, 1, "min"), format!("at {}", number(file.speed_m_s, 1, "m/s")), html! {}))
                    }
                }
            }
        }
    }

    pub(super) fn noise(&self) -> Markup {
        let file = self.outputs.file;
        let noise = &file.noise;
        let Some(accuracy) = &file.accuracy else { return html! {} };
        let row = |name: &str, plan_m: f64, height_m: f64| {
            html! { tr { th { (name) } td class="n" { (number(plan_m, 3, "m")) } td class="n" { (number(height_m, 3, "m")) } } }
        };
        html! {
            section {
                h2 { "Predicted accuracy" }
                table {
                    thead { tr { th { "Over " (whole(accuracy.cells as u64)) " cells" } th class="r" { "Plan" } th class="r" { "Height" } } }
                    tbody {
                        (row("Predicted from the covariance, RMS", accuracy.plan_m, accuracy.height_m))
                        (row(&format!("Intersected with simulated noise (seed {}), RMS", accuracy.seed), accuracy.simulated_plan_m, accuracy.simulated_height_m))
                        (row("Largest predicted of a cell", accuracy.plan_max_m, accuracy.height_max_m))
                    }
                }
                p class="note" {
                    "Standard deviations assumed: image coordinates " (number(noise.image_px, 3, "px")) ", each coordinate of a projection centre "
                    (number(noise.position_m, 3, "m")) ", each angle " (number(noise.attitude_deg, 4, "")) "° ("
                    (number(noise.attitude_deg * 3600.0, 1, "″")) "). Points are intersected from orientations as measured; no "
                    "adjustment improves them here."
                }
            }
        }
    }
}

fn kept(is_kept: bool, yes: &str, no: &str) -> Markup {
    html! { span class=(if is_kept { "good" } else { "bad" }) { (if is_kept { yes } else { no }) } }
}
